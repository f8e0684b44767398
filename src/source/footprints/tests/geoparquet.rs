//! GeoParquet, written by the tests themselves: WKB and native encodings, boxes, reference systems.

use std::fs;
use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use geo::Area;
use parquet::basic::Compression;
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use serde_json::{Value, json};
use tempfile::TempDir;

use super::super::{FootprintOptions, Within, read};
use super::{assert_sound, ids, plain};
use crate::source::crs::Crs;

/// A column of a row group.
enum Column {
    Bytes(Vec<Vec<u8>>),
    Numbers(Vec<i64>),
    Doubles(Vec<f64>),
    /// Values of nested lists, with their definition and repetition levels.
    Nested(Vec<f64>, Vec<i16>, Vec<i16>),
}

fn write(path: &Path, schema: &str, geo: &Value, groups: &[Vec<Column>]) {
    let metadata = vec![KeyValue::new("geo".to_owned(), geo.to_string())];
    let properties =
        WriterProperties::builder().set_key_value_metadata(Some(metadata)).set_compression(Compression::SNAPPY).build();
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let mut writer = SerializedFileWriter::new(File::create(path).unwrap(), schema, Arc::new(properties)).unwrap();
    for group in groups {
        let mut rows = writer.next_row_group().unwrap();
        for column in group {
            let mut out = rows.next_column().unwrap().unwrap();
            match column {
                Column::Bytes(values) => {
                    let values: Vec<ByteArray> = values.iter().cloned().map(ByteArray::from).collect();
                    out.typed::<ByteArrayType>().write_batch(&values, None, None).unwrap();
                }
                Column::Numbers(values) => drop(out.typed::<Int64Type>().write_batch(values, None, None).unwrap()),
                Column::Doubles(values) => drop(out.typed::<DoubleType>().write_batch(values, None, None).unwrap()),
                Column::Nested(values, definitions, repetitions) => {
                    out.typed::<DoubleType>().write_batch(values, Some(definitions), Some(repetitions)).unwrap();
                }
            }
            out.close().unwrap();
        }
        rows.close().unwrap();
    }
    writer.close().unwrap();
}

/// The WKB of a square.
fn square(x: f64, side: f64) -> Vec<u8> {
    let mut bytes = vec![1];
    for number in [3_u32, 1, 5] {
        bytes.extend(number.to_le_bytes());
    }
    for [dx, dy] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0]] {
        bytes.extend((x + dx * side).to_le_bytes());
        bytes.extend((dy * side).to_le_bytes());
    }
    bytes
}

const WITH_BOXES: &str = "message schema { required binary geometry; required binary id (UTF8); required int64 big;
    required group bbox { required double xmin; required double ymin; required double xmax; required double ymax; } }";

fn geo(encoding: &str, crs: Option<Value>) -> Value {
    let column = |name: &str| json!(["bbox", name]);
    let mut about = json!({"encoding": encoding, "geometry_types": ["Polygon"], "covering": {"bbox":
        {"xmin": column("xmin"), "ymin": column("ymin"), "xmax": column("xmax"), "ymax": column("ymax")}}});
    if let Some(crs) = crs {
        about["crs"] = crs;
    }
    json!({"version": "1.1.0", "primary_column": "geometry", "columns": {"geometry": about}})
}

/// Squares of 10 from `x` on, as a row group of a file with boxes.
fn group(squares: &[(&str, f64)]) -> Vec<Column> {
    let each = |value: &dyn Fn(f64) -> f64| Column::Doubles(squares.iter().map(|(_, x)| value(*x)).collect());
    vec![
        Column::Bytes(squares.iter().map(|(_, x)| square(*x, 10.0)).collect()),
        Column::Bytes(squares.iter().map(|(id, _)| id.as_bytes().to_vec()).collect()),
        Column::Numbers(vec![9_007_199_254_740_993; squares.len()]),
        each(&|x| x),
        each(&|_| 0.0),
        each(&|x| x + 10.0),
        each(&|_| 10.0),
    ]
}

#[test]
fn wkb_with_attributes_and_what_is_far_from_the_tiles_is_not_read() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.parquet");
    let groups = [group(&[("a", 0.0), ("b", 500.0)]), group(&[("c", 9000.0)])];
    write(&path, WITH_BOXES, &geo("WKB", Some(Value::Null)), &groups);
    let layer = plain(&path);
    assert_eq!((ids(&layer), layer.crs.clone()), (vec!["a", "b", "c"], None));
    assert_eq!(
        Value::Object(layer.footprints[0].attributes.to_map()),
        json!({"id": "a", "big": 9_007_199_254_740_993_i64})
    );
    assert_eq!(layer.footprints[0].polygon.unsigned_area(), 100.0);
    assert_sound(&layer);
    let crs = Crs::parse("EPSG:28992").unwrap();
    let within = Some(Within { crs: crs.clone(), extent: [-50.0, -50.0, 100.0, 100.0] });
    let layer = read(&path, &FootprintOptions { crs: Some(crs), within, ..FootprintOptions::default() }).unwrap();
    assert_eq!(ids(&layer), ["a"]);
    assert!(layer.warnings[0].starts_with("2 features lie beside the tiles"), "{:?}", layer.warnings);
}

