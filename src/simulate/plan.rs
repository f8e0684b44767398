//! Points found by their place in the plan.

use std::collections::HashMap;

use nalgebra::{Point2, Point3};

/// Points in square cells of the plan.
#[derive(Debug, Default)]
pub(super) struct Plan {
    side: f64,
    cells: HashMap<[i64; 2], Vec<u32>>,
}

impl Plan {
    /// Sorts points into cells of this side, metres.
    pub fn new(points: &[Point3<f64>], side: f64) -> Self {
        let mut plan = Self { side, cells: HashMap::new() };
        for (number, point) in (0u32..).zip(points) {
            plan.cells.entry(plan.cell(point.x, point.y)).or_default().push(number);
        }
        plan
    }

    fn cell(&self, x: f64, y: f64) -> [i64; 2] {
        [x, y].map(|v| (v / self.side).floor() as i64)
    }

    /// The numbers of the points in the cells that a circle reaches, cell by cell and in their order.
    pub fn around(&self, middle: &Point2<f64>, radius: f64) -> impl Iterator<Item = u32> + '_ {
        let [low, high] = [-radius, radius].map(|r| self.cell(middle.x + r, middle.y + r));
        let cells = (low[0]..=high[0]).flat_map(move |column| (low[1]..=high[1]).map(move |row| [column, row]));
        cells.filter_map(|cell| self.cells.get(&cell)).flatten().copied()
    }
}
