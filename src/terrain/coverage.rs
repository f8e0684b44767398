//! Which parts of a tile are terrain: those near ground points, and those around buildings.
//!
//! Parts with some ground points are seen. A part is covered where no circle as wide as the gap holds it and no seen part: narrow
//! gaps are spanned, wide ones are left out (a closing, in the words of mathematical morphology). Around buildings there is
//! terrain in any case, so that none stands in the air.

use super::grid::Grid;
use super::ground::{Ground, State};
use super::surroundings::Surroundings;

/// A part is seen where this share of its cells has a ground point, or one at least: a few beyond the end of what was scanned
/// are no reason for terrain as wide as the part.
const FEWEST: f64 = 0.05;
/// The radius of the circle in parts.
const RADIUS: i64 = 2;
/// Parts around the tile that must be known to tell which of it are covered: the circle moves beyond both ways.
const SEEN_BEYOND: i64 = 3 * RADIUS;
const FILLED_BEYOND: i64 = 2 * RADIUS;
/// Parts around the tile that are told.
const TOLD_BEYOND: i64 = RADIUS;

/// The parts in and around a tile.
pub(super) struct Coverage {
    covered: Mask,
    /// Parts with a ground point or a building.
    seen: Mask,
    parts: [i64; 2],
}

impl Coverage {
    /// Of a tile with this ground and these buildings.
    pub fn of(ground: &Ground, outlines: &Surroundings) -> Self {
        let grid = &ground.grid;
        let parts = grid.parts;
        let mut seen = Mask::new(parts, SEEN_BEYOND);
        let mut counts = vec![0_u32; seen.bits.len()];
        // What is too near to a building for a vertex was seen all the same.
        for index in (0..ground.states.len()).filter(|index| ground.states[*index] != State::Absent) {
            let slot = ground.point(index).and_then(|(place, _)| seen.slot(grid.part_of(place)));
            if let Some(count) = slot.and_then(|slot| counts.get_mut(slot)) {
                *count += 1;
            }
        }
        let cells: f64 =
            [0, 1].map(|axis| (grid.tile[axis] / parts[axis]) as f64 / grid.sample[axis] as f64).iter().product();
        let fewest = (FEWEST * cells).floor().max(1.0) as u32;
        seen.bits = counts.iter().map(|count| *count >= fewest).collect();
        mark_outlines(outlines, grid, &mut seen);
        let mut filled = Mask::new(parts, FILLED_BEYOND);
        filled.fill(|at| circle().any(|[i, j]| seen.get([at[0] + i, at[1] + j])));
        let mut covered = Mask::new(parts, TOLD_BEYOND);
        covered.fill(|at| seen.get(at) || circle().all(|[i, j]| filled.get([at[0] + i, at[1] + j])));
        Self { covered, seen, parts }
    }

    /// Whether a part is terrain, counted from the south-western one of the tile.
    pub fn is_covered(&self, part: [i64; 2]) -> bool {
        self.covered.get(part)
    }

    /// Whether it is terrain although there is no ground point and no building.
    pub fn is_spanned(&self, part: [i64; 2]) -> bool {
        self.covered.get(part) && !self.seen.get(part)
    }

    /// All parts of the tile.
    pub fn of_tile(&self) -> impl Iterator<Item = [i64; 2]> + use<> {
        let [columns, rows] = self.parts;
        (0..rows).flat_map(move |row| (0..columns).map(move |column| [column, row]))
    }
}

/// The parts that a circle around the middle of one reaches.
fn circle() -> impl Iterator<Item = [i64; 2]> {
    let all = (-RADIUS..=RADIUS).flat_map(|i| (-RADIUS..=RADIUS).map(move |j| [i, j]));
    all.filter(|[i, j]| i * i + j * j <= RADIUS * RADIUS)
}

/// Marks the parts that outlines touch, and those around them.
fn mark_outlines(outlines: &Surroundings, grid: &Grid, mask: &mut Mask) {
    let stride = [0, 1].map(|axis| (grid.tile[axis] / grid.parts[axis] / 2).max(1));
    for edge in &outlines.edges {
        let [a, b] = edge.ends;
        let run = [0, 1].map(|axis| b[axis] - a[axis]);
        let pieces = (0..2).map(|axis| run[axis].abs() / stride[axis] + 1).max().unwrap_or(1);
        for piece in 0..=pieces {
            let [column, row] = grid.part_of([0, 1].map(|axis| a[axis] + run[axis] * piece / pieces));
            for i in -1..=1 {
                for j in -1..=1 {
                    mask.set([column + i, row + j]);
                }
            }
        }
    }
}

