//! Connected areas of faulty cells.

use std::collections::BTreeMap;

use nalgebra::Point3;

/// A cell of the plan: column and row, counted from the origin of the local frame.
pub(super) type Cell = [i64; 2];

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
    /// Number of cells that were judged: inside the footprint, not too near its outline, with building points in them.
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

/// Joins the faulty cells that touch, at a side or a corner, to areas of at least `smallest` m²; `side` is that of a cell.
pub(super) fn join(mut faults: BTreeMap<Cell, Fault>, side: f64, smallest: f64) -> Vec<Area> {
    let mut areas = Vec::new();
    while let Some((first, fault)) = faults.pop_first() {
        let mut found = vec![(first, fault)];
        let mut next = 0;
        while let Some(([column, row], _)) = found.get(next) {
            let (column, row) = (*column, *row);
            for cell in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [column + dx, row + dy])) {
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
    let centre = |cell: &Cell| cell.map(|index| (index as f64 + 0.5) * side);
    let mean = [0, 1].map(|axis| found.iter().map(|(cell, _)| centre(cell)[axis]).sum::<f64>() / count);
    let off = |cell: &Cell| (0..2).map(|axis| (centre(cell)[axis] - mean[axis]).powi(2)).sum::<f64>();
    let (midst, fault) = found.iter().min_by(|(a, _), (b, _)| off(a).total_cmp(&off(b)))?;
    let [x, y] = centre(midst);
    let place = Point3::new(x, y, fault.z);
    let mut heights: Vec<f64> = found.iter().map(|(_, fault)| fault.height).collect();
    heights.sort_unstable_by(f64::total_cmp);
    let height = *heights.get(heights.len() / 2)?;
    let (cells, faults): (Vec<_>, Vec<_>) = found.into_iter().unzip();
    let mut points: Vec<u32> = faults.into_iter().flat_map(|fault| fault.points).collect();
    points.sort_unstable();
    points.dedup();
    Some(Area { area: count * side * side, place, height, cells, points })
}
