//! What was scanned and is no part of a building: too small to stand, or hanging in the air.
//!
//! Cranes, masts, wires, birds and the tips of spires are among the building points of every cloud. Where the model has
//! none of them, they say nothing of its roof nor of how well it fits.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Point3;

use crate::geometry::Cover;

/// Side of the cells of the plan, metres.
const CELL: f64 = 1.0;
/// Points this near in plan to a place where the model is as high as they are belong there, metres.
const NEAR: f64 = 0.5;
/// What takes up fewer cells than this does not stand, if it is higher than [`GAP`]: 4 m².
const FEWEST_CELLS: usize = 4;
/// What holds a square of so many cells is no mast, no wire and no crane: 3 m by 3 m.
const WIDE: i64 = 3;
/// What begins this high above the model hovers, metres; what ends below this is a part of the roof, however small.
const GAP: f64 = 3.0;
/// What is this many times as high as it is wide is a mast or a spire.
const SLENDER: f64 = 3.0;

/// Which points are more than `height` metres above the model, and of things that hover, or are higher than three metres
/// and too small or too slender to stand; ascending. Over the block of a building that has no better model all that is certain is what hovers.
pub(super) fn unmodelled(points: &[Point3<f64>], model: &Cover, floor: f64, height: f64, is_block: bool) -> Vec<u32> {
    let top = |p: &Point3<f64>| {
        let around = [[0.0, 0.0], [-NEAR, 0.0], [NEAR, 0.0], [0.0, -NEAR], [0.0, NEAR]];
        around.iter().filter_map(|[x, y]| model.highest(p.x + x, p.y + y)).fold(floor, f64::max)
    };
    let mut cells: BTreeMap<[i64; 2], Vec<(u32, f64)>> = BTreeMap::new();
    for (index, p) in (0_u32..).zip(points) {
        // Most points lie on the model, and need only one look.
        if model.highest(p.x, p.y).is_some_and(|z| p.z - z <= height) {
            continue;
        }
        let over = p.z - top(p);
        if over > height {
            cells.entry([p.x, p.y].map(|c| (c / CELL).floor() as i64)).or_default().push((index, over));
        }
    }
    let mut found = Vec::new();
    while let Some((first, content)) = cells.pop_first() {
        let mut thing = vec![(first, content)];
        let mut head = 0;
        while let Some(([column, row], _)) = thing.get(head) {
            let (column, row) = (*column, *row);
            head += 1;
            for key in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| [column + dx, row + dy])) {
                thing.extend(cells.remove(&key).map(|content| (key, content)));
            }
        }
        let overs = || thing.iter().flat_map(|(_, content)| content.iter().map(|(_, over)| *over));
        let (lowest, tallest) =
            overs().fold((f64::INFINITY, 0.0), |(low, high), over| (low.min(over), f64::max(high, over)));
        let width = (thing.len() as f64).sqrt() * CELL;
        let is_narrow = !holds_square(&thing.iter().map(|(cell, _)| *cell).collect());
        let hovers = is_narrow && lowest >= GAP;
        let is_mast = thing.len() < FEWEST_CELLS || (is_narrow && tallest >= SLENDER * width);
        if hovers || (!is_block && is_mast && tallest >= GAP) {
            found.extend(thing.iter().flat_map(|(_, content)| content.iter().map(|(index, _)| *index)));
        }
    }
    found.sort_unstable();
    found
}

/// Whether some of the cells make a square of [`WIDE`] by [`WIDE`].
fn holds_square(cells: &BTreeSet<[i64; 2]>) -> bool {
    let square =
        |[column, row]: &[i64; 2]| (0..WIDE).all(|dx| (0..WIDE).all(|dy| cells.contains(&[column + dx, row + dy])));
    cells.iter().any(square)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flat model of 10 m by 10 m at 6 m, and the roof points on it, four per square metre.
    fn roof() -> (Cover, Vec<Point3<f64>>) {
        let [a, b, c, d] = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]].map(|[x, y]| Point3::new(x, y, 6.0));
        let points = (0..400).map(|i| Point3::new(f64::from(i % 20) * 0.5 + 0.25, f64::from(i / 20) * 0.5 + 0.25, 6.0));
        (Cover::new([[a, b, c], [a, c, d]]), points.collect())
    }

    /// How many points over the roof are left out, of a box of points from `low` to `high` with sides of `width` metres.
    fn left_out(width: f64, low: f64, high: f64, is_block: bool) -> (usize, usize) {
        let (model, mut points) = roof();
        let own = points.len();
        let steps = |length: f64| (0..=(length / 0.5).round() as i32).map(|i| 0.5 * f64::from(i));
        for z in steps(high - low) {
            for x in steps(width) {
                points.extend(steps(width).map(|y| Point3::new(3.1 + x, 3.1 + y, low + z)));
            }
        }
        (unmodelled(&points, &model, 0.0, 1.0, is_block).len(), points.len() - own)
    }

    #[test]
    fn spires_birds_and_antennas_are_left_out_and_storeys_are_not() {
        let (all, some) = left_out(0.5, 40.0, 40.5, false);
        assert_eq!(all, some, "a bird");
        let (all, some) = left_out(1.5, 7.5, 25.0, false);
        assert_eq!(all, some, "a spire");
        let (all, some) = left_out(0.5, 7.5, 10.5, false);
        assert_eq!(all, some, "an antenna");
        assert_eq!(left_out(0.5, 7.5, 8.0, false).0, 0, "a chimney");
        assert_eq!(left_out(4.5, 9.5, 9.5, false).0, 0, "a storey that was not modelled");
        assert_eq!(left_out(1.5, 7.5, 8.0, false).0, 0, "a small storey");
    }

    #[test]
    fn over_a_block_only_what_hovers_is_left_out() {
        let (all, some) = left_out(0.5, 40.0, 40.5, true);
        assert_eq!(all, some);
        assert_eq!(left_out(0.5, 7.5, 8.0, true).0, 0);
    }
}
