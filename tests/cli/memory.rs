//! A front that sweeps over tiles gives the same model whatever it may hold, and in however many tiles the points come.

use std::path::{Path, PathBuf};

use serde_json::json;

use crate::bench::*;

/// Cuts the bundled tile into columns and rows of tiles, some of which overlap.
fn cut(folder: &Path, columns: u32, rows: u32) -> PathBuf {
    let tiles = folder.join(format!("{columns}x{rows}"));
    std::fs::create_dir(&tiles).unwrap();
    let info = gable(["info", "--json", data("delft_ahn3.laz").to_str().unwrap()]);
    let info: serde_json::Value = serde_json::from_str(&info.out).unwrap();
    let extent = &info["tiles"][0]["extent"];
    let end = |corner: usize, axis: usize| extent[corner][axis].as_f64().unwrap();
    let mut stages = vec![json!({"type": "readers.las", "filename": data("delft_ahn3.laz"), "tag": "all"})];
    for column in 0..columns {
        for row in 0..rows {
            let side = |axis: usize, n: u32, of: u32| {
                let (low, high) = (end(0, axis), end(1, axis));
                let length = (high - low) / f64::from(of);
                // Every other one reaches into the next.
                [low + length * f64::from(n) - 0.01, low + length * f64::from(n + 1) + 3.0 * f64::from(n % 2) + 0.01]
            };
            let ([x0, x1], [y0, y1]) = (side(0, column, columns), side(1, row, rows));
            let tag = format!("tile_{column}_{row}");
            stages.push(json!({"type": "filters.crop", "bounds": format!("([{x0}, {x1}], [{y0}, {y1}])"), "inputs": ["all"], "tag": tag}));
            let filename = tiles.join(format!("{column}-{row}.laz"));
            stages.push(json!({"type": "writers.las", "filename": filename, "inputs": [tag], "forward": "all"}));
        }
    }
    let pipeline = folder.join("cut.json");
    std::fs::write(&pipeline, json!(stages).to_string()).unwrap();
    assert_ends(&gable(["pipeline", pipeline.to_str().unwrap()]), 0, &[]);
    tiles
}

#[test]
fn the_model_is_the_same_whatever_is_held_and_however_the_points_are_cut() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole.city.json");
    assert_ends(&delft(&whole, "--title x"), 0, &[]);
    let expected = std::fs::read(&whole).unwrap();
    for (columns, rows) in [(1, 4), (3, 3)] {
        let tiles = cut(folder.path(), columns, rows);
        for (memory, jobs) in [("0B", 1), ("100kB", 3), ("1GiB", 2)] {
            let out = folder.path().join(format!("{columns}-{memory}-{jobs}.city.json"));
            let rest = format!("--title x --memory {memory} -j {jobs}");
            assert_ends(&reconstruct(&[&tiles], &data("footprints.geojson"), &out, &rest), 0, &[]);
            assert!(std::fs::read(&out).unwrap() == expected, "{columns} × {rows} tiles, {memory}, {jobs} threads");
        }
    }
}

#[test]
fn a_size_of_memory_is_a_number_of_bytes() {
    let folder = house_folder();
    for size in ["some", "-1", "12 parsecs", "1e400"] {
        let run =
            run_in(folder.path(), "house.laz", "footprints.geojson", &format!("--memory={}", size.replace(' ', "_")));
        assert_ends(&run, 1, &["--memory", "such as 64MB or 1GiB"]);
    }
    assert_ends(&run_in(folder.path(), "house.laz", "footprints.geojson", "--memory 1.5kB"), 0, &[]);
}
