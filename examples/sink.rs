//! A `Sink` of one's own, and points that come from memory: nothing is read from a tile and no model is written to a file.
//!
//! ```text
//! cargo run --release --example sink
//! ```
//!
//! The sink makes a table of the roofs: a line for every roof plane.

use std::error::Error;
use std::io::Write;
use std::path::{Path, PathBuf};

use gable::error::{self, Result};
use gable::run::{Feed, FootprintSource, Job, Silent, run_into};
use gable::serde_json::Value;
use gable::sink::{Feature, Sink, Written};
use gable::source::footprints::FootprintOptions;
use gable::source::points::{ScanPoint, Tile};

/// Writes a line for every roof plane to anything that takes bytes.
struct RoofTable<W> {
    out: W,
    buildings: usize,
    roofs: usize,
}

impl<W: Write + Send> Sink for RoofTable<W> {
    /// Features come one by one, in the order of the footprints: a building and its parts, with a model or with the reason
    /// why not.
    fn write(&mut self, feature: &Feature) -> Result<()> {
        self.buildings += 1;
        let geometries = feature.objects.iter().flat_map(|object| &object.geometries);
        for geometry in geometries.filter(|geometry| geometry.lod == "2.2") {
            for roof in geometry.surfaces.iter().filter(|surface| surface.kind == "RoofSurface") {
                let number = |name: &str| roof.attributes.get(name).and_then(Value::as_f64).unwrap_or(f64::NAN);
                let (slope, azimuth, top) = (number("slope"), number("azimuth"), number("height_max"));
                writeln!(self.out, "{},{slope:.1},{azimuth:.0},{top:.2}", feature.id)
                    .map_err(|fault| error::Error::io("the table of roofs", "write", fault))?;
                self.roofs += 1;
            }
        }
        Ok(())
    }

    /// Called once after the last building, also when the run was stopped.
    fn finish(self: Box<Self>) -> Result<Written> {
        let Self { buildings, roofs, .. } = *self;
        let path = PathBuf::new();
        Ok(Written { path, format: None, features: buildings, objects: roofs, bytes: 0, notes: Vec::new() })
    }
}

/// Stands in for whatever has points: here the bundled tile, in chunks.
fn chunks(tile: &Path, mut take: impl FnMut(&[ScanPoint]) -> Result<()>) -> Result<()> {
    let mut outcome = Ok(());
    Tile::open(tile)?.stream(None, &mut |block| {
        let chunk: Vec<ScanPoint> = block.points().collect();
        if outcome.is_ok() {
            outcome = take(&chunk);
        }
    })?;
    outcome
}

pub(crate) fn main() -> std::result::Result<(), Box<dyn Error>> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data");

    // Points wait in a temporary file, so there may be more of them than fit in memory.
    let mut feed = Feed::new("delft")?;
    chunks(&data.join("delft_ahn3.laz"), |chunk| feed.push(chunk.iter().copied()))?;
    let fed = feed.finish(Some("EPSG:7415"))?;

    let footprints = FootprintSource { path: data.join("footprints.geojson"), options: FootprintOptions::default() };
    // Without an output no model is written; with one it would be, besides.
    let job = Job { fed: Some(fed), footprints: Some(footprints), ..Job::default() };
    let mut table = Vec::new();
    let report = run_into(&job, &Silent, |metadata| {
        println!("in {}", metadata.reference_system.as_deref().unwrap_or("an unknown system"));
        Ok(Box::new(RoofTable { out: &mut table, buildings: 0, roofs: 0 }))
    })?;

    let table = String::from_utf8(table)?;
    println!("building,slope,azimuth,top");
    table.lines().take(5).for_each(|line| println!("{line}"));
    println!("… {} roofs of {} buildings", table.lines().count(), report.counts.written);
    assert!(report.outputs.is_empty() && report.counts.written == 71);
    assert!(table.lines().count() > 71, "a roof at least for each");
    Ok(())
}
