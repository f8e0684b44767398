//! OBJ, `GeoPackage` and 3D Tiles, read back by other means than they were written.

use std::collections::BTreeMap;
use std::path::Path;

use geo::Area;
use rusqlite::Connection;

use super::*;
use crate::source::footprints::{self, FootprintOptions};

/// The files of a folder, or the file itself, with their bytes.
fn tree(path: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut out = BTreeMap::new();
    let mut left = vec![path.to_path_buf()];
    while let Some(path) = left.pop() {
        if path.is_dir() {
            left.extend(fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path()));
        } else {
            out.insert(path.clone(), fs::read(&path).unwrap());
        }
    }
    out
}

fn write_any(folder: &tempfile::TempDir, name: &str, buildings: &[Building]) -> (PathBuf, Written) {
    let path = folder.path().join(name);
    let mut sink = create(&path, metadata(), true).unwrap();
    let mut encoder = encoder(buildings);
    for building in buildings {
        sink.write(&encoder.feature(building)).unwrap();
    }
    let written = sink.finish().unwrap();
    assert_eq!((written.features, written.objects), (4, 7));
    (path, written)
}

#[test]
fn an_obj_holds_closed_solids_by_object_and_class() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = write_any(&folder, "out.obj", &neighbourhood());
    let text = fs::read_to_string(&path).unwrap();
    assert!(text.contains("# offset 84900 447400 0\n") && text.contains("EPSG:7415"), "{text}");
    let (mut vertices, mut volumes, mut materials) = (Vec::new(), BTreeMap::<String, f64>::new(), BTreeSet::new());
    let mut object = String::new();
    for line in text.lines() {
        let (key, rest) = line.split_once(' ').unwrap();
        match key {
            "o" => rest.clone_into(&mut object),
            "v" => vertices.push(rest.split(' ').map(|c| c.parse::<f64>().unwrap()).collect::<Vec<_>>()),
            "usemtl" => drop(materials.insert(rest.to_owned())),
            "f" => {
                let corners: Vec<&Vec<f64>> =
                    rest.split(' ').map(|i| &vertices[i.parse::<usize>().unwrap() - 1]).collect();
                // A fan of tetrahedra from the origin.
                for pair in corners[1..].windows(2) {
                    let [a, b, c] = [corners[0], pair[0], pair[1]];
                    let six = a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0])
                        + a[2] * (b[0] * c[1] - b[1] * c[0]);
                    *volumes.entry(object.clone()).or_default() += six / 6.0;
                }
            }
            _ => {}
        }
    }
    // 8 × 6 × (3 + 2 / 2); (6² − 2² + 4²) × 9.5.
    assert!((volumes["huis/é_七_\"1\""] - 192.0).abs() < 1e-6, "{volumes:?}");
    assert!((volumes["A"] - 456.0).abs() < 1e-6, "{volumes:?}");
    assert!(vertices.contains(&vec![67.0, 97.0, -1.0]), "the corner of the house less the offset");
    let library = fs::read_to_string(path.with_extension("mtl")).unwrap();
    assert!(text.contains("mtllib out.mtl\n"));
    assert_eq!(materials, ["GroundSurface", "RoofSurface", "WallSurface"].map(str::to_owned).into());
    assert!(materials.iter().all(|name| library.contains(&format!("newmtl {name}\nKd "))));
}

