//! Folders and patterns wherever models and tiles are read, and what is said of files that are none.

use serde_json::json;
use tempfile::tempdir;

use crate::bench::*;

/// A folder with two models and their reports.
fn models() -> tempfile::TempDir {
    let folder = house_folder();
    std::fs::create_dir(folder.path().join("out")).unwrap();
    for (name, id) in [("a.city.json", "007"), ("b.city.jsonl", "008")] {
        write_footprints(&folder.path().join("f.geojson"), &[(id, rectangle(0.0, 0.0, 10.0, 8.0))]);
        let out = folder.path().join("out").join(name);
        let run =
            reconstruct(&[&folder.path().join("house.laz")], &folder.path().join("f.geojson"), &out, "--crs EPSG:7415");
        assert_eq!(run.code, 0, "{}", run.err);
    }
    folder
}

#[test]
fn folders_and_patterns_of_models_are_models() {
    let folder = models();
    let path = |name: &str| folder.path().join(name).display().to_string();
    let validated = gable(["validate", &path("out")]);
    assert_eq!(validated.code, 0, "{}{}", validated.out, validated.err);
    assert_says(&validated.out, &["a.city.json: valid", "b.city.jsonl: valid"]);
    let pattern = gable(["validate", &path("out/*.json*")]);
    assert_eq!(
        (pattern.code, pattern.out.matches(": valid").count()),
        (0, 2),
        "reports are no models: {}",
        pattern.out
    );
    for (command, out) in [("convert", "all.gpkg"), ("merge", "all.city.json")] {
        let run = gable([command, &path("out"), "-o", &path(out)]);
        assert_eq!(run.code, 0, "{}", run.err);
        assert_says(&run.out, &["2 features"]);
    }
    assert_ends(
        &gable(["merge", &path("out/a.*.json"), "-o", &path("one.city.json")]),
        1,
        &["one city model", "two or more"],
    );
    assert_says(&gable(["info", &path("out")]).out, &["a.city.json", "b.city.jsonl"]);
    let several = gable(["view", &path("out"), "-o", &path("page.html")]);
    assert_ends(&several, 1, &["2 city models", "gable merge"]);
    let view = gable(["view", &path("out/a.*son"), "-o", &path("page.html")]);
    assert_eq!(view.code, 0, "{}", view.err);
    let evaluated = gable(["evaluate", &path("out/b.*"), "--points", &folder.path().display().to_string()]);
    assert_eq!(evaluated.code, 0, "{}", evaluated.err);
    assert_ends(&gable(["evaluate", &path("out")]), 1, &["2 models", "one"]);
}

#[test]
fn what_is_no_model_is_told_in_words() {
    let folder = tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path.display().to_string()
    };
    let files = [
        (data("delft_ahn3.laz").display().to_string(), "a point cloud (LAS or LAZ)"),
        (data("footprints.geojson").display().to_string(), "GeoJSON"),
        (write("a.gml", b"<?xml version='1.0'?>"), "CityGML must be turned into CityJSON"),
        (write("empty.json", b""), "nothing: the file is empty"),
        (write("list.json", b"[1, 2]"), "an array of JSON"),
        (write("notes.txt", b"# A model"), "a text that is no JSON"),
        (write("cut.city.json", b"{\"type\": \"CityJSON\", \"version\": \"2.0\""), "cut off"),
        (write("value.json", b"{\"type\": x}"), "something else than JSON"),
        (write("other.json", b"{\"a\": 1}"), "a JSON object without a type"),
    ];
    for (file, words) in &files {
        for command in [&["validate"][..], &["view", "--output", "x.html"], &["convert", "-o", "x.obj"]] {
            let run = gable(command.iter().copied().chain([file.as_str()]));
            assert_eq!(run.code, 1, "{file}");
            assert_says(&run.err, &[file, words, "expected CityJSON 1.0, 1.1 or 2.0"]);
            assert!(!run.err.contains("expected value"), "{}", run.err);
        }
    }
}

#[test]
fn a_pipeline_takes_a_folder_and_refuses_what_exists_before_it_reads() {
    let folder = house_folder();
    let path = |name: &str| folder.path().join(name).display().to_string();
    std::fs::create_dir(folder.path().join("tiles")).unwrap();
    std::fs::rename(folder.path().join("house.laz"), folder.path().join("tiles/house.laz")).unwrap();
    let stage = |overwrite: bool| {
        json!({"type": "writers.lod2", "filename": path("out.city.json"), "footprints": path("footprints.geojson"),
            "crs": "EPSG:7415", "overwrite": overwrite})
    };
    let run = |overwrite: bool| {
        let pipeline = json!([path("tiles"), {"type": "filters.stats"}, stage(overwrite)]);
        std::fs::write(path("p.json"), pipeline.to_string()).unwrap();
        gable(["pipeline", &path("p.json")])
    };
    let first = run(false);
    assert_ends(&first, 0, &["written ", "out.city.json"]);
    // The tile need not even be whole: nothing of it is read.
    let bytes = std::fs::read(path("tiles/house.laz")).unwrap();
    std::fs::write(path("tiles/house.laz"), &bytes[..bytes.len() / 2]).unwrap();
    let again = run(false);
    assert_ends(&again, 1, &["out.city.json", "(writers.lod2)", "a file of that name", "\"overwrite\": true"]);
    assert!(!again.err.contains("--overwrite") && !again.err.contains("could not be read"), "{}", again.err);
    std::fs::write(path("tiles/house.laz"), &bytes).unwrap();
    assert_ends(&run(true), 0, &["written "]);
}

#[test]
fn options_of_reconstruct_stand_under_headings() {
    let help = gable(["reconstruct", "--help"]).out;
    let headings =
        ["Footprints:", "Output:", "Points:", "Run:", "Which points belong to a building:", "Attributes:", "Method:"];
    assert_says(&help, &headings);
    let under = |heading: &str| {
        help.split(&format!("\n{heading}:\n")).nth(1).unwrap().split("\n\n\n").next().unwrap().to_owned()
    };
    let section = |heading: &str| {
        let rest = under(heading);
        let end = headings.iter().filter_map(|next| rest.find(&format!("\n{next}\n"))).min().unwrap_or(rest.len());
        rest[..end].to_owned()
    };
    assert_says(&section("Footprints"), &["--box", "--limit-area", "--layer"]);
    assert_says(&section("Run"), &["--jobs", "--quiet", "--verbose"]);
    assert!(!section("Footprints").contains("--jobs"), "{help}");
}
