//! The field that knows the truth: what is wrong with a model made by it is the fault of the cells or of the cut.

use nalgebra::Point3;

use super::subject::Subject;
use crate::reconstruct::Partitioned;
use crate::reconstruct::occupancy::{Occupancy, OccupancyError};

/// The truth about one building as an occupancy: the inside fraction of every cell.
#[derive(Debug, Clone, Copy)]
pub struct Oracle<'a> {
    subject: &'a Subject,
}

impl<'a> Oracle<'a> {
    /// The oracle about a building.
    pub fn new(subject: &'a Subject) -> Self {
        Self { subject }
    }
}

impl Occupancy for Oracle<'_> {
    fn occupancy(&self, building: &Partitioned) -> Result<Vec<f64>, OccupancyError> {
        Ok(self.subject.fractions(building).to_vec())
    }

    fn probability(&self, _: &Partitioned, places: &[Point3<f64>]) -> Result<Vec<f64>, OccupancyError> {
        Ok(places.iter().map(|p| f64::from(u8::from(self.subject.truth().is_inside(p)))).collect())
    }
}
