//! Occupancy (paper, section 3.3): how much each cell is inside.
//!
//! - [`HeightField`]: the vote of the roof evidence, which needs no network.
//! - [`Neural`]: the implicit field of a [`network`], conditioned on the [`inputs`], where it can change what the vote says.

mod doubt;
mod height_field;
pub mod inputs;
pub mod network;
mod neural;
mod sparing;

use std::fmt::Debug;

use nalgebra::Point3;

use super::Partitioned;

pub use height_field::HeightField;
pub use network::NetworkError;
pub use neural::{CellRule, Encoded, Neural};

/// Why a field says nothing about a building.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum OccupancyError {
    /// The network gave no answer.
    #[error(transparent)]
    Network(#[from] NetworkError),
}

/// An implicit field that says how much each cell of a complex is inside the building.
pub trait Occupancy: Debug + Send + Sync {
    /// One value per cell, 0 (outside) to 1 (inside), in the order of
    /// [`Complex::cells`](super::complex::Complex::cells). Cells that are [fixed](Partitioned::fixed) need no value.
    ///
    /// # Errors
    /// Fails when the field cannot be asked.
    fn occupancy(&self, building: &Partitioned) -> Result<Vec<f64>, OccupancyError>;

    /// How likely each of these places, local metres, is inside: 0 to 1.
    ///
    /// # Errors
    /// Fails when the field cannot be asked.
    fn probability(&self, building: &Partitioned, places: &[Point3<f64>]) -> Result<Vec<f64>, OccupancyError>;

    /// Whether the field knows one height per place only, and so nothing of overhangs.
    fn is_height_field(&self) -> bool {
        false
    }
}
