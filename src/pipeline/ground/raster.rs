//! Heights in square cells.

use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use rayon::slice::ParallelSliceMut;

use super::{Failure, MOST_CELLS};

/// Cells whose heights are averaged where there is none.
const NEIGHBOURS: NonZero<usize> = NonZero::new(8).unwrap();

/// Where cells lie.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Grid {
    /// The corner of the first cell.
    pub origin: [f64; 2],
    /// The side of a cell.
    pub cell: f64,
    /// Cells in the direction of x.
    pub columns: usize,
    /// Cells in the direction of y.
    pub rows: usize,
}

/// The box around positions in the plan: its lower corner and its sides.
pub(super) fn plan_box(positions: &[[f64; 3]]) -> ([f64; 2], [f64; 2]) {
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for position in positions {
        for axis in 0..2 {
            low[axis] = low[axis].min(position[axis]);
            high[axis] = high[axis].max(position[axis]);
        }
    }
    (low, std::array::from_fn(|axis| high[axis] - low[axis]))
}

/// The numbers of columns and rows, if there is room for them.
///
/// # Errors
/// There is not.
pub(super) fn room(columns: f64, rows: f64) -> Result<[usize; 2], Failure> {
    let cells = columns * rows;
    // A number of cells that is none is no room either.
    if cells <= MOST_CELLS { Ok([columns as usize, rows as usize]) } else { Err(Failure::TooManyCells(cells)) }
}

impl Grid {
    /// Cells of side `cell` from the lowest x and y of all positions, of which there is one, on.
    ///
    /// # Errors
    /// There would be too many.
    pub fn around(positions: &[[f64; 3]], cell: f64) -> Result<Self, Failure> {
        let (origin, [width, height]) = plan_box(positions);
        let [columns, rows] = room((width / cell).floor() + 1.0, (height / cell).floor() + 1.0)?;
        Ok(Self { origin, cell, columns, rows })
    }

    /// The cell that holds a place within the box around all positions.
    pub fn cell_of(&self, position: [f64; 3]) -> usize {
        let along = |axis: usize, count: usize| {
            (((position[axis] - self.origin[axis]) / self.cell).floor() as usize).min(count - 1)
        };
        along(1, self.rows) * self.columns + along(0, self.columns)
    }
}

/// Heights in cells, row after row; not a number where there is none.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Raster {
    /// Cells of a row.
    pub columns: usize,
    /// The heights.
    pub values: Vec<f64>,
}

impl Raster {
    /// The lowest height in each cell.
    pub fn lowest(grid: &Grid, positions: &[[f64; 3]]) -> Self {
        let mut values = vec![f64::NAN; grid.columns * grid.rows];
        for position in positions {
            let value = &mut values[grid.cell_of(*position)];
            *value = value.min(position[2]);
        }
        Self { columns: grid.columns, values }
    }

    /// Gives each cell without a height the mean of the eight cells nearest to it that have one; nothing where none has.
    pub fn fill(&mut self) {
        let columns = self.columns;
        let place = |i: &usize| [(i % columns) as f64, (i / columns) as f64];
        let (gaps, known): (Vec<usize>, Vec<usize>) = (0..self.values.len()).partition(|&i| self.values[i].is_nan());
        if gaps.is_empty() || known.is_empty() {
            return;
        }
        let places: Vec<[f64; 2]> = known.iter().map(place).collect();
        let Ok(tree) = ImmutableKdTree::<f64, 2>::new_from_slice(&places) else { return };
        let wanted = NEIGHBOURS.min(NonZero::new(places.len()).unwrap_or(NEIGHBOURS));
        let mean = |gap: &usize| {
            let found = tree.query(&place(gap)).nearest_n::<SquaredEuclidean<f64>>(wanted).execute();
            let sum: f64 = found.iter().map(|hit| self.values[known[hit.item as usize]]).sum();
            sum / found.len() as f64
        };
        let means: Vec<f64> = gaps.par_iter().map(mean).collect();
        for (gap, mean) in gaps.into_iter().zip(means) {
            self.values[gap] = mean;
        }
    }

