//! What stands apart in a cloud: the parts of a plan between which nothing was scanned.
//!
//! Points are counted in cells of the plane that stand fast in the CRS, so neither the order of the points nor the way the
//! cloud is cut into tiles matters. How wide a gap parts two buildings follows the spacing of the points: where these are
//! half a metre apart, three metres without one are nothing between two roofs, and where they are five centimetres apart,
//! half a metre is a hole in a wall that a scanner could not see.

use std::collections::HashMap;

use foldhash::fast::FixedState;

use crate::source::points::Parcels;

/// Side of the cells in which points are counted, metres.
const FINE: f64 = 0.25;
/// Cells along the longer side of the cloud, at most.
const MOST_CELLS: f64 = 8192.0;
/// A gap is as wide as so many spacings of points,
const SPACINGS: f64 = 5.0;
/// and at least so wide, metres: gaps of a cloud that is denser are holes in it.
const NARROWEST: f64 = 1.0;
/// Cells per gap.
const PER_GAP: i64 = 3;
/// A part with fewer points than this, or less area in square metres, is no building.
const FEWEST: u64 = 30;
const SMALLEST: f64 = 4.0;
/// What is too small for a building is part of one that is no further than so many gaps.
const NEAR: f64 = 2.0;
/// Heights within this share of the height of the cloud above its lowest, or this many metres, are low.
const LOW: (f64, f64) = (0.15, 1.0);
/// Where this share of the cells is low, and of the edge of what is not low this share meets low cells, there is ground.
const GROUND: (f64, f64) = (0.3, 0.6);

/// A cell of the plan: how many points it holds, and the highest and lowest of them in metres.
#[derive(Debug, Clone, Copy)]
struct Cell {
    points: u64,
    low: f64,
    high: f64,
}

impl Cell {
    const EMPTY: Self = Self { points: 0, low: f64::INFINITY, high: f64::NEG_INFINITY };

    fn join(&mut self, other: &Self) {
        self.points += other.points;
        self.low = self.low.min(other.low);
        self.high = self.high.max(other.high);
    }
}

type Cells = HashMap<[i64; 2], Cell, FixedState>;

/// The plan of a cloud.
#[derive(Debug)]
pub(super) struct Plan {
    cells: Cells,
    /// Side of a cell, metres.
    side: f64,
    metres_per_unit: [f64; 3],
}

/// What stands apart.
#[derive(Debug)]
pub(super) struct Parts {
    /// Which part each cell belongs to; the parts are numbered by their westernmost cells.
    pub parcels: Parcels,
    /// Number of parts.
    pub count: usize,
    /// Points that are too few, too far from all parts.
    pub unused: u64,
    /// How wide a gap is, metres.
    pub gap: f64,
}

impl Plan {
    /// An empty plan for a cloud that reaches over `size` metres at most.
    pub fn new(size: f64, metres_per_unit: [f64; 3]) -> Self {
        let side = FINE.max(size / MOST_CELLS);
        Self { cells: Cells::default(), side, metres_per_unit }
    }

    /// Takes a point in, CRS units.
    pub fn add(&mut self, position: [f64; 3]) {
        let z = position[2] * self.metres_per_unit[2];
        let cell = self.cells.entry(Parcels::key(self.cell(1), position)).or_insert(Cell::EMPTY);
        cell.join(&Cell { points: 1, low: z, high: z });
    }

    /// Sides of `n` cells in CRS units.
    fn cell(&self, n: i64) -> [f64; 2] {
        [0, 1].map(|axis| self.side * n as f64 / self.metres_per_unit[axis])
    }

    /// Cells of `n` by `n` in one.
    fn coarser(&self, n: i64) -> Cells {
        let mut coarse = Cells::default();
        for (key, cell) in &self.cells {
            coarse.entry(key.map(|k| k.div_euclid(n))).or_insert(Cell::EMPTY).join(cell);
        }
        coarse
    }

    /// The usual distance between neighbours in plan, metres: that of as many points on a square grid as half of the cells
    /// of a metre have at most.
    fn spacing(&self) -> f64 {
        let n = ((1.0 / self.side).round() as i64).max(1);
        let mut counts: Vec<u64> = self.coarser(n).values().map(|cell| cell.points).collect();
        counts.sort_unstable();
        let median = counts.get(counts.len() / 2).copied().unwrap_or(1);
        self.side * n as f64 / (median as f64).sqrt()
    }

