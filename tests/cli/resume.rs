//! `--resume`: what a run that was killed has done is not done again, and the result is that of an undisturbed run.

#![cfg(unix)]

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::json;

use crate::bench::*;

/// The checkpoint of a model.
fn checkpoint(out: &Path) -> PathBuf {
    PathBuf::from(format!("{}.partial/buildings.jsonl", out.display()))
}

/// How many buildings a checkpoint holds: its whole lines but the head.
fn kept(out: &Path) -> u64 {
    let content = std::fs::read(checkpoint(out)).unwrap_or_default();
    // Before the first line end is the head, behind the last one nothing or a line that was cut off.
    (content.split(|&byte| byte == b'\n').count() as u64).saturating_sub(2)
}

/// Starts the quick start on one thread and kills it once `after` buildings are done; says how many are kept. `None` when
/// the run was over before.
fn killed(out: &Path, after: u64, rest: &str) -> Option<u64> {
    let mut command = command(["reconstruct", "--jobs", "1", "--quiet", "-o"]);
    command.arg(out).arg(data("delft_ahn3.laz")).arg("-f").arg(data("footprints.geojson"));
    command.args(rest.split_whitespace());
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    let limit = Instant::now() + Duration::from_mins(2);
    while !checkpoint(out).exists() || kept(out) < after {
        if child.try_wait().unwrap().is_some() {
            return None;
        }
        assert!(Instant::now() < limit, "the run makes no headway");
        std::thread::sleep(Duration::from_micros(200));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    checkpoint(out).exists().then(|| kept(out))
}

#[test]
fn a_run_that_was_killed_at_any_moment_is_resumed_to_the_same_bytes() {
    for extension in ["city.json", "city.jsonl", "gpkg"] {
        let folder = tempfile::tempdir().unwrap();
        let whole = folder.path().join(format!("whole.{extension}"));
        assert_eq!(delft(&whole, "--quiet").code, 0);
        let whole = std::fs::read(whole).unwrap();
        let mut resumed = 0;
        for (round, after) in [0, 1, 7, 15, 22, 30, 37, 45, 52, 60].into_iter().enumerate() {
            let out = folder.path().join(format!("{round}.{extension}"));
            let Some(mut kept) = killed(&out, after, "") else { continue };
            // A kill in the last moments finds the whole model under its name; never half of one.
            assert!(!out.exists() || std::fs::read(&out).unwrap() == whole, "half a model under the final name");
            // A second kill, in the middle of what the first has left.
            if round % 3 == 1 {
                match killed(&out, kept + 4, "--resume") {
                    Some(more) => kept = more,
                    None => continue,
                }
            }
            let run = delft(&out, "--resume");
            assert_eq!(run.code, 0, "{}{}", run.out, run.err);
            assert!(std::fs::read(&out).unwrap() == whole, "killed after {kept} buildings");
            let report = report_of(&out);
            assert_eq!(report["counts"]["resumed"], kept, "what was done is not done again");
            let buildings = report["buildings"].as_array().unwrap();
            assert_eq!(buildings.iter().filter(|b| b["resumed"] == true).count() as u64, kept);
            let left = names_in(folder.path());
            assert!(!left.iter().any(|name| name.contains("part")), "{left:?}");
            resumed += u64::from(kept > 0);
        }
        assert!(resumed >= 5, "the runs were over before they could be killed");
    }
}

/// The files below a folder, by name, with their bytes.
fn tree(folder: &Path) -> Vec<(String, Vec<u8>)> {
    let mut left = vec![folder.to_path_buf()];
    let mut files = Vec::new();
    while let Some(path) = left.pop() {
        if path.is_dir() {
            left.extend(std::fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path()));
        } else {
            let name = path.strip_prefix(folder).unwrap().display().to_string();
            files.push((name, std::fs::read(&path).unwrap()));
        }
    }
    files.sort();
    files
}

#[test]
fn a_tileset_is_resumed_to_the_same_files() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, out] = ["whole.3dtiles", "out.3dtiles"].map(|name| folder.path().join(name));
    assert_eq!(delft(&whole, "--quiet").code, 0);
    let kept = killed(&out, 20, "").expect("killed in time");
    let run = delft(&out, "--resume");
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    assert_eq!(report_of(&out)["counts"]["resumed"], kept);
    assert!(tree(&out) == tree(&whole));
    assert!(run.err.contains("above the ellipsoid"), "what the format does to heights is told: {}", run.err);
}

