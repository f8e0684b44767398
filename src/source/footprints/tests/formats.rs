//! GeoPackage, SpatiaLite, Shapefile and FlatGeobuf, written by the tests themselves.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use geo::{Area, Contains};
use serde_json::{Value, json};
use tempfile::TempDir;

use super::super::{FootprintLayer, FootprintOptions, read};
use super::{assert_sound, ids, plain};

/// A well-known binary polygon of one ring, with z where wanted.
fn wkb(kind: u32, ring: &[[f64; 3]], dimensions: usize) -> Vec<u8> {
    let mut bytes = vec![1];
    for number in [kind, 1, ring.len() as u32] {
        bytes.extend(number.to_le_bytes());
    }
    for point in ring {
        point[..dimensions].iter().for_each(|c| bytes.extend(c.to_le_bytes()));
    }
    bytes
}

const RING: [[f64; 3]; 5] = [[0.0, 0.0, 1.0], [0.0, 10.0, 2.0], [10.0, 10.0, 3.0], [10.0, 0.0, 4.0], [0.0, 0.0, 1.0]];

#[test]
fn geopackages_with_layers_and_all_kinds_of_values() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.gpkg");
    let database = rusqlite::Connection::open(&path).unwrap();
    database
        .execute_batch(
            "PRAGMA page_size = 512;
             CREATE TABLE gpkg_contents (table_name TEXT, data_type TEXT, srs_id INTEGER);
             CREATE TABLE gpkg_geometry_columns (table_name TEXT, column_name TEXT, geometry_type_name TEXT, srs_id INTEGER);
             CREATE TABLE gpkg_spatial_ref_sys (srs_id INTEGER, organization TEXT, organization_coordsys_id INTEGER, definition TEXT);
             INSERT INTO gpkg_spatial_ref_sys VALUES (28992, 'EPSG', 28992, 'undefined');
             INSERT INTO gpkg_contents VALUES ('pand', 'features', 28992), ('wegen', 'features', 28992);
             INSERT INTO gpkg_geometry_columns VALUES ('pand', 'geom', 'MULTIPOLYGON', 28992), ('wegen', 'geom', 'LINESTRING', 28992);
             CREATE TABLE pand (fid INTEGER PRIMARY KEY, geom BLOB, identificatie TEXT, big INTEGER, ok BOOLEAN, day DATE, photo BLOB, h REAL);
             CREATE TABLE wegen (fid INTEGER PRIMARY KEY, geom BLOB);",
        )
        .unwrap();
    let header = [b"GP\0\x01".as_slice(), &28992_i32.to_le_bytes()].concat();
    let blob = |wkb: &[u8]| [header.as_slice(), wkb].concat();
    let curve = [vec![1], 10_u32.to_le_bytes().to_vec(), 1_u32.to_le_bytes().to_vec()].concat();
    let greedy = [vec![1], 3_u32.to_le_bytes().to_vec(), u32::MAX.to_le_bytes().to_vec()].concat();
    let insert = "INSERT INTO pand VALUES (?1, ?2, ?3, 9007199254740993, 1, '2020-01-31', x'00', 2.5)";
    let mut infinite = RING;
    infinite[1][0] = f64::INFINITY;
    for (fid, geometry, id) in [
        (1, Some(blob(&wkb(1003, &RING, 3))), "0001"),
        (2, Some(wkb(3, &RING, 2)), "0002"),
        (3, None, "0003"),
        (4, Some(blob(&curve)), "0004"),
        (5, Some(blob(&greedy)), "0005"),
        (6, Some(blob(&wkb(3, &infinite, 2))), "0006"),
        (7, Some([b"GP\0\0".as_slice(), &28992_i32.to_be_bytes(), &wkb(3, &RING, 2)].concat()), "0007"),
    ] {
        database.execute(insert, (fid, geometry, id)).unwrap();
    }
    drop(database);
    let layer = plain(&path);
    assert_eq!((layer.layer.as_str(), ids(&layer)), ("pand", vec!["0001", "0002", "0007"]));
    assert_eq!(layer.crs.as_ref().unwrap().code.as_deref(), Some("EPSG:28992"));
    let expected = json!({"fid": 1, "identificatie": "0001", "big": 9_007_199_254_740_993_i64, "ok": true,
        "day": "2020-01-31", "h": 2.5});
    assert_eq!(Value::Object(layer.footprints[0].attributes.to_map()), expected);
    assert_eq!(layer.footprints[0].polygon.unsigned_area(), 100.0);
    assert!(layer.warnings.iter().any(|w| w.contains("`photo`")));
    let reasons: Vec<_> = layer.rejected.iter().map(|r| r.reason.as_str()).collect();
    for (reason, says) in
        reasons.iter().zip(["no geometry", "cannot be understood", "cannot be understood", "not finite"])
    {
        assert!(reason.contains(says), "{reason}");
    }
    assert_sound(&layer);
    let roads = read(&path, &FootprintOptions { layer: Some("WEGEN".into()), ..Default::default() }).unwrap();
    assert!(roads.layer == "wegen" && roads.footprints.is_empty());
    let error = read(&path, &FootprintOptions { layer: Some("huis".into()), ..Default::default() }).unwrap_err();
    assert!(error.to_string().contains("pand, wegen"), "{error}");
    assert_damage_is_survived(&path, &path, DATABASE_STEP);
}

