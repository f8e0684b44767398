//! The ground points in and around one tile.

use super::grid::{Grid, Place, TileKey};
use super::samples::{GroundStore, Sample};
use super::surroundings::Surroundings;
use crate::error::Result;

/// Half the width of the square of cells in which a ground point must have company, in cells.
const COMPANY: i64 = 2;
/// From so many neighbours on it is judged …
const FEWEST: u32 = 8;
/// … and is astray where fewer than one of so many lie near its height,
const SUPPORT: u32 = 8;
/// which is within this many metres and the distance: a slope of 45° is no step.
const LEVEL: f64 = 0.5;
/// Width of the collar around outlines in which the terrain gets from the floor to the ground, metres.
pub(super) const COLLAR: f64 = 2.0;
/// The steepest that it is there, where the ground allows: rise over run.
pub(super) const STEEPEST: f64 = 1.0;
/// So many ground points tell the height of a place.
const NEAREST: usize = 6;
/// Points as near as this count alike, metres.
const BLUNT: f64 = 0.25;

/// What becomes of the ground point of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum State {
    /// There is none.
    Absent,
    /// It may become a vertex.
    Free,
    /// It is none: of no company, or too near to an outline.
    Left,
    /// It should be one, but there is no room for it beside another, or beside an edge that must stay.
    Crowded,
    /// It is a vertex.
    Vertex,
}

/// The ground points in and around a tile; places are counted from its south-western corner.
pub(super) struct Ground {
    pub(super) grid: Grid,
    /// The first cell of the window, counted from the origin of the CRS.
    first: [i64; 2],
    size: [i64; 2],
    corner: Place,
    samples: Vec<Option<Sample>>,
    pub(super) states: Vec<State>,
    /// How many were of no company.
    pub strays: usize,
    /// Whether a terrain model gave any, and whether the scan did.
    pub has_model: bool,
    pub has_points: bool,
}

impl Ground {
    /// Reads the ground points of a tile; `model` has the heights of the terrain model in the middles of every second cell, and
    /// goes before them.
    ///
    /// # Errors
    /// A store cannot be read.
    pub fn read(store: &GroundStore, key: TileKey, model: Option<&GroundStore>) -> Result<Self> {
        let grid = *store.grid();
        let corner = grid.corner(key);
        let first = grid.cell([0, 1].map(|axis| corner[axis] - grid.margin[axis]));
        let last = grid.cell([0, 1].map(|axis| corner[axis] + grid.tile[axis] + grid.margin[axis]));
        let size = [0, 1].map(|axis| last[axis] - first[axis] + 1);
        let mut samples = store.window(first, last)?;
        let of_model = match model {
            Some(model) => lay_over(&mut samples, &model.window(first, last)?, (first, size)),
            None => 0,
        };
        let (has_model, has_points) = (of_model > 0, samples.iter().flatten().count() > of_model);
        let state = |sample: &Option<Sample>| if sample.is_some() { State::Free } else { State::Absent };
        let states = samples.iter().map(state).collect();
        let mut ground = Self { grid, first, size, corner, samples, states, strays: 0, has_model, has_points };
        ground.drop_strays();
        Ok(ground)
    }

    /// The place and height of the ground point of a cell, if it has one.
    pub fn point(&self, index: usize) -> Option<(Place, i64)> {
        let sample = self.samples.get(index).copied().flatten()?;
        let cell = [index as i64 % self.size[0], index as i64 / self.size[0]];
        let start = |axis: usize| (self.first[axis] + cell[axis]) * self.grid.sample[axis] - self.corner[axis];
        Some(([0, 1].map(|axis| start(axis) + i64::from(sample.at[axis])), i64::from(sample.z)))
    }

    /// The cells between two columns of a row that are in the window, both counted in steps from the corner of the tile.
    pub fn row(&self, y: i64, low: i64, high: i64) -> std::ops::Range<usize> {
        let row = y - self.first[1];
        if !(0..self.size[1]).contains(&row) {
            return 0..0;
        }
        let column = |x: i64| (x + self.corner[0]).div_euclid(self.grid.sample[0]) - self.first[0];
        let (from, to) = (column(low).clamp(0, self.size[0]), (column(high) + 1).clamp(0, self.size[0]));
        let start = row * self.size[0];
        (start + from) as usize..(start + to.max(from)) as usize
    }

    /// The row of cells that a place is in.
    pub fn row_of(&self, y: i64) -> i64 {
        (y + self.corner[1]).div_euclid(self.grid.sample[1])
    }

    /// Where a row of cells begins.
    pub fn row_start(&self, row: i64) -> i64 {
        row * self.grid.sample[1] - self.corner[1]
    }

    /// Calls `visit` with the index of each cell of the window that has a usable ground point.
    pub fn each(&self, mut visit: impl FnMut(usize)) {
        self.states.iter().enumerate().filter(|(_, state)| **state == State::Free).for_each(|(i, _)| visit(i));
    }

