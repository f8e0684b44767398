//! What is in a tile, counted by streaming it once.

use super::problem::TileProblem;
use super::tile::{Extent, Tile};
use crate::error::Result;
use schemars::JsonSchema;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};

/// Side of the cells by which the scanned area is measured, metres.
const CELL: f64 = 4.0;

/// What is in a tile.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct TileSummary {
    /// Points that the header announces.
    pub points_stated: u64,
    /// Points read.
    pub points: u64,
    /// Points per ASPRS class, all flags included.
    pub classes: BTreeMap<u8, u64>,
    /// Points per number of the return.
    pub returns: BTreeMap<u8, u64>,
    /// Points marked as withheld.
    pub withheld: u64,
    /// Points marked as synthetic.
    pub synthetic: u64,
    /// Points marked as lying in the overlap of two strips.
    pub overlap: u64,
    /// Smallest and largest coordinates of the points, CRS units; `None` without a point.
    pub extent: Option<[[f64; 3]; 2]>,
    /// Scanned area in square metres: that of the 4 m cells that hold a point.
    pub area: f64,
    /// Points per square metre of scanned area.
    pub density: f64,
    /// First returns per square metre of scanned area; `None` where the writer did not fill the numbers of returns in.
    pub pulse_density: Option<f64>,
    /// What is wrong with the tile.
    pub problems: Vec<TileProblem>,
}

impl Tile {
    /// Counts what is in the tile, whose CRS has `metres_per_unit` (1 where that is unknown).
    ///
    /// # Errors
    /// The file cannot be opened.
    pub fn summary(&self, metres_per_unit: [f64; 3]) -> Result<TileSummary> {
        let mut summary = TileSummary { points_stated: self.points, ..TileSummary::default() };
        let (mut classes, mut returns) = ([0_u64; 256], [0_u64; 256]);
        let mut extent = Extent::EMPTY;
        let mut outside = 0;
        let mut cells = BTreeSet::new();
        let mut cell_before = None;
        let reading = self.stream(None, &mut |block| {
            for point in block.points() {
                summary.points += 1;
                classes[usize::from(point.class)] += 1;
                returns[usize::from(point.return_number)] += 1;
                summary.withheld += u64::from(point.withheld);
                summary.synthetic += u64::from(point.synthetic);
                summary.overlap += u64::from(point.overlap);
                extent.grow(point.position);
                outside += u64::from(self.stated_extent.is_some_and(|stated| !stated.holds(point.position)));
                let cell = [0, 1].map(|axis| (point.position[axis] * metres_per_unit[axis] / CELL).floor() as i64);
                // Neighbours in the file are neighbours on the ground, mostly.
                if cell_before != Some(cell) {
                    cells.insert(cell);
                    cell_before = Some(cell);
                }
            }
        })?;
        let counted = |counts: [u64; 256]| (0..=255).zip(counts).filter(|(_, n)| *n > 0).collect::<BTreeMap<u8, u64>>();
        summary.classes = counted(classes);
        summary.returns = counted(returns);
        summary.extent = (!extent.is_empty()).then_some([extent.min, extent.max]);
        summary.area = cells.len() as f64 * CELL * CELL;
        if summary.area > 0.0 {
            summary.density = summary.points as f64 / summary.area;
            summary.pulse_density = summary.returns.get(&1).map(|first| *first as f64 / summary.area);
        }
        summary.problems = reading.problems(self);
        summary.problems.extend(self.wrong_claims(outside, reading.read));
        Ok(summary)
    }
}
