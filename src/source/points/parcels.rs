//! Places in plan that belong to buildings, for points that name none themselves.

use std::collections::HashMap;

/// Square cells of the plane, each of a building, as a place in [`Tile::buildings`](super::Tile::buildings).
#[derive(Debug, Clone, Default)]
pub struct Parcels {
    /// Sides of a cell along x and y, CRS units.
    pub cell: [f64; 2],
    /// The building of each cell that has one.
    pub buildings: HashMap<[i64; 2], u32, foldhash::fast::FixedState>,
}

impl Parcels {
    /// The cell that a position lies in.
    #[inline]
    pub fn key(cell: [f64; 2], position: [f64; 3]) -> [i64; 2] {
        [(position[0] / cell[0]).floor() as i64, (position[1] / cell[1]).floor() as i64]
    }

    /// The building whose parcel a position lies in.
    #[inline]
    pub fn building(&self, position: [f64; 3]) -> Option<u32> {
        self.buildings.get(&Self::key(self.cell, position)).copied()
    }
}
