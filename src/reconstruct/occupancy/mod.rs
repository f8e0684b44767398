//! Occupancy (paper, section 3.3): how much each cell is inside.

mod height_field;

use super::Partitioned;

pub use height_field::HeightField;

/// An implicit field that says how much each cell of a complex is inside the building.
pub trait Occupancy {
    /// One value per cell, 0 (outside) to 1 (inside), in the order of
    /// [`Complex::cells`](super::complex::Complex::cells). Cells that are [fixed](Partitioned::fixed) need no value.
    fn occupancy(&self, building: &Partitioned) -> Vec<f64>;

    /// Whether the field knows one height per place only, and so nothing of overhangs.
    fn is_height_field(&self) -> bool {
        false
    }
}