/// What GDAL and the standard write for a system that nobody stated.
#[test]
fn geopackages_without_a_system_say_none() {
    let undefined = r#"LOCAL_CS["Undefined SRS",LOCAL_DATUM["unknown",32767],UNIT["unknown",0],AXIS["Easting",EAST],AXIS["Northing",NORTH]]"#;
    for (number, organisation, definition) in
        [(99_999, "GDAL", undefined), (-1, "NONE", "undefined"), (0, "NONE", "undefined")]
    {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("made.gpkg");
        let database = rusqlite::Connection::open(&path).unwrap();
        database
            .execute_batch(&format!(
                "CREATE TABLE gpkg_contents (table_name TEXT, data_type TEXT, srs_id INTEGER);
                 CREATE TABLE gpkg_geometry_columns (table_name TEXT, column_name TEXT, geometry_type_name TEXT, srs_id INTEGER);
                 CREATE TABLE gpkg_spatial_ref_sys (srs_id INTEGER, organization TEXT, organization_coordsys_id INTEGER, definition TEXT);
                 INSERT INTO gpkg_spatial_ref_sys VALUES ({number}, '{organisation}', {number}, '{definition}');
                 INSERT INTO gpkg_contents VALUES ('pand', 'features', {number});
                 INSERT INTO gpkg_geometry_columns VALUES ('pand', 'geom', 'POLYGON', {number});
                 CREATE TABLE pand (fid INTEGER PRIMARY KEY, geom BLOB);"
            ))
            .unwrap();
        let header = [b"GP\0\x01".as_slice(), &i32::to_le_bytes(number)].concat();
        let blob = [header.as_slice(), &wkb(3, &RING, 2)].concat();
        database.execute("INSERT INTO pand VALUES (1, ?1)", [blob]).unwrap();
        drop(database);
        let layer = plain(&path);
        assert_eq!((layer.footprints.len(), layer.crs.is_none()), (1, true), "{number}: {:?}", layer.crs);
    }
}

