//! `gable reconstruct` on the quick start and on made-up houses.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;

use serde_json::Value;
use tempfile::tempdir;

use crate::bench::*;

/// The ids of the footprint file, in its order.
fn delft_ids() -> Vec<String> {
    let footprints = json_of(data("footprints.geojson"));
    let features = footprints["features"].as_array().unwrap();
    features.iter().map(|f| f["properties"]["id"].as_str().unwrap().to_owned()).collect()
}

#[test]
fn the_quick_start_gives_every_building_a_model_and_a_report() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("delft.city.json");
    let run = delft(&out, "");
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    assert_says(&run.out, &["footprints", "LoD 2.2", "points in footprints", "time and memory", "delft.city.json"]);
    assert!(!run.err.contains('\u{1b}') && !run.err.contains('\r'), "a progress bar in a pipe: {:?}", run.err);
    assert_says(&run.err, &["collecting points: ", "reconstructing: 71 buildings in "]);

    let model = json_of(&out);
    assert_eq!(model["type"], "CityJSON");
    assert_valid(&out);
    let objects = model["CityObjects"].as_object().unwrap();
    let buildings: Vec<_> = objects.iter().filter(|(_, o)| o["type"] == "Building").map(|(id, _)| id.clone()).collect();
    assert_eq!(buildings.len(), 71);

    let report = report_of(&out);
    let ids: Vec<_> = report["buildings"].as_array().unwrap().iter().map(|b| b["id"].as_str().unwrap()).collect();
    assert_eq!(ids, delft_ids());
    assert_eq!(report["exit_code"], 0);
    assert_eq!(report["crs"]["code"], "EPSG:7415");
    assert_eq!(report["crs"]["source"], "tiles");
    assert_eq!(report["inputs"]["tiles"][0]["points"], 141_577);
    assert_eq!(report["inputs"]["footprints"]["footprints"], 71);
    let counts = &report["counts"];
    assert_eq!((&counts["footprints"], &counts["written"]), (&71.into(), &71.into()));
    assert!(counts["buildings_lod22"].as_u64().unwrap() >= 70, "{counts:#}");
    assert_eq!(report["quality"]["rmse_lod22"]["buildings"], counts["buildings_lod22"]);
    assert_eq!(report["outputs"].as_array().unwrap().len(), 2);
}

#[test]
fn the_bytes_do_not_depend_on_the_number_of_threads() {
    let folder = tempdir().unwrap();
    let models: Vec<Vec<u8>> = [1, 2, 3]
        .map(|jobs| {
            let out = folder.path().join(format!("{jobs}.city.jsonl"));
            let run = delft(&out, &format!("--jobs {jobs} --quiet"));
            assert_eq!((run.code, run.out.as_str(), run.err.as_str()), (0, "", ""));
            assert_eq!(report_of(&out)["threads"], jobs);
            std::fs::read(out).unwrap()
        })
        .into();
    assert!(models[0] == models[1] && models[0] == models[2]);
    let text = String::from_utf8(models[0].clone()).unwrap();
    let lines: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines[0]["type"], "CityJSON");
    let ids: Vec<_> = lines[1..].iter().map(|feature| feature["id"].as_str().unwrap().to_owned()).collect();
    assert_eq!(ids, delft_ids(), "features stand in the order of the footprints");
}

#[test]
fn the_models_do_not_depend_on_how_the_cloud_was_cut() {
    let folder = tempdir().unwrap();
    let whole = folder.path().join("whole.city.jsonl");
    assert_eq!(delft(&whole, "--quiet").code, 0);
    let quarters = cut_into_four(&data("delft_ahn3.laz"), folder.path());
    let cut = folder.path().join("cut.city.jsonl");
    for order in [[0, 1, 2, 3], [2, 0, 3, 1]] {
        let tiles = order.map(|i| quarters[i].as_path());
        let run = reconstruct(&tiles, &data("footprints.geojson"), &cut, "--overwrite --quiet");
        assert_eq!(run.code, 0, "{}", run.err);
        assert_eq!(report_of(&cut)["counts"]["points"], report_of(&whole)["counts"]["points"]);
        assert!(std::fs::read(&cut).unwrap() == std::fs::read(&whole).unwrap(), "{order:?}");
    }
}

#[test]
fn footprints_in_degrees_are_brought_to_the_tiles() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("delft.city.json");
    let run = reconstruct(&[&data("delft_ahn3.laz")], &data("footprints_wgs84.geojson"), &out, "");
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    let report = report_of(&out);
    assert_eq!(report["counts"]["written"], 71);
    assert_eq!(report["inputs"]["footprints"]["crs"], "OGC:CRS84");
    let points = report["counts"]["points"].as_u64().unwrap();
    assert!((27_500..=28_000).contains(&points), "{points}: 27 744 with the footprints in the CRS of the tiles");
}

