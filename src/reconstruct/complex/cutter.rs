//! Single cuts of cells of a complex that is done.

use super::split::Partition;
use super::{CellId, Complex, IntegerPlane, PlaneId};
use crate::geometry::Plane;

/// Cuts single cells of a complex by further planes, as exactly as the partition did.
pub struct Cutter(Partition);

impl Cutter {
    /// Takes up a complex.
    pub fn new(complex: Complex) -> Self {
        Self(Partition::reopened(complex))
    }

    /// The complex as it is.
    pub fn complex(&self) -> &Complex {
        &self.0.complex
    }

    /// The complex.
    pub fn into_complex(self) -> Complex {
        self.0.complex
    }

    /// The plane nearest to this one on the grid, new or known; `None` where it is not finite or out of reach.
    pub fn plane(&mut self, plane: &Plane) -> Option<PlaneId> {
        IntegerPlane::snap(plane).map(|(plane, _)| self.0.plane_id(plane))
    }

    /// Cuts a cell by a plane, if that parts it; the part on the positive side is the new cell that is returned.
    pub fn cut(&mut self, cell: CellId, plane: PlaneId) -> Option<CellId> {
        self.0.begin_plane();
        let before = self.0.complex.cells.len();
        self.0.cut_cell(0, cell, plane);
        (self.0.complex.cells.len() > before).then_some(before as CellId)
    }
}