/// Views are programs. These yield rows for ever, work for ever on the first, or make values beyond all measure.
#[test]
fn views_without_end_are_told_soon() {
    let endless = "WITH RECURSIVE r(i) AS (SELECT 1 UNION ALL SELECT i + 1 FROM r)";
    let views = [
        (format!("{endless} SELECT i AS fid, randomblob(1000) AS geom FROM r"), "more than"),
        (format!("{endless} SELECT i AS fid, x'00' AS geom FROM r WHERE i < 0"), "interrupted"),
        ("SELECT 1 AS fid, zeroblob(900000000) AS geom".to_owned(), "too big"),
    ];
    for (view, says) in views {
        let folder = TempDir::new().unwrap();
        let path = folder.path().join("made.gpkg");
        let database = rusqlite::Connection::open(&path).unwrap();
        database
            .execute_batch(&format!(
                "CREATE TABLE gpkg_contents (table_name TEXT, data_type TEXT, srs_id INTEGER);
                 CREATE TABLE gpkg_geometry_columns (table_name TEXT, column_name TEXT, geometry_type_name TEXT, srs_id INTEGER);
                 INSERT INTO gpkg_contents VALUES ('v', 'features', 0);
                 INSERT INTO gpkg_geometry_columns VALUES ('v', 'geom', 'POLYGON', 0);
                 CREATE VIEW v AS {view};"
            ))
            .unwrap();
        drop(database);
        let error = read(&path, &FootprintOptions::default()).unwrap_err().to_string();
        assert!(error.contains("made.gpkg: found tables or views without end") && error.contains(says), "{error}");
    }
}

#[test]
fn spatialite_blobs() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.sqlite");
    let database = rusqlite::Connection::open(&path).unwrap();
    database
        .execute_batch(
            "PRAGMA page_size = 512;
             CREATE TABLE geometry_columns (f_table_name TEXT, f_geometry_column TEXT, geometry_type INTEGER, coord_dimension INTEGER, srid INTEGER, spatial_index_enabled INTEGER);
             CREATE TABLE spatial_ref_sys (srid INTEGER, auth_name TEXT, auth_srid INTEGER, ref_sys_name TEXT, proj4text TEXT, srtext TEXT);
             INSERT INTO geometry_columns VALUES ('h', 'geometry', 3, 2, 2154, 0);
             INSERT INTO spatial_ref_sys VALUES (2154, 'epsg', 2154, '', '', '');
             CREATE TABLE h (pk INTEGER PRIMARY KEY, geometry BLOB);",
        )
        .unwrap();
    let mut blob = vec![0, 1];
    blob.extend(2154_i32.to_le_bytes());
    for c in [0.0_f64, 0.0, 10.0, 10.0] {
        blob.extend(c.to_le_bytes());
    }
    blob.push(0x7C);
    blob.extend(&wkb(3, &RING, 2)[1..]);
    blob.push(0xFE);
    database.execute("INSERT INTO h VALUES (1, ?1)", [blob]).unwrap();
    drop(database);
    let layer = plain(&path);
    assert_eq!(layer.crs.as_ref().unwrap().code.as_deref(), Some("EPSG:2154"));
    assert_eq!(layer.footprints[0].polygon.unsigned_area(), 100.0, "{:?}", layer.rejected);
    assert_damage_is_survived(&path, &path, DATABASE_STEP);
}

