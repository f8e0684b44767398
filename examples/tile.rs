//! A tile with its footprints: what `gable reconstruct` does, from Rust.
//!
//! ```text
//! cargo run --release --example tile
//! ```

use std::error::Error;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use gable::building::LadderStep;
use gable::run::{Event, FootprintSource, Job, Observer, run};
use gable::source::footprints::FootprintOptions;

/// Listens to the run: it may show progress, and stop the run by `interrupted`. Events come from several threads.
#[derive(Default)]
struct Listener {
    buildings: AtomicUsize,
}

impl Observer for Listener {
    fn event(&self, event: Event<'_>) {
        match event {
            Event::Started { stage, total } => println!("{}: {total} {}s", stage.label(), stage.unit()),
            Event::Building(_) => drop(self.buildings.fetch_add(1, Ordering::Relaxed)),
            Event::Warning(text) => println!("note: {text}"),
            _ => {}
        }
    }
}

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data");
    let folder = tempfile::tempdir()?;
    let job = Job {
        // Files, folders or patterns, as on the command line.
        tiles: vec![data.join("delft_ahn3.laz").display().to_string()],
        footprints: Some(FootprintSource {
            path: data.join("footprints.geojson"),
            options: FootprintOptions::default(),
        }),
        // The extension chooses the format.
        output: folder.path().join("delft.city.jsonl"),
        ..Job::default()
    };
    let listener = Listener::default();
    let report = run(&job, &listener)?;

    // A building that could not be done is no error: it is in the report, with its reason.
    let counts = &report.counts;
    println!("{} of {} buildings at LoD 2.2", counts.buildings_lod22, counts.footprints);
    for building in report.buildings.iter().filter(|building| building.ladder_step != Some(LadderStep::Lod22)) {
        println!("  {}: {:?}", building.id, building.outcome);
    }
    assert_eq!(listener.buildings.into_inner(), 71);
    assert!(counts.buildings_lod22 >= 70);
    // One line for the head and one for each building.
    assert_eq!(std::fs::read_to_string(&job.output)?.lines().count(), 72);
    Ok(())
}
