//! `--cloud`: of several point clouds each building gets the best.

use std::path::Path;

use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};

use crate::bench::*;

/// A roof: its left and right edge, its height, and how far its points are apart.
type Roof = (f64, f64, f64, f64);

/// A tile of roofs 8 m deep on ground at 0 m.
fn tile(path: &Path, roofs: &[Roof]) {
    let mut points = Vec::new();
    let steps = |from: f64, to: f64, step: f64| {
        (0..).map(move |i| from + (f64::from(i) + 0.5) * step).take_while(move |at| *at < to)
    };
    for (x, y) in steps(-6.0, 66.0, 0.5).flat_map(|x| steps(-6.0, 14.0, 0.5).map(move |y| (x, y))) {
        let is_roofed = roofs.iter().any(|(west, east, ..)| (*west..*east).contains(&x) && (0.0..8.0).contains(&y));
        if !is_roofed {
            points.push((CORNER[0] + x, CORNER[1] + y, 0.0, 2));
        }
    }
    for (west, east, height, spacing) in roofs {
        let places = steps(*west, *east, *spacing).flat_map(|x| steps(0.0, 8.0, *spacing).map(move |y| (x, y)));
        points.extend(places.map(|(x, y)| (CORNER[0] + x, CORNER[1] + y, *height, 6)));
    }
    write_tile(path, None, &points);
}

/// Five houses as they were in 2014 and in 2020, and their footprints.
fn street() -> TempDir {
    let folder = tempdir().unwrap();
    let roofs = |heights: [f64; 5], spacings: [f64; 5]| -> Vec<Roof> {
        let houses = heights.into_iter().zip(spacings).enumerate();
        let houses = houses.filter(|(_, (height, _))| *height > 0.0);
        houses.map(|(i, (height, spacing))| (12.0 * i as f64, 12.0 * i as f64 + 10.0, height, spacing)).collect()
    };
    // The first as it was; the second hardly seen in 2020; the third raised; the fourth built; the fifth torn down.
    tile(&folder.path().join("old.laz"), &roofs([6.0, 6.0, 6.0, 0.0, 6.0], [0.5; 5]));
    tile(&folder.path().join("new.laz"), &roofs([6.0, 6.0, 9.0, 7.0, 0.0], [0.5, 1.6, 1.2, 0.5, 0.5]));
    let footprint = |i: u32| {
        let west = 12.0 * f64::from(i);
        let year = if i == 3 { 2018 } else { 1970 };
        let geometry = rectangle(west, 0.0, west + 10.0, 8.0);
        json!({"type": "Feature", "properties": {"id": format!("h{i}"), "built": year}, "geometry": geometry})
    };
    let features: Vec<Value> = (0..5).map(footprint).collect();
    let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::28992"}});
    let file = json!({"type": "FeatureCollection", "crs": crs, "features": features});
    std::fs::write(folder.path().join("f.geojson"), file.to_string()).unwrap();
    folder
}

fn clouds(folder: &Path, rest: &[&str]) -> Run {
    let path = |name: &str| folder.join(name).display().to_string();
    let mut command = command(["reconstruct", "--crs", "EPSG:7415", "--overwrite", "--field", "height-field"]);
    command.arg("-f").arg(path("f.geojson")).arg("-o").arg(path("out.city.json")).args(rest);
    command.output().unwrap().into()
}

/// Some attributes of a house after a run over both clouds.
fn told(folder: &Path, house: &str, names: &[&str]) -> Vec<Value> {
    let model = json_of(folder.join("out.city.json"));
    let attributes = &model["CityObjects"][house]["attributes"];
    names.iter().map(|name| attributes[format!("gable_{name}")].clone()).collect()
}

