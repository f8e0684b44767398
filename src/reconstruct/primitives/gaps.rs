//! Gaps in an uneven cloud: where there is little texture image matching finds a tenth of the points, and a roof goes on
//! all the same.

use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::Point3;

/// A cloud is uneven where its wide spacing is so many times the usual one; of points at random it is one and a half times.
const UNEVEN: f64 = 1.9;
/// Of an uneven cloud, gaps up to so many wide spacings on either side are none …
const BRIDGED: f64 = 2.5;
/// … but not more than this, metres.
const WIDEST: f64 = 1.5;

/// The wide spacing is so many times the noise at least: else what is sparse is a halo of noise around the surface.
const CLEAR: f64 = 4.0;

/// How far from points, in the plan, a surface may still be the one that they sample with this noise, metres: 0 of an even
/// cloud, where the mean spacing says enough.
pub(super) fn bridged(points: &[Point3<f64>], noise: f64) -> f64 {
    /// The shares of the surface that are sampled more closely than the usual and the wide spacing.
    const SHARES: [f64; 2] = [0.5, 0.9];
    let plan: Vec<[f64; 2]> = points.iter().map(|p| [p.x, p.y]).collect();
    let Ok(tree) = ImmutableKdTree::<f64, 2>::new_from_slice(&plan) else { return 0.0 };
    let two = const { NonZero::new(2).expect("two is not zero") };
    let mut squares: Vec<f64> = plan
        .iter()
        .filter_map(|place| {
            let near = tree.query(place).nearest_n::<SquaredEuclidean<f64>>(two).execute();
            near.iter().map(|near| near.distance).max_by(f64::total_cmp)
        })
        .collect();
    squares.sort_unstable_by(f64::total_cmp);
    // Each point stands for a surface as large as the square of its distance from the next.
    let whole: f64 = squares.iter().sum();
    let [usual, wide] = SHARES.map(|share| {
        let mut left = share * whole;
        let found = squares.iter().find(|square| {
            left -= **square;
            left <= 0.0
        });
        found.map_or(0.0, |square| square.sqrt())
    });
    if wide > UNEVEN * usual && wide > CLEAR * noise { (BRIDGED * wide).min(WIDEST) } else { 0.0 }
}

/// Closes the gaps of a mask of `columns` columns that reach no farther than `radius` pixels from it on all sides; its
/// straight borders and corners that stick out stay.
pub(super) fn close(mask: &mut [bool], columns: usize, radius: usize) {
    if radius == 0 || columns == 0 {
        return;
    }
    let rows = mask.len() / columns;
    let wide = columns + 2 * radius;
    let place = |i: usize| (i / columns + radius) * wide + i % columns + radius;
    let mut padded = vec![false; wide * (rows + 2 * radius)];
    mask.iter().enumerate().for_each(|(i, &set)| padded[place(i)] = set);
    let grown = grow(&padded, wide, radius, true);
    let closed = grow(&grown, wide, radius, false);
    mask.iter_mut().enumerate().for_each(|(i, set)| *set |= closed[place(i)]);
}

/// Lets the pixels that are `set`, or those that are not, grow by a square of this radius; beyond the border none is set.
fn grow(mask: &[bool], columns: usize, radius: usize, set: bool) -> Vec<bool> {
    let rows = mask.len() / columns;
    let mut across = mask.to_vec();
    line_by_line(&mut across, rows, columns, |row, column| row * columns + column, radius, set);
    line_by_line(&mut across, columns, rows, |column, row| row * columns + column, radius, set);
    across
}

/// Lets pixels grow along lines.
fn line_by_line(
    mask: &mut [bool],
    lines: usize,
    length: usize,
    at: impl Fn(usize, usize) -> usize,
    radius: usize,
    set: bool,
) {
    let beyond = !set;
    for line in 0..lines {
        // How many of those that grow come before each pixel of the line.
        let mut before = Vec::with_capacity(length + 1);
        before.push(0_usize);
        for i in 0..length {
            before.push(before[i] + usize::from(mask[at(line, i)] == set));
        }
        for i in 0..length {
            let (low, high) = (i.saturating_sub(radius), (i + radius + 1).min(length));
            let reaches = before[high] > before[low] || (beyond && (i < radius || i + radius >= length));
            mask[at(line, i)] = reaches == set;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Random;

    #[test]
    fn gaps_close_and_borders_stay() {
        // A slanting half of a square with a hole of 4 × 4 and a slit of 3 pixels to its border, and one of 10 × 10.
        let columns = 60;
        let inside = |x: usize, y: usize| x + y < 100;
        let hole = |x: usize, y: usize| {
            ((10..14).contains(&x) && (10..14).contains(&y))
                || ((20..23).contains(&x) && y < 12)
                || ((30..40).contains(&x) && (30..40).contains(&y))
        };
        let mut mask: Vec<bool> = (0..columns * columns)
            .map(|i| inside(i % columns, i / columns) && !hole(i % columns, i / columns))
            .collect();
        close(&mut mask, columns, 3);
        for (i, &set) in mask.iter().enumerate() {
            let (x, y) = (i % columns, i / columns);
            let large = (30..40).contains(&x) && (30..40).contains(&y);
            assert_eq!(set, inside(x, y) && !large, "{x} {y}");
        }
    }

    #[test]
    fn only_an_uneven_cloud_is_bridged() {
        let mut random = Random::new(1);
        let mut points = |count: usize, from: f64| -> Vec<Point3<f64>> {
            (0..count).map(|_| Point3::new(random.between(from, from + 10.0), random.between(0.0, 10.0), 0.0)).collect()
        };
        let even = points(1000, 0.0);
        assert_eq!(bridged(&even, 0.0), 0.0);
        // Half of the surface has a tenth of the points.
        let uneven: Vec<_> = points(2000, 0.0).into_iter().chain(points(200, 10.0)).collect();
        let found = bridged(&uneven, 0.05);
        assert!((0.8..=WIDEST).contains(&found), "{found}");
        assert_eq!(bridged(&uneven, 0.5), 0.0);
    }
}