    /// What stands apart.
    pub fn parts(&self) -> Parts {
        let gap = NARROWEST.max(SPACINGS * self.spacing());
        let n = ((gap / PER_GAP as f64 / self.side).round() as i64).max(1);
        let side = self.side * n as f64;
        let cells = self.coarser(n);
        let mut keys: Vec<[i64; 2]> = cells.keys().copied().collect();
        keys.sort_unstable();
        let reach = gap / side;
        let mut of_cell: HashMap<[i64; 2], usize, FixedState> = HashMap::default();
        let mut groups: Vec<Vec<[i64; 2]>> = Vec::new();
        for &start in &keys {
            if of_cell.contains_key(&start) {
                continue;
            }
            let group = groups.len();
            of_cell.insert(start, group);
            let mut members = vec![start];
            let mut next = 0;
            while let Some(&from) = members.get(next) {
                next += 1;
                for to in within(from, reach).filter(|to| cells.contains_key(to)) {
                    of_cell.entry(to).or_insert_with(|| {
                        members.push(to);
                        group
                    });
                }
            }
            groups.push(members);
        }
        let points =
            |members: &[[i64; 2]]| members.iter().filter_map(|key| cells.get(key)).map(|c| c.points).sum::<u64>();
        let is_building: Vec<bool> = groups
            .iter()
            .map(|members| points(members) >= FEWEST && members.len() as f64 * side * side >= SMALLEST)
            .collect();
        // Groups are found from west to east, so their numbers depend on nothing else.
        let mut number = vec![None; groups.len()];
        let mut count = 0;
        for (number, _) in number.iter_mut().zip(&is_building).filter(|(_, is_building)| **is_building) {
            *number = Some(count);
            count += 1;
        }
        let mut unused = 0;
        let mut parcels = Parcels { cell: self.cell(n), buildings: HashMap::default() };
        for (group, members) in groups.iter().enumerate() {
            let building = number[group].or_else(|| {
                let around = members.iter().flat_map(|&from| within(from, NEAR * reach).map(move |to| (from, to)));
                let near = around.filter_map(|(from, to)| {
                    let building = number[*of_cell.get(&to)?]?;
                    Some((distance(from, to), building))
                });
                near.min().map(|(_, building)| building)
            });
            match building {
                Some(building) => parcels.buildings.extend(members.iter().map(|key| (*key, building))),
                None => unused += points(members),
            }
        }
        Parts { parcels, count: count as usize, unused, gap }
    }

    /// The share of the cells that is ground, where ground lies around what stands out of it.
    pub fn ground(&self) -> Option<f64> {
        let n = ((1.0 / self.side).round() as i64).max(1);
        let cells = self.coarser(n);
        let mut tops: Vec<f64> = cells.values().map(|cell| cell.high).collect();
        tops.sort_unstable_by(f64::total_cmp);
        let at = |share: f64| tops.get((share * tops.len() as f64) as usize).copied();
        let (lowest, highest) = (at(0.02)?, at(0.98)?);
        let level = lowest + LOW.1.max(LOW.0 * (highest - lowest));
        let is_low = |key: &[i64; 2]| cells.get(key).map(|cell| cell.high <= level);
        let low = cells.keys().filter(|key| is_low(key) == Some(true)).count();
        let (mut edges, mut to_low) = (0_u32, 0_u32);
        for key in cells.keys().filter(|key| is_low(key) == Some(false)) {
            for beside in [[-1, 0], [1, 0], [0, -1], [0, 1]] {
                match is_low(&[key[0] + beside[0], key[1] + beside[1]]) {
                    Some(false) => {}
                    Some(true) => (edges, to_low) = (edges + 1, to_low + 1),
                    None => edges += 1,
                }
            }
        }
        let share = low as f64 / cells.len().max(1) as f64;
        (share >= GROUND.0 && f64::from(to_low) >= GROUND.1 * f64::from(edges) && edges > 0).then_some(share)
    }
}

/// The square of the distance of two cells.
fn distance(a: [i64; 2], b: [i64; 2]) -> i64 {
    (a[0] - b[0]).pow(2) + (a[1] - b[1]).pow(2)
}