#[test]
fn shapefiles_with_holes_long_numbers_and_accents() {
    use ::shapefile::dbase::{FieldName, TableWriterBuilder};
    use ::shapefile::{Point, PolygonRing, Writer};
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.shp");
    let table = TableWriterBuilder::new().add_character_field(FieldName::try_from("NAME").unwrap(), 20);
    let table = table.add_numeric_field(FieldName::try_from("LONGID").unwrap(), 18, 0);
    let ring = |x: f64, side: f64, clockwise: bool| {
        let mut points = vec![Point::new(x, x), Point::new(x, x + side), Point::new(x + side, x + side)];
        points.extend([Point::new(x + side, x), Point::new(x, x)]);
        if clockwise { PolygonRing::Outer(points) } else { PolygonRing::Inner(points) }
    };
    let mut writer = Writer::from_path(&path, table).unwrap();
    let mut record = ::shapefile::dbase::Record::default();
    record.insert("NAME".into(), ::shapefile::dbase::FieldValue::Character(Some("X".into())));
    record.insert("LONGID".into(), ::shapefile::dbase::FieldValue::Numeric(Some(1.0)));
    let rings = vec![ring(0.0, 10.0, true), ring(20.0, 5.0, true), ring(21.0, 1.0, false), ring(2.0, 4.0, false)];
    writer.write_shape_and_record(&::shapefile::Polygon::with_rings(rings), &record).unwrap();
    writer.write_shape_and_record(&::shapefile::Polygon::new(ring(50.0, 2.0, true)), &record).unwrap();
    drop(writer);
    // A number beyond the precision of f64 and a name in Latin-1, as they stand in many tables.
    let mut dbf = fs::read(path.with_extension("dbf")).unwrap();
    let start = usize::from(u16::from_le_bytes([dbf[8], dbf[9]])) + 1;
    dbf[start..start + 20].copy_from_slice(b"  Caf\xe9 du  Nord     ");
    dbf[start + 20..start + 38].copy_from_slice(b"123456789012345679");
    fs::write(path.with_extension("dbf"), dbf).unwrap();
    fs::write(path.with_extension("cpg"), "ISO-8859-1").unwrap();
    // The last shape is cut off.
    let shp = fs::read(&path).unwrap();
    fs::write(&path, &shp[..shp.len() - 20]).unwrap();
    assert_damage_is_survived(&path, &path, 1);
    assert_damage_is_survived(&path, &path.with_extension("dbf"), 1);
    let options = FootprintOptions { id_attribute: Some("longid".into()), ..Default::default() };
    let layer = read(&path, &options).unwrap();
    assert_eq!(ids(&layer), ["123456789012345679"]);
    assert_eq!(layer.footprints[0].attributes.to_map()["NAME"], json!("  Café du  Nord"));
    let polygon = &layer.footprints[0].polygon;
    assert_eq!(polygon.0.len(), 2);
    assert_eq!(polygon.unsigned_area(), 100.0 - 16.0 + 25.0 - 1.0);
    assert!(polygon.contains(&geo::Point::new(21.0, 23.0)) && !polygon.contains(&geo::Point::new(3.0, 3.0)));
    assert!(layer.rejected.len() == 1 && layer.rejected[0].reason.contains("ends within"), "{:?}", layer.rejected);
    assert!(layer.crs.is_none() && layer.warnings.iter().any(|w| w.contains(".prj")));
    assert_sound(&layer);
    // A `.cpg` that lies is told, and the name is read all the same.
    assert!(layer.warnings.iter().all(|w| !w.contains("are not in")), "{:?}", layer.warnings);
    fs::write(path.with_extension("cpg"), "UTF-8").unwrap();
    let lying = read(&path, &options).unwrap();
    assert_eq!(lying.footprints[0].attributes.to_map()["NAME"], json!("  Café du  Nord"));
    let told = |w: &String| w.contains("1 value(s) of the .dbf are not in UTF-8") && w.contains("`NAME` of record 1");
    assert!(lying.warnings.iter().any(told), "{:?}", lying.warnings);
}

/// A shapefile of so many squares with the attribute `id`, and the bytes of its `.shp`, `.shx` and `.dbf`.
fn squares(folder: &TempDir, count: usize) -> (PathBuf, [Vec<u8>; 3]) {
    use ::shapefile::dbase::{FieldName, FieldValue, Record, TableWriterBuilder};
    use ::shapefile::{Point, Polygon, PolygonRing, Writer};
    let path = folder.path().join("squares.shp");
    let table = TableWriterBuilder::new().add_character_field(FieldName::try_from("id").unwrap(), 8);
    let mut writer = Writer::from_path(&path, table).unwrap();
    for i in 0..count {
        let x = 10.0 * i as f64;
        let ring = [(x, 0.0), (x, 5.0), (x + 5.0, 5.0), (x + 5.0, 0.0)].map(|(x, y)| Point::new(x, y));
        let mut record = Record::default();
        record.insert("id".into(), FieldValue::Character(Some(format!("b{i}"))));
        writer.write_shape_and_record(&Polygon::new(PolygonRing::Outer(ring.to_vec())), &record).unwrap();
    }
    drop(writer);
    let bytes = ["shp", "shx", "dbf"].map(|part| fs::read(path.with_extension(part)).unwrap());
    (path, bytes)
}

