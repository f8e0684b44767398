//! Whether all edges of a polygon keep apart, told by a sweep (Shamos and Hoey 1976) in little more than the time that it
//! takes to sort them.
//!
//! Comparing edges whose boxes meet takes the square of that where they are long, slanting and close in masses, as the
//! spikes of a star are.

use std::f64::consts::SQRT_2;

use super::ring::{Point, distance_to_segment, orient};
use crate::geometry::Boxes;

/// A corner of a polygon: its place, and the numbers of the corners before and after it.
struct Corner {
    point: Point,
    before: usize,
    after: usize,
}

/// An edge by the number of the corner that it starts at, from its left end to its right.
#[derive(Clone, Copy)]
struct Edge {
    start: usize,
    left: Point,
    right: Point,
}

/// The corners of a polygon, and how near they may come to edges that they are no end of.
struct Corners {
    all: Vec<Corner>,
    snap: f64,
}

/// Whether it is certain that no two edges cross, and that no corner is closer than `snap` steps to an edge that it is no
/// end of. Those of a triangle are not held against each other. Rings must be clean.
pub(super) fn are_apart(rings: &[Vec<Point>], snap: f64) -> bool {
    let corners = Corners::of(rings, snap);
    // A corner is near an edge that is not steep by the sweep, near a steep one by the other, or near an end of it.
    corners.are_ends_apart() && corners.sweep() && corners.turned().sweep()
}

impl Corners {
    fn of(rings: &[Vec<Point>], snap: f64) -> Self {
        let mut all = Vec::new();
        for ring in rings {
            let (first, n) = (all.len(), ring.len());
            all.extend(ring.iter().enumerate().map(|(i, &point)| Corner {
                point,
                before: first + (i + n - 1) % n,
                after: first + (i + 1) % n,
            }));
        }
        Self { all, snap }
    }

    /// The same with x for y.
    fn turned(mut self) -> Self {
        self.all.iter_mut().for_each(|corner| corner.point.reverse());
        self
    }

    fn point(&self, corner: usize) -> Point {
        self.all[corner].point
    }

    /// Whether a corner may be as near to the edge that starts at another as it is.
    fn is_clear(&self, corner: usize, start: usize) -> bool {
        let Corner { point, before, after } = self.all[corner];
        let end = self.all[start].after;
        let is_triangle = self.all[after].after == before;
        let is_opposite = is_triangle && start == after;
        start == corner
            || end == corner
            || is_opposite
            || distance_to_segment(point, self.point(start), self.point(end)) >= self.snap
    }

    /// Whether corners near each other are clear of each other's edges.
    fn are_ends_apart(&self) -> bool {
        let margin = (SQRT_2 * self.snap).ceil() as i64;
        let boxes = |margin| Boxes::of_segments(self.all.iter().map(|corner| [corner.point; 2]), margin);
        let (wide, narrow) = (boxes(margin), boxes(0));
        wide.meeting(&narrow).all(|(one, other)| {
            one == other || (self.is_clear(one, other) && self.is_clear(one, self.all[other].before))
        })
    }

    /// Whether no edges cross, and every corner is clear of the edges above and below it that are not steeper than 45°.
    fn sweep(&self) -> bool {
        let mut order: Vec<usize> = (0..self.all.len()).collect();
        order.sort_unstable_by_key(|&corner| self.point(corner));
        // The edges that the sweep line meets, from the lowest to the highest.
        let mut met: Vec<Edge> = Vec::new();
        order.into_iter().all(|corner| self.pass(corner, &mut met).is_some())
    }

    /// Moves the sweep line over a corner; `None` where something is not clear.
    fn pass(&self, corner: usize, met: &mut Vec<Edge>) -> Option<()> {
        let Corner { point, before, .. } = self.all[corner];
        let mut starting: Vec<Edge> = Vec::with_capacity(2);
        let mut ending = 0;
        for start in [before, corner] {
            let [a, b] = [self.point(start), self.point(self.all[start].after)];
            let edge = Edge { start, left: a.min(b), right: a.max(b) };
            if edge.left == point { starting.push(edge) } else { ending += 1 }
        }
        let from = met.partition_point(|edge| orient(edge.left, edge.right, point) > 0);
        let on = met[from..].iter().take_while(|edge| orient(edge.left, edge.right, point) == 0);
        let to = from + on.count();
        if to - from != ending || met[from..to].iter().any(|edge| edge.right != point) {
            return None;
        }
        let is_near = |edge: &&Edge| {
            let across = (edge.right[0] - edge.left[0]) as f64;
            // No edge nearer than the snapping distance, and at most 45° steep, is farther up or down than this.
            (orient(edge.left, edge.right, point) as f64).abs() <= (SQRT_2 * self.snap + 1.0) * across
        };
        let mut near = met[..from].iter().rev().take_while(is_near).chain(met[to..].iter().take_while(is_near));
        if !near.all(|edge| self.is_clear(corner, edge.start)) {
            return None;
        }
        if let [one, other] = starting[..] {
            match orient(point, one.right, other.right) {
                0 => return None,
                turn if turn < 0 => starting.swap(0, 1),
                _ => {}
            }
        }
        let top = from + starting.len();
        met.splice(from..to, starting);
        let crosses = |lower: usize| {
            let (Some(a), Some(b)) = (met.get(lower), met.get(lower + 1)) else { return false };
            self.meet(*a, *b)
        };
        let lowest = from.saturating_sub(1);
        (!crosses(lowest) && (top == lowest + 1 || top == 0 || !crosses(top - 1))).then_some(())
    }

