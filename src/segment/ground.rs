//! The ground around a building.
//!
//! Ground points are thinned while they stream by: of each square metre the one nearest to its centre is kept, which
//! gives every part of the ring the same weight whatever the overlap of strips, and makes the result independent of
//! order, tiling and duplicates.

use super::neighbourhood::{Neighbourhood, to_local};
use super::options::SegmentOptions;
use crate::site::{Frame, Ground, GroundSource};
use std::cmp::Ordering;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Side of the cells of the ground, metres.
pub(super) const GROUND_CELL: f64 = 1.0;
/// Side of the cells of the ground inside footprints, metres; of open ground every part counts, so they are small.
pub(super) const OPEN_CELL: f64 = 0.5;
/// Side of the cells of the lowest points, metres; wide, so that a cell under a tree sees the ground somewhere.
pub(super) const LOWEST_CELL: f64 = 2.0;
/// Fewer cells than this say nothing of the ground.
const FEWEST_CELLS: usize = 4;

/// Which point of a cell stands for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Choice {
    /// The one nearest to the centre.
    Central,
    /// The lowest.
    Lowest,
}

/// One point per cell, in snapped CRS units.
#[derive(Debug)]
pub(super) struct Thinned {
    choice: Choice,
    /// Side of a cell, CRS units.
    side: [f64; 2],
    cells: HashMap<[i32; 2], [f64; 3]>,
}

impl Thinned {
    /// No point yet; cells of `side` metres.
    pub fn new(choice: Choice, side: f64, metres_per_unit: [f64; 3]) -> Self {
        let side = [side / metres_per_unit[0], side / metres_per_unit[1]];
        Self { choice, side, cells: HashMap::new() }
    }

    /// Takes a point, in snapped CRS units, if it stands for its cell better than the one that does.
    pub fn add(&mut self, point: [f64; 3]) {
        let key = self.key([point[0], point[1]]);
        let (choice, side) = (self.choice, self.side);
        match self.cells.entry(key) {
            Entry::Vacant(slot) => {
                slot.insert(point);
            }
            Entry::Occupied(mut slot) => {
                if rank(choice, side, key, point, *slot.get()) == Ordering::Less {
                    slot.insert(point);
                }
            }
        }
    }

    /// Takes over what another one kept.
    pub fn merge(&mut self, other: Self) {
        if self.cells.is_empty() {
            self.cells = other.cells;
            return;
        }
        // The order of iteration does not matter: the best of a cell is the best in any order.
        for point in other.cells.into_values() {
            self.add(point);
        }
    }

    /// The points in the cells that touch the rectangle, in no particular order.
    pub fn within(&self, low: [f64; 2], high: [f64; 2]) -> Vec<[f64; 3]> {
        let (first, last) = (self.key(low), self.key(high));
        let sides = [0, 1].map(|axis| i64::from(last[axis]) - i64::from(first[axis]) + 1);
        // Footprints as wide as a country exist, by mistake or not: then it is faster to go through what there is.
        if sides[0].saturating_mul(sides[1]) > self.cells.len() as i64 {
            let touches = |key: &[i32; 2]| (0..2).all(|axis| (first[axis]..=last[axis]).contains(&key[axis]));
            return self.cells.iter().filter(|(key, _)| touches(key)).map(|(_, point)| *point).collect();
        }
        (first[1]..=last[1])
            .flat_map(move |row| (first[0]..=last[0]).map(move |column| [column, row]))
            .filter_map(|key| self.cells.get(&key).copied())
            .collect()
    }

    fn key(&self, place: [f64; 2]) -> [i32; 2] {
        [0, 1].map(|axis| (place[axis] / self.side[axis]).floor() as i32)
    }
}