#[test]
fn the_reference_system_is_that_of_the_metadata() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.parquet");
    let with = |crs: Option<Value>| {
        write(&path, WITH_BOXES, &geo("WKB", crs), &[group(&[("a", 0.0)])]);
        plain(&path).crs.and_then(|crs| crs.code)
    };
    assert_eq!(with(None).as_deref(), Some("OGC:CRS84"), "left out means degrees");
    assert_eq!(with(Some(Value::Null)), None);
    let projjson = json!({"type": "GeographicCRS", "name": "ETRS89", "datum": {"type": "GeodeticReferenceFrame",
        "name": "European Terrestrial Reference System 1989", "ellipsoid": {"name": "GRS 1980",
        "semi_major_axis": 6_378_137, "inverse_flattening": 298.257_222_101}}, "coordinate_system": {"subtype":
        "ellipsoidal", "axis": [{"name": "Geodetic latitude", "abbreviation": "Lat", "direction": "north", "unit":
        "degree"}, {"name": "Geodetic longitude", "abbreviation": "Lon", "direction": "east", "unit": "degree"}]},
        "id": {"authority": "EPSG", "code": 4258}});
    assert_eq!(with(Some(projjson)).as_deref(), Some("EPSG:4258"));
}

#[test]
fn polygons_in_the_native_encoding() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.parquet");
    let schema =
        "message schema { optional group geometry (LIST) { repeated group list { optional group element (LIST) {
        repeated group list { optional group element { required double x; required double y; } } } } } }";
    // A square with a hole, and another square: rings begin at level 1, features at 0, all else is in a ring.
    let ring = |x: f64, side: f64| [[x, 0.0], [x + side, 0.0], [x + side, side], [x, side], [x, 0.0]];
    let rings = [(ring(0.0, 10.0), 0), (ring(2.0, 2.0).map(|[x, y]| [x, y + 2.0]), 1), (ring(50.0, 5.0), 0)];
    let column = |axis: usize| {
        let values: Vec<f64> = rings.iter().flat_map(|(ring, _)| ring.map(|point| point[axis])).collect();
        let repetitions: Vec<i16> = rings.iter().flat_map(|(_, first)| [*first, 2, 2, 2, 2]).collect();
        Column::Nested(values.clone(), vec![5; values.len()], repetitions)
    };
    write(&path, schema, &geo("polygon", Some(Value::Null)), &[vec![column(0), column(1)]]);
    let layer = plain(&path);
    assert_eq!(layer.rejected, []);
    let areas: Vec<f64> = layer.footprints.iter().map(|f| f.polygon.unsigned_area()).collect();
    assert_eq!(areas, [96.0, 25.0]);
    assert_sound(&layer);
}

#[test]
fn what_is_damaged_or_no_geoparquet_is_told() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.parquet");
    let said = |geo: &Value| {
        write(&path, WITH_BOXES, geo, &[group(&[("a", 0.0)])]);
        read(&path, &FootprintOptions::default()).unwrap_err().to_string()
    };
    assert!(said(&geo("linestring", None)).contains("geometry in the encoding \"linestring\""));
    assert!(said(&json!({"columns": {}})).contains("no primary column"));
    write(&path, WITH_BOXES, &geo("WKB", None), &[group(&[("a", 0.0), ("b", 20.0)])]);
    let bytes = fs::read(&path).unwrap();
    for at in (0..bytes.len()).step_by(3) {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0xA5;
        fs::write(&path, &damaged).unwrap();
        match read(&path, &FootprintOptions::default()) {
            Ok(layer) => assert_sound(&layer),
            Err(error) => assert!(error.to_string().contains("made."), "{error}"),
        }
        fs::write(&path, &bytes[..at]).unwrap();
        assert!(read(&path, &FootprintOptions::default()).is_err(), "cut at {at}");
    }
}

#[test]
fn two_columns_of_one_name_are_refused() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.parquet");
    let schema = "message m { required binary geometry; required int64 height; required int64 height; }";
    let columns = vec![Column::Bytes(vec![square(0.0, 10.0)]), Column::Numbers(vec![1]), Column::Numbers(vec![2])];
    write(&path, schema, &geo("WKB", None), &[columns]);
    let message = read(&path, &FootprintOptions::default()).unwrap_err().to_string();
    assert!(message.contains("two columns of one name") && message.contains("`height`"), "{message}");
}
