//! Points in the square cells of the plan.

use std::ops::Range;

use nalgebra::Point3;

/// A cell of the plan: column and row, counted from the origin of the local frame.
pub(super) type Cell = [i64; 2];

/// The centre of a cell of this side.
pub(super) fn centre(cell: Cell, side: f64) -> [f64; 2] {
    cell.map(|index| (index as f64 + 0.5) * side)
}

/// Points in the cells of the plan.
#[derive(Debug)]
pub(super) struct Lattice<'a> {
    points: &'a [Point3<f64>],
    side: f64,
    /// The points cell by cell, ascending in each.
    order: Vec<u32>,
    /// The cells that hold points, sorted, each with its points in `order`.
    cells: Vec<(Cell, Range<usize>)>,
}

impl<'a> Lattice<'a> {
    /// Points that are not finite are in no cell.
    pub(super) fn new(points: &'a [Point3<f64>], side: f64) -> Self {
        let cell = |p: &Point3<f64>| [p.x, p.y].map(|c| (c / side).floor() as i64);
        let finite = points.iter().zip(0_u32..).filter(|(p, _)| p.iter().all(|c| c.is_finite() && c.abs() < 1e12));
        let mut keyed: Vec<(Cell, u32)> = finite.map(|(p, index)| (cell(p), index)).collect();
        keyed.sort_unstable();
        let mut cells: Vec<(Cell, Range<usize>)> = Vec::new();
        for (place, (cell, _)) in keyed.iter().enumerate() {
            match cells.last_mut() {
                Some((last, range)) if last == cell => range.end = place + 1,
                _ => cells.push((*cell, place..place + 1)),
            }
        }
        Self { points, side, order: keyed.into_iter().map(|(_, index)| index).collect(), cells }
    }

    /// A point.
    pub(super) fn point(&self, index: u32) -> Option<&'a Point3<f64>> {
        self.points.get(index as usize)
    }

    /// The cells that hold points, sorted, with these.
    pub(super) fn cells(&self) -> impl Iterator<Item = (Cell, impl Iterator<Item = (u32, &'a Point3<f64>)> + '_)> + '_ {
        self.cells.iter().map(|(cell, range)| (*cell, self.of(range)))
    }

    /// The cells whose centre may be at most `reach` metres from a point, sorted.
    pub(super) fn cells_around(&self, reach: f64) -> Vec<Cell> {
        // The centre of a cell is half a cell from its side.
        let around = (reach / self.side - 0.5).ceil().clamp(0.0, 16.0) as i64;
        let mut cells: Vec<Cell> = Vec::with_capacity(self.cells.len());
        for ([column, row], _) in &self.cells {
            let neighbours = (-around..=around).flat_map(|dx| (-around..=around).map(move |dy| [dx, dy]));
            cells.extend(neighbours.map(|[dx, dy]| [column + dx, row + dy]));
        }
        cells.sort_unstable();
        cells.dedup();
        cells
    }

    /// The points at most `reach` metres from a place of the plan.
    pub(super) fn around(&self, place: [f64; 2], reach: f64) -> impl Iterator<Item = (u32, &'a Point3<f64>)> + '_ {
        let [columns, rows] =
            place.map(|c| ((c - reach) / self.side).floor() as i64..=((c + reach) / self.side).floor() as i64);
        columns
            .flat_map(move |column| {
                // The cells of a column stand one after the other.
                let from = self.cells.partition_point(|(cell, _)| *cell < [column, *rows.start()]);
                let to = self.cells.partition_point(|(cell, _)| *cell <= [column, *rows.end()]);
                self.cells.get(from..to.max(from)).unwrap_or_default()
            })
            .flat_map(|(_, range)| self.of(range))
            .filter(move |(_, p)| (p.x - place[0]).powi(2) + (p.y - place[1]).powi(2) <= reach * reach)
    }

    fn of(&self, range: &Range<usize>) -> impl Iterator<Item = (u32, &'a Point3<f64>)> + '_ {
        let indices = self.order.get(range.clone()).unwrap_or_default();
        indices.iter().filter_map(|&index| Some((index, self.point(index)?)))
    }
}
