//! An `Occupancy` of one's own: another answer to the question which cells are inside.
//!
//! ```text
//! cargo run --release --example occupancy
//! ```
//!
//! The planes found in the points cut the space of a building into convex cells. An implicit field says of each how likely
//! it is inside; a minimum cut decides, and everything after that (surface, repair, validation) is the same for all
//! fields. The field of this example looks at the nearest point in the plan: what lies below it is inside.

use std::error::Error;
use std::path::Path;

use gable::nalgebra::Point3;
use gable::reconstruct::occupancy::{Occupancy, OccupancyError};
use gable::reconstruct::{Parameters, Partitioned, reconstruct};
use gable::run::{FootprintSource, Job, Silent, run_with};
use gable::source::footprints::FootprintOptions;

/// Inside is what lies below the nearest point.
#[derive(Debug)]
struct BelowNearest;

impl Occupancy for BelowNearest {
    /// One value per cell. Where a cell is known to be outside the footprint nobody asks, but a value must stand there.
    fn occupancy(&self, building: &Partitioned) -> Result<Vec<f64>, OccupancyError> {
        let complex = &building.complex;
        let centres: Vec<_> = (0..complex.cells.len() as u32).map(|cell| complex.cell_centroid(cell)).collect();
        self.probability(building, &centres)
    }

    /// The same for places. A smooth step half a metre wide says how sure it is.
    fn probability(&self, building: &Partitioned, places: &[Point3<f64>]) -> Result<Vec<f64>, OccupancyError> {
        let site = building.site;
        let probability = |place: &Point3<f64>| {
            let distance = |point: &&Point3<f64>| (point.xy() - place.xy()).norm_squared();
            let nearest = site.points.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
            nearest.map_or(0.0, |point| (0.5 + (point.z - place.z)).clamp(0.0, 1.0))
        };
        Ok(places.iter().map(probability).collect())
    }

    /// It knows one height per place, so nothing can hang over.
    fn is_height_field(&self) -> bool {
        true
    }
}

pub(crate) fn main() -> Result<(), Box<dyn Error>> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data");
    let folder = tempfile::tempdir()?;
    let options = FootprintOptions { filter: Some("id LIKE '%186%'".to_owned()), ..FootprintOptions::default() };
    let job = Job {
        tiles: vec![data.join("delft_ahn3.laz").display().to_string()],
        footprints: Some(FootprintSource { path: data.join("footprints.geojson"), options }),
        output: folder.path().join("own.city.json"),
        ..Job::default()
    };
    // Any function from a site to a building can take the place of the method; this one keeps all of it but the field.
    let parameters = Parameters::default();
    let report = run_with(&job, &Silent, |site| reconstruct(site, &parameters, &BelowNearest))?;
    let rmse = report.quality.rmse_lod22.as_ref().map_or(f64::NAN, |percentiles| percentiles.p50);
    let counts = &report.counts;
    println!(
        "{} of {} buildings at LoD 2.2, half of them within {rmse:.2} m",
        counts.buildings_lod22, counts.footprints
    );
    assert!(counts.footprints > 2 && counts.buildings_lod22 * 10 >= counts.footprints * 8);
    assert!(rmse < 0.5);
    Ok(())
}