    /// Leaves out points that lie far above or below all others around them.
    fn drop_strays(&mut self) {
        let [columns, rows] = self.size;
        let mut strays = Vec::new();
        self.each(|index| {
            let Some((place, z)) = self.point(index) else { return };
            let (column, row) = (index as i64 % columns, index as i64 / columns);
            let (mut around, mut support) = (0, 0);
            for r in (row - COMPANY).max(0)..=(row + COMPANY).min(rows - 1) {
                for c in (column - COMPANY).max(0)..=(column + COMPANY).min(columns - 1) {
                    let other = (r * columns + c) as usize;
                    let Some((there, height)) = self.point(other).filter(|_| other != index) else { continue };
                    let rise = (height - z).abs() as f64 * self.grid.step[2];
                    around += 1;
                    support += u32::from(rise <= LEVEL + self.grid.distance(place, there));
                }
            }
            if around >= FEWEST && SUPPORT * support < around {
                strays.push(index);
            }
        });
        for index in &strays {
            self.states[*index] = State::Left;
        }
        self.strays = strays.iter().filter(|index| self.is_in_tile(**index)).count();
    }

    fn is_in_tile(&self, index: usize) -> bool {
        self.point(index).is_some_and(|(place, _)| (0..2).all(|axis| (0..self.grid.tile[axis]).contains(&place[axis])))
    }

    /// Leaves out the points of the collar of an outline to which the terrain would have to climb steeper than it may.
    pub fn clear_collars(&mut self, outlines: &Surroundings) {
        let reach = self.grid.steps(COLLAR);
        let mut near: Vec<usize> = Vec::new();
        for edge in &outlines.edges {
            let [a, b] = edge.ends;
            let (low, high) = ([0, 1].map(|i| a[i].min(b[i]) - reach[i]), [0, 1].map(|i| a[i].max(b[i]) + reach[i]));
            for row in self.row_of(low[1])..=self.row_of(high[1]) {
                near.extend(self.row(row, low[0], high[0]).filter(|index| self.states[*index] == State::Free));
            }
        }
        near.sort_unstable();
        near.dedup();
        for index in near {
            if let Some((place, z)) = self.point(index)
                && is_too_steep(outlines, place, z as f64, &self.grid)
            {
                self.states[index] = State::Left;
            }
        }
    }

    /// The height of the ground at a place, in steps, from the points around it within so many metres; near ones count more.
    pub fn height(&self, place: Place, metres: f64) -> Option<f64> {
        let centre =
            [0, 1].map(|axis| (place[axis] + self.corner[axis]).div_euclid(self.grid.sample[axis]) - self.first[axis]);
        let side = [0, 1].map(|axis| self.grid.sample[axis] as f64 * self.grid.step[axis]);
        let rings = (metres / side[0].min(side[1])).ceil() as i64;
        let mut found: Vec<(f64, i64)> = Vec::new();
        let mut enough = None;
        for ring in 0..=rings {
            // One more ring than it takes: corners of a square are farther than the middles of the next one's sides.
            if enough.is_some_and(|last| ring > last) {
                break;
            }
            for row in -ring..=ring {
                let step = if row.abs() == ring { 1 } else { (2 * ring).max(1) };
                for column in (-ring..=ring).step_by(step as usize) {
                    let cell = [centre[0] + column, centre[1] + row];
                    if (0..2).any(|axis| !(0..self.size[axis]).contains(&cell[axis])) {
                        continue;
                    }
                    let index = (cell[1] * self.size[0] + cell[0]) as usize;
                    if self.states[index] != State::Free {
                        continue;
                    }
                    if let Some((there, z)) = self.point(index) {
                        found.push((self.grid.distance(place, there), z));
                    }
                }
            }
            if enough.is_none() && found.len() >= NEAREST {
                enough = Some(ring + 1);
            }
        }
        found.retain(|(distance, _)| *distance <= metres);
        found.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
        found.truncate(NEAREST);
        let weight = |distance: f64| 1.0 / (distance * distance + BLUNT * BLUNT);
        let weights: f64 = found.iter().map(|(distance, _)| weight(*distance)).sum();
        let sum: f64 = found.iter().map(|(distance, z)| weight(*distance) * *z as f64).sum();
        (!found.is_empty()).then(|| sum / weights)
    }
}

/// Whether a place at this height (steps) is in the collar of an outline, and steeper above or below it than the terrain may
/// rise there.
pub(super) fn is_too_steep(outlines: &Surroundings, place: Place, z: f64, grid: &Grid) -> bool {
    outlines.near(place, COLLAR).any(|(distance, height)| (z - height).abs() * grid.step[2] > STEEPEST * distance)
}

