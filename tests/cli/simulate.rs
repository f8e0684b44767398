//! `gable simulate`, and the whole road over what it makes.

use tempfile::tempdir;

use crate::bench::*;

#[test]
fn scans_of_known_buildings_go_the_whole_road() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let town = path("town");
    let scan = |overwrite: bool| -> Run {
        let mut command = command(["simulate", "--generate", "12", "--seed", "4", "--clean", "--density", "12"]);
        command.args(["--noise", "0.0005", "--scans"]).arg(&town).args(overwrite.then_some("--overwrite"));
        command.output().unwrap().into()
    };
    let run = scan(false);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.out, &["12 buildings", "points.laz", "footprints.geojson", "reference.city.json"]);
    let [tile, footprints, reference] =
        ["points.laz", "footprints.geojson", "reference.city.json"].map(|name| town.join(name));

    // What stands there is kept unless it shall not be, and comes back byte for byte.
    let before = std::fs::read(&tile).unwrap();
    let refused = scan(false);
    assert_eq!(refused.code, 1);
    assert_says(&refused.err, &["points.laz", "--overwrite"]);
    assert_eq!(scan(true).code, 0);
    assert_eq!(std::fs::read(&tile).unwrap(), before);

    let valid = gable(["validate".as_ref(), reference.as_os_str()]);
    assert_eq!(valid.code, 0, "{}", valid.out);
    let run = gable(["info".as_ref(), tile.as_os_str(), footprints.as_os_str()]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.out, &["EPSG:7415", "12"]);

    let (model, json) = (path("model.city.json"), path("figures.json"));
    let mut command = command(["reconstruct"]);
    let run: Run = command.arg(&tile).arg("-f").arg(&footprints).arg("-o").arg(&model).output().unwrap().into();
    assert_eq!(run.code, 0, "{}", run.err);
    let mut command = crate::bench::command(["evaluate"]);
    let run: Run =
        command.arg(&model).arg("--reference").arg(&reference).arg("--json").arg(&json).output().unwrap().into();
    assert_eq!(run.code, 0, "{}", run.err);
    let overall = json_of(&json)["overall"].clone();
    let figure = |pointer: &str| overall.pointer(pointer).and_then(serde_json::Value::as_f64).unwrap();
    assert_eq!(figure("/reference/matched"), 12.0);
    assert!(figure("/reference/volume_iou") > 0.95, "{overall:#}");
    assert!(figure("/reference/roof_distance") < 0.05, "{overall:#}");
}

#[test]
fn training_data_are_made_and_not_overwritten_by_mistake() {
    let folder = tempdir().unwrap();
    let output = folder.path().join("shards");
    let make = |rest: &[&str]| -> Run {
        let mut command = command(["simulate"]);
        let mut command = command.arg(data("reference_3dbag_lod22.city.jsonl")).args(["--generate", "55", "-o"]);
        command = command.arg(&output).args(rest);
        command.output().unwrap().into()
    };
    let run = make(&["--limit", "55", "--variants", "2", "--split", "0.5,0.25,0.25"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.out, &["generator", "train (", "validation (", "test ("]);
    let manifest = json_of(output.join("manifest.json"));
    let scans: u64 = manifest["scans"].as_object().unwrap().values().map(|n| n.as_u64().unwrap()).sum();
    let failed: u64 = manifest["failed"].as_object().unwrap().values().map(|n| n.as_u64().unwrap()).sum();
    let models: u64 = manifest["sources"].as_array().unwrap().iter().map(|s| s["models"].as_u64().unwrap()).sum();
    assert_eq!(scans + failed, 2 * models);
    assert!(scans > 110 && failed < 10, "{manifest:#}");
    let again = make(&[]);
    assert_eq!(again.code, 1);
    assert_says(&again.err, &["training data", "--overwrite"]);
    assert_eq!(make(&["--overwrite", "--limit", "1", "--quiet"]).code, 0);
    // Shards of the larger run are gone.
    let left = std::fs::read_dir(&output).unwrap().count();
    assert!(left <= 3, "{left}");
}

#[test]
fn real_tiles_become_training_data() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    // Two towns that stand for tiles of a flight.
    for (town, seed) in [("west", "4"), ("east", "5")] {
        let mut command =
            command(["simulate", "--generate", "6", "--density", "6", "--setup", "airborne", "--seed", seed]);
        let run: Run = command.arg("--scans").arg(path(town)).output().unwrap().into();
        assert_eq!(run.code, 0, "{}", run.err);
    }
    let make = |town: &str, output: &str, rest: &[&str]| -> Run {
        let mut command = command(["simulate", "--variants", "2", "--split", "1,0,0"]);
        command.arg("-f").arg(path(town).join("footprints.geojson")).arg("-o").arg(path(output)).args(rest);
        command.arg("--real").arg(path(town).join("points.laz")).output().unwrap().into()
    };
    let run = make("west", "shards", &[]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.out, &["points.laz", "train (1 tile)"]);
    let manifest = json_of(path("shards").join("manifest.json"));
    assert_eq!(manifest["tiles"]["points.laz"], "train");
    assert!(manifest["scans"]["train"].as_u64().unwrap() >= 8, "{manifest:#}");
    let run = make("west", "again", &["--jobs", "1"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let shard = |name: &str| std::fs::read(path(name).join("train-00000.safetensors")).unwrap();
    assert!(shard("shards") == shard("again"));

    let mut command = command(["simulate", "--hold-back"]);
    command.arg(path("east").join("points.laz")).arg("-f").arg(path("east").join("footprints.geojson"));
    let run: Run = command.arg("-o").arg(path("held")).output().unwrap().into();
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.out, &["validation (1 tile)"]);
    // Footprints are needed, and points of the class that is asked for.
    let mut command = crate::bench::command(["simulate", "--real"]);
    let run: Run = command.arg(path("west").join("points.laz")).arg("-o").arg(path("x")).output().unwrap().into();
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["--footprints"]);
    let run = make("west", "x", &["--building-class", "64"]);
    assert_eq!(run.code, 1, "{}", run.out);
    assert_says(&run.err, &["64"]);
}

#[test]
fn what_cannot_be_scanned_is_said() {
    let folder = tempdir().unwrap();
    let output = folder.path().join("out");
    let run = |file: std::path::PathBuf| -> Run {
        let mut command = command(["simulate"]);
        command.arg(file).arg("-o").arg(&output).output().unwrap().into()
    };
    let no_model = run(data("footprints.geojson"));
    assert_eq!(no_model.code, 1);
    assert_says(&no_model.err, &["footprints.geojson", "CityJSON"]);
    let missing = run(folder.path().join("none.city.json"));
    assert_eq!(missing.code, 1);
    assert_says(&missing.err, &["none.city.json", "cannot open"]);
    assert_eq!(gable(["simulate", "-o", "x"]).code, 1);
}
