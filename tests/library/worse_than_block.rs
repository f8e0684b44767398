//! A model that fits its points worse than the block of the building is no success, whatever field made it.

use gable::building::{LadderStep, Outcome, Reason};
use gable::reconstruct::occupancy::{Occupancy, OccupancyError};
use gable::reconstruct::{Parameters, Partitioned, reconstruct};
use gable::site::{Frame, Site};
use geo::polygon;
use nalgebra::Point3;

/// Fills the box of a building, and says that it is the vote, so that there is none to ask after it.
#[derive(Debug)]
struct Filled;

impl Occupancy for Filled {
    fn occupancy(&self, building: &Partitioned) -> Result<Vec<f64>, OccupancyError> {
        Ok(vec![1.0; building.complex.cells.len()])
    }

    fn probability(&self, _: &Partitioned, places: &[Point3<f64>]) -> Result<Vec<f64>, OccupancyError> {
        Ok(vec![1.0; places.len()])
    }

    fn is_height_field(&self) -> bool {
        true
    }
}

#[test]
fn a_model_that_fits_worse_than_its_block_gives_way_to_it_and_says_so() {
    // A gable roof of 12 m by 8 m, four points per square metre.
    let points = (0..24).flat_map(|i| {
        (0..16).map(move |j| {
            let (x, y) = (0.25 + 0.5 * f64::from(i), 0.25 + 0.5 * f64::from(j));
            Point3::new(x, y, 8.0 - 0.8 * (y - 4.0).abs())
        })
    });
    let frame = Frame { origin: [85_000.0, 447_000.0, 0.0], metres_per_unit: [1.0; 3] };
    let footprint = polygon![(x: 0.0, y: 0.0), (x: 12.0, y: 0.0), (x: 12.0, y: 8.0), (x: 0.0, y: 8.0)];
    let site = Site::new("lifted", frame, points.collect(), 0.0).with_footprint(&footprint.into());
    let building = reconstruct(&site, &Parameters::default(), &Filled);

    let Outcome::Lod12 { reason, detail } = &building.outcome else { panic!("{:?}", building.outcome) };
    assert_eq!(*reason, Reason::WorseThanBlock);
    assert!(detail.starts_with("the model fits its points to ") && detail.contains("the block to "), "{detail}");
    assert_eq!(building.ladder_step(), Some(LadderStep::Lod12));
    // Coarser tolerances were tried.
    let setbacks = &building.measures.setbacks;
    let tried: Vec<_> = setbacks.iter().map(|setback| (setback.step, setback.reason)).collect();
    assert_eq!(tried, LadderStep::LOD22.map(|step| (step, Reason::WorseThanBlock)));
    assert_eq!((building.model.lod22().count(), building.model.lod12().count()), (0, 1));
    // Nothing of the model that was refused is told of the building.
    let measures = &building.measures;
    assert_eq!((measures.roof_planes, measures.rmse_lod22, measures.confidence), (None, None, None));
    assert!(measures.rmse_lod12.is_some_and(|rmse| rmse > 0.5), "{measures:?}");
    let told = serde_json::to_value(&building.outcome).unwrap();
    assert_eq!((told["outcome"].as_str(), told["reason"].as_str()), (Some("lod12"), Some("worse-than-block")));
}