#[test]
fn a_geopackage_is_read_as_footprints_with_typed_attributes() {
    let folder = tempfile::tempdir().unwrap();
    let (path, _) = write_any(&folder, "out.gpkg", &neighbourhood());
    let options = FootprintOptions { layer: Some("footprints".into()), ..FootprintOptions::default() };
    let layer = footprints::read(&path, &options).unwrap();
    assert_eq!(layer.crs.unwrap().code.as_deref(), Some("EPSG:7415"));
    let areas: Vec<(String, f64)> = layer
        .footprints
        .iter()
        .map(|f| (f.attributes.get("id").unwrap().as_str().unwrap().to_owned(), f.polygon.unsigned_area()))
        .collect();
    let expected = [(neighbourhood()[0].id.clone(), 48.0), ("A".to_owned(), 48.0), ("A-0".to_owned(), 9.0)];
    assert_eq!(areas.len(), 3);
    for ((id, area), (expected_id, expected_area)) in areas.iter().zip(&expected) {
        assert_eq!(id, expected_id);
        assert!((area - expected_area).abs() < 1e-6, "{area}");
    }

    let connection = Connection::open(&path).unwrap();
    let mut types: BTreeMap<String, String> = BTreeMap::new();
    let mut statement = connection.prepare("SELECT name, type FROM pragma_table_info('footprints')").unwrap();
    let rows = statement.query_map((), |row| Ok((row.get(0)?, row.get(1)?))).unwrap();
    types.extend(rows.map(Result::unwrap));
    let expected = [
        ("identificatie", "TEXT"),
        ("big", "INTEGER"),
        ("huge", "TEXT"),
        ("nested", "TEXT"),
        ("gable_success", "BOOLEAN"),
        ("gable_points", "INTEGER"),
        ("gable_height_ridge", "REAL"),
    ];
    for (name, kind) in expected {
        assert_eq!(types[name], kind, "{name}");
    }
    let one = |sql: &str| connection.query_row(sql, (), |row| row.get::<_, i64>(0)).unwrap();
    assert_eq!(one("SELECT count(*) FROM footprints WHERE geom IS NULL"), 1, "00012 has no geometry");
    assert_eq!(one("SELECT big = 9223372036854775807 FROM footprints WHERE fid = 1"), 1);
    assert_eq!(one("SELECT huge = '18446744073709551615' FROM footprints WHERE fid = 1"), 1);
    // Seven surfaces of the house at LoD 2.2 (four walls, two roofs, the ground), and one at LoD 0.
    assert_eq!(one("SELECT count(*) FROM faces WHERE lod = '2.2'"), 7);
    assert_eq!(
        one("SELECT count(*) FROM faces WHERE lod = '2.2' AND surface_type = 'RoofSurface' AND slope > 33.6"),
        2
    );
    assert_eq!(
        one("SELECT count(*) FROM faces f JOIN rtree_faces_geom r ON r.id = f.fid"),
        one("SELECT count(*) FROM faces")
    );
    assert_eq!(one("SELECT count(*) FROM rtree_footprints_geom WHERE minx > 84966 AND maxx < 84976"), 1);
    assert_eq!(one("SELECT count(*) FROM layer_styles"), 2);
    let check: String = connection.query_row("PRAGMA integrity_check", (), |row| row.get(0)).unwrap();
    assert_eq!(check, "ok");
}

#[test]
fn a_tileset_stands_in_delft_and_says_what_its_heights_are() {
    let folder = tempfile::tempdir().unwrap();
    let (path, written) = write_any(&folder, "out.3dtiles", &neighbourhood());
    let files = tree(&path);
    assert_eq!(files.values().map(|bytes| bytes.len() as u64).sum::<u64>(), written.bytes);
    let root: Value = serde_json::from_slice(&files[&path.join("tileset.json")]).unwrap();
    let transform: Vec<f64> =
        root["root"]["transform"].as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    // RD (84975, 447505) by another program, GDAL; X = N cos φ cos λ.
    let (latitude, longitude) = (52.011_484_f64.to_radians(), 4.367_216_f64.to_radians());
    let n = 6_378_137.0 / (1.0 - 0.006_694_379_99 * latitude.sin().powi(2)).sqrt();
    let expected = [
        n * latitude.cos() * longitude.cos(),
        n * latitude.cos() * longitude.sin(),
        n * (1.0 - 0.006_694_379_99) * latitude.sin(),
    ];
    for (found, expected) in transform[12..15].iter().zip(expected) {
        assert!((found - expected).abs() < 60.0, "{transform:?} and {expected:?}");
    }
    // Up is away from the centre of the earth.
    let up: f64 = (0..3).map(|i| transform[8 + i] * transform[12 + i]).sum();
    assert!(up > 6_300_000.0);
    assert_eq!(root["root"]["refine"], "REPLACE");
    let leaf = &root["root"]["children"][0];
    assert_eq!(leaf["content"]["uri"], "tiles/_block.glb");
    assert_eq!(leaf["children"][0]["content"]["uri"], "tiles/_fine.glb");
    // The ridge is at 5 m, the block at 4.4 m: less than the least error.
    assert_eq!((&leaf["geometricError"], &leaf["children"][0]["geometricError"]), (&json!(1.0), &json!(0.0)));
    let notes = written.notes.join("\n");
    assert!(notes.contains("above the ellipsoid") && notes.contains("1 of 4 features have no face"), "{notes}");
    // The binary part holds the ids.
    let glb = &files[&path.join("tiles/_fine.glb")];
    assert!(glb.starts_with(b"glTF") && glb.len() == u32::from_le_bytes(glb[8..12].try_into().unwrap()) as usize);
}

#[test]
fn the_same_features_give_the_same_bytes_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.obj", "a.gpkg", "a.3dtiles"] {
        let first = tree(&write_any(&folder, name, &neighbourhood()).0);
        let again = tree(&write_any(&folder, name, &neighbourhood()).0);
        assert!(first == again, "{name}");
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4, "nothing temporary is left");
}