#[test]
fn a_shapefile_says_which_of_its_parts_it_lacks() {
    let folder = TempDir::new().unwrap();
    let (path, parts) = squares(&folder, 4);
    let layer_with = |shorter: &[(&str, usize)]| {
        for (part, bytes) in ["shp", "shx", "dbf"].iter().zip(&parts) {
            let at = path.with_extension(part);
            match shorter.iter().find(|(name, _)| name == part) {
                Some((_, 0)) => fs::remove_file(&at).unwrap_or_default(),
                Some((_, by)) => fs::write(&at, &bytes[..bytes.len() - by]).unwrap(),
                None => fs::write(&at, bytes).unwrap(),
            }
        }
        read(&path, &FootprintOptions::default()).unwrap()
    };
    let lacks = |layer: &FootprintLayer| {
        let beside = [".prj", "numbered"];
        let warnings = layer.warnings.iter().filter(|warning| !beside.iter().any(|word| warning.contains(word)));
        warnings.cloned().collect::<Vec<_>>().join("; ")
    };
    let record = (parts[0].len() - 100) / 4;
    let whole = layer_with(&[]);
    assert_eq!((whole.footprints.len(), whole.is_damaged, lacks(&whole).as_str()), (4, false, ""));

    for (shorter, footprints, rejected, missing, says) in [
        // The table tells of the shapes that are gone; the index does where there is no table.
        (&[("shp", record)][..], 3, 1, 0, "it is cut off: 1 of 4 shapes are missing"),
        (&[("shp", record + 9)], 2, 2, 0, "it is cut off: 2 of 4 shapes are missing"),
        (&[("shp", 2 * record), ("dbf", 0)], 2, 0, 2, "it is cut off: 2 of 4 shapes are missing"),
        (&[("shp", 2 * record), ("dbf", 0), ("shx", 0)], 2, 0, 0, "shorter than it says"),
        (&[("dbf", 0)], 4, 0, 0, "there is no .dbf beside it"),
        (&[("dbf", 12)], 4, 0, 0, "the .dbf beside it is cut off: 2 of 4 features have no attributes"),
        (&[("shx", 0)], 4, 0, 0, "there is no .shx beside it"),
        (&[("shx", 3)], 4, 0, 0, "the .shx beside it is cut off"),
    ] {
        let layer = layer_with(shorter);
        let found = (layer.footprints.len(), layer.rejected.len(), layer.missing);
        assert_eq!(found, (footprints, rejected, missing), "{shorter:?}: {:?}", layer.warnings);
        assert!(layer.is_damaged && lacks(&layer).contains(says), "{shorter:?}: {:?}", layer.warnings);
    }
}

