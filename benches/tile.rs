//! The whole road on the bundled corner of Delft, 71 footprints and 141 577 points, files in and files out; and the
//! evaluation of what comes out.
//!
//! `cargo bench --bench tile`

#![allow(clippy::expect_used, reason = "a bench on the bundled data has nobody to report to")]

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use divan::Bencher;
use divan::counter::ItemsCount;
use gable::evaluate::{PointMeter, TileFilter, read_shapes};
use gable::run::{FootprintSource, Job, Silent, run};
use gable::source::footprints::FootprintOptions;

fn main() {
    divan::main();
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data").join(name)
}

fn job(threads: usize, folder: &Path) -> Job {
    Job {
        tiles: vec![data("delft_ahn3.laz").display().to_string()],
        footprints: Some(FootprintSource { path: data("footprints.geojson"), options: FootprintOptions::default() }),
        output: folder.join("delft.city.json"),
        overwrite: true,
        threads: NonZeroUsize::new(threads),
        ..Job::default()
    }
}

#[divan::bench(args = [1, 2], sample_count = 10, sample_size = 1)]
fn delft(bencher: Bencher, threads: usize) {
    let folder = tempfile::tempdir().expect("a folder for the output");
    let job = job(threads, folder.path());
    bencher.counter(ItemsCount::new(71_usize)).bench_local(|| run(&job, &Silent).expect("the bundled data is sound"));
}

#[divan::bench(sample_count = 10, sample_size = 1)]
fn evaluate_points(bencher: Bencher) {
    let folder = tempfile::tempdir().expect("a folder for the output");
    let job = job(1, folder.path());
    run(&job, &Silent).expect("the bundled data is sound");
    let model = read_shapes(&job.output, "2.2", None).expect("gable reads what it writes");
    let filter = TileFilter { classes: &[6], frame: model.frame, crs: model.crs.as_ref() };
    bencher.counter(ItemsCount::new(141_577_usize)).bench_local(|| {
        let mut meter = PointMeter::new(&model.shapes);
        meter.add_tiles(&[data("delft_ahn3.laz")], filter).expect("the bundled data is sound");
        meter.finish()
    });
}
