//! Footprints that are not what they should be: every one that comes in goes out, with a model or with a reason.

use std::path::Path;

use serde_json::{Value, json};

use crate::bench::*;

/// A GeoJSON file whose features are as given; without `crs` it says none.
fn write_features(path: &Path, features: &[Value], crs: Option<&str>) {
    let mut file = json!({"type": "FeatureCollection", "features": features});
    if let Some(crs) = crs {
        file["crs"] = json!({"type": "name", "properties": {"name": crs}});
    }
    std::fs::write(path, file.to_string()).unwrap();
}

fn feature(id: &Value, geometry: &Value) -> Value {
    json!({"type": "Feature", "properties": {"id": id}, "geometry": geometry})
}

/// Rings in the made-up neighbourhood.
fn polygon(rings: &[&[[f64; 2]]]) -> Value {
    json!({"type": "Polygon", "coordinates": placed(rings)})
}

fn placed(rings: &[&[[f64; 2]]]) -> Vec<Vec<[f64; 2]>> {
    rings.iter().map(|ring| ring.iter().map(|c| [c[0] + CORNER[0], c[1] + CORNER[1]]).collect()).collect()
}

const RD: Option<&str> = Some("urn:ogc:def:crs:EPSG::28992");
const ROOF: &[[f64; 2]] = &[[0.0, 0.0], [10.0, 0.0], [10.0, 8.0], [0.0, 8.0], [0.0, 0.0]];

/// Reconstructs the made-up house with these features.
fn with(features: &[Value], crs: Option<&str>, rest: &str) -> (Run, tempfile::TempDir) {
    let folder = house_folder();
    write_features(&folder.path().join("f.geojson"), features, crs);
    (run_in(folder.path(), "house.laz", "f.geojson", rest), folder)
}

/// Ids, outcomes and notes, in the order of the report, which holds what the model does.
fn outcomes(folder: &tempfile::TempDir) -> Vec<(String, String, String)> {
    let out = folder.path().join("out.city.json");
    let report = report_of(&out);
    let text = |value: &Value| value.as_str().unwrap_or_default().to_owned();
    let notes = |b: &Value| format!("{} {}", text(&b["detail"]), b["notes"]);
    let buildings = report["buildings"].as_array().unwrap();
    let all: Vec<_> = buildings.iter().map(|b| (text(&b["id"]), text(&b["outcome"]), notes(b))).collect();
    let model = json_of(&out);
    let objects = model["CityObjects"].as_object().unwrap();
    for (id, ..) in &all {
        assert_eq!(objects[id]["type"], "Building", "{id}");
    }
    assert_eq!(objects.values().filter(|o| o["type"] == "Building").count(), all.len());
    all
}

#[test]
fn footprints_elsewhere_are_told_with_both_extents() {
    let away =
        json!({"type": "Polygon", "coordinates": [[[1e5, 4e5], [100_010.0, 4e5], [1e5, 400_010.0], [1e5, 4e5]]]});
    let (run, folder) = with(&[feature(&json!("1"), &away)], RD, "");
    assert_ends(&run, 1, &["f.geojson, in EPSG:28992: found no overlap", "100000.00 to 100010.00", "84990"]);
    assert!(!folder.path().join("out.city.json").exists());
}

#[test]
fn footprints_in_another_system_need_its_name_only_where_the_file_has_none() {
    // A wrong name takes them elsewhere.
    let (run, folder) = with(&[feature(&json!("1"), &polygon(&[ROOF]))], RD, "--footprint-crs EPSG:25831");
    assert_ends(&run, 1, &["EPSG:25831", "no overlap"]);
    assert!(!folder.path().join("out.city.json").exists());

    // GeoJSON without a CRS is in degrees (RFC 7946); what cannot be degrees is taken to be in that of the tiles.
    let (run, folder) = with(&[feature(&json!("1"), &polygon(&[ROOF]))], None, "");
    assert_ends(&run, 0, &["f.geojson"]);
    assert_eq!(outcomes(&folder)[0].1, "lod22");
}

/// The Shapefile of this ring, id 0042, without a `.prj`.
pub fn write_shapefile(path: &Path, ring: &[[f64; 2]]) {
    use shapefile::dbase::{FieldName, TableWriterBuilder};
    let table = TableWriterBuilder::new().add_character_field(FieldName::try_from("id").unwrap(), 20);
    let mut writer = shapefile::Writer::from_path(path, table).unwrap();
    let points = ring.iter().map(|c| shapefile::Point::new(c[0], c[1])).collect();
    let polygon = shapefile::Polygon::new(shapefile::PolygonRing::Outer(points));
    let mut record = shapefile::dbase::Record::default();
    record.insert("id".to_owned(), shapefile::dbase::FieldValue::Character(Some("0042".to_owned())));
    writer.write_shape_and_record(&polygon, &record).unwrap();
}