/// Whether `a` stands better (less) or worse (greater) for cell `key` than `b`; equal only for equal points.
fn rank(choice: Choice, side: [f64; 2], key: [i32; 2], a: [f64; 3], b: [f64; 3]) -> Ordering {
    let merit = |point: [f64; 3]| match choice {
        Choice::Lowest => point[2],
        Choice::Central => {
            let off: [f64; 2] = std::array::from_fn(|axis| point[axis] - (f64::from(key[axis]) + 0.5) * side[axis]);
            off[0] * off[0] + off[1] * off[1]
        }
    };
    let coordinates = || a.iter().zip(&b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
    merit(a).total_cmp(&merit(b)).then_with(|| coordinates().unwrap_or(Ordering::Equal))
}

/// The ground around footprint `index`, in its local frame.
///
/// From ground points in a ring outside the footprint and outside all others, widened until there is enough of it; then
/// from the lowest points of any class inside the footprint and in the ring; then from `lowest_point`, the height of the
/// lowest building point (or 0 without any).
pub(super) fn estimate(
    index: usize,
    all: &Neighbourhood,
    ground: &Thinned,
    lowest: &Thinned,
    lowest_point: Option<f64>,
    options: &SegmentOptions,
) -> Ground {
    let mut width = options.ring_width;
    loop {
        let heights = heights_around(index, all, ground, width, false);
        if heights.len() >= options.ring_area as usize {
            return robust(heights, options.ground_percentile, GroundSource::GroundPoints);
        }
        if width >= options.ring_limit {
            if heights.len() >= FEWEST_CELLS {
                return robust(heights, options.ground_percentile, GroundSource::GroundPoints);
            }
            break;
        }
        width = (2.0 * width).min(options.ring_limit);
    }
    let heights = heights_around(index, all, lowest, options.ring_width, true);
    if heights.len() >= FEWEST_CELLS {
        return robust(heights, options.ground_percentile, GroundSource::LowestPoints);
    }
    let height = heights.into_iter().chain(lowest_point).reduce(f64::min).unwrap_or(0.0);
    Ground { height, spread: 0.0, source: GroundSource::BoundingBox }
}

/// The ground points inside a footprint, in its local frame, sorted by x, y, z.
pub(super) fn inside(frame: &Frame, ground: Option<Thinned>) -> Vec<[f64; 3]> {
    let kept = ground.into_iter().flat_map(|ground| ground.cells.into_values());
    let mut points: Vec<_> = kept.map(|position| to_local(frame, position)).collect();
    points.sort_unstable_by(super::lexicographic);
    points
}

/// Heights (local metres) of the points of `thinned` within `width` metres of the footprint, those inside it included
/// or not, those inside other footprints excluded.
fn heights_around(index: usize, all: &Neighbourhood, thinned: &Thinned, width: f64, inside: bool) -> Vec<f64> {
    let (frame, prepared) = (&all.frames[index], &all.prepared[index]);
    let Some((low, high)) = all.surroundings(index, width) else { return Vec::new() };
    let kept = thinned.within(low, high).into_iter().filter_map(|position| {
        let [x, y, z] = to_local(frame, position);
        let wanted = if prepared.contains([x, y]) {
            inside
        } else {
            prepared.boundary_distance([x, y], width) <= width && !all.is_inside_another(position, index)
        };
        wanted.then_some(z)
    });
    kept.collect()
}

fn robust(mut heights: Vec<f64>, percent: f64, source: GroundSource) -> Ground {
    heights.sort_unstable_by(f64::total_cmp);
    let height = percentile(&heights, percent);
    Ground { height, spread: percentile(&heights, 75.0) - percentile(&heights, 25.0), source }
}

/// The percentile of sorted values, interpolated between neighbours; 0 of none.
fn percentile(sorted: &[f64], percent: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return 0.0 };
    let place = percent.clamp(0.0, 100.0) / 100.0 * last as f64;
    let below = (place.floor() as usize).min(last);
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::{Choice, Thinned, percentile};

    #[test]
    fn percentiles_are_interpolated() {
        let heights = [1.0, 2.0, 3.0, 7.0];
        assert_eq!(percentile(&heights, 0.0), 1.0);
        assert_eq!(percentile(&heights, 50.0), 2.5);
        assert_eq!(percentile(&heights, 100.0), 7.0);
        assert_eq!(percentile(&[], 50.0), 0.0);
    }

    #[test]
    fn a_cell_is_represented_the_same_in_any_order_and_with_duplicates() {
        let points = [[0.4, 0.5, 3.0], [0.6, 0.5, 1.0], [0.1, 0.9, 0.5], [0.4, 0.5, 2.0]];
        for choice in [Choice::Central, Choice::Lowest] {
            let thin = |order: &[usize]| {
                let mut thinned = Thinned::new(choice, 1.0, [1.0; 3]);
                for i in order {
                    thinned.add(points[*i]);
                }
                thinned.within([0.0; 2], [0.9; 2])
            };
            let expected = if choice == Choice::Central { [0.4, 0.5, 2.0] } else { [0.1, 0.9, 0.5] };
            for order in [&[0, 1, 2, 3][..], &[3, 2, 1, 0], &[1, 3, 0, 2, 2, 1, 0, 3]] {
                assert_eq!(thin(order), [expected]);
            }
        }
    }
}