/// Puts the heights of the terrain model over the ground points: each stands for four cells. Where it has none the points
/// stay. How many it had.
fn lay_over(samples: &mut [Option<Sample>], model: &[Option<Sample>], (first, size): ([i64; 2], [i64; 2])) -> usize {
    let mut count = 0;
    for (slot, height) in model.iter().enumerate().filter(|(_, height)| height.is_some()) {
        count += 1;
        let [column, row] = [slot as i64 % size[0], slot as i64 / size[0]];
        let even = |c: i64, first: i64| c - (c + first).rem_euclid(2);
        for (i, j) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let [c, r] = [even(column, first[0]) + i, even(row, first[1]) + j];
            if (0..size[0]).contains(&c) && (0..size[1]).contains(&r) {
                samples[(r * size[0] + c) as usize] = None;
            }
        }
        samples[slot] = *height;
    }
    count
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terrain::TerrainOptions;
    use crate::terrain::outlines::{Inside, Outlines};

    /// Ground points each half metre on what `height` says, in metres, around the tile at the origin.
    fn ground(height: impl Fn(f64, f64) -> f64) -> (Ground, Grid) {
        let options = TerrainOptions { terrain_tile: 20.0, terrain_gap: 4.0, ..TerrainOptions::default() };
        let grid = Grid::new(&options, [1.0; 3]);
        let folder = tempfile::tempdir().unwrap();
        let store = GroundStore::create(folder.path(), grid).unwrap();
        let mut collector = store.collector();
        for i in -60..100 {
            for j in -60..100 {
                let (x, y) = (f64::from(i) * 0.5 + 0.2, f64::from(j) * 0.5 + 0.3);
                collector.add([x, y, height(x, y)], true);
            }
        }
        collector.finish().unwrap();
        (Ground::read(&store, [0, 0], None).unwrap(), grid)
    }

    #[test]
    fn a_point_without_company_is_left_out_and_a_step_is_not() {
        let pit = |x: f64, y: f64| (x - 10.2).abs() < 0.1 && (y - 10.3).abs() < 0.1;
        let (ground, _) = ground(|x, y| {
            if pit(x, y) {
                -3.0
            } else if x < 5.0 {
                2.0
            } else {
                0.0
            }
        });
        assert_eq!(ground.strays, 1);
        assert!((ground.height([102_000, 103_000], 2.0).unwrap() / 1e4).abs() < 0.01);
        assert!((ground.height([30_000, 103_000], 2.0).unwrap() / 1e4 - 2.0).abs() < 0.01);
    }

    #[test]
    fn heights_follow_a_slope_and_end_where_there_are_no_points() {
        let (ground, _) = ground(|x, y| 0.5 * x - 0.2 * y);
        let height = ground.height([83_000, 121_000], 2.0).unwrap() / 1e4;
        assert!((height - (0.5 * 8.3 - 0.2 * 12.1)).abs() < 0.1, "{height}");
        assert_eq!(ground.height([900_000, 0], 2.0), None);
    }

    #[test]
    fn what_is_steep_above_a_floor_is_left_out_in_the_collar_only() {
        let (mut ground, grid) = ground(|_, _| 1.0);
        let mut outlines = Outlines::default();
        let floor = [[50_000, 50_000, 0], [90_000, 50_000, 0], [90_000, 90_000, 0], [50_000, 90_000, 0]];
        outlines.polygon(Inside::Hole, [0; 3], &[floor.to_vec()]);
        ground.clear_collars(&Surroundings::of(&outlines.close(&grid), &grid, [0, 0]));
        let state = |x: i64, y: i64| {
            let index = ground.row(ground.row_of(y), x, x).start;
            ground.states[index]
        };
        assert_eq!(state(43_000, 70_000), State::Left, "0.7 m from a floor 1 m below");
        assert_eq!(state(37_000, 70_000), State::Free, "1.3 m from it");
    }

    #[test]
    fn a_terrain_model_goes_before_points_where_it_has_heights() {
        let folder = tempfile::tempdir().unwrap();
        let grid = Grid::new(&TerrainOptions { terrain_tile: 20.0, ..TerrainOptions::default() }, [1.0; 3]);
        let store = GroundStore::create(folder.path(), grid).unwrap();
        let mut collector = store.collector();
        (0..40).for_each(|i| collector.add([f64::from(i) * 0.5 + 0.1, 5.1, 1.0], true));
        collector.finish().unwrap();
        let model = GroundStore::create(folder.path(), grid).unwrap();
        let mut collector = model.collector();
        (0..10).for_each(|i| collector.add([f64::from(i) + 0.25, 5.25, 7.0], true));
        collector.finish().unwrap();
        let ground = Ground::read(&store, [0, 0], Some(&model)).unwrap();
        assert!(ground.has_model && ground.has_points);
        let at = |x: i64| -> Vec<(Place, i64)> {
            ground.row(ground.row_of(51_000), x, x + 9999).filter_map(|i| ground.point(i)).collect()
        };
        assert_eq!(at(50_000), [([52_500, 52_500], 70_000)]);
        assert_eq!(at(150_000), [([151_000, 51_000], 10_000), ([156_000, 51_000], 10_000)]);
    }
}
