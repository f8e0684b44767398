//! GeoParquet 1.0 and 1.1: geometry as WKB or in the native encodings, the CRS from the metadata of the file, and row
//! groups and rows that are nowhere near the tiles passed over by the column of boxes that the file names.

use std::collections::BTreeMap;
use std::io::{self, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use bytes::Bytes;
use geo::Coord;
use parquet::file::metadata::RowGroupMetaData;
use parquet::file::reader::{ChunkReader, FileReader, Length, SerializedFileReader};
use parquet::file::statistics::Statistics;
use parquet::record::{Field, List, Row};
use serde_json::{Map, Number, Value};

use super::attributes::distinct;
use super::format::stem;
use super::outline::{Outline, Ring};
use super::reference_system::{crs_of_file, wanted_in};
use super::{FootprintOptions, LayerInfo, RawFeature, Sink, wkb};
use crate::error::{InputError, Result};
use crate::guard::guarded;
use crate::source::crs::Crs;
use crate::source::open::{Input, Place};

/// The first bytes of a Parquet file.
pub(super) const MAGIC: &[u8; 4] = b"PAR1";
/// The key of the metadata that make a Parquet file a GeoParquet file.
const GEO: &str = "geo";

/// How the geometry stands in its column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Encoding {
    Wkb,
    Polygon,
    MultiPolygon,
}

/// What the metadata say of the geometry.
struct Geometry {
    column: String,
    encoding: Encoding,
    /// The columns of the boxes, from the root on: smallest x and y, largest x and y.
    boxes: Option<[Vec<String>; 4]>,
    crs: Option<Crs>,
    warnings: Vec<String>,
}

/// A box in the coordinates of the file: smallest x and y, largest x and y.
type Box4 = [f64; 4];

/// Reads a GeoParquet file.
pub(super) fn read(path: &Path, options: &FootprintOptions, sink: Sink<'_>) -> Result<LayerInfo> {
    let (place, size) = Place::of(path, "a GeoParquet file")?;
    let file = Ranges { place: place.clone(), size };
    // The library takes much of what a damaged file says for true.
    let read = guarded(|| read_unguarded(path, file, options, sink));
    place.verdict()?;
    read.unwrap_or_else(|_| Err(damaged(path, "a damaged file").into()))
}

/// A file or an object that is read here and there.
struct Ranges {
    place: Place,
    size: u64,
}

impl Ranges {
    /// A reader at `start`; of an object, `length` bytes from there come at once.
    fn at(&self, start: u64, length: usize) -> io::Result<Input> {
        let mut input = self.place.open().map_err(io::Error::other)?;
        if length > 0 {
            input.expect(std::iter::once(start..start.saturating_add(length as u64)));
        }
        input.seek(SeekFrom::Start(start))?;
        Ok(input)
    }
}

impl Length for Ranges {
    fn len(&self) -> u64 {
        self.size
    }
}

impl ChunkReader for Ranges {
    type T = BufReader<Input>;

    fn get_read(&self, start: u64) -> parquet::errors::Result<Self::T> {
        Ok(BufReader::new(self.at(start, 0)?))
    }

    fn get_bytes(&self, start: u64, length: usize) -> parquet::errors::Result<Bytes> {
        if start.checked_add(length as u64).is_none_or(|end| end > self.size) {
            return Err(io::Error::from(io::ErrorKind::UnexpectedEof).into());
        }
        let mut bytes = vec![0; length];
        self.at(start, length)?.read_exact(&mut bytes)?;
        Ok(bytes.into())
    }
}