/// The cells within `reach` cells of one, itself excepted.
fn within(from: [i64; 2], reach: f64) -> impl Iterator<Item = [i64; 2]> {
    let n = reach.floor() as i64;
    let all = (-n..=n).flat_map(move |dx| (-n..=n).map(move |dy| [from[0] + dx, from[1] + dy]));
    all.filter(move |to| *to != from && distance(from, *to) as f64 <= reach * reach)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points of a slab over a rectangle at a height, so many metres apart.
    fn slab(plan: &mut Plan, x: [f64; 2], y: [f64; 2], z: f64, spacing: f64) -> u64 {
        let steps = |[low, high]: [f64; 2]| ((high - low) / spacing) as i64;
        let mut points = 0;
        for i in 0..steps(x) {
            for j in 0..steps(y) {
                // Not on a lattice: a scan is none.
                let turn = ((i * 7 + j * 13) % 10) as f64 / 10.0 * spacing * 0.5;
                plan.add([x[0] + i as f64 * spacing + turn, y[0] + j as f64 * spacing - turn, z]);
                points += 1;
            }
        }
        points
    }

    #[test]
    fn gaps_that_are_wide_for_the_spacing_part_buildings() {
        for (spacing, gap) in [(0.05, 1.5), (0.3, 2.5), (0.7, 5.0), (1.0, 7.0)] {
            let mut plan = Plan::new(100.0, [1.0; 3]);
            slab(&mut plan, [0.0, 20.0], [0.0, 15.0], 5.0, spacing);
            slab(&mut plan, [20.0 + gap, 40.0], [0.0, 15.0], 8.0, spacing);
            let parts = plan.parts();
            assert_eq!((parts.count, parts.unused), (2, 0), "{spacing}: {}", parts.gap);
            assert_eq!(parts.parcels.building([1.0, 1.0, 0.0]), Some(0));
            assert_eq!(parts.parcels.building([30.0 + gap / 2.0, 1.0, 0.0]), Some(1));
        }
    }

    #[test]
    fn holes_and_thin_places_part_nothing() {
        let mut plan = Plan::new(100.0, [1.0; 3]);
        slab(&mut plan, [0.0, 10.0], [0.0, 15.0], 5.0, 0.1);
        // A hole, and beyond it a roof that was seen ten times less.
        slab(&mut plan, [10.7, 20.0], [0.0, 15.0], 5.0, 0.3);
        assert_eq!(plan.parts().count, 1);
    }

    #[test]
    fn what_is_too_small_belongs_to_what_is_near_or_to_nothing() {
        let mut plan = Plan::new(100.0, [1.0; 3]);
        slab(&mut plan, [0.0, 10.0], [0.0, 10.0], 5.0, 0.2);
        let chimney = slab(&mut plan, [11.4, 12.0], [5.0, 5.6], 7.0, 0.2);
        let bird = slab(&mut plan, [60.0, 60.6], [50.0, 50.6], 30.0, 0.2);
        let parts = plan.parts();
        assert!(chimney > 0 && bird > 0);
        assert_eq!((parts.count, parts.unused), (1, bird));
        assert_eq!(parts.parcels.building([11.5, 5.1, 7.0]), Some(0));
        assert_eq!(parts.parcels.building([60.1, 50.1, 7.0]), None);
    }

    #[test]
    fn feet_are_no_metres() {
        let feet = 0.3048;
        let mut plan = Plan::new(100.0, [feet; 3]);
        let scaled = |range: [f64; 2]| range.map(|x| x / feet);
        slab(&mut plan, scaled([0.0, 10.0]), scaled([0.0, 10.0]), 5.0, 0.3 / feet);
        slab(&mut plan, scaled([12.5, 20.0]), scaled([0.0, 10.0]), 5.0, 0.3 / feet);
        assert_eq!(plan.parts().count, 2);
    }

    #[test]
    fn ground_is_what_lies_around_and_no_low_roof_beside_a_high_one() {
        let mut plan = Plan::new(100.0, [1.0; 3]);
        slab(&mut plan, [0.0, 30.0], [0.0, 30.0], 0.2, 0.3);
        slab(&mut plan, [10.0, 20.0], [10.0, 20.0], 6.0, 0.3);
        assert!(plan.ground().is_some_and(|share| share > 0.8));
        let mut plan = Plan::new(100.0, [1.0; 3]);
        slab(&mut plan, [0.0, 10.0], [0.0, 10.0], 3.0, 0.3);
        slab(&mut plan, [10.0, 20.0], [0.0, 10.0], 9.0, 0.3);
        assert_eq!(plan.ground(), None);
        let mut plan = Plan::new(100.0, [1.0; 3]);
        slab(&mut plan, [0.0, 10.0], [0.0, 10.0], 3.0, 0.3);
        assert_eq!(plan.ground(), None);
    }
}
