//! The choice of the field.

use std::fs;
use std::time::Instant;

use serde_json::Value;

use crate::bench::*;

/// All confidences of the roof surfaces of a model, and of its buildings.
fn confidences(model: &Value) -> [Vec<f64>; 2] {
    let objects = model["CityObjects"].as_object().unwrap();
    let roofs = objects
        .values()
        .flat_map(|object| object["geometry"].as_array().into_iter().flatten())
        .filter(|geometry| geometry["lod"] == "2.2")
        .flat_map(|geometry| geometry["semantics"]["surfaces"].as_array().into_iter().flatten())
        .filter(|surface| surface["type"] == "RoofSurface")
        .map(|surface| surface["confidence"].as_f64().expect("every roof at LoD 2.2 says how sure it is"));
    let buildings = objects.values().filter_map(|object| object["attributes"]["gable_confidence"].as_f64());
    [roofs.collect(), buildings.collect()]
}

#[test]
fn the_network_is_the_default_and_says_how_sure_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("neural.city.json");
    assert_eq!(delft(&out, "--jobs 2").code, 0);
    let neural = fs::read(&out).unwrap();
    let model: Value = serde_json::from_slice(&neural).unwrap();
    let [roofs, buildings] = confidences(&model);
    assert_eq!(buildings.len(), 71);
    assert!(roofs.len() > 100 && roofs.iter().chain(&buildings).all(|c| (0.0..=1.0).contains(c)));
    let mean = buildings.iter().sum::<f64>() / 71.0;
    assert!(mean > 0.8 && mean < 1.0, "{mean}");

    assert_eq!(delft(&out, "--jobs 1 --field neural --overwrite").code, 0);
    assert!(fs::read(&out).unwrap() == neural, "neither the number of threads nor naming the default matters");

    assert_eq!(delft(&out, "--field height-field --overwrite").code, 0);
    assert!(fs::read(&out).unwrap() != neural, "the vote is another field");
    assert_eq!(delft(&out, "--cell-rule paper --overwrite").code, 0);
    assert!(fs::read(&out).unwrap() != neural, "the paper's rule is another rule");
}

#[test]
fn the_network_of_the_paper_runs_through_the_same_door() {
    let folder = house_folder();
    let run = run_in(folder.path(), "house.laz", "footprints.geojson", "--field points2surf");
    assert_ends(&run, 0, &[]);
}

#[test]
fn onnx_runtime_finds_the_same_buildings() {
    let Some(library) = std::env::var("GABLE_ONNXRUNTIME").ok().filter(|library| !library.is_empty()) else {
        println!("skipped: GABLE_ONNXRUNTIME names no library; `sh scripts/setup-onnxruntime.sh` gets one");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let model = |name: &str, options: &str| -> Value {
        let out = folder.path().join(name);
        assert_eq!(delft(&out, options).code, 0);
        serde_json::from_slice(&fs::read(&out).unwrap()).unwrap()
    };
    let embedded = model("embedded.city.json", "");
    let loaded = model("loaded.city.json", &format!("--onnxruntime {library}"));
    let [sure, as_sure] = [&embedded, &loaded].map(|model| confidences(model)[1].clone());
    assert_eq!(sure.len(), as_sure.len());
    // The two round differently in the last digits, which may turn a cell about which the field is of two minds.
    let alike = sure.iter().zip(&as_sure).filter(|(a, b)| (*a - *b).abs() < 0.01).count();
    assert!(alike >= 68, "{alike} of {}", sure.len());
}

#[test]
fn the_embedded_runtime_starts_at_once() {
    let folder = house_folder();
    let time = |field: &str| {
        let start = Instant::now();
        assert_ends(&run_in(folder.path(), "house.laz", "footprints.geojson", &format!("--overwrite {field}")), 0, &[]);
        start.elapsed()
    };
    let vote = (0..3).map(|_| time("--field height-field")).min().unwrap();
    let neural = (0..3).map(|_| time("--field neural")).min().unwrap();
    // A third of a second is what a start may cost on a machine that does nothing else; this one may be busy.
    assert!(neural.saturating_sub(vote).as_secs_f64() < 1.0, "{neural:?} against {vote:?}");
}

#[test]
fn what_is_no_network_and_what_is_no_runtime_is_refused() {
    let folder = house_folder();
    let at = |name: &str| folder.path().join(name);
    fs::write(at("text.safetensors"), "a text").unwrap();
    let embedded = concat!(env!("CARGO_MANIFEST_DIR"), "/src/network/weights/field.safetensors");
    let mut damaged = fs::read(embedded).unwrap();
    let half = damaged.len() / 2;
    damaged[half..half + 4096].fill(0xA5);
    fs::write(at("damaged.safetensors"), damaged).unwrap();
    fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/src/network/weights/points2surf.safetensors"), at("p2s")).unwrap();

    let cases: [(&str, &str, &[&str]); 6] = [
        ("--model", "nowhere.safetensors", &["nowhere.safetensors: cannot open"]),
        ("--model", "text.safetensors", &["found no readable safetensors file", "expected a network file"]),
        ("--model", "p2s", &["found a network of another interface (points2surf)", "one for --field neural"]),
        ("--onnxruntime", "house.laz", &["house.laz", "expected a library of ONNX Runtime", "leave --onnxruntime out"]),
        ("--field height-field --model", "p2s", &["--model: found a value, expected none with --field height-field"]),
        ("--onnxruntime", "nowhere.so", &["nowhere.so", "expected a library of ONNX Runtime"]),
    ];
    for (option, file, says) in cases {
        let run = run_in(folder.path(), "house.laz", "footprints.geojson", &format!("{option} {}", at(file).display()));
        assert_ends(&run, 1, says);
        assert!(!run.err.contains("panicked"), "{}", run.err);
    }
    let run = run_in(folder.path(), "house.laz", "footprints.geojson", "--field neurall");
    assert_ends(&run, 1, &["a similar value exists: 'neural'"]);
    // A graph whose weights are noise is refused or overruled; it neither crashes nor lies.
    let damaged = format!("--model {}", at("damaged.safetensors").display());
    let run = run_in(folder.path(), "house.laz", "footprints.geojson", &damaged);
    assert!((0..=2).contains(&run.code) && !run.err.contains("panicked"), "{}", run.err);
}