#[test]
fn degrees_that_are_not_declared_are_recognised() {
    let folder = house_folder();
    write_shapefile(&folder.path().join("f.shp"), &[[4.37, 52.0], [4.37, 52.01], [4.38, 52.01], [4.37, 52.0]]);
    let run = run_in(folder.path(), "house.laz", "f.shp", "");
    assert_ends(&run, 1, &["f.shp", "found no overlap", "degrees", "--footprint-crs EPSG:4326"]);
}

#[test]
fn every_kind_of_bad_geometry_comes_out_again() {
    let twice: &[[f64; 2]] = &[[0.0, 0.0], [10.0, 0.0], [10.0, 0.0], [10.0, 8.0], [10.0, 8.0], [0.0, 8.0], [0.0, 0.0]];
    let spike: &[[f64; 2]] =
        &[[0.0, 0.0], [10.0, 0.0], [10.0, 4.0], [30.0, 4.0], [10.0, 4.0], [10.0, 8.0], [0.0, 8.0], [0.0, 0.0]];
    let bow: &[[f64; 2]] = &[[0.0, 0.0], [10.0, 8.0], [10.0, 0.0], [0.0, 8.0], [0.0, 0.0]];
    let crossing: &[[f64; 2]] = &[
        [0.0, 0.0],
        [10.0, 0.0],
        [10.0, 8.0],
        [4.0, 8.0],
        [4.0, -1.0],
        [2.0, -1.0],
        [2.0, 8.0],
        [0.0, 8.0],
        [0.0, 0.0],
    ];
    let outside: &[[f64; 2]] = &[[14.0, 1.0], [16.0, 1.0], [16.0, 3.0], [14.0, 3.0], [14.0, 1.0]];
    let flat: &[[f64; 2]] = &[[0.0, 0.0], [10.0, 0.0], [5.0, 0.0], [0.0, 0.0]];
    let infinite = json!({"type": "Polygon", "coordinates": [[[85_000.0, 447_000.0], [1e300, 447_000.0], [85_000.0, 1e300], [85_000.0, 447_000.0]]]});
    let cases = [
        ("good", polygon(&[ROOF]), "lod22", ""),
        ("twice", polygon(&[twice]), "lod22", ""),
        ("spike", polygon(&[spike]), "lod22", ""),
        ("bow-tie", polygon(&[bow]), "lod22", ""),
        ("crossing", polygon(&[crossing]), "lod22", ""),
        ("hole-outside", polygon(&[ROOF, outside]), "lod22", ""),
        ("overlapping", polygon(&[&[[2.0, 2.0], [8.0, 2.0], [8.0, 6.0], [2.0, 6.0], [2.0, 2.0]]]), "lod22", ""),
        ("the-same", polygon(&[ROOF]), "lod22", ""),
        ("empty", json!({"type": "Polygon", "coordinates": []}), "rejected", "empty"),
        ("empty-multi", json!({"type": "MultiPolygon", "coordinates": []}), "rejected", "empty"),
        ("null", Value::Null, "rejected", "no geometry"),
        ("line", line(), "rejected", "LineString"),
        ("point", json!({"type": "Point", "coordinates": CORNER}), "rejected", "Point"),
        ("flat", polygon(&[flat]), "rejected", "area"),
        ("infinite", infinite, "rejected", "a coordinate of 1e300 lies on no map"),
        (
            "giant",
            polygon(&[&[[0.0, 0.0], [6000.0, 0.0], [10.0, 8.0], [0.0, 0.0]]]),
            "rejected",
            "it extends over 6000 m",
        ),
        ("mixed", json!({"type": "GeometryCollection", "geometries": [line(), polygon(&[ROOF])]}), "lod22", ""),
    ];
    let features: Vec<Value> = cases.iter().map(|(id, geometry, ..)| feature(&json!(id), geometry)).collect();
    let (run, folder) = with(&features, RD, "");
    assert_ends(&run, 2, &["17 features have no usable polygon and are written without geometry"]);
    assert_says(&run.out, &["without a model:", "  null: rejected (no usable polygon", "  line: rejected"]);
    let found = outcomes(&folder);
    assert_eq!(found.len(), cases.len());
    for (id, _, outcome, says) in &cases {
        let (_, is, notes) = found.iter().find(|(other, ..)| other == id).unwrap();
        assert_eq!(is, outcome, "{id}: {notes}");
        assert!(notes.contains(says), "{id}: {notes}");
    }
    // What was changed is said.
    for id in ["bow-tie", "crossing", "hole-outside", "spike"] {
        let (_, _, notes) = found.iter().find(|(other, ..)| other == id).unwrap();
        assert!(notes.len() > 4, "{id}: {notes}");
    }
}

