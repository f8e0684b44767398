//! Whole files through [`read`]: real ones, and small ones of every format that the tests write themselves.

use std::fs;

use geo::{Area, Contains, Distance, Euclidean, Validation, Winding};
use serde_json::json;
use tempfile::TempDir;

use super::*;

const RD: &str = r#""crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::28992"}},"#;

fn shared(file: &str) -> Option<PathBuf> {
    let path = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data")).join(file);
    if !path.exists() {
        println!("skipped: shared data not found");
        return None;
    }
    Some(path)
}

fn plain(path: impl AsRef<Path>) -> FootprintLayer {
    read(path.as_ref(), &FootprintOptions::default()).unwrap()
}

/// A GeoJSON file of these features.
fn geojson(folder: &TempDir, features: &[Value]) -> PathBuf {
    let path = folder.path().join("made.geojson");
    let features: Vec<String> = features.iter().map(Value::to_string).collect();
    fs::write(&path, format!(r#"{{"type":"FeatureCollection",{RD}"features":[{}]}}"#, features.join(","))).unwrap();
    path
}

fn square(x: f64, y: f64, side: f64) -> Value {
    json!([[x, y], [x + side, y], [x + side, y + side], [x, y + side], [x, y]])
}

fn polygon(properties: &Value, rings: &Value) -> Value {
    json!({"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": rings}})
}

fn ids(layer: &FootprintLayer) -> Vec<&str> {
    layer.footprints.iter().map(|f| f.id.as_str()).collect()
}

fn assert_sound(layer: &FootprintLayer) {
    for footprint in &layer.footprints {
        assert!(footprint.polygon.is_valid(), "{}", footprint.id);
        assert!(footprint.polygon.iter().all(|p| p.exterior().is_ccw()), "{}", footprint.id);
        assert!(footprint.polygon.iter().flat_map(|p| p.interiors()).all(Winding::is_cw), "{}", footprint.id);
    }
    let all = ids(layer).into_iter().chain(layer.rejected.iter().map(|r| r.id.as_str()));
    let unique: std::collections::HashSet<_> = all.clone().collect();
    assert_eq!(all.count(), unique.len());
}

#[test]
fn delft_in_two_reference_systems_agrees_within_the_stated_error() {
    let (Some(rd), Some(wgs84)) =
        (shared("delft-quickstart/footprints.geojson"), shared("delft-quickstart/footprints_wgs84.geojson"))
    else {
        return;
    };
    let (rd, mut wgs84) = (plain(rd), plain(wgs84));
    assert_eq!(rd.footprints.len(), 71);
    assert_eq!(ids(&rd), ids(&wgs84));
    assert!(rd.footprints[0].id == "NL.IMBAG.Pand.0503100000018603" && rd.id_attribute.as_deref() == Some("id"));
    assert_eq!(rd.crs.as_ref().unwrap().code.as_deref(), Some("EPSG:28992"));
    assert_eq!(wgs84.crs.as_ref().unwrap().code.as_deref(), Some("OGC:CRS84"));
    let cloud = Crs::parse("EPSG:7415").unwrap();
    let expected = Transformer::new(wgs84.crs.as_ref().unwrap(), &cloud, None).unwrap().accuracy().unwrap();
    let warnings = wgs84.reproject(&cloud).unwrap();
    assert!(warnings.len() == 1 && warnings[0].contains(" m"), "{warnings:?}");
    assert_sound(&wgs84);
    let worst = rd.footprints.iter().zip(&wgs84.footprints).fold(0.0_f64, |worst, (a, b)| {
        let pairs = a.polygon.0[0].exterior().points().zip(b.polygon.0[0].exterior().points());
        pairs.fold(worst, |worst, (p, q)| worst.max(Euclidean.distance(p, q)))
    });
    println!("worst distance {worst:.3} m, expected at most {expected} m: {}", warnings[0]);
    assert!(worst <= expected);
    let mut same = rd.clone();
    assert!(same.reproject(&cloud).unwrap().is_empty());
    assert_eq!(same.footprints[0].polygon, rd.footprints[0].polygon);
}

#[test]
fn delft_from_an_sqlite_file() {
    let Some(path) = shared("delft/bgt_pand.sqlite") else { return };
    let layer = plain(&path);
    assert_eq!((layer.footprints.len(), layer.rejected.len()), (160, 0));
    assert_eq!(layer.crs.as_ref().unwrap().code.as_deref(), Some("EPSG:28992"));
    assert_eq!(layer.id_attribute.as_deref(), Some("gml_id"));
    assert_eq!(layer.footprints[0].id, "b31e1feb1-00ba-11e6-b420-2bdcc4ab5d7f");
    assert_eq!(layer.footprints[0].attributes["identificatiebagpnd"], json!(503_100_000_018_603_i64));
    assert_eq!(layer.footprints[0].attributes["inonderzoek"], json!(false));
    assert!(!layer.footprints[0].attributes.contains_key("GEOMETRY"));
    assert_sound(&layer);
    let options = FootprintOptions {
        filter: Some("identificatieBAGpnd = 503100000018603".into()),
        id_attribute: Some("identificatiebagpnd".into()),
        ..FootprintOptions::default()
    };
    assert_eq!(ids(&read(&path, &options).unwrap()), ["503100000018603"]);
}

#[test]
fn ign_from_a_shapefile_in_space() {
    let Some(path) = shared("ign-rural/870000_6618000.subset.postIA.shp") else { return };
    let layer = plain(&path);
    assert_eq!(layer.footprints.len() + layer.rejected.len(), 40);
    assert_eq!(layer.footprints.len(), 40, "{:?}", layer.rejected);
    assert_eq!(layer.crs.as_ref().unwrap().code.as_deref(), Some("EPSG:2154"));
    assert_eq!(layer.footprints[0].attributes["PRESENCE"], json!(1));
    assert!(layer.id_attribute.is_none() && layer.footprints[0].id == "footprint-1");
    assert_sound(&layer);
    let extent = layer.extent().unwrap();
    assert!(extent.min().x > 8.6e5 && extent.max().y < 6.7e6);
    // Any part of a shapefile stands for the whole.
    assert_eq!(plain(path.with_extension("dbf")).footprints.len(), 40);
}

#[test]
fn ids_survive_and_become_unique_without_taking_another() {
    let folder = TempDir::new().unwrap();
    let with = |properties: Value, x: f64| polygon(&properties, &json!([square(x, 0.0, 5.0)]));
    let path = geojson(
        &folder,
        &[
            with(json!({"identificatie": "0503100000018603"}), 0.0),
            with(json!({"identificatie": "a b"}), 10.0),
            with(json!({"identificatie": "a b-2"}), 20.0),
            with(json!({"identificatie": "a b"}), 30.0),
            with(json!({"identificatie": null}), 40.0),
            with(json!({"identificatie": 18_446_744_073_709_551_615_u64}), 50.0),
            with(json!({"identificatie": " "}), 60.0),
            json!({"type": "Feature", "properties": {"identificatie": "a b"}, "geometry": null}),
        ],
    );
    let layer = plain(&path);
    assert_eq!(
        ids(&layer),
        ["0503100000018603", "a b", "a b-2", "a b-3", "footprint-5", "18446744073709551615", "footprint-7"]
    );
    assert_eq!(layer.rejected[0].id, "a b-4");
    assert!(layer.footprints[3].notes[0].contains("`a b-3`"), "{:?}", layer.footprints[3].notes);
    assert_eq!(layer.warnings.len(), 2, "{:?}", layer.warnings);
    let error = read(&path, &FootprintOptions { id_attribute: Some("nr".into()), ..Default::default() }).unwrap_err();
    assert!(error.to_string().contains("identificatie"), "{error}");
}

#[test]
fn a_guess_prefers_what_is_unique_and_the_member_id_counts() {
    let folder = TempDir::new().unwrap();
    let feature = |id: u64, fid: u64, gml: &str| {
        let mut feature = polygon(&json!({"GML_ID": gml, "fid": fid}), &json!([square(10.0 * id as f64, 0.0, 5.0)]));
        feature["id"] = json!(id);
        feature
    };
    let layer = plain(geojson(&folder, &[feature(1, 7, "x"), feature(2, 7, "x")]));
    assert_eq!((layer.id_attribute.as_deref(), ids(&layer)), (Some("id"), vec!["1", "2"]));
    let layer = plain(geojson(&folder, &[feature(1, 7, "x"), feature(1, 7, "y")]));
    assert_eq!((layer.id_attribute.as_deref(), ids(&layer)), (Some("GML_ID"), vec!["x", "y"]));
}

#[test]
fn nothing_is_dropped_in_silence() {
    let folder = TempDir::new().unwrap();
    let of = |geometry: Value| json!({"type": "Feature", "properties": {"id": null}, "geometry": geometry});
    let bad = [
        (of(json!(null)), "no geometry"),
        (of(json!({"type": "LineString", "coordinates": [[0, 0], [1, 1]]})), "LineString"),
        (of(json!({"type": "Point", "coordinates": [0, 0]})), "Point"),
        (of(json!({"type": "Polygon", "coordinates": []})), "empty"),
        (of(json!({"type": "MultiPolygon", "coordinates": []})), "empty"),
        (of(json!({"type": "Polygon", "coordinates": [[[0, 0], [1, 1], [0, 0]]]})), "no area"),
        (of(json!({"type": "Polygon", "coordinates": [[[0, 0], [1, 0], [2, 0], [0, 0]]]})), "no area"),
        (of(json!({"type": "Polygon", "coordinates": [[[0, 0], [1], [2, 0], [0, 0]]]})), "1 number"),
        (of(json!({"type": "Polygon", "coordinates": "far away"})), "cannot be understood"),
        (of(json!({"type": "Blob", "coordinates": []})), "cannot be understood"),
        (json!(17), "no GeoJSON feature"),
    ];
    let mut features: Vec<Value> = bad.iter().map(|(feature, _)| feature.clone()).collect();
    features.push(polygon(&json!({"id": "good"}), &json!([square(0.0, 0.0, 5.0)])));
    let layer = plain(geojson(&folder, &features));
    assert_eq!(ids(&layer), ["good"]);
    assert_eq!(layer.rejected.len(), bad.len());
    for (rejected, (_, reason)) in layer.rejected.iter().zip(&bad) {
        assert!(rejected.reason.contains(reason), "{}: {}", rejected.index, rejected.reason);
    }
    assert_sound(&layer);
}

#[test]
fn collections_give_their_polygons_and_holes_stay() {
    let folder = TempDir::new().unwrap();
    let collection = json!({"type": "Feature", "properties": {}, "geometry": {"type": "GeometryCollection",
        "geometries": [{"type": "Point", "coordinates": [1, 1, 1]},
        {"type": "Polygon", "coordinates": [square(0.0, 0.0, 10.0), square(2.0, 2.0, 3.0)]}]}});
    let layer = plain(geojson(&folder, &[collection]));
    assert!(layer.footprints[0].notes[0].contains("Point"), "{:?}", layer.footprints[0].notes);
    assert!((layer.footprints[0].polygon.unsigned_area() - 91.0).abs() < 1e-12);
    assert_sound(&layer);
}

#[test]
fn geojson_without_a_crs_is_wgs84_only_where_it_can_be() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("bare.json");
    let write = |x: f64| {
        let geometry = json!({"type": "Polygon", "coordinates": [square(x, 52.0, 0.001)]});
        fs::write(&path, format!("\u{feff} {geometry}")).unwrap();
    };
    write(4.0);
    assert_eq!(plain(&path).crs.unwrap().code.as_deref(), Some("OGC:CRS84"));
    write(84_000.0);
    let mut layer = plain(&path);
    assert!(layer.crs.is_none() && layer.warnings[0].contains("no degrees"), "{:?}", layer.warnings);
    let cloud = Crs::parse("EPSG:7415").unwrap();
    assert!(layer.reproject(&cloud).unwrap()[0].contains("EPSG:7415"));
    assert_eq!(layer.crs, Some(cloud.clone()));
    let options = FootprintOptions { crs: Some(cloud.clone()), ..Default::default() };
    assert_eq!(read(&path, &options).unwrap().crs, Some(cloud));
}