fn read_unguarded(path: &Path, file: Ranges, options: &FootprintOptions, sink: Sink<'_>) -> Result<LayerInfo> {
    let reader = SerializedFileReader::new(file).map_err(|e| damaged(path, &e.to_string()))?;
    let metadata = reader.metadata();
    let names = metadata.file_metadata().schema().get_fields().iter().map(|field| field.name().to_owned());
    if let Some(clash) = distinct(names).1.first() {
        let fault = InputError::new(path, "two columns of one name", "a name for each column").at(clash.clone());
        return Err(fault.remedy("Write the file anew with other names").into());
    }
    let geometry = geometry_of(path, metadata.file_metadata().key_value_metadata(), options)?;
    let mut info = LayerInfo { layer: stem(path), crs: geometry.crs.clone(), ..LayerInfo::default() };
    info.warnings.clone_from(&geometry.warnings);
    let wanted = wanted_in(options, geometry.crs.as_ref()).filter(|_| geometry.boxes.is_some());
    let mut passed_over = 0;
    let mut blobs: BTreeMap<String, usize> = BTreeMap::new();
    for (index, group) in metadata.row_groups().iter().enumerate() {
        if let (Some(wanted), Some(boxes)) = (&wanted, &geometry.boxes)
            && !may_touch(group, boxes, wanted)
        {
            passed_over += u64::try_from(group.num_rows()).unwrap_or(0);
            continue;
        }
        let rows = reader.get_row_group(index).and_then(|group| {
            // Not the iterator of the crate over its own boxed reader: rows come one by one.
            let group: Vec<Row> = group.get_row_iter(None)?.collect::<std::result::Result<_, _>>()?;
            Ok(group)
        });
        let rows = rows.map_err(|e| damaged(path, &e.to_string()).at(format!("row group {index}")))?;
        for row in rows {
            let touches = match (&wanted, &geometry.boxes) {
                (Some(wanted), Some(boxes)) => box_of(&row, boxes).is_none_or(|own| overlap(&own, wanted)),
                _ => true,
            };
            if touches {
                sink(feature_of(row, &geometry, &mut blobs));
            } else {
                passed_over += 1;
            }
        }
    }
    if passed_over > 0 {
        info.has_more = true;
        info.warnings
            .push(format!("{passed_over} features lie beside the tiles, by the boxes of the file, and are not read"));
    }
    info.warnings.extend(
        blobs
            .into_iter()
            .map(|(column, count)| format!("attribute `{column}` is binary in {count} features and was left out")),
    );
    Ok(info)
}

fn damaged(path: &Path, found: &str) -> InputError {
    InputError::new(path, found, "a GeoParquet file").remedy("The file is damaged or cut off: get it anew")
}

/// What the key `geo` says.
fn geometry_of(
    path: &Path,
    pairs: Option<&Vec<parquet::file::metadata::KeyValue>>,
    options: &FootprintOptions,
) -> Result<Geometry> {
    let expected = "the metadata `geo` of GeoParquet 1.0 or 1.1";
    let text = pairs.into_iter().flatten().find(|pair| pair.key == GEO).and_then(|pair| pair.value.as_deref());
    let Some(text) = text else {
        return Err(InputError::new(path, "a Parquet file without geometry", expected)
            .remedy("Write it with a program that writes GeoParquet")
            .into());
    };
    let geo: Value = serde_json::from_str(text)
        .map_err(|e| InputError::new(path, e.to_string(), expected).at("its metadata `geo`"))?;
    let fault = |found: String, expected: &str| InputError::new(path, found, expected).at("its metadata `geo`");
    let primary = geo.get("primary_column").and_then(Value::as_str);
    let column = options.layer.as_deref().filter(|name| geo["columns"].get(name).is_some()).or(primary);
    let Some(column) = column else { return Err(fault("no primary column".into(), "the name of one").into()) };
    let about = &geo["columns"][column];
    let encoding = match about.get("encoding").and_then(Value::as_str).unwrap_or("WKB").to_ascii_lowercase().as_str() {
        "wkb" => Encoding::Wkb,
        "polygon" => Encoding::Polygon,
        "multipolygon" => Encoding::MultiPolygon,
        other => {
            let expected = "WKB, polygon or multipolygon";
            return Err(fault(format!("geometry in the encoding {other:?}"), expected).into());
        }
    };
    let path_of = |name: &str| -> Option<Vec<String>> {
        let parts = about["covering"]["bbox"][name].as_array()?;
        parts.iter().map(|part| part.as_str().map(str::to_owned)).collect()
    };
    let boxes = (|| Some([path_of("xmin")?, path_of("ymin")?, path_of("xmax")?, path_of("ymax")?]))();
    let mut warnings = Vec::new();
    if about.get("edges").and_then(Value::as_str) == Some("spherical") {
        warnings.push("its edges are great circles; they are taken for straight ones".to_owned());
    }
    let crs = match about.get("crs") {
        _ if options.crs.is_some() => None,
        // Left out means longitude and latitude, null means unknown.
        None => Some(Crs::wgs84()?),
        Some(Value::Null) => None,
        Some(definition) => crs_of_file(path, &definition.to_string(), options)?,
    };
    Ok(Geometry { column: column.to_owned(), encoding, boxes, crs, warnings })
}

fn overlap(a: &Box4, b: &Box4) -> bool {
    a[0] <= b[2] && a[2] >= b[0] && a[1] <= b[3] && a[3] >= b[1]
}

/// Whether rows of a group may touch the box, by the statistics of its columns.
fn may_touch(group: &RowGroupMetaData, boxes: &[Vec<String>; 4], wanted: &Box4) -> bool {
    let bounds = |path: &[String]| -> Option<[f64; 2]> {
        let column = group.columns().iter().find(|column| column.column_path().parts() == path)?;
        match column.statistics()? {
            Statistics::Double(found) => Some([*found.min_opt()?, *found.max_opt()?]),
            Statistics::Float(found) => Some([f64::from(*found.min_opt()?), f64::from(*found.max_opt()?)]),
            _ => None,
        }
    };
    let [Some(left), Some(low), Some(right), Some(high)] = boxes.each_ref().map(|path| bounds(path)) else {
        return true;
    };
    overlap(&[left[0], low[0], right[1], high[1]], wanted)
}