#[test]
fn ids_survive_as_they_stand_and_become_unique() {
    let at = |i: u32| {
        let x = 2.0 * f64::from(i);
        polygon(&[&[[x, 0.0], [x + 2.0, 0.0], [x + 2.0, 8.0], [x, 8.0], [x, 0.0]]])
    };
    let ids = [json!("0042"), json!(9_007_199_254_740_993_u64), json!("Zoë’s 家/\"1\""), Value::Null, json!("0042")];
    let features: Vec<Value> = (0..).zip(&ids).map(|(i, id)| feature(id, &at(i))).collect();
    let (run, folder) = with(&features, RD, "--id-attribute id");
    assert_ends(&run, 0, &["f.geojson: "]);
    let found = outcomes(&folder);
    let names: Vec<&str> = found.iter().map(|(id, ..)| id.as_str()).collect();
    assert_eq!(names[..3], ["0042", "9007199254740993", "Zoë’s 家/\"1\""]);
    assert!(!names[3].is_empty() && names[4] != "0042", "{names:?}");
    assert!(found[3].2.len() > 4 && found[4].2.len() > 4, "what was made up is said: {found:?}");
    let model = json_of(folder.path().join("out.city.json"));
    assert_eq!(model["CityObjects"]["9007199254740993"]["attributes"]["id"], 9_007_199_254_740_993_u64);
}

#[test]
fn a_thousand_parts_are_one_building() {
    let cell = |i: u32| {
        let (x, y) = (f64::from(i % 40) * 0.25, f64::from(i / 40) * 0.32);
        placed(&[&[[x, y], [x + 0.2, y], [x + 0.2, y + 0.25], [x, y + 0.25], [x, y]]])
    };
    let parts: Vec<_> = (0..1000).map(cell).collect();
    let started = std::time::Instant::now();
    let (run, folder) =
        with(&[feature(&json!("many"), &json!({"type": "MultiPolygon", "coordinates": parts}))], RD, "");
    assert!(matches!(run.code, 0 | 2), "{}{}", run.out, run.err);
    assert!(started.elapsed().as_secs() < 60, "{:?}", started.elapsed());
    assert_eq!(outcomes(&folder).len(), 1);
}

#[test]
fn files_that_are_no_footprints_are_refused() {
    let folder = house_folder();
    let cases: [(&str, &[u8], &str); 7] = [
        ("zero.geojson", b"", "zero.geojson"),
        ("half.geojson", br#"{"type":"FeatureCollection","features":[{"type":"Fea"#, "half.geojson"),
        ("other.geojson", br#"{"type":"Topology"}"#, "other.geojson"),
        ("none.geojson", br#"{"type":"FeatureCollection","features":[]}"#, "found no feature, expected footprints"),
        ("bad.gpkg", b"SQLite format 3\0 and no more", "bad.gpkg"),
        ("bad.shp", b"\x00\x00\x27\x0a and no more", "bad.shp"),
        ("bad.fgb", b"fgb\x03fgb\x00 and no more", "bad.fgb"),
    ];
    for (name, content, says) in cases {
        std::fs::write(folder.path().join(name), content).unwrap();
        let run = run_in(folder.path(), "house.laz", name, "");
        assert_ends(&run, 1, &[name, says, "found", "expected"]);
        assert!(!folder.path().join("out.city.json").exists(), "{name}");
    }
}

#[test]
fn a_shapefile_without_its_parts_is_used_and_told() {
    let folder = house_folder();
    let path = folder.path().join("f.shp");
    let parts = ["shp", "shx", "dbf"].map(|part| path.with_extension(part));
    let ring = [[0.0, 0.0], [0.0, 8.0], [10.0, 8.0], [10.0, 0.0], [0.0, 0.0]];
    let ring = ring.map(|c: [f64; 2]| [c[0] + CORNER[0], c[1] + CORNER[1]]);
    write_shapefile(&path, &ring);
    let whole = parts.clone().map(|part| std::fs::read(part).unwrap());
    for (lost, code, says) in [
        ("shx", 2, "f.shp: there is no .shx beside it"),
        ("dbf", 2, "f.shp: there is no .dbf beside it"),
        // The one footprint has no geometry left.
        ("shp", 1, "f.shp: it is cut off: 1 of 1 shapes are missing"),
    ] {
        for (part, content) in parts.iter().zip(&whole) {
            std::fs::write(part, content).unwrap();
        }
        let part = path.with_extension(lost);
        if lost == "shp" {
            std::fs::write(&part, &whole[0][..whole[0].len() - 20]).unwrap();
        } else {
            std::fs::remove_file(&part).unwrap();
        }
        let run = run_in(folder.path(), "house.laz", "f.shp", "--overwrite");
        assert_ends(&run, code, &[says]);
    }
}
