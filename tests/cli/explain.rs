//! `gable explain`. What the page shows is tested in a browser: tests/platforms/explain.test.js.

use std::fs;

use serde_json::json;
use tempfile::tempdir;

use crate::bench::*;

const HOUSE: &str = "NL.IMBAG.Pand.0503100000017310";

#[test]
fn a_page_of_one_building_and_what_is_in_it() {
    let folder = tempdir().unwrap();
    let page = folder.path().join("house.html");
    let explain = |rest: &[&str]| -> Run {
        let mut command = command(["explain"]);
        command.arg(data("delft_ahn3.laz")).arg("-f").arg(data("footprints.geojson")).arg("-o").arg(&page);
        command.args(["--id", HOUSE]).args(rest).output().unwrap().into()
    };
    let run = explain(&[]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.out, &["points", "planes", "found", "after refinement", "cells", "inside", "faces", "house.html"]);
    let html = fs::read_to_string(&page).unwrap();
    assert!(html.contains(&format!("<title>{HOUSE}")) && html.ends_with("</html>\n"));
    let run = explain(&[]);
    assert_eq!(run.code, 1, "an existing file is kept");
    assert_says(&run.err, &["house.html", "--overwrite"]);
    assert_eq!(explain(&["--overwrite", "--quiet"]).out, "");
    assert_eq!(fs::read_to_string(&page).unwrap(), html, "the same every time");
    // The options are those of a run.
    assert_eq!(explain(&["--overwrite", "--field", "height-field", "--lambda", "0.5"]).code, 0);
    assert_ne!(fs::read_to_string(&page).unwrap(), html);
}

#[test]
fn a_configuration_of_a_run_is_one_of_a_page() {
    let folder = tempdir().unwrap();
    let (config, page) = (folder.path().join("city.toml"), folder.path().join("house.html"));
    let (tile, footprints) = (data("delft_ahn3.laz"), data("footprints.geojson"));
    // What it says of the model is not meant for the page.
    fs::write(
        &config,
        format!(
            "tiles = [{:?}]\nfootprints = {:?}\noutput = \"city.city.json\"\nlod = \"0,2.2\"\nlambda = 0.2\n",
            tile.display().to_string(),
            footprints.display().to_string()
        ),
    )
    .unwrap();
    let mut command = command(["explain", "--config"]);
    let run: Run = command.arg(&config).args(["--id", HOUSE, "-o"]).arg(&page).output().unwrap().into();
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(page.exists() && !folder.path().join("city.city.json").exists());
}

#[test]
fn an_id_that_is_not_there_is_told_with_those_that_are_like_it() {
    let folder = tempdir().unwrap();
    let page = folder.path().join("house.html");
    let mut command = command(["explain"]);
    command.arg(data("delft_ahn3.laz")).arg("-f").arg(data("footprints.geojson")).arg("-o").arg(&page);
    let run: Run = command.args(["--id", "NL.IMBAG.Pand.05031000000173"]).output().unwrap().into();
    assert_eq!(run.code, 1);
    assert_says(
        &run.err,
        &["footprints", "no building with the id", "71 buildings", "NL.IMBAG.Pand.0503100000017303", "--id-attribute"],
    );
    assert!(!page.exists());
}

#[test]
fn a_building_without_points_has_a_page_and_says_so() {
    let folder = tempdir().unwrap();
    let (footprints, page) = (folder.path().join("yard.geojson"), folder.path().join("yard.html"));
    let ring = json!([[84_958, 447_523], [84_961, 447_523], [84_961, 447_526], [84_958, 447_526], [84_958, 447_523]]);
    let layer = json!({
        "type": "FeatureCollection",
        "crs": {"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::28992"}},
        "features": [{"type": "Feature", "properties": {"id": "yard"},
            "geometry": {"type": "Polygon", "coordinates": [ring]}}]
    });
    fs::write(&footprints, layer.to_string()).unwrap();
    let mut command = command(["explain"]);
    command.arg(data("delft_ahn3.laz")).arg("-f").arg(&footprints).args(["--id", "yard", "-o"]).arg(&page);
    let run: Run = command.output().unwrap().into();
    assert_eq!(run.code, 2, "{}{}", run.out, run.err);
    assert_says(&run.err, &["yard", "no building point lies in the footprint"]);
    assert!(page.exists());
}

#[test]
fn a_page_is_html() {
    let folder = tempdir().unwrap();
    let mut command = command(["explain"]);
    command.arg(data("delft_ahn3.laz")).arg("-f").arg(data("footprints.geojson"));
    let run: Run = command.args(["--id", HOUSE, "-o"]).arg(folder.path().join("a.json")).output().unwrap().into();
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["a.json", "PAGE.html"]);
}