#[test]
fn flatgeobuf_with_a_header_crs_and_damage() {
    use ::flatgeobuf::{ColumnType, FgbCrs, FgbWriter, FgbWriterOptions, GeometryType};
    use geozero::{ColumnValue, PropertyProcessor};
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.fgb");
    let options =
        FgbWriterOptions { crs: FgbCrs { code: 28992, ..Default::default() }, write_index: true, ..Default::default() };
    let mut writer = FgbWriter::create_with_options("panden", GeometryType::MultiPolygon, options).unwrap();
    writer.add_column("fid", ColumnType::ULong, |_, _| {});
    writer.add_column("name", ColumnType::String, |_, _| {});
    for i in 0..3_u32 {
        let x = f64::from(i) * 100.0;
        let shape = geo::Geometry::Polygon(geo::Rect::new((x, 0.0), (x + 10.0, 20.0)).to_polygon());
        writer
            .add_feature_geom(shape, |feature| {
                feature.property(0, "fid", &ColumnValue::ULong(u64::MAX - u64::from(i))).unwrap();
                feature.property(1, "name", &ColumnValue::String("no. 1")).unwrap();
            })
            .unwrap();
    }
    let mut bytes = Vec::new();
    writer.write(&mut bytes).unwrap();
    fs::write(&path, &bytes).unwrap();
    let layer = plain(&path);
    assert_eq!((layer.layer.as_str(), layer.footprints.len()), ("panden", 3));
    assert_eq!(layer.crs.as_ref().unwrap().code.as_deref(), Some("EPSG:28992"));
    let mut sorted = ids(&layer);
    sorted.sort_unstable();
    assert_eq!(sorted, ["18446744073709551613", "18446744073709551614", "18446744073709551615"]);
    assert_eq!(layer.footprints[0].attributes.to_map()["name"], json!("no. 1"));
    assert_eq!(layer.footprints[0].polygon.unsigned_area(), 200.0);
    assert_sound(&layer);
    for cut in (0..bytes.len()).step_by(7) {
        fs::write(&path, &bytes[..cut]).unwrap();
        if let Ok(layer) = read(&path, &FootprintOptions::default()) {
            let n = layer.footprints.len();
            assert_eq!(layer.missing, 3 - n as u64, "cut at {cut}");
            assert!(n == 3 || layer.warnings[0].contains(&format!("cut off: {} of 3", 3 - n)), "{:?}", layer.warnings);
        }
    }
    fs::write(&path, &bytes).unwrap();
    assert_damage_is_survived(&path, &path, 1);
}

/// Every so many bytes of a database are damaged: pages are mostly empty, and opening one takes a while.
const DATABASE_STEP: usize = 11;

/// Damages one byte of `part` after the other, or every `step`th, and cuts it off in places: reading `path` gives a sound
/// layer or an error that names the file, and soon. Puts `part` back.
fn assert_damage_is_survived(path: &Path, part: &Path, step: usize) {
    let bytes = fs::read(part).unwrap();
    let survives = |damaged: &[u8], what: &str| {
        fs::write(part, damaged).unwrap();
        let started = Instant::now();
        match read(path, &FootprintOptions::default()) {
            Ok(layer) => assert_sound(&layer),
            Err(error) => assert!(error.to_string().contains("made."), "{what}: {error}"),
        }
        assert!(started.elapsed() < Duration::from_secs(20), "{what} took {:?}", started.elapsed());
    };
    for at in (0..bytes.len()).step_by(step) {
        for mask in [0x01, 0xA5] {
            let mut damaged = bytes.clone();
            damaged[at] ^= mask;
            survives(&damaged, &format!("byte {at} ^ {mask:#x}"));
        }
    }
    for cut in (0..bytes.len()).step_by(bytes.len() / 50 + 1) {
        survives(&bytes[..cut], &format!("cut at {cut}"));
    }
    fs::write(part, bytes).unwrap();
}

#[test]
fn damaged_blobs_are_refused_or_read() {
    let whole = wkb(1003, &RING, 3);
    let blob = [b"GP\0\x01".as_slice(), &0_i32.to_le_bytes(), &whole].concat();
    let collection = [vec![1], 7_u32.to_le_bytes().to_vec(), 1_u32.to_le_bytes().to_vec()].concat();
    let nested = collection.repeat(100_000);
    assert!(super::super::wkb::outline(&nested).unwrap_err().contains("too deep"));
    for bytes in [whole, blob] {
        for at in 0..bytes.len() {
            assert!(super::super::wkb::outline(&bytes[..at]).is_err(), "cut at {at}");
            for bit in 0..8 {
                let mut damaged = bytes.clone();
                damaged[at] ^= 1 << bit;
                let _ = super::super::wkb::outline(&damaged).and_then(super::super::Outline::into_valid);
            }
        }
    }
}