#[test]
fn each_building_is_made_from_the_newest_cloud_that_is_good_enough() {
    let folder = street();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let (old, new) = (format!("AHN3={},date=2014", path("old.laz")), format!("AHN4={},date=2020-05", path("new.laz")));
    let run = clouds(folder.path(), &["--cloud", &old, "--cloud", &new, "--year-attribute", "built"]);
    assert_ends(&run, 0, &[]);
    assert_valid(&folder.path().join("out.city.json"));
    let names = ["point_cloud_source", "point_cloud_date", "point_cloud_choice", "is_mutated", "mutation", "lod"];
    let of = |house: &str| told(folder.path(), house, &names);
    assert_eq!(of("h0"), [json!("AHN4"), json!("2020-05"), json!("first"), json!(false), json!(null), json!("2.2")]);
    assert_eq!(
        of("h1"),
        [json!("AHN3"), json!("2014"), json!("others-too-thin"), json!(false), json!(null), json!("2.2")]
    );
    let raised = of("h2");
    assert_eq!(raised[..5], [json!("AHN4"), json!("2020-05"), json!("others-outdated"), json!(true), json!("raised")]);
    assert_eq!(of("h3")[..5], [json!("AHN4"), json!("2020-05"), json!("first"), json!(true), json!("built")]);
    let torn = of("h4");
    assert_eq!((&torn[0], &torn[3], &torn[4]), (&json!("AHN4"), &json!(true), &json!("torn-down")));
    assert_eq!(told(folder.path(), "h4", &["points", "mutated_since"]), [json!(0), json!("AHN3")]);
    let report = report_of(&folder.path().join("out.city.json"));
    let tiles = report["inputs"]["tiles"].as_array().unwrap();
    assert_eq!(tiles.iter().map(|tile| tile["cloud"].as_str().unwrap()).collect::<Vec<_>>(), ["AHN4", "AHN3"]);

    // A priority goes before the date.
    let first = format!("{old},priority=1");
    assert_ends(&clouds(folder.path(), &["--cloud", &first, "--cloud", &new]), 0, &[]);
    assert_eq!(of("h0")[..3], [json!("AHN3"), json!("2014"), json!("first")]);
    // The tiles are a cloud, too, and a house of 2018 is none of 2014's.
    let of_2014 = [&path("old.laz"), "--point-cloud-date", "2014", "--year-attribute", "built"];
    assert_ends(&clouds(folder.path(), &of_2014), 0, &[]);
    assert_eq!(
        told(folder.path(), "h3", &["point_cloud_choice", "fallback_reason"]),
        [json!("none-new-enough"), json!("outdated")]
    );
}

#[test]
fn clouds_are_options_of_a_configuration_and_of_a_pipeline() {
    let folder = street();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let config = path("city.toml");
    let clouds_of = [format!("AHN3={},date=2014", path("old.laz")), format!("AHN4={},date=2020", path("new.laz"))];
    std::fs::write(&config, format!("cloud = [{:?}, {:?}]\n", clouds_of[0], clouds_of[1])).unwrap();
    assert_ends(&clouds(folder.path(), &["--config", &config]), 0, &[]);
    let names = ["point_cloud_source", "point_cloud_choice"];
    assert_eq!(told(folder.path(), "h1", &names), [json!("AHN3"), json!("others-too-thin")]);
    let pipeline = json!([path("new.laz"), {
        "type": "writers.lod2", "filename": path("out.city.json"), "footprints": path("f.geojson"), "crs": "EPSG:7415",
        "overwrite": true, "field": "height-field", "cloud": [clouds_of[0]], "point_cloud_source": "AHN4",
        "point_cloud_date": "2020",
    }]);
    std::fs::write(path("p.json"), pipeline.to_string()).unwrap();
    assert_ends(&gable(["pipeline", &path("p.json")]), 0, &[]);
    assert_eq!(told(folder.path(), "h1", &names), [json!("AHN3"), json!("others-too-thin")]);
    assert_eq!(told(folder.path(), "h0", &names), [json!("AHN4"), json!("first")]);
}

#[test]
fn clouds_that_are_none_are_told() {
    let folder = street();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let new = format!("AHN4={},date=2020", path("new.laz"));
    let refused = |rest: &[&str], says: &[&str]| assert_ends(&clouds(folder.path(), rest), 1, says);
    refused(&["--cloud", "tiles/"], &["--cloud", "NAME=TILES is expected"]);
    refused(&["--cloud", &format!("{new},priority=high")], &["priority=high", "a whole number"]);
    refused(&["--cloud", &new, "--cloud", &new], &["two clouds called AHN4"]);
    refused(&[&path("new.laz"), "--cloud", &new], &["a tile of two clouds"]);
    refused(&["--cloud", &format!("a={}", path("none*.laz"))], &["none*.laz"]);
    refused(&["--cloud", &new, "--year-attribute", "year"], &["--year-attribute", "no attribute `year`"]);
    refused(&[&path("new.laz"), "--year-attribute", "built"], &["no date of any point cloud"]);
    // One that is somewhere else is left out.
    let far = folder.path().join("far.laz");
    write_tile(&far, None, &[(0.0, 0.0, 0.0, 6), (5.0, 5.0, 1.0, 2)]);
    let run = clouds(folder.path(), &["--cloud", &new, "--cloud", &format!("far={},date=2021", far.display())]);
    assert_ends(&run, 0, &["warning: far: ", "this point cloud is left out"]);
}