/// The box of a row.
fn box_of(row: &Row, boxes: &[Vec<String>; 4]) -> Option<Box4> {
    let value = |path: &[String]| {
        let (last, groups) = path.split_last()?;
        let mut row = row;
        for name in groups {
            row = match field(row, name)? {
                Field::Group(group) => group,
                _ => return None,
            };
        }
        number(field(row, last)?)
    };
    let [left, low, right, high] = boxes.each_ref().map(|path| value(path));
    Some([left?, low?, right?, high?])
}

fn field<'a>(row: &'a Row, name: &str) -> Option<&'a Field> {
    row.get_column_iter().find(|(column, _)| *column == name).map(|(_, field)| field)
}

fn number(field: &Field) -> Option<f64> {
    match field {
        Field::Float(value) => Some(f64::from(*value)),
        Field::Double(value) => Some(*value),
        _ => None,
    }
}

fn feature_of(row: Row, geometry: &Geometry, blobs: &mut BTreeMap<String, usize>) -> RawFeature {
    let is_box = |name: &str| geometry.boxes.as_ref().is_some_and(|boxes| boxes[0].len() > 1 && boxes[0][0] == name);
    let mut attributes = Map::new();
    let mut outline = Err("it has no geometry".to_string());
    for (name, field) in row.into_columns() {
        if name == geometry.column {
            outline = match (&field, geometry.encoding) {
                (Field::Null, _) => Err("it has no geometry".into()),
                (Field::Bytes(blob), Encoding::Wkb) => wkb::outline(blob.data()),
                (Field::ListInternal(rings), Encoding::Polygon) => {
                    polygon(rings).map(|rings| Outline { polygons: vec![rings], notes: Vec::new() })
                }
                (Field::ListInternal(polygons), Encoding::MultiPolygon) => polygons
                    .elements()
                    .iter()
                    .map(|part| list(part).and_then(polygon))
                    .collect::<std::result::Result<_, _>>()
                    .map(|polygons| Outline { polygons, notes: Vec::new() }),
                _ => Err("its geometry is not in the encoding that the file states".into()),
            };
        } else if let Field::Bytes(_) = field {
            *blobs.entry(name).or_default() += 1;
        } else if !is_box(&name) {
            attributes.insert(name, value_of(field));
        }
    }
    RawFeature { attributes, outline }
}

fn list(field: &Field) -> std::result::Result<&List, String> {
    match field {
        Field::ListInternal(list) => Ok(list),
        _ => Err("its rings are damaged".to_owned()),
    }
}

/// The rings of a polygon in the native encoding: lists of structures of x and y.
fn polygon(rings: &List) -> std::result::Result<Vec<Ring>, String> {
    let point = |field: &Field| {
        let Field::Group(point) = field else { return None };
        let coordinate = |name| self::field(point, name).and_then(number);
        Some(Coord { x: coordinate("x")?, y: coordinate("y")? })
    };
    let ring = |field: &Field| -> std::result::Result<Ring, String> {
        let points = list(field)?.elements().iter().map(point).collect::<Option<Ring>>();
        points.ok_or_else(|| "a point of it has no x and y".to_owned())
    };
    rings.elements().iter().map(ring).collect()
}

/// A value as JSON; dates and times as text.
fn value_of(field: Field) -> Value {
    let float = |number: f64| Number::from_f64(number).map_or(Value::Null, Value::Number);
    match field {
        Field::Null | Field::Bytes(_) => Value::Null,
        Field::Bool(value) => value.into(),
        Field::Byte(value) => value.into(),
        Field::Short(value) => value.into(),
        Field::Int(value) => value.into(),
        Field::Long(value) => value.into(),
        Field::UByte(value) => value.into(),
        Field::UShort(value) => value.into(),
        Field::UInt(value) => value.into(),
        Field::ULong(value) => value.into(),
        // As it is written down, not as its nearest double: 2.8, not 2.799999952316284.
        Field::Float(value) => value.to_string().parse().map_or(Value::Null, float),
        Field::Double(value) => float(value),
        Field::Str(text) => text.into(),
        Field::Group(row) => row.into_columns().into_iter().map(|(name, field)| (name, value_of(field))).collect(),
        Field::ListInternal(list) => list.elements().iter().cloned().map(value_of).collect(),
        // What else there is (dates, times, decimals, maps) reads well as the crate shows it.
        other => {
            let text = other.to_string();
            text.trim_matches('"').into()
        }
    }
}