/// A folder with a made-up house and its footprint.
fn house(class: u8) -> tempfile::TempDir {
    let folder = tempdir().unwrap();
    write_house(&folder.path().join("house.laz"), None, class);
    write_footprints(&folder.path().join("footprints.geojson"), &[("007", rectangle(0.0, 0.0, 10.0, 8.0))]);
    folder
}

fn house_run(folder: &Path, rest: &str) -> Run {
    let out = folder.join("out.city.json");
    reconstruct(
        &[&folder.join("house.laz")],
        &folder.join("footprints.geojson"),
        &out,
        &format!("--crs EPSG:7415 {rest}"),
    )
}

#[test]
fn a_house_is_a_box() {
    let folder = house(6);
    let run = house_run(folder.path(), "--verbose");
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    assert_says(&run.err, &["007: LoD 2.2, 320 points"]);
    let report = report_of(&folder.path().join("out.city.json"));
    assert_eq!(report["crs"]["source"], "option");
    assert_eq!(report["buildings"][0]["id"], "007");
    assert_eq!(report["buildings"][0]["outcome"], "lod22");
    assert_eq!(report["buildings"][0]["points"], 320);
    assert!(report["buildings"][0]["rmse_lod22"].as_f64().unwrap() < 0.01);
}

#[test]
fn some_buildings_without_a_model_are_exit_code_2() {
    let folder = house(6);
    let features = [
        ("1", rectangle(0.0, 0.0, 10.0, 8.0)),
        ("2", line()),
        ("3", Value::Null),
        ("4", rectangle(12.0, 1.0, 16.0, 5.0)),
    ];
    write_footprints(&folder.path().join("footprints.geojson"), &features);
    let run = house_run(folder.path(), "");
    assert_eq!(run.code, 2, "{}{}", run.out, run.err);
    assert_says(
        &run.out,
        &["without a model:\n", "  2: rejected (no usable polygon", "  3: rejected (no usable polygon"],
    );
    assert!(!run.out.contains("  4: "), "a footprint without points owes nobody a model");
    let report = report_of(&folder.path().join("out.city.json"));
    let outcomes: Vec<_> = report["buildings"].as_array().unwrap().iter().map(|b| (&b["id"], &b["outcome"])).collect();
    assert_eq!(outcomes.len(), 4, "{outcomes:?}");
    assert_eq!(report["counts"]["skipped"]["no-polygon"], 2);
    assert_eq!(report["counts"]["skipped"]["no-points"], 1);
    assert_eq!(report["counts"]["lacking"], 2);
    let model = json_of(folder.path().join("out.city.json"));
    let objects = model["CityObjects"].as_object().unwrap();
    assert_eq!(objects.values().filter(|o| o["type"] == "Building").count(), 4, "nothing is dropped in silence");
}

#[test]
fn no_building_at_all_is_exit_code_1_and_says_which_classes_there_are() {
    let folder = house(1);
    let run = house_run(folder.path(), "");
    assert_eq!(run.code, 1, "{}{}", run.out, run.err);
    assert_says(&run.err, &["no point of building class 6", "1 (320 points)", "2 (3040 points)", "--building-class"]);
    assert!(!folder.path().join("out.city.json").exists());
}

#[test]
fn footprints_without_a_single_building_point_are_exit_code_1() {
    let folder = house(6);
    let beside = [("1", rectangle(12.0, 1.0, 16.0, 5.0)), ("2", rectangle(12.0, 8.0, 16.0, 12.0))];
    write_footprints(&folder.path().join("footprints.geojson"), &beside);
    let run = house_run(folder.path(), "");
    assert_eq!(run.code, 1, "{}{}", run.out, run.err);
    assert_says(&run.err, &["no footprint holds a point of building class 6", "6 (building): 320", "--building-class"]);
    let report = report_of(&folder.path().join("out.city.json"));
    assert_eq!((&report["exit_code"], &report["counts"]["written"]), (&1.into(), &2.into()));
    assert_eq!(report["counts"]["skipped"]["no-points"], 2);
}

#[test]
fn classes_are_chosen() {
    let folder = house(1);
    assert_eq!(house_run(folder.path(), "--building-class 6,1").code, 0);
    let run = house_run(folder.path(), "--building-class any --overwrite");
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    let run = house_run(folder.path(), "--building-class roof --overwrite");
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["roof", "any"]);
}