    /// Gives each cell the least, or the greatest, of its own height and those of the four cells beside it, as often as
    /// `times` says: an erosion, or a dilation, by a diamond of that radius.
    ///
    /// # Errors
    /// An interruption.
    pub fn spread(
        &mut self,
        times: usize,
        chosen: fn(f64, f64) -> f64,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Result<(), Failure> {
        let columns = self.columns;
        let mut out = vec![0.0; self.values.len()];
        for _ in 0..times {
            if stop() {
                return Err(Failure::Interrupted);
            }
            let values = &self.values;
            out.par_chunks_mut(columns).enumerate().for_each(|(row, out)| {
                let line = |row: usize| values.get(row * columns..(row + 1) * columns);
                let Some(own) = line(row) else { return };
                out.copy_from_slice(own);
                for other in [row.checked_sub(1).and_then(line), line(row + 1)].into_iter().flatten() {
                    for (out, other) in out.iter_mut().zip(other) {
                        *out = chosen(*out, *other);
                    }
                }
                for (out, left) in out[1..].iter_mut().zip(own) {
                    *out = chosen(*out, *left);
                }
                for (out, right) in out.iter_mut().zip(&own[1..]) {
                    *out = chosen(*out, *right);
                }
            });
            std::mem::swap(&mut self.values, &mut out);
        }
        Ok(())
    }

    /// How steep the heights are in each cell of side `cell`, rise over run: by the cells on both sides, by the only one at
    /// the border.
    pub fn slopes(&self, cell: f64) -> Vec<f64> {
        let columns = self.columns;
        let rows = self.values.len() / columns;
        let rise = |at: usize, count: usize, value: &dyn Fn(usize) -> f64| {
            let (before, behind) = (at.saturating_sub(1), (at + 1).min(count - 1));
            if behind > before { (value(behind) - value(before)) / ((behind - before) as f64 * cell) } else { 0.0 }
        };
        (0..self.values.len())
            .map(|i| {
                let (row, column) = (i / columns, i % columns);
                let x = rise(column, columns, &|column| self.values[row * columns + column]);
                let y = rise(row, rows, &|row| self.values[row * columns + column]);
                x.hypot(y)
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn raster(columns: usize, values: &[f64]) -> Raster {
        Raster { columns, values: values.to_vec() }
    }

    #[test]
    fn cells_hold_their_lowest_point() {
        let positions = [[10.0, 20.0, 5.0], [10.9, 20.0, 3.0], [11.0, 20.0, 4.0], [12.0, 22.5, 9.0]];
        let grid = Grid::around(&positions, 1.0).unwrap();
        assert_eq!((grid.columns, grid.rows, grid.origin), (3, 3, [10.0, 20.0]));
        let lowest = Raster::lowest(&grid, &positions);
        assert_eq!(lowest.values[..2], [3.0, 4.0]);
        assert_eq!(lowest.values[8], 9.0);
        assert_eq!(lowest.values.iter().filter(|value| value.is_nan()).count(), 6);
        let far = [[0.0; 3], [1e9, 1e9, 0.0]];
        assert_eq!(Grid::around(&far, 1.0).unwrap_err(), Failure::TooManyCells(1_000_000_001.0 * 1_000_000_001.0));
        assert!(Grid::around(&[[0.0; 3], [1e300, 0.0, 0.0]], 1e-300).is_err());
    }

    #[test]
    fn gaps_get_the_mean_of_eight() {
        let gap = f64::NAN;
        let mut ring = raster(3, &[1.0, 2.0, 3.0, 4.0, gap, 5.0, 6.0, 7.0, 8.0]);
        ring.fill();
        assert_eq!(ring.values[4], 4.5);
        // Fewer than eight: all of them.
        let mut few = raster(3, &[1.0, gap, 3.0]);
        few.fill();
        assert_eq!(few.values, [1.0, 2.0, 3.0]);
        let mut none = raster(2, &[gap, gap]);
        none.fill();
        assert!(none.values.iter().all(|value| value.is_nan()));
    }

    #[test]
    fn a_diamond_grows_by_one_each_time() {
        let mut peak = raster(5, &[0.0; 25]);
        peak.values[12] = 1.0;
        peak.spread(1, f64::max, &|| false).unwrap();
        assert_eq!(peak.values.iter().sum::<f64>(), 5.0);
        peak.spread(1, f64::max, &|| false).unwrap();
        assert_eq!(peak.values.iter().sum::<f64>(), 13.0);
        // Erosion takes back what dilation gave: the border counts for nothing.
        peak.spread(2, f64::min, &|| false).unwrap();
        assert_eq!(peak.values.iter().sum::<f64>(), 1.0);
        assert_eq!(peak.spread(1, f64::min, &|| true), Err(Failure::Interrupted));
        let mut one = raster(1, &[3.0]);
        one.spread(4, f64::min, &|| false).unwrap();
        assert_eq!(one.values, [3.0]);
    }

    #[test]
    fn slopes_are_rise_over_run() {
        // z = 0.3 x + 0.4 y in cells of 2.
        let plane = raster(3, &[0.0, 0.6, 1.2, 0.8, 1.4, 2.0]);
        assert!(plane.slopes(2.0).iter().all(|slope| (slope - 0.5).abs() < 1e-12));
        assert_eq!(raster(1, &[7.0]).slopes(1.0), [0.0]);
    }
}
