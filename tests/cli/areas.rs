//! `--box` and `--limit-area`: a part of the footprints, as it would be in a run over all of them.

use std::path::Path;

use serde_json::{Value, json};
use tempfile::tempdir;

use crate::bench::*;

/// The buildings of a model by their ids, without what lies in the file as a whole.
fn buildings(model: &Path) -> Vec<Value> {
    let text = std::fs::read_to_string(model).unwrap();
    text.lines().skip(1).map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn id(feature: &Value) -> &str {
    feature["id"].as_str().unwrap()
}

/// The objects of a feature and its vertices in CRS coordinates.
fn content(model: &Path) -> Vec<(String, Value, Vec<[i64; 3]>)> {
    let head: Value = serde_json::from_str(std::fs::read_to_string(model).unwrap().lines().next().unwrap()).unwrap();
    let translate = [0, 1, 2].map(|axis| (head["transform"]["translate"][axis].as_f64().unwrap() * 1e4).round() as i64);
    let vertices = |feature: &Value| -> Vec<[i64; 3]> {
        let of = |vertex: &Value| [0, 1, 2].map(|axis| vertex[axis].as_i64().unwrap() + translate[axis]);
        feature["vertices"].as_array().unwrap().iter().map(of).collect()
    };
    let features = buildings(model);
    features.iter().map(|f| (id(f).to_owned(), f["CityObjects"].clone(), vertices(f))).collect()
}

#[test]
fn two_boxes_with_a_common_edge_give_each_building_once_and_as_it_is() {
    let folder = tempdir().unwrap();
    let file = |name: &str| folder.path().join(name);
    let fast = "--field height-field --quiet";
    assert_eq!(delft(&file("all.city.jsonl"), fast).code, 0);
    let all = content(&file("all.city.jsonl"));
    let west = delft(&file("west.city.jsonl"), &format!("{fast} --box 0,0,84960,1e6"));
    let east = delft(&file("east.city.jsonl"), &format!("{fast} --box=84960,0,1e6,1e6"));
    assert_eq!((west.code, east.code), (0, 0), "{}{}", west.err, east.err);
    let mut parts = content(&file("west.city.jsonl"));
    let in_west = parts.len();
    parts.extend(content(&file("east.city.jsonl")));
    assert!(in_west > 5 && parts.len() - in_west > 5, "{in_west} of {}", parts.len());
    let order = |id: &str| all.iter().position(|(own, ..)| own == id).unwrap();
    parts.sort_by_key(|(id, ..)| order(id));
    assert_eq!(parts.len(), all.len());
    for (part, whole) in parts.iter().zip(&all) {
        assert!(part == whole, "{} differs from what it is in a run over all", whole.0);
    }
    let report = report_of(&file("west.city.jsonl"));
    let footprints = &report["inputs"]["footprints"];
    assert_eq!((&footprints["footprints"], &footprints["outside"]), (&in_west.into(), &(71 - in_west).into()));
    assert_eq!(report["counts"]["footprints"], in_west);
}

#[test]
fn polygons_of_a_file_in_another_crs_limit_a_run() {
    let folder = house_folder();
    let write = |name: &str, rings: &[[[f64; 2]; 5]]| {
        let feature = |ring: &[[f64; 2]; 5]| json!({"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}});
        let features: Vec<Value> = rings.iter().map(feature).collect();
        let path = folder.path().join(name);
        std::fs::write(&path, json!({"type": "FeatureCollection", "features": features}).to_string()).unwrap();
        path.display().to_string()
    };
    let square = |w: f64, s: f64, e: f64, n: f64| [[w, s], [e, s], [e, n], [w, n], [w, s]];
    // Degrees: the house stands near 52.0085 N, 4.3776 E.
    let here = write("here.geojson", &[square(4.3, 52.0, 4.5, 52.1)]);
    let there = write("there.geojson", &[square(5.3, 52.0, 5.5, 52.1)]);
    let run = run_in(folder.path(), "house.laz", "footprints.geojson", &format!("--limit-area {here}"));
    assert_ends(&run, 0, &[]);
    let run = run_in(folder.path(), "house.laz", "footprints.geojson", &format!("--overwrite --limit-area {there}"));
    assert_ends(&run, 1, &["none of 1 footprints in --limit-area", "there.geojson"]);
    let both = format!("--overwrite --limit-area {here} --box 84000,446000,86000,448000");
    assert_ends(&run_in(folder.path(), "house.laz", "footprints.geojson", &both), 0, &[]);
    for (rest, says) in [
        ("--box 1,2,3", "four numbers"),
        ("--box 3,2,1,4", "each least below its largest"),
        ("--limit-area nowhere.geojson", "nowhere.geojson"),
    ] {
        let run = run_in(folder.path(), "house.laz", "footprints.geojson", &format!("--overwrite {rest}"));
        assert_ends(&run, 1, &[says]);
    }
}

#[test]
fn what_has_no_polygon_is_in_no_area_and_told() {
    let folder = house_folder();
    let features = [("007", rectangle(0.0, 0.0, 10.0, 8.0)), ("line", line())];
    write_footprints(&folder.path().join("footprints.geojson"), &features);
    let run = run_in(folder.path(), "house.laz", "footprints.geojson", "--box 84000,446000,86000,448000");
    assert_ends(&run, 0, &["1 features without a usable polygon are left out: they are in no area"]);
    let report = report_of(&folder.path().join("out.city.json"));
    assert_eq!(report["inputs"]["footprints"]["outside"], 1);
    assert_eq!(report["buildings"].as_array().unwrap().len(), 1);
}
