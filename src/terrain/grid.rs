//! The grids that the terrain is made on, all of them fast in the CRS: nothing depends on where a file begins.

use super::TerrainOptions;
use crate::site::QUANTUM;

/// Grid steps of the output in a unit of the CRS.
pub(super) const STEPS_PER_UNIT: i64 = (1.0 / QUANTUM) as i64;
/// Side of the cells of which each gives one ground point, metres.
const SAMPLE: f64 = 0.5;
/// The largest side of such a cell in steps: so that a place in it takes 16 bits an axis.
const LARGEST_SAMPLE: f64 = 65_535.0;
/// So many parts of a tile's side are as wide as a gap.
const PARTS_PER_GAP: f64 = 5.0;
/// So many parts around a tile count for it: what is covered depends on six, heights on those within a gap.
const PARTS_AROUND: i64 = 8;
/// However narrow the gap, heights are asked of points within this distance, metres …
const LEAST_REACH: f64 = 8.0;
/// … and so much around a tile counts for it: what is left out of these depends on outlines a collar away.
const LEAST_AROUND: f64 = 12.0;
/// How far vertices of outlines may be moved, metres: what is no farther apart than a millimetre is one place to every validator.
/// The rest is rounding of the numbers that tell the millimetre and the step.
pub(super) const SNAP: f64 = 0.001 + 1e-10;

/// A place on the grid of the output, in steps.
pub(super) type Place = [i64; 2];

/// The grids of a run, in steps of the output: `x` and `y` of the CRS times `STEPS_PER_UNIT`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// Size of a step in metres.
    pub(super) step: [f64; 3],
    /// Sides of a tile.
    pub(super) tile: [i64; 2],
    /// Sides of the cells of which each gives one ground point.
    pub(super) sample: [i64; 2],
    /// How many parts a tile has along each side: the squares that are covered by terrain or not.
    pub(super) parts: [i64; 2],
    /// How far beyond a tile ground and outlines count for it.
    pub(super) margin: [i64; 2],
}

/// Which tile, counted from the origin of the CRS.
pub type TileKey = [i64; 2];

impl Grid {
    /// The grids of a CRS with units of so many metres.
    pub fn new(options: &TerrainOptions, metres_per_unit: [f64; 3]) -> Self {
        let step = metres_per_unit.map(|metres| metres * QUANTUM);
        let axis = |axis: usize| -> (i64, i64, i64, i64) {
            let tile = (options.terrain_tile / metres_per_unit[axis]).round().max(1.0) as i64 * STEPS_PER_UNIT;
            let sample = (SAMPLE / step[axis]).round().clamp(1.0, LARGEST_SAMPLE) as i64;
            let part = options.terrain_gap / PARTS_PER_GAP / step[axis];
            let parts = (tile as f64 / part).round().max(1.0) as i64;
            let least = (LEAST_AROUND / step[axis]).ceil() as i64;
            let margin = (PARTS_AROUND * (tile / parts + 1)).max(least);
            (tile, sample, parts, margin)
        };
        let [x, y] = [0, 1].map(axis);
        Self { step, tile: [x.0, y.0], sample: [x.1, y.1], parts: [x.2, y.2], margin: [x.3, y.3] }
    }

    /// How far points count for the height of a place, metres.
    pub(super) fn reach(options: &TerrainOptions) -> f64 {
        options.terrain_gap.max(LEAST_REACH)
    }

    /// The nearest place and height on the grid of the output; `None` of what is too far for it.
    pub(super) fn of_position(position: [f64; 3]) -> Option<([i64; 2], i32)> {
        let steps = position.map(|c| (c * STEPS_PER_UNIT as f64).round());
        let is_near = steps.iter().all(|c| c.abs() < 1e14) && steps[2].abs() < f64::from(i32::MAX);
        is_near.then(|| ([steps[0] as i64, steps[1] as i64], steps[2] as i32))
    }