#[test]
fn a_folder_that_is_no_tileset_is_not_replaced() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mine.3dtiles");
    fs::create_dir(&path).unwrap();
    fs::write(path.join("thesis.txt"), "years of work").unwrap();
    let message = create(&path, metadata(), true).err().unwrap().to_string();
    assert!(message.contains("tileset.json"), "{message}");
    let named = folder.path().join("tileset.json");
    assert!(create(&named, metadata(), true).err().unwrap().to_string().contains(".3dtiles"));
    let nowhere = Metadata { crs: None, ..metadata() };
    assert!(create(&folder.path().join("a.3dtiles"), nowhere, true).err().unwrap().to_string().contains("--crs"));
}

#[test]
fn an_empty_model_is_written_in_every_format() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["a.obj", "a.gpkg", "a.3dtiles"] {
        let written = create(&folder.path().join(name), metadata(), false).unwrap().finish().unwrap();
        assert_eq!(written.features, 0);
    }
}

#[test]
fn attributes_whose_names_are_taken_are_told() {
    let folder = tempfile::tempdir().unwrap();
    let mut buildings = neighbourhood();
    // The id says what the column of the format says; the others do not.
    let id = buildings[0].id.clone();
    for (name, value) in [
        ("id", json!(id)),
        ("type", json!("church")),
        ("fid", json!(7)),
        ("Big", json!(1)),
        ("attribute_type", json!("x")),
    ] {
        buildings[0].attributes.insert(name.to_owned(), value);
    }
    let (path, written) = write_any(&folder, "out.gpkg", &buildings);
    let told = written.notes.join("\n");
    for says in [r#""type" is "source_type""#, r#""fid" is "source_fid""#, r#""Big" is "Big_2""#] {
        assert!(told.contains(says), "{told}");
    }
    assert!(!told.contains(r#""id""#), "{told}");
    let connection = Connection::open(&path).unwrap();
    let row = connection.query_row(
        "SELECT id || source_type || source_fid || Big_2 FROM footprints WHERE fid = 1",
        (),
        |row| row.get::<_, String>(0),
    );
    assert_eq!(row.unwrap(), format!("{id}church71"));
    let (path, written) = write_any(&folder, "out.3dtiles", &buildings);
    let told = written.notes.join("\n");
    assert!(told.contains(r#"attributes "attribute_type", "type" have the names"#), "{told}");
    assert!(told.contains(r#""Big" is "Big_2""#) && !told.contains(r#""id""#), "{told}");
    let bytes: Vec<u8> = tree(&path).into_values().flatten().collect();
    let text = String::from_utf8_lossy(&bytes);
    assert!(text.contains("attribute_attribute_type") && text.contains("church"), "all of them are in the tiles");
    // Without a clash nothing is told.
    assert!(write_any(&folder, "plain.gpkg", &neighbourhood()).1.notes.iter().all(|note| !note.contains("taken")));
}

#[test]
fn an_attribute_that_says_what_the_id_says_has_no_column_of_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let columns = |path: &Path| -> Vec<String> {
        let connection = Connection::open(path).unwrap();
        let statement = connection.prepare("SELECT * FROM footprints").unwrap();
        statement.column_names().into_iter().map(str::to_owned).collect()
    };
    let mut buildings = neighbourhood();
    // Some have it, one has it without a value, one lacks it.
    for i in [0, 2] {
        let id = json!(buildings[i].id.clone());
        buildings[i].attributes.insert("ID".into(), id);
    }
    buildings[3].attributes.insert("ID".into(), json!(null));
    let (path, written) = write_any(&folder, "same.gpkg", &buildings);
    assert!(columns(&path).iter().all(|name| !name.contains("ID")), "{:?}", columns(&path));
    assert!(written.notes.iter().all(|note| !note.contains("taken")), "{:?}", written.notes);

    // The last one says something else: all that was said is kept.
    buildings[3].attributes.insert("ID".into(), json!("other"));
    let (path, written) = write_any(&folder, "other.gpkg", &buildings);
    assert!(columns(&path).contains(&"source_ID".to_owned()), "{:?}", columns(&path));
    assert!(written.notes.join("").contains(r#""ID" is "source_ID""#), "{:?}", written.notes);
    let connection = Connection::open(&path).unwrap();
    let mut statement = connection.prepare("SELECT source_ID FROM footprints ORDER BY fid").unwrap();
    let said: Vec<Option<String>> = statement.query_map((), |row| row.get(0)).unwrap().map(Result::unwrap).collect();
    let id = |i: usize| Some(buildings[i].id.clone());
    assert_eq!(said, [id(0), None, id(2), Some("other".into())]);
    let version: i64 = connection.pragma_query_value(None, "user_version", |row| row.get(0)).unwrap();
    assert_eq!(version, 10_300);
}