#[test]
fn what_is_no_footprint_file_is_refused_by_name() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("file.geojson");
    for (content, says) in [
        (&b""[..], "empty file"),
        (b"LASF", "point cloud"),
        (b"hello", "unknown format"),
        (b"PK\x03\x04", "ZIP"),
        (b"{\"type\":\"CityJSON\"}", "CityJSON"),
        (b"{\"type\":\"FeatureCollection\"}", "features"),
        (b"{\"type\":\"FeatureCollection\",\"features\":[{\"type\":", "cut off"),
        (b"SQLite format 3\0 but not really", "SQLite"),
        (b"fgb\x03fgb\0\xff\xff\xff\xff", "FlatGeobuf"),
        (b"\0\0\x27\x0a", "shapefile"),
    ] {
        fs::write(&path, content).unwrap();
        let error = read(&path, &FootprintOptions::default()).unwrap_err().to_string();
        assert!(error.contains(says) && error.contains("file.geojson"), "{error}");
    }
    let unknown = read(folder.path(), &FootprintOptions::default()).unwrap_err().to_string();
    for format in ["GeoJSON", "GeoPackage", "SpatiaLite", "Shapefile", "FlatGeobuf"] {
        assert!(unknown.contains(format), "{unknown}");
    }
}

#[test]
fn a_filter_leaves_out_and_names_what_it_does_not_know() {
    let folder = TempDir::new().unwrap();
    let with = |properties: Value, x: f64| polygon(&properties, &json!([square(x, 0.0, 5.0)]));
    let path = geojson(
        &folder,
        &[with(json!({"id": "a", "status": "in use"}), 0.0), with(json!({"id": "b", "height": 3}), 10.0)],
    );
    let filtered = |filter: &str| read(&path, &FootprintOptions { filter: Some(filter.into()), ..Default::default() });
    assert_eq!(ids(&filtered("status = 'in use'").unwrap()), ["a"]);
    assert_eq!(ids(&filtered("status IS NULL AND height >= 3").unwrap()), ["b"]);
    assert!(filtered("height > 99").unwrap().warnings.iter().any(|w| w.contains("none of 2")));
    let error = filtered("color = 'red'").unwrap_err().to_string();
    assert!(error.contains("`color`") && error.contains("id, status, height"), "{error}");
}

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