    /// The cell that gives one ground point.
    pub(super) fn cell(&self, place: Place) -> [i64; 2] {
        [0, 1].map(|axis| place[axis].div_euclid(self.sample[axis]))
    }

    /// The tile that a place is in; of two that meet there, the one to the north and east.
    pub(super) fn tile_of(&self, place: Place) -> TileKey {
        [0, 1].map(|axis| place[axis].div_euclid(self.tile[axis]))
    }

    /// The south-western corner of a tile.
    pub(super) fn corner(&self, key: TileKey) -> Place {
        [0, 1].map(|axis| key[axis] * self.tile[axis])
    }

    /// What a tile is called: after its south-western corner, in whole units of the CRS.
    pub fn name(&self, key: TileKey) -> String {
        let [x, y] = self.corner(key).map(|steps| steps / STEPS_PER_UNIT);
        format!("terrain-{x}-{y}")
    }

    /// Where part `index` of a tile begins, counted from its south-western corner; there may be fewer than none and more than
    /// all.
    pub(super) fn part_start(&self, axis: usize, index: i64) -> i64 {
        let (tiles, own) = (index.div_euclid(self.parts[axis]), index.rem_euclid(self.parts[axis]));
        tiles * self.tile[axis] + (own * self.tile[axis] + self.parts[axis] / 2) / self.parts[axis]
    }

    /// The part of a tile that a place is in, counted from its south-western corner, from which the place is told.
    pub(super) fn part_of(&self, place: Place) -> [i64; 2] {
        [0, 1].map(|axis| {
            let tiles = place[axis].div_euclid(self.tile[axis]);
            let own = place[axis] - tiles * self.tile[axis];
            let guess = tiles * self.parts[axis] + own * self.parts[axis] / self.tile[axis];
            // Parts begin at whole steps.
            let nearer =
                |index: &i64| (self.part_start(axis, *index)..self.part_start(axis, index + 1)).contains(&place[axis]);
            [guess, guess - 1, guess + 1].into_iter().find(nearer).unwrap_or(guess)
        })
    }

    /// Metres of a difference in steps along each axis of the plane.
    pub(super) fn metres(&self, steps: [i64; 2]) -> [f64; 2] {
        [0, 1].map(|axis| steps[axis] as f64 * self.step[axis])
    }

    /// Metres between two places.
    pub(super) fn distance(&self, a: Place, b: Place) -> f64 {
        let [x, y] = self.metres([a[0] - b[0], a[1] - b[1]]);
        x.hypot(y)
    }

    /// So many metres in steps, along each axis of the plane, rounded up.
    pub(super) fn steps(&self, metres: f64) -> [i64; 2] {
        [0, 1].map(|axis| (metres / self.step[axis]).ceil() as i64)
    }

    /// So many metres of height in steps.
    pub(super) fn height_steps(&self, metres: f64) -> f64 {
        metres / self.step[2]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_fill_tiles_without_gaps_on_both_sides_of_the_origin() {
        let options = TerrainOptions { terrain_gap: 17.0, ..TerrainOptions::default() };
        for metres in [[1.0; 3], [0.3048, 0.3048, 1.0]] {
            let grid = Grid::new(&options, metres);
            assert!(grid.tile.iter().all(|side| side % STEPS_PER_UNIT == 0));
            for index in -3 * grid.parts[0]..3 * grid.parts[0] {
                let (low, high) = (grid.part_start(0, index), grid.part_start(0, index + 1));
                assert!(low < high);
                for x in [low, i64::midpoint(low, high), high - 1] {
                    assert_eq!(grid.part_of([x, low])[0], index);
                }
            }
            assert_eq!(grid.part_start(1, -grid.parts[1]), -grid.tile[1]);
        }
    }

    #[test]
    fn tiles_are_named_after_their_corner() {
        let grid = Grid::new(&TerrainOptions::default(), [1.0; 3]);
        let key = grid.tile_of([850_001_234, -1]);
        assert_eq!((key, grid.name(key).as_str()), ([340, -1], "terrain-85000--250"));
    }
}
