//! A model that fits its points worse than the block of the building is no success, whatever field made it.

use gable::building::{LadderStep, Outcome};
use gable::reconstruct::occupancy::{HeightField, Occupancy, OccupancyError};
use gable::reconstruct::{Parameters, Partitioned, reconstruct};
use gable::site::{Frame, Site};
use nalgebra::Point3;

/// A field that fills the box of a building.
#[derive(Debug)]
struct Filled;

impl Occupancy for Filled {
    fn occupancy(&self, building: &Partitioned) -> Result<Vec<f64>, OccupancyError> {
        Ok(vec![1.0; building.complex.cells.len()])
    }

    fn probability(&self, _: &Partitioned, places: &[Point3<f64>]) -> Result<Vec<f64>, OccupancyError> {
        Ok(vec![1.0; places.len()])
    }
}

#[test]
fn a_field_that_fits_worse_than_the_block_gives_way_to_the_vote_and_the_building_says_so() {
    // A gable roof of 12 m by 8 m, four points per square metre; without a footprint the field decides alone.
    let points = (0..24).flat_map(|i| {
        (0..16).map(move |j| {
            let (x, y) = (0.25 + 0.5 * f64::from(i), 0.25 + 0.5 * f64::from(j));
            Point3::new(x, y, 8.0 - 0.8 * (y - 4.0).abs())
        })
    });
    let frame = Frame { origin: [85_000.0, 447_000.0, 0.0], metres_per_unit: [1.0; 3] };
    let site = Site::new("filled", frame, points.collect(), 0.0);
    let building = reconstruct(&site, &Parameters::default(), &Filled);
    let vote = reconstruct(&site, &Parameters::default(), &HeightField);

    assert_eq!((&building.outcome, building.ladder_step()), (&Outcome::Lod22, Some(LadderStep::Lod22)));
    assert_eq!(building.model.parts, vote.model.parts);
    let why = building.measures.field_fallback.clone().unwrap();
    assert!(why.starts_with("by its answers the model fits its points to ") && why.contains("the block to "), "{why}");
    assert!(building.notes.iter().any(|note| note.contains(&why)), "{:?}", building.notes);
    let measures = &building.measures;
    assert!(measures.rmse_lod22.unwrap() < 0.1 && measures.rmse_lod12.unwrap() > 0.3, "{measures:?}");
}