const RING: [[f64; 3]; 5] =
    [[0.0, 0.0, 1.0], [0.0, 10.0, 2.0], [10.0, 10.0, 3.0], [10.0, 0.0, 4.0], [0.0, 0.0, 1.0]];

#[test]
fn geopackages_with_layers_and_all_kinds_of_values() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.gpkg");
    let database = rusqlite::Connection::open(&path).unwrap();
    database
        .execute_batch(
            "CREATE TABLE gpkg_contents (table_name TEXT, data_type TEXT, srs_id INTEGER);
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
    ] {
        database.execute(insert, (fid, geometry, id)).unwrap();
    }
    drop(database);
    let layer = plain(&path);
    assert_eq!((layer.layer.as_str(), ids(&layer)), ("pand", vec!["0001", "0002"]));
    assert_eq!(layer.crs.as_ref().unwrap().code.as_deref(), Some("EPSG:28992"));
    let expected = json!({"fid": 1, "identificatie": "0001", "big": 9_007_199_254_740_993_i64, "ok": true,
        "day": "2020-01-31", "h": 2.5});
    assert_eq!(Value::Object(layer.footprints[0].attributes.clone()), expected);
    assert_eq!(layer.footprints[0].polygon.unsigned_area(), 100.0);
    assert!(layer.warnings.iter().any(|w| w.contains("`photo`")));
    let reasons: Vec<_> = layer.rejected.iter().map(|r| r.reason.as_str()).collect();
    for (reason, says) in reasons.iter().zip(["no geometry", "curved", "cannot be understood", "not finite"]) {
        assert!(reason.contains(says), "{reason}");
    }
    assert_sound(&layer);
    let roads = read(&path, &FootprintOptions { layer: Some("WEGEN".into()), ..Default::default() }).unwrap();
    assert!(roads.layer == "wegen" && roads.footprints.is_empty());
    let error = read(&path, &FootprintOptions { layer: Some("huis".into()), ..Default::default() }).unwrap_err();
    assert!(error.to_string().contains("pand, wegen"), "{error}");
}

