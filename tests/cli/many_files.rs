//! `-o 'out/{tile}.city.json'`, `-o 'out/{id}.obj'`: a file for each tile or building.

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::Value;
use tempfile::tempdir;

use crate::bench::*;

/// Two houses in two tiles, and a feature without a polygon.
fn street(folder: &Path) {
    write_two_houses(folder);
    let houses = [
        ("../b", rectangle(40.0, 0.0, 50.0, 8.0)),
        ("a/1", rectangle(0.0, 0.0, 10.0, 8.0)),
        ("a_1", rectangle(15.0, 0.0, 18.0, 3.0)),
        ("none", line()),
    ];
    write_footprints(&folder.join("f.geojson"), &houses);
}

fn run(folder: &Path, output: &str, rest: &str) -> Run {
    let [west, east] = ["west.laz", "east.laz"].map(|name| folder.join(name));
    let rest = format!("--crs EPSG:7415 {rest}");
    reconstruct(&[&west, &east], &folder.join("f.geojson"), &folder.join(output), &rest)
}

fn ids(model: &Path) -> BTreeSet<String> {
    let objects = json_of(model)["CityObjects"].as_object().unwrap().clone();
    objects.into_iter().filter(|(_, object)| object["type"] == "Building").map(|(id, _)| id).collect()
}

#[test]
fn each_tile_has_a_file_with_its_buildings() {
    let folder = tempdir().unwrap();
    street(folder.path());
    let done = run(folder.path(), "out/{tile}.city.json", "");
    assert_ends(&done, 2, &[]);
    let out = folder.path().join("out");
    assert_eq!(names_in(&out), ["east.city.json", "gable.report.json", "west.city.json"]);
    let [east, west] = ["east.city.json", "west.city.json"].map(|name| out.join(name));
    assert_valid(&east);
    assert_valid(&west);
    // What has no polygon belongs to the first tile, what lies in no tile to the nearest.
    assert_eq!(ids(&east), ["../b".to_owned(), "none".to_owned()].into());
    assert_eq!(ids(&west), ["a/1".to_owned(), "a_1".to_owned()].into());
    let report = report_of(&out.join("gable"));
    let files: Vec<&str> =
        report["buildings"].as_array().unwrap().iter().map(|b| b["file"].as_str().unwrap()).collect();
    assert!(files[0].ends_with("east.city.json") && files[3].ends_with("west.city.json"), "{files:?}");
    assert_eq!(report["outputs"].as_array().unwrap().len(), 3);
    // Each file is as if its buildings were all.
    assert_eq!(json_of(&east)["transform"]["translate"][0], CORNER[0] + 40.0);
    assert_eq!(json_of(&west)["transform"]["translate"][0], CORNER[0]);

    let again = run(folder.path(), "out/{tile}.city.json", "");
    assert_ends(&again, 1, &["a file of that name: 2 of 2 are there", "--overwrite"]);
    assert_eq!(run(folder.path(), "out/{tile}.city.json", "--overwrite").code, 2);
}

#[test]
fn each_building_has_a_file_whatever_its_id() {
    let folder = tempdir().unwrap();
    street(folder.path());
    for (extension, own) in [("city.json", 4), ("city.jsonl", 4), ("gpkg", 4), ("obj", 8), ("3dtiles", 4)] {
        let done = run(folder.path(), &format!("{extension}/x-{{id}}.{extension}"), "");
        assert_ends(&done, 2, &[]);
        let names = names_in(&folder.path().join(extension));
        assert_eq!(names.len(), own + 1, "{names:?}");
        let stems: BTreeSet<&str> =
            names.iter().map(|name| name.split_once('.').map_or("", |(stem, _)| stem)).collect();
        assert!(stems.contains("x-a_1") && stems.contains("x-a_1_2") && stems.contains("x-none"), "{names:?}");
        assert!(names.iter().any(|name| name.starts_with("x-___b.")), "{names:?}");
    }
    assert_eq!(ids(&folder.path().join("city.json/x-a_1.city.json")), ["a_1".to_owned()].into());
    assert_eq!(ids(&folder.path().join("city.json/x-a_1_2.city.json")), ["a/1".to_owned()].into());
    let both = run(folder.path(), "both/{tile}/{id}.city.jsonl", "--field height-field");
    assert_ends(&both, 2, &[]);
    assert_eq!(names_in(&folder.path().join("both")), ["east", "gable.report.json", "west"]);
}

#[test]
fn places_that_are_unknown_and_pages_of_many_files_are_refused() {
    let folder = tempdir().unwrap();
    street(folder.path());
    assert_ends(&run(folder.path(), "out/{tyle}.city.json", ""), 1, &["{tyle}", "expected {tile} or {id}"]);
    assert_ends(&run(folder.path(), "out/{tile}.xyz", ""), 1, &["an unknown extension"]);
    assert_ends(&run(folder.path(), "out/{tile}.city.json", "--view"), 1, &["a page of a model in several files"]);
    assert!(!folder.path().join("out").exists());
}

#[cfg(unix)]
#[test]
fn a_run_over_many_files_that_was_killed_is_resumed_to_the_same_bytes() {
    use std::process::Stdio;
    use std::time::{Duration, Instant};

    let folder = tempdir().unwrap();
    let start = |name: &str, rest: &str| {
        let mut command = command(["reconstruct", "--jobs", "1", "--quiet", "--field", "height-field", "-o"]);
        command.arg(folder.path().join(name).join("{id}.city.json"));
        command.arg(data("delft_ahn3.laz")).arg("-f").arg(data("footprints.geojson"));
        command.args(rest.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
    };
    assert!(start("whole", "").wait().unwrap().success());
    let whole = folder.path().join("whole");
    assert_eq!(names_in(&whole).len(), 72);
    let mut child = start("killed", "");
    let out = folder.path().join("killed");
    let limit = Instant::now() + Duration::from_mins(2);
    while !out.is_dir() || names_in(&out).iter().filter(|name| name.ends_with(".city.json")).count() < 10 {
        assert!(child.try_wait().unwrap().is_none() && Instant::now() < limit, "the run is over or makes no headway");
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    for name in names_in(&out).iter().filter(|name| name.ends_with(".city.json")) {
        assert_eq!(std::fs::read(out.join(name)).unwrap(), std::fs::read(whole.join(name)).unwrap(), "{name} is half");
    }
    assert!(!start("killed", "").wait().unwrap().success(), "what is left is neither taken nor removed");
    assert!(start("killed", "--resume").wait().unwrap().success());
    assert_eq!(names_in(&out), names_in(&whole));
    let models = names_in(&whole).into_iter().filter(|name| name.ends_with(".city.json"));
    for name in models {
        assert_eq!(std::fs::read(out.join(&name)).unwrap(), std::fs::read(whole.join(&name)).unwrap(), "{name}");
    }
    let report: Value = json_of(out.join("gable.report.json"));
    assert!(report["counts"]["resumed"].as_u64().unwrap() >= 10);
}
