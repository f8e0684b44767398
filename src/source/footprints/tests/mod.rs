//! Whole files through [`read`]: real ones, and small ones of every format that the tests write themselves.

mod clashes;
mod curves;
mod formats;
mod geoparquet;
mod sequences;

use std::collections::HashSet;
use std::fs;

use geo::{Area, Distance, Euclidean, Validation, Winding};
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
        assert!(footprint.polygon.iter().flat_map(geo::Polygon::interiors).all(Winding::is_cw), "{}", footprint.id);
    }
    let all = ids(layer).into_iter().chain(layer.rejected.iter().map(|r| r.id.as_str()));
    let unique: HashSet<_> = all.clone().collect();
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
    assert_eq!(layer.footprints[0].attributes.to_map()["identificatiebagpnd"], json!(503_100_000_018_603_i64));
    assert_eq!(layer.footprints[0].attributes.to_map()["inonderzoek"], json!(false));
    assert!(layer.footprints[0].attributes.get("GEOMETRY").is_none());
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
    assert_eq!(layer.footprints[0].attributes.to_map()["PRESENCE"], json!(1));
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
fn numbers_that_json_does_not_have_cost_one_feature() {
    let folder = TempDir::new().unwrap();
    let path = geojson(
        &folder,
        &[
            polygon(&json!({"id": 1, "h": "H"}), &json!([square(0.0, 0.0, 5.0)])),
            polygon(&json!({"id": 2}), &json!([square(0.5, 0.0, 5.0)])),
        ],
    );
    let text = fs::read_to_string(&path).unwrap().replace("\"H\"", "NaN").replace("0.5", "NaN");
    fs::write(&path, text).unwrap();
    let layer = plain(&path);
    assert_eq!(layer.footprints[0].attributes.to_map()["h"], json!(null));
    assert!(layer.rejected[0].id == "2" && layer.rejected[0].reason.contains("cannot be understood"));
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
