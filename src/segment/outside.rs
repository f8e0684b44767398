//! Points outside the box that the header of their tile states.

use crate::source::points::Extent;
use std::collections::BTreeMap;

/// Side of the cells that such points are gathered in, metres.
const CELL: f64 = 16.0;
/// Fewer points than this in a cell are damage, and cover nothing.
const FEWEST: u32 = 4;

/// The points outside a box: how many, and where.
#[derive(Debug)]
pub(super) struct Outside {
    stated: Option<Extent>,
    metres_per_unit: [f64; 3],
    /// The box and what lies in it or just outside.
    near: Extent,
    cells: BTreeMap<[i64; 2], (u32, Extent)>,
    /// How many.
    pub count: u64,
}

impl Outside {
    /// None yet; without a box none is outside.
    pub fn of(stated: Option<Extent>, metres_per_unit: [f64; 3]) -> Self {
        Self { stated, metres_per_unit, near: stated.unwrap_or(Extent::EMPTY), cells: BTreeMap::new(), count: 0 }
    }

    /// Looks at a point, CRS units.
    #[inline]
    pub fn see(&mut self, position: [f64; 3]) {
        let Some(stated) = self.stated else { return };
        if stated.holds(position) {
            self.near.grow(position);
            return;
        }
        self.count += 1;
        let cell = [0, 1].map(|axis| (position[axis] * self.metres_per_unit[axis] / CELL).floor() as i64);
        let (count, extent) = self.cells.entry(cell).or_insert((0, Extent::EMPTY));
        *count = count.saturating_add(1);
        extent.grow(position);
    }

    /// What the points cover, CRS units; nothing where none is outside.
    pub fn covered(self) -> impl Iterator<Item = Extent> {
        let near = (self.count > 0).then_some(self.near);
        let cells = self.cells.into_values().filter(|(count, _)| *count >= FEWEST).map(|(_, extent)| extent);
        near.into_iter().chain(cells)
    }
}