/// A bit for each part of a tile and of so many around it.
struct Mask {
    beyond: i64,
    size: [i64; 2],
    bits: Vec<bool>,
}

impl Mask {
    fn new(parts: [i64; 2], beyond: i64) -> Self {
        let size = parts.map(|n| n + 2 * beyond);
        Self { beyond, size, bits: vec![false; (size[0] * size[1]) as usize] }
    }

    fn slot(&self, part: [i64; 2]) -> Option<usize> {
        let at = part.map(|p| p + self.beyond);
        let is_inside = (0..2).all(|axis| (0..self.size[axis]).contains(&at[axis]));
        is_inside.then(|| (at[1] * self.size[0] + at[0]) as usize)
    }

    fn get(&self, part: [i64; 2]) -> bool {
        self.slot(part).is_some_and(|slot| self.bits[slot])
    }

    fn set(&mut self, part: [i64; 2]) {
        if let Some(slot) = self.slot(part) {
            self.bits[slot] = true;
        }
    }

    fn fill(&mut self, is_set: impl Fn([i64; 2]) -> bool) {
        let (size, beyond) = (self.size, self.beyond);
        for (slot, bit) in self.bits.iter_mut().enumerate() {
            let at = [slot as i64 % size[0], slot as i64 / size[0]];
            *bit = is_set(at.map(|c| c - beyond));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terrain::TerrainOptions;
    use crate::terrain::outlines::{Inside, Outlines};
    use crate::terrain::samples::GroundStore;

    /// Coverage of the tile at `key`, 100 m wide, of ground that is everywhere but where `is_gap` says.
    fn coverage(key: [i64; 2], outlines: Outlines, is_gap: impl Fn(f64, f64) -> bool) -> Coverage {
        let options = TerrainOptions { terrain_tile: 100.0, ..TerrainOptions::default() };
        let grid = Grid::new(&options, [1.0; 3]);
        let folder = tempfile::tempdir().unwrap();
        let store = GroundStore::create(folder.path(), grid).unwrap();
        let mut collector = store.collector();
        for i in -100..300 {
            for j in -100..200 {
                let (x, y) = (f64::from(i) + 0.5, f64::from(j) + 0.5);
                if !is_gap(x, y) {
                    collector.add([x, y, 0.0], true);
                }
            }
        }
        collector.finish().unwrap();
        let ground = Ground::read(&store, key, None).unwrap();
        Coverage::of(&ground, &Surroundings::of(&outlines.close(&grid), &grid, key))
    }

    #[test]
    fn narrow_gaps_are_spanned_and_wide_ones_left_out() {
        let narrow = |x: f64, _: f64| (30.0..45.0).contains(&x);
        let wide = |x: f64, y: f64| (60.0..90.0).contains(&x) && (20.0..50.0).contains(&y);
        let found = coverage([0, 0], Outlines::default(), |x, y| narrow(x, y) || wide(x, y));
        assert!((0..25).all(|row| (8..11).all(|column| found.is_spanned([column, row]))));
        assert!(!found.is_covered([15, 8]) && !found.is_covered([18, 8]) && found.is_covered([13, 8]));
        // 7 by 7 without a point; the circle does not get into the corners.
        assert_eq!(found.of_tile().filter(|part| !found.is_covered(*part)).count(), 37);
    }

    #[test]
    fn neighbours_agree_on_the_parts_along_their_border() {
        let wide = |x: f64, y: f64| (x - 103.0).hypot(y - 61.0) < 19.0;
        let tiles = [[0, 0], [1, 0]].map(|key| coverage(key, Outlines::default(), wide));
        for row in 0..25 {
            for column in 23..27 {
                assert_eq!(
                    tiles[0].is_covered([column, row]),
                    tiles[1].is_covered([column - 25, row]),
                    "{column} {row}"
                );
            }
        }
        assert!(!tiles[0].is_covered([24, 15]));
    }

    #[test]
    fn around_a_building_there_is_terrain() {
        let mut outlines = Outlines::default();
        let floor = [[500_000, 500_000, 0], [600_000, 500_000, 0], [600_000, 560_000, 0], [500_000, 560_000, 0]];
        outlines.polygon(Inside::Hole, [0; 3], &[floor.to_vec()]);
        let found = coverage([0, 0], outlines, |x, y| x.max(y) > 10.0);
        assert!(found.is_covered([12, 12]) && !found.is_covered([8, 12]) && !found.is_spanned([12, 12]));
    }
}