#[test]
fn spatialite_blobs() {
    let folder = TempDir::new().unwrap();
    let path = folder.path().join("made.sqlite");
    let database = rusqlite::Connection::open(&path).unwrap();
    database
        .execute_batch(
            "CREATE TABLE geometry_columns (f_table_name TEXT, f_geometry_column TEXT, geometry_type INTEGER, coord_dimension INTEGER, srid INTEGER, spatial_index_enabled INTEGER);
             CREATE TABLE spatial_ref_sys (srid INTEGER, auth_name TEXT, auth_srid INTEGER, ref_sys_name TEXT, proj4text TEXT, srtext TEXT);
             INSERT INTO geometry_columns VALUES ('h', 'geometry', 3, 2, 2154, 0);
             INSERT INTO spatial_ref_sys VALUES (2154, 'epsg', 2154, '', '', '');
             CREATE TABLE h (pk INTEGER PRIMARY KEY, geometry BLOB);",
        )
        .unwrap();
    let mut blob = vec![0, 1];
    blob.extend(2154_i32.to_le_bytes());
    [0.0, 0.0, 10.0, 10.0].iter().for_each(|c: &f64| blob.extend(c.to_le_bytes()));
    blob.push(0x7C);
    blob.extend(&wkb(3, &RING, 2)[1..]);
    blob.push(0xFE);
    database.execute("INSERT INTO h VALUES (1, ?1)", [blob]).unwrap();
    drop(database);
    let layer = plain(&path);
    assert_eq!(layer.crs.as_ref().unwrap().code.as_deref(), Some("EPSG:2154"));
    assert_eq!(layer.footprints[0].polygon.unsigned_area(), 100.0, "{:?}", layer.rejected);
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
    let options = FootprintOptions { id_attribute: Some("longid".into()), ..Default::default() };
    let layer = read(&path, &options).unwrap();
    assert_eq!(ids(&layer), ["123456789012345679"]);
    assert_eq!(layer.footprints[0].attributes["NAME"], json!("  Café du  Nord"));
    let polygon = &layer.footprints[0].polygon;
    assert_eq!(polygon.0.len(), 2);
    assert_eq!(polygon.unsigned_area(), 100.0 - 16.0 + 25.0 - 1.0);
    assert!(polygon.contains(&geo::Point::new(21.0, 23.0)) && !polygon.contains(&geo::Point::new(3.0, 3.0)));
    assert!(layer.rejected.len() == 1 && layer.rejected[0].reason.contains("ends within"), "{:?}", layer.rejected);
    assert!(layer.crs.is_none() && layer.warnings.iter().any(|w| w.contains(".prj")));
    assert_sound(&layer);
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
    assert_eq!(layer.footprints[0].attributes["name"], json!("no. 1"));
    assert_eq!(layer.footprints[0].polygon.unsigned_area(), 200.0);
    assert_sound(&layer);
    // Whatever is damaged, the answer is a layer or an error.
    for cut in (0..bytes.len()).step_by(7) {
        fs::write(&path, &bytes[..cut]).unwrap();
        if let Ok(layer) = read(&path, &FootprintOptions::default()) {
            assert!(layer.footprints.len() == 3 || !layer.warnings.is_empty(), "cut at {cut}");
        }
    }
    for at in 8..bytes.len() {
        let mut damaged = bytes.clone();
        damaged[at] ^= 0xA5;
        fs::write(&path, &damaged).unwrap();
        if let Ok(layer) = read(&path, &FootprintOptions::default()) {
            assert_sound(&layer);
        }
    }
}
