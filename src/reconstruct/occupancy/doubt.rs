//! Where the height-field vote may be wrong: what it says is held against the points, column by column.
//!
//! A column of the roof map is in doubt
//! - between its roof and a point that lies more than [`TOLERANCE`] above or below it, unless the roof of a column beside
//!   it, or a wall of the outline, explains the point; of points below the roof only where none lies on it;
//! - from such a point, in it or beside it, down to the ground and up to its roof, where the scan shows that something
//!   hangs over: the vote knows of no overhangs;
//! - everywhere, where no point lies in it nor in one beside it.

use crate::reconstruct::Hypotheses;
use crate::site::Site;

/// Points nearer to the roof of their column than this do not speak against it, metres.
const TOLERANCE: f64 = 0.5;

/// Nothing is in doubt.
const NOWHERE: [f64; 2] = [f64::INFINITY, f64::NEG_INFINITY];
/// Everything is.
const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];

/// The stretch of every column of a roof map that is in doubt.
#[derive(Debug)]
pub(super) struct Doubt {
    columns: usize,
    stretches: Vec<[f64; 2]>,
}

/// What the points of a column say.
#[derive(Debug, Clone, Copy)]
struct Column {
    roof: Option<f64>,
    on_roof: bool,
    is_hit: bool,
    highest: f64,
    lowest: f64,
}

impl Doubt {
    /// Holds the roofs of a building, given column by column, against its points.
    pub fn new(site: &Site, hypotheses: &Hypotheses, roof: impl Fn(usize, usize) -> Option<f64>) -> Self {
        let map = &hypotheses.map;
        let [columns, rows] = map.size();
        let empty = |i: usize| Column {
            roof: roof(i % columns, i / columns),
            on_roof: false,
            is_hit: false,
            highest: f64::NEG_INFINITY,
            lowest: f64::INFINITY,
        };
        let mut found: Vec<Column> = (0..columns * rows).map(empty).collect();
        let place = |p: &nalgebra::Point3<f64>| map.pixel_at(&p.xy()).map(|[column, row]| row * columns + column);
        for point in &site.points {
            if let Some(column) = place(point).and_then(|i| found.get_mut(i)) {
                column.is_hit = true;
                column.on_roof |= column.roof.is_some_and(|roof| (point.z - roof).abs() <= TOLERANCE);
            }
        }
        let around = |i: usize| {
            let [column, row] = [i % columns, i / columns];
            let rows = row.saturating_sub(1)..(row + 2).min(rows);
            rows.flat_map(move |r| (column.saturating_sub(1)..(column + 2).min(columns)).map(move |c| r * columns + c))
        };
        for point in &site.points {
            let Some(i) = place(point) else { continue };
            let explains = |j: usize| match found[j].roof {
                Some(roof) => (point.z - roof).abs() <= TOLERANCE,
                // Beyond the outline nothing stands: the point is on its wall.
                None => found[i].roof.is_some_and(|roof| point.z < roof),
            };
            if !around(i).any(explains) {
                let column = &mut found[i];
                column.highest = column.highest.max(point.z);
                column.lowest = column.lowest.min(point.z);
            }
        }
        let stretch = |i: usize| {
            let column = &found[i];
            let Some(roof) = column.roof else { return NOWHERE };
            if !around(i).any(|j| found[j].is_hit) {
                return EVERYWHERE;
            }
            let high = column.highest.max(roof);
            let hangs_over = || around(i).any(|j| found[j].lowest < roof - TOLERANCE);
            let low = if hypotheses.shows_overhang && hangs_over() {
                f64::NEG_INFINITY
            } else if column.on_roof {
                roof
            } else {
                column.lowest.min(roof)
            };
            if low < high { [low, high] } else { NOWHERE }
        };
        let stretches = (0..found.len()).map(stretch).collect();
        Self { columns, stretches }
    }

    /// How much of a stretch of a column is in doubt, metres.
    pub fn overlap(&self, column: usize, row: usize, bottom: f64, top: f64) -> f64 {
        let stretch = self.stretches.get(row * self.columns + column).copied().unwrap_or(NOWHERE);
        (stretch[1].min(top) - stretch[0].max(bottom)).max(0.0)
    }
}