#[test]
fn what_is_left_is_not_lost_and_not_mixed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.city.json");
    let kept = killed(&out, 5, "").expect("killed in time");
    let run = delft(&out, "");
    assert_ends(&run, 1, &["out.city.json.partial: found", "of a run that did not end", "--resume", "--overwrite"]);
    let run = delft(&out, "--resume --lambda 0.2");
    assert_ends(&run, 1, &["lambda 0.1", "lambda 0.2", "same options"]);
    assert_eq!(self::kept(&out), kept, "a refusal costs nothing");
    let run = delft(&out, "--overwrite");
    assert_ends(&run, 0, &["of a run that did not end are removed"]);
    assert_eq!(report_of(&out)["counts"]["resumed"], 0);
}

#[test]
fn what_was_made_from_other_points_or_footprints_is_made_anew() {
    let folder = tempfile::tempdir().unwrap();
    let [out, fresh] = ["out.city.json", "fresh.city.json"].map(|name| folder.path().join(name));
    killed(&out, 20, "").expect("killed in time");
    // Every other footprint is not as it was.
    let mut layer = json_of(data("footprints.geojson"));
    for feature in layer["features"].as_array_mut().unwrap().iter_mut().step_by(2) {
        let ring = feature["geometry"]["coordinates"][0].as_array_mut().unwrap();
        for corner in [0, ring.len() - 1] {
            ring[corner][0] = json!(ring[corner][0].as_f64().unwrap() + 0.25);
        }
    }
    let changed = folder.path().join("changed.geojson");
    std::fs::write(&changed, layer.to_string()).unwrap();
    let tile = data("delft_ahn3.laz");
    let run = reconstruct(&[&tile], &changed, &out, "--resume --title x");
    assert_ends(&run, 0, &["made from other points, footprints or classes: they are made anew"]);
    let resumed = report_of(&out)["counts"]["resumed"].as_u64().unwrap();
    assert!((1..71).contains(&resumed), "{resumed}");
    assert_ends(&reconstruct(&[&tile], &changed, &fresh, "--title x"), 0, &[]);
    assert!(std::fs::read(&out).unwrap() == std::fs::read(&fresh).unwrap());
}

#[test]
fn without_anything_to_resume_a_run_starts_from_the_beginning() {
    let folder = house_folder();
    let run = run_in(folder.path(), "house.laz", "footprints.geojson", "--resume");
    assert_ends(&run, 0, &["nothing to resume"]);
    let run = run_in(folder.path(), "house.laz", "footprints.geojson", "--resume");
    assert_ends(&run, 1, &["out.city.json", "--overwrite"]);
}

#[test]
fn two_runs_do_not_write_the_same_model() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.city.json");
    let mut command = command(["reconstruct", "--jobs", "1", "--quiet", "-o"]);
    command.arg(&out).arg(data("delft_ahn3.laz")).arg("-f").arg(data("footprints.geojson"));
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
    while !checkpoint(&out).exists() && child.try_wait().unwrap().is_none() {
        std::thread::sleep(Duration::from_micros(200));
    }
    let stopped = std::process::Command::new("kill").args(["-STOP", &child.id().to_string()]).status().unwrap();
    assert!(stopped.success());
    if child.try_wait().unwrap().is_none() && checkpoint(&out).exists() {
        assert_ends(&delft(&out, "--overwrite"), 1, &["another run that is writing this model"]);
    }
    std::process::Command::new("kill").args(["-CONT", &child.id().to_string()]).status().unwrap();
    assert!(child.wait().unwrap().success());
    assert_eq!(json_of(&out)["type"], "CityJSON");
}

#[test]
fn a_run_that_was_killed_as_it_ended_is_resumed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.city.json");
    assert_eq!(delft(&out, "--quiet --field height-field").code, 0);
    let whole = std::fs::read(&out).unwrap();
    // The model has its name, and of what was kept beside it only the folder is left.
    let partial = folder.path().join("out.city.json.partial");
    std::fs::create_dir(&partial).unwrap();
    assert_says(&delft(&out, "--field height-field").err, &["--overwrite"]);
    let run = delft(&out, "--resume --field height-field");
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(std::fs::read(&out).unwrap() == whole && !partial.exists());
}
