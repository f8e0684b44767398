//! Compressed tiles whose damage sends the decoder of the laz crate into an endless recursion: every command names file and
//! chunk, uses the rest, and says nothing of a panic.

use std::path::Path;

use serde_json::json;

use crate::bench::*;
use crate::damage::write_damaged;

/// Asserts that a command went on without a chunk of this tile.
fn assert_goes_on(run: &Run, tile: &str) {
    let told = format!("{}{}", run.out, run.err);
    assert_eq!(run.code, 2, "{told}");
    assert_says(&told, &[tile, "of 120000 points are missing", "in the chunk at byte"]);
    assert!(!told.contains("panicked") && !told.contains("stack"), "{told}");
}

/// The house folder with a damaged tile of a point format in place of the sound one.
fn damaged_folder(format: u8) -> tempfile::TempDir {
    let folder = house_folder();
    write_damaged(&folder.path().join("house.laz"), format);
    folder
}

#[test]
fn info_names_the_chunk_and_counts_the_rest() {
    let folder = damaged_folder(1);
    assert_goes_on(&gable([Path::new("info"), &folder.path().join("house.laz")]), "house.laz");
}

#[test]
fn reconstruct_uses_the_rest() {
    let folder = damaged_folder(1);
    assert_goes_on(&run_in(folder.path(), "house.laz", "footprints.geojson", ""), "house.laz");
    let report = report_of(&folder.path().join("out.city.json"));
    assert_eq!(report["buildings"][0]["outcome"], "lod22");
    let missing = report["inputs"]["tiles"][0]["missing_points"].as_u64().unwrap();
    assert!((1..=50_000).contains(&missing), "{missing}");
}

#[test]
fn pipelines_use_the_rest() {
    // Layers of times are decoded for whoever wants all fields.
    for format in [1, 6] {
        let folder = damaged_folder(format);
        let pipeline = folder.path().join("pipeline.json");
        let stages = json!(["house.laz", {"type": "filters.range", "limits": "Classification[6:6]"}, "roof.las"]);
        std::fs::write(&pipeline, stages.to_string()).unwrap();
        let run = command(["pipeline", "pipeline.json"]).current_dir(folder.path()).output().unwrap().into();
        assert_goes_on(&run, "house.laz");
        let roof = las::Reader::from_path(folder.path().join("roof.las")).unwrap().header().number_of_points();
        assert_eq!(roof, 40 * 32, "format {format}");
    }
}

#[test]
fn the_tile_of_the_load_test_is_read_as_far_as_it_is_sound() {
    let Some(tile) = shared("reported/load/stack-overflow.laz") else { return };
    let run = gable([Path::new("info"), &tile]);
    assert_ends(&run, 2, &[]);
    assert_says(&run.out, &["stack-overflow.laz", "of 208432 points are missing", "in the chunk at byte"]);
    assert!(!run.err.contains("panicked") && !run.err.contains("stack backtrace"), "{}", run.err);
}