    /// Whether two edges share a point that is not a corner of both.
    fn meet(&self, a: Edge, b: Edge) -> bool {
        if self.all[a.start].after == b.start || self.all[b.start].after == a.start {
            return false;
        }
        let sides = |of: Edge, ends: Edge| [ends.left, ends.right].map(|end| orient(of.left, of.right, end).signum());
        let ([c, d], [e, f]) = (sides(a, b), sides(b, a));
        c * d <= 0 && e * f <= 0
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::super::repair::all_conflicts;
    use super::*;

    /// A star of so many spikes, in steps.
    fn star(corners: usize, inner: f64, outer: f64) -> Vec<Point> {
        let corner = |i: usize| {
            let reach = if i.is_multiple_of(2) { outer } else { inner };
            let angle = TAU * i as f64 / corners as f64;
            [reach * angle.cos(), reach * angle.sin()].map(|c| c.round() as i64)
        };
        (0..corners).map(corner).collect()
    }

    #[test]
    fn spikes_are_apart_until_they_come_too_close() {
        // 18 steps from spike to spike at their roots, and 9.
        assert!(are_apart(&[star(10_000, 14_000.0, 20_000.0)], 10.1));
        assert!(!are_apart(&[star(20_000, 14_000.0, 20_000.0)], 10.1));
    }

    #[test]
    fn crossings_and_touches_are_found() {
        let square = vec![[0, 0], [1000, 0], [1000, 1000], [0, 1000]];
        let hole = |x: i64, y: i64| vec![[x, y], [x, y + 200], [x + 200, y + 200], [x + 200, y]];
        let triangle = vec![[500, 600], [500, 900], [505, 600]];
        assert!(are_apart(&[square.clone(), hole(300, 300), triangle], 10.0));
        for (x, y) in [(900, 300), (0, 300), (5, 300), (300, 795), (795, 5), (300, 1000)] {
            assert!(!are_apart(&[square.clone(), hole(x, y)], 10.0), "{x} {y}");
        }
        assert!(!are_apart(&[vec![[0, 0], [1000, 1000], [1000, 0], [0, 1000]]], 10.0));
        // A corner near a steep edge, and one beyond the end of an edge.
        assert!(!are_apart(&[vec![[0, 0], [900, 0], [1000, 3000], [0, 3000], [941, 1500]]], 10.0));
        assert!(!are_apart(&[square.clone(), vec![[1008, 0], [1200, 0], [1200, 50]]], 10.0));
        assert!(are_apart(&[square, vec![[1011, 0], [1200, 0], [1200, 50]]], 10.0));
    }

    proptest! {
        /// The sweep never says that edges are apart which are not, and says so where no two are near.
        #[test]
        fn the_sweep_agrees_with_all_pairs(
            corners in prop::collection::vec([0_i64..60, 0_i64..60], 4..9),
            others in prop::collection::vec([0_i64..60, 0_i64..60], 3..5),
            scale in 1_i64..40,
        ) {
            let rings = [corners, others].map(|ring| {
                let mut ring: Vec<Point> = ring.into_iter().map(|p| p.map(|c| c * scale)).collect();
                ring.dedup();
                ring
            });
            // Rings are clean: without repeated corners and without edges that go back on themselves.
            let is_clean = |ring: &Vec<Point>| {
                let n = ring.len();
                n >= 3 && (0..n).all(|i| orient(ring[i], ring[(i + 1) % n], ring[(i + 2) % n]) != 0)
            };
            prop_assume!(rings.iter().all(is_clean));
            for some in [&rings[..1], &rings[..]] {
                let conflicts = all_conflicts(&some.to_vec(), 10.0);
                prop_assert_eq!(are_apart(some, 10.0), conflicts.is_empty(), "{:?} {:?}", some, conflicts);
            }
        }
    }
}
