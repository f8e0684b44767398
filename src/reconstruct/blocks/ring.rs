//! Rings of grid points: exact predicates, and what a ring must lose before it can stand on the grid.

use crate::geometry::Linked;

/// A grid point (x, y), in steps.
pub(super) type Point = [i64; 2];

/// Twice the signed area of the triangle `o`, `a`, `b`; exact. Positive when `b` lies left of the line from `o` to `a`.
pub(super) fn orient(o: Point, a: Point, b: Point) -> i128 {
    let d = |p: Point, axis: usize| i128::from(p[axis]) - i128::from(o[axis]);
    d(a, 0) * d(b, 1) - d(a, 1) * d(b, 0)
}

/// Twice the signed area of a ring; exact. Positive when counter-clockwise.
pub(super) fn doubled_area(ring: &[Point]) -> i128 {
    let Some(&anchor) = ring.first() else { return 0 };
    ring.windows(2).map(|edge| orient(anchor, edge[0], edge[1])).sum()
}

/// Distance between two grid points, in steps.
pub(super) fn distance(a: Point, b: Point) -> f64 {
    ((a[0] - b[0]) as f64).hypot((a[1] - b[1]) as f64)
}

/// Distance of a grid point to the segment from `a` to `b`, in steps.
pub(super) fn distance_to_segment(p: Point, a: Point, b: Point) -> f64 {
    let length = distance(a, b);
    if length == 0.0 {
        return distance(p, a);
    }
    let along = ((p[0] - a[0]) as f64 * (b[0] - a[0]) as f64 + (p[1] - a[1]) as f64 * (b[1] - a[1]) as f64) / length;
    if along <= 0.0 {
        distance(p, a)
    } else if along >= length {
        distance(p, b)
    } else {
        (orient(a, b, p) as f64).abs() / length
    }
}

/// Angle at `p` between the directions to `a` and `b`, in radians, 0 to π.
pub(super) fn angle(a: Point, p: Point, b: Point) -> f64 {
    let dot = (a[0] - p[0]) as f64 * (b[0] - p[0]) as f64 + (a[1] - p[1]) as f64 * (b[1] - p[1]) as f64;
    (orient(p, a, b) as f64).abs().atan2(dot)
}

/// Where a point lies with respect to a ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Inside,
    Boundary,
    Outside,
}

/// Where `p` lies with respect to `ring`, by the crossing number; exact.
pub(super) fn side(p: Point, ring: &[Point]) -> Side {
    let Some(&last) = ring.last() else { return Side::Outside };
    let (mut inside, mut a) = (false, last);
    for &b in ring {
        let turn = orient(a, b, p);
        let within = |axis: usize| p[axis] >= a[axis].min(b[axis]) && p[axis] <= a[axis].max(b[axis]);
        if turn == 0 && within(0) && within(1) {
            return Side::Boundary;
        }
        if (a[1] > p[1]) != (b[1] > p[1]) && (turn > 0) == (b[1] > a[1]) {
            inside = !inside;
        }
        a = b;
    }
    if inside { Side::Inside } else { Side::Outside }
}

/// A ring without what is no corner, and how many spikes it lost.
#[derive(Debug)]
pub(super) struct Cleaned {
    pub ring: Vec<Point>,
    pub spikes: usize,
}

/// Removes vertices that are repeated, collinear with their neighbours (exactly), closer than `snap` steps to the one
/// before, or the tip of a spike narrower than `snap` steps. `None` when fewer than three are left. A ring that crosses
/// itself still does.
pub(super) fn clean(ring: &[Point], snap: f64) -> Option<Cleaned> {
    let mut left = Linked::new(ring.len());
    let (mut at, mut settled, mut spikes) = (0, 0, 0);
    while left.len() >= 3 && settled < left.len() {
        let [previous, next] = left.around(at);
        let (before, tip, after) = (ring[previous], ring[at], ring[next]);
        let is_spike = is_spike(before, tip, after, snap);
        if is_spike || orient(before, tip, after) == 0 || distance(before, tip) < snap {
            // A vertex less than `snap` from its neighbour looks like a spike, too, but is only a repeated vertex.
            spikes += usize::from(is_spike && distance(before, tip) >= snap && distance(tip, after) >= snap);
            left.remove(at);
            // Removing it changes what its two neighbours look like.
            [at, _] = left.around(previous);
            settled = 0;
        } else {
            at = next;
            settled += 1;
        }
    }
    let ring: Vec<Point> = left.left().into_iter().map(|i| ring[i]).collect();
    (ring.len() >= 3).then_some(Cleaned { ring, spikes })
}

/// Whether the ring goes to `tip` and back within `snap` steps.
fn is_spike(before: Point, tip: Point, after: Point, snap: f64) -> bool {
    if angle(before, tip, after) >= std::f64::consts::FRAC_PI_2 {
        return false;
    }
    if distance(before, tip) <= distance(tip, after) {
        distance_to_segment(before, tip, after) < snap
    } else {
        distance_to_segment(after, before, tip) < snap
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cleaning_keeps_corners_only() {
        // A square of 1000 steps with a repeated vertex, a collinear one, a needle 4 steps wide and a short edge.
        let ring = vec![
            [0, 0],
            [0, 0],
            [500, 0],
            [1000, 0],
            [1000, 400],
            [5000, 402],
            [1000, 404],
            [1000, 1000],
            [997, 1000],
            [0, 1000],
        ];
        let cleaned = clean(&ring, 10.0).unwrap();
        assert_eq!(cleaned.ring, [[0, 0], [1000, 0], [1000, 1000], [0, 1000]]);
        assert_eq!(cleaned.spikes, 1);
    }

    #[test]
    fn a_sliver_is_no_ring() {
        assert!(clean(&[[0, 0], [10_000, 0], [5000, 5]], 10.0).is_none());
        assert!(clean(&[[0, 0], [10, 10], [20, 20], [5, 5]], 1.0).is_none());
    }

    #[test]
    fn sides_are_exact() {
        let ring = [[0, 0], [3, 0], [3, 2], [0, 2]];
        assert_eq!(side([1, 1], &ring), Side::Inside);
        assert_eq!(side([3, 1], &ring), Side::Boundary);
        assert_eq!(side([0, 0], &ring), Side::Boundary);
        assert_eq!(side([4, 2], &ring), Side::Outside);
        assert_eq!(side([-1, 0], &ring), Side::Outside);
        let clockwise: Vec<_> = ring.into_iter().rev().collect();
        assert_eq!(side([1, 1], &clockwise), Side::Inside);
        assert_eq!(doubled_area(&ring), 12);
        assert_eq!(doubled_area(&clockwise), -12);
    }
}
