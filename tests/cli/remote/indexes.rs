//! Indexes of tiles: only the tiles that touch what is wanted are opened.

use std::path::Path;

use serde_json::{Value, json};
use tempfile::tempdir;

use super::server::{Answer, Server};
use crate::bench::*;

/// Four tiles, and indexes of them: `tindex.geojson` in the system of the tiles, `items.json` in STAC.
fn quarters() -> tempfile::TempDir {
    let folder = tempdir().unwrap();
    std::fs::create_dir(folder.path().join("tiles")).unwrap();
    let tiles = cut_into_four(&data("delft_ahn3.laz"), &folder.path().join("tiles"));
    let (mut polygons, mut items) = (Vec::new(), Vec::new());
    for tile in &tiles {
        let bounds = las::Reader::from_path(tile).unwrap().header().bounds();
        let name = tile.file_name().unwrap().to_str().unwrap();
        let ring = |x0: f64, y0: f64, x1: f64, y1: f64| json!({"type": "Polygon", "coordinates": [[[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]]]});
        polygons.push(json!({"type": "Feature", "properties": {"location": format!("tiles/{name}")},
            "geometry": ring(bounds.min.x, bounds.min.y, bounds.max.x, bounds.max.y)}));
        // Degrees around the middle of the Dutch system, near enough for tiles of 100 m.
        let [lon, lat] = [bounds.min.x.midpoint(bounds.max.x), bounds.min.y.midpoint(bounds.max.y)];
        let (lon, lat) = (5.387_206 + (lon - 155_000.0) / 68_400.0, 52.155_174 + (lat - 463_000.0) / 111_260.0);
        items.push(json!({"type": "Feature", "stac_version": "1.0.0", "id": name, "properties": {}, "links": [],
            "geometry": ring(lon - 0.004, lat - 0.004, lon + 0.004, lat + 0.004),
            "assets": {"data": {"href": format!("./tiles/{name}?sig=hunter2"), "type": "application/vnd.laszip"},
                "thumbnail": {"href": "t.png"}}}));
    }
    // One that is far from everything, and not even there.
    items.push(json!({"type": "Feature", "stac_version": "1.0.0", "id": "far", "properties": {}, "links": [],
        "bbox": [6.0, 53.0, 6.1, 53.1], "geometry": null, "assets": {"data": {"href": "far.copc.laz"}}}));
    let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::28992"}});
    let tindex = json!({"type": "FeatureCollection", "crs": crs, "features": polygons});
    std::fs::write(folder.path().join("tindex.geojson"), tindex.to_string()).unwrap();
    let items = json!({"type": "FeatureCollection", "features": items});
    std::fs::write(folder.path().join("items.json"), items.to_string()).unwrap();
    let mut footprints = json_of(data("footprints.geojson"));
    std::fs::write(folder.path().join("footprints.geojson"), footprints.to_string()).unwrap();
    // Those of one corner.
    let west_of = |feature: &Value| feature["geometry"]["coordinates"].to_string();
    let features = footprints["features"].as_array_mut().unwrap();
    features.sort_by_key(west_of);
    features.truncate(2);
    std::fs::write(folder.path().join("corner.geojson"), footprints.to_string()).unwrap();
    folder
}

#[test]
fn the_tiles_that_touch_the_footprints_are_opened_and_no_others() {
    let folder = quarters();
    let server = Server::of(folder.path(), |_| Answer::Well);
    let out = tempdir().unwrap();
    let expected = out.path().join("expected.city.json");
    let all: Vec<_> = ["sw", "se", "nw", "ne"].map(|name| folder.path().join(format!("tiles/{name}.laz"))).into();
    let all: Vec<&Path> = all.iter().map(std::path::PathBuf::as_path).collect();
    assert_eq!(reconstruct(&all, &folder.path().join("footprints.geojson"), &expected, "").code, 0);
    let indexes = [
        folder.path().join("tindex.geojson").to_str().unwrap().to_owned(),
        server.url("tindex.geojson"),
        server.url("items.json"),
    ];
    for (number, index) in indexes.iter().enumerate() {
        let model = out.path().join(format!("{number}.city.json"));
        let run = reconstruct(&[Path::new(index)], &folder.path().join("footprints.geojson"), &model, "");
        assert_eq!(run.code, 0, "{}", run.err);
        assert!(std::fs::read(&model).unwrap() == std::fs::read(&expected).unwrap(), "{index}");
        assert_says(&run.err, &["4 of "]);
        assert!(!report_of(&model).to_string().contains("hunter2"));
    }
    assert!(server.requests().iter().all(|request| !request.file().contains("far")));
    // With the footprints of one corner fewer tiles are opened, but for the one that tells the system.
    let server = Server::of(folder.path(), |_| Answer::Well);
    let model = out.path().join("corner.city.json");
    let index = server.url("tindex.geojson");
    let run = reconstruct(
        &[Path::new(&index)],
        &folder.path().join("corner.geojson"),
        &model,
        "--crs EPSG:7415 --ring-limit 5",
    );
    assert_eq!(run.code, 0, "{}", run.err);
    println!("{}", run.err);
    let tiles = report_of(&model)["inputs"]["tiles"].as_array().unwrap().len();
    let opened = server.sent().keys().filter(|name| name.contains("tiles/")).count();
    assert_eq!(tiles, opened, "what is not listed is not opened");
}

#[test]
fn a_box_chooses_tiles_too_and_an_index_that_touches_nothing_is_an_error() {
    let folder = quarters();
    let index = folder.path().join("tindex.geojson");
    let out = tempdir().unwrap();
    let model = out.path().join("out.city.json");
    let far = out.path().join("far.geojson");
    write_footprints(&far, &[("1", rectangle(50_000.0, 0.0, 50_010.0, 10.0))]);
    let run = reconstruct(&[&index], &far, &model, "");
    assert_ends(&run, 1, &["tindex.geojson", "4 tiles, none of which touches a footprint"]);
    let run = reconstruct(&[&index], &folder.path().join("footprints.geojson"), &model, "--box 0,0,10,10");
    assert_ends(&run, 1, &["tindex.geojson", "none of which touches"]);
    let run = gable([Path::new("info"), &index]);
    assert_eq!(run.code, 0, "{}", run.err);
}