#[test]
fn a_single_object_needs_no_footprint() {
    let folder = house(6);
    let out = folder.path().join("out.city.json");
    let tile = folder.path().join("house.laz");
    let args = ["reconstruct", "--no-footprint", "--crs", "EPSG:7415", "-o"].map(std::ffi::OsStr::new);
    let run = gable(args.into_iter().chain([out.as_os_str(), tile.as_os_str()]));
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    let report = report_of(&out);
    assert_eq!(report["counts"]["footprints"], 1);
    assert_eq!(report["buildings"][0]["id"], "house");
    assert_eq!(report["inputs"]["footprints"], Value::Null);
}

#[test]
fn a_folder_gets_a_file_named_after_the_inputs() {
    let folder = house(6);
    let tile = folder.path().join("house.laz");
    let footprints = folder.path().join("footprints.geojson");
    let run = reconstruct(&[&tile], &footprints, &folder.path().join("new"), "--crs EPSG:7415");
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    assert!(folder.path().join("new/house.city.json").is_file());
    assert!(folder.path().join("new/house.city.json.report.json").is_file());
}

#[test]
fn a_report_goes_where_it_is_told() {
    let folder = house(6);
    let report = folder.path().join("r.json");
    let run = house_run(folder.path(), &format!("--report {}", report.display()));
    assert_eq!(run.code, 0, "{}", run.err);
    assert_eq!(json_of(&report)["exit_code"], 0);
    let run =
        house_run(folder.path(), &format!("--overwrite --report {}", folder.path().join("out.city.json").display()));
    assert_eq!(run.code, 1, "the report would replace the model");
    assert!(!folder.path().join("out.city.json.report.json").exists());
}

#[test]
fn a_damaged_tile_costs_no_more_than_itself() {
    let folder = house(6);
    let good = folder.path().join("house.laz");
    let bad = folder.path().join("bad.laz");
    std::fs::write(&bad, b"LASF and then nothing").unwrap();
    let footprints = folder.path().join("footprints.geojson");
    let out = folder.path().join("out.city.json");
    let run = reconstruct(&[&bad, &good], &footprints, &out, "--crs EPSG:7415");
    assert_eq!(run.code, 2, "the other tiles are used, but not all is well: {}{}", run.out, run.err);
    assert_says(&run.err, &["warning: ", "bad.laz"]);
    assert_says(&run.out, &["tiles that could not be read or not wholly: 1 of 2\n"]);
    let report = report_of(&out);
    let problems: Vec<_> =
        report["inputs"]["tiles"].as_array().unwrap().iter().map(|t| t["problems"].as_array().unwrap().len()).collect();
    assert_eq!(problems.iter().sum::<usize>(), 1);
    assert_eq!((&report["exit_code"], &report["inputs"]["tiles"][0]["left_out"]), (&2.into(), &true.into()));
    assert_eq!(report["buildings"][0]["outcome"], "lod22");
}

#[cfg(unix)]
#[test]
fn an_interrupt_keeps_what_is_done() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("delft.city.json");
    let mut command = command(["reconstruct", "--jobs", "1", "--verbose", "-o"]);
    command.arg(&out).arg(data("delft_ahn3.laz")).arg("--footprints").arg(data("footprints.geojson"));
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    // Once the points are collected the buildings are under way.
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    assert!(lines.by_ref().any(|line| line.unwrap().starts_with("collecting points: ")));
    let signal = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(signal.success());
    let rest: Vec<String> = lines.map(Result::unwrap).collect();
    let code = child.wait().unwrap().code();
    // How far it came depends on the machine; whatever was done must be there, and be told as it is.
    if code == Some(1) {
        assert!(rest.iter().any(|line| line.contains("interrupted before anything was written")), "{rest:?}");
        assert!(!out.exists());
        return;
    }
    let report = report_of(&out);
    let counts = &report["counts"];
    let written = counts["written"].as_u64().unwrap();
    assert_eq!(written + counts["not_reached"].as_u64().unwrap(), 71);
    assert_eq!(code, Some(if written < 71 { 2 } else { 0 }), "{rest:?}");
    assert_eq!(report["interrupted"].as_bool().unwrap(), written < 71);
    let model = json_of(&out);
    let objects = model["CityObjects"].as_object().unwrap();
    assert_eq!(objects.values().filter(|o| o["type"] == "Building").count() as u64, written);
    if written < 71 {
        let resumed = delft(&out, "--resume --quiet");
        assert_eq!(resumed.code, 0, "{}", resumed.err);
        assert_eq!(report_of(&out)["counts"]["resumed"], written);
        let whole = folder.path().join("whole.city.json");
        assert_eq!(delft(&whole, "--quiet").code, 0);
        assert!(std::fs::read(&out).unwrap() == std::fs::read(&whole).unwrap());
    }
}
