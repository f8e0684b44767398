//! Connected areas of faulty cells.

use std::collections::BTreeMap;

use nalgebra::Point3;

use super::lattice::{Cell, centre};


/// A connected area of the plan with one fault.
#[derive(Debug, Clone, PartialEq)]
pub struct Area {
    /// Its size, m².
    pub area: f64,
    /// Where it is: the centre of the cell in its midst, at the height of what is at fault there (the top points that are
    /// missing, the model that is in excess, the ground that is roofed), local metres.
    pub place: Point3<f64>,
    /// How far apart model and points are, metres: the median over its cells.
    pub height: f64,
    /// Its cells, as column and row of the lattice with its origin in that of the local frame, sorted.
    pub cells: Vec<Cell>,
    /// What tells it: the top points over the model, the building points around the excess, or the roofed ground points,
    /// as ascending indices into those of the [`Scan`](super::Scan).
    pub points: Vec<u32>,
}

/// What a judge finds. Areas stand with the largest first.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Completeness {
    /// Number of cells that were judged: with top points inside the footprint and not too near its outline.
    pub judged: usize,
    /// Scanned and not modelled.
    pub missing: Vec<Area>,
    /// Modelled above everything that was scanned around.
    pub excess: Vec<Area>,
    /// Open ground under the model.
    pub roofed_ground: Vec<Area>,
}

/// What is wrong with a cell.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fault {
    /// Height of what is at fault, local metres.
    pub z: f64,
    /// How far model and points are apart, metres.
    pub height: f64,
    /// The points that tell it.
    pub points: Vec<u32>,
}

impl Fault {
    /// A fault that points tell, each with its height and how far it is from the model.
    pub(super) fn told_by(found: &[(u32, f64, f64)]) -> Self {
        Self {
            z: median(found.iter().map(|f| f.1)),
            height: median(found.iter().map(|f| f.2)),
            points: found.iter().map(|f| f.0).collect(),
        }
    }
}

/// The upper of the two middle values; 0 of none.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_unstable_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or_default()
}

/// Joins the faulty cells that share a side to areas of at least `smallest` m²; `side` is that of a cell.
pub(super) fn join(mut faults: BTreeMap<Cell, Fault>, side: f64, smallest: f64) -> Vec<Area> {
    let mut areas = Vec::new();
    while let Some((first, fault)) = faults.pop_first() {
        let mut found = vec![(first, fault)];
        let mut next = 0;
        while let Some(([column, row], _)) = found.get(next) {
            let (column, row) = (*column, *row);
            for cell in [[column - 1, row], [column + 1, row], [column, row - 1], [column, row + 1]] {
                found.extend(faults.remove(&cell).map(|fault| (cell, fault)));
            }
            next += 1;
        }
        // Less than the least that rounding could make of it.
        if found.len() as f64 * side * side >= smallest * (1.0 - 1e-9) {
            areas.extend(area(found, side));
        }
    }
    areas.sort_by(|a, b| b.area.total_cmp(&a.area).then_with(|| a.cells.cmp(&b.cells)));
    areas
}

fn area(mut found: Vec<(Cell, Fault)>, side: f64) -> Option<Area> {
    found.sort_by_key(|(cell, _)| *cell);
    let count = found.len() as f64;
    let mean = [0, 1].map(|axis| found.iter().map(|(cell, _)| centre(*cell, side)[axis]).sum::<f64>() / count);
    let off = |cell: &Cell| (0..2).map(|axis| (centre(*cell, side)[axis] - mean[axis]).powi(2)).sum::<f64>();
    let (midst, fault) = found.iter().min_by(|(a, _), (b, _)| off(a).total_cmp(&off(b)))?;
    let [x, y] = centre(*midst, side);
    let place = Point3::new(x, y, fault.z);
    let height = median(found.iter().map(|(_, fault)| fault.height));
    let (cells, faults): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    let mut points: Vec<u32> = faults.into_iter().flat_map(|fault| fault.points).collect();
    points.sort_unstable();
    points.dedup();
    Some(Area { area: count * side * side, place, height, cells, points })
}
