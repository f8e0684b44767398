//! Real neighbourhoods beyond the bundled one, where they lie beside the project: counts, validity and fit.

use std::path::PathBuf;

use serde_json::Value;
use tempfile::tempdir;

use crate::bench::*;

/// Files of the data folder beside the project; `None`, and said so, where it is not there.
fn shared<const N: usize>(names: [&str; N]) -> Option<[PathBuf; N]> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data"));
    let files = names.map(|name| folder.join(name));
    let there = files.iter().all(|file| file.exists());
    if !there {
        println!("skipped: {} are not there", names.join(", "));
    }
    there.then_some(files)
}

/// The figures of `gable evaluate` for a model and its points.
fn figures(model: &std::path::Path, tiles: &[&std::path::Path]) -> Value {
    let json = model.with_extension("figures.json");
    let mut command = command(["evaluate"]);
    let run: Run = command.arg(model).arg("--json").arg(&json).arg("--points").args(tiles).output().unwrap().into();
    assert_eq!(run.code, 0, "{}", run.err);
    json_of(&json)["overall"].clone()
}

#[test]
fn delft_without_a_crs_in_its_tiles() {
    let names = ["delft/ahn3_cropped_1.laz", "delft/ahn3_cropped_2.laz", "delft/bgt_pand.sqlite"];
    let Some([one, two, footprints]) = shared(names) else { return };
    let folder = tempdir().unwrap();
    let out = folder.path().join("delft.city.json");
    let run = reconstruct(&[&one, &two], &footprints, &out, "--crs EPSG:7415");
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    assert_valid(&out);
    let counts = report_of(&out)["counts"].clone();
    assert_eq!((&counts["footprints"], &counts["written"]), (&160.into(), &160.into()));
    assert!(counts["buildings_lod22"].as_u64().unwrap() >= 158, "{counts:#}");

    let overall = figures(&out, &[&one, &two]);
    let figure = |pointer: &str| overall.pointer(pointer).and_then(Value::as_f64).unwrap();
    assert_eq!(overall["valid_solids"], overall["solids"], "every solid that is written is valid");
    assert!(figure("/points/vertical/median") <= 0.035, "{overall:#}");
    assert!(figure("/points/vertical/within_0_2") >= 0.82, "{overall:#}");
    assert!(figure("/tops/above_1") <= 1.0, "{overall:#}");
    assert!(figure("/faces/median") <= 20.0, "{overall:#}");

    let other = folder.path().join("other.city.json");
    assert_eq!(reconstruct(&[&two, &one], &footprints, &other, "--crs EPSG:7415 --jobs 1").code, 0);
    assert!(std::fs::read(&other).unwrap() == std::fs::read(&out).unwrap());
}

#[test]
fn an_old_city_cut_by_the_edge_of_its_tiles() {
    let names =
        ["ahn_2386_9702.laz", "ahn_2397_9705.laz", "footprints.geojson"].map(|n| format!("amsterdam-dense/{n}"));
    let Some([one, two, footprints]) = shared(names.each_ref().map(String::as_str)) else { return };
    let folder = tempdir().unwrap();
    let out = folder.path().join("old.city.json");
    let run = reconstruct(&[&one, &two], &footprints, &out, "--crs EPSG:7415");
    assert!(matches!(run.code, 0 | 2), "{}{}", run.out, run.err);
    assert_says(&run.err, &["22 of 31 footprints are not wholly covered by the tiles"]);
    assert_valid(&out);
    for building in report_of(&out)["buildings"].as_array().unwrap() {
        if building["points"].as_u64().unwrap() >= 50 {
            // Half a metre beyond the tiles counts as covered, so that some are whole that the tiles do not quite cover.
            let coverage = building["coverage"].as_f64().unwrap();
            let outcome = building["outcome"].as_str().unwrap();
            match coverage {
                0.999.. => assert_eq!(outcome, "lod22", "{building:#}"),
                ..0.9 => assert_eq!(outcome, "partial", "{building:#}"),
                _ => assert!(["lod22", "partial"].contains(&outcome), "{building:#}"),
            }
        }
    }
    let overall = figures(&out, &[&one, &two]);
    assert_eq!(overall["valid_solids"], overall["solids"]);
}

#[test]
fn a_rural_tile_with_a_shapefile_needs_no_option() {
    let [tile, footprints] =
        ["postCompletion.laz", "postIA.shp"].map(|n| format!("ign-rural/870000_6618000.subset.{n}"));
    let Some([tile, footprints]) = shared([tile.as_str(), footprints.as_str()]) else { return };
    let folder = tempdir().unwrap();
    let out = folder.path().join("rural.city.jsonl");
    let run = reconstruct(&[&tile], &footprints, &out, "");
    assert!(matches!(run.code, 0 | 2), "{}{}", run.out, run.err);
    let report = report_of(&out);
    assert_eq!(report["crs"]["code"], "EPSG:2154");
    assert_eq!(report["counts"]["written"], 40);
    let with_points = |b: &&Value| b["points"].as_u64().unwrap() > 0;
    let buildings = report["buildings"].as_array().unwrap();
    assert!(buildings.iter().filter(with_points).count() >= 5);
    assert!(buildings.iter().filter(with_points).all(|b| b["outcome"] == "lod22"), "{report:#}");
}
