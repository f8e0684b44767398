//! The library as others call it: from Rust and from C.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on fails")]

mod c;
#[path = "../cli/damage.rs"]
mod damage;
mod examples;
mod feed;
mod halls;
mod worse_than_block;

use std::path::{Path, PathBuf};

use gable::network::{Field, FieldOptions};
use gable::run::{FootprintSource, Job};
use gable::source::footprints::FootprintOptions;
use gable::source::points::{ScanPoint, Tile};

/// A file of the quick start.
fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data").join(name)
}

/// The points of the quick start.
fn points() -> Vec<ScanPoint> {
    let mut points = Vec::new();
    let tile = Tile::open(data("delft_ahn3.laz")).unwrap();
    tile.stream(None, &mut |block| points.extend(block.points())).unwrap();
    assert_eq!(points.len(), 141_577);
    points
}

/// The quick start, with the field that takes the least time.
fn quickstart(output: &Path) -> Job {
    let footprints = FootprintSource { path: data("footprints.geojson"), options: FootprintOptions::default() };
    Job {
        tiles: vec![data("delft_ahn3.laz").display().to_string()],
        footprints: Some(footprints),
        output: output.to_path_buf(),
        field: FieldOptions { field: Field::HeightField, ..FieldOptions::default() },
        ..Job::default()
    }
}
