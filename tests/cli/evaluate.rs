//! `gable evaluate`, and the accuracy that the bundled neighbourhood must reach.

use tempfile::tempdir;

use crate::bench::*;

const REFERENCE: &str = "reference_3dbag_lod22.city.jsonl";

fn evaluate(model: &std::path::Path, rest: &[&std::path::Path], json: &std::path::Path) -> Run {
    let mut command = command(["evaluate"]);
    command.arg(model).args(rest).arg("--json").arg(json);
    command.output().unwrap().into()
}

#[test]
fn a_model_against_itself_and_the_points_it_was_made_from() {
    let folder = tempdir().unwrap();
    let json = folder.path().join("figures.json");
    let [points, reference] = ["--points", "--reference"].map(std::path::Path::new);
    let (tile, model) = (data("delft_ahn3.laz"), data(REFERENCE));
    let run = evaluate(&model, &[points, &tile, reference, &model], &json);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.out, &["within 0.2 m", "84.0 %", "volume, intersection over union", "1.0000", "least agreement"]);
    let figures = json_of(&json);
    assert_eq!(figures["buildings"].as_array().unwrap().len(), 11);
    // Figures of the reference that were measured by other means.
    let vertical = &figures["overall"]["points"]["vertical"];
    assert!((vertical["offset"].as_f64().unwrap() + 0.005).abs() < 0.001, "{vertical}");
    assert_eq!(figures["overall"]["reference"]["matched"], 11);
    let again = folder.path().join("again.json");
    assert_eq!(evaluate(&model, &[points, &tile, reference, &model], &again).code, 0);
    assert_eq!(std::fs::read(&json).unwrap(), std::fs::read(&again).unwrap());
}

#[test]
fn the_quick_start_reaches_what_is_promised() {
    let folder = tempdir().unwrap();
    let [model, json] = ["delft.city.json", "figures.json"].map(|name| folder.path().join(name));
    let run = delft(&model, "");
    assert!(matches!(run.code, 0 | 2), "{}", run.err);
    let [points, reference] = ["--points", "--reference"].map(std::path::Path::new);
    let run = evaluate(&model, &[points, &data("delft_ahn3.laz"), reference, &data(REFERENCE)], &json);
    assert_eq!(run.code, 0, "{}", run.err);
    let overall = json_of(&json)["overall"].clone();
    let figure = |pointer: &str| overall.pointer(pointer).and_then(serde_json::Value::as_f64).unwrap();
    assert_eq!(overall["valid_solids"], overall["solids"], "every solid that is written is valid");
    assert!(figure("/points/vertical/median") <= 0.035, "{overall:#}");
    assert!(figure("/points/vertical/within_0_2") >= 0.82, "{overall:#}");
    assert!(figure("/tops/above_1") <= 1.0, "{overall:#}");
    assert!(figure("/faces/median") <= 20.0, "{overall:#}");
    assert!(figure("/reference/roof_distance") <= 0.05, "{overall:#}");
    assert!(figure("/reference/volume_iou") >= 0.95, "{overall:#}");
}

#[test]
fn what_cannot_be_evaluated_is_said() {
    let run = gable(["evaluate".as_ref(), data(REFERENCE).as_os_str(), "--lod".as_ref(), "3.3".as_ref()]);
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["buildings at LoD 1.2, 1.3, 2.2 only", "--lod"]);
    let run = gable(["evaluate".as_ref(), data("footprints.geojson").as_os_str()]);
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["footprints.geojson", "CityJSON"]);
}
