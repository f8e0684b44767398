//! Wall planes from the footprint: what an airborne scanner hardly sees.

use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;

use geo::{Coord, LineString, MultiPolygon, Polygon};
use nalgebra::Point2;

use super::PrimitiveKind;
use super::trace::Trace;
use crate::geometry::{Linked, validity};

/// The footprint with every vertex left out that is not needed to stay within `tolerance` metres of the original
/// outline. Rings that would collapse and polygons that would become invalid stay as they are.
pub fn simplify(footprint: &MultiPolygon<f64>, tolerance: f64) -> MultiPolygon<f64> {
    MultiPolygon(
        footprint
            .iter()
            .map(|polygon| {
                let simpler = Polygon::new(
                    simplify_ring(polygon.exterior(), tolerance),
                    polygon.interiors().iter().map(|ring| simplify_ring(ring, tolerance)).collect(),
                );
                if validity::is_valid_polygon(&simpler) { simpler } else { polygon.clone() }
            })
            .collect(),
    )
}

fn simplify_ring(ring: &LineString<f64>, tolerance: f64) -> LineString<f64> {
    let mut original: Vec<Coord<f64>> = ring.coords().copied().collect();
    original.pop();
    let mut simpler = LineString(needed(&original, tolerance).into_iter().map(|i| original[i]).collect());
    simpler.close();
    simpler
}

/// Indices of the vertices of a ring (not closed) that are needed to stay within `tolerance` metres of it, at least
/// three: drops, one after the other, the vertex that costs least, as long as every vertex stays within `tolerance` of
/// the chord that replaces it.
pub(in crate::reconstruct) fn needed(ring: &[Coord<f64>], tolerance: f64) -> Vec<usize> {
    needed_by(ring.len(), tolerance, |before, after| chord_error(ring, before, after))
}

/// The same of a ring with the interior on its left, by chords that nowhere leave it to the right: the ring stands back,
/// as far as its neighbouring vertices tell.
pub(in crate::reconstruct) fn needed_within(ring: &[Coord<f64>], tolerance: f64) -> Vec<usize> {
    needed_by(ring.len(), tolerance, |before, after| {
        let (a, b) = (ring[before], ring[after]);
        let is_left = |c: Coord<f64>| (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x) > 0.0;
        let mut between = (1..(after + ring.len() - before) % ring.len()).map(|k| ring[(before + k) % ring.len()]);
        if between.any(is_left) { f64::INFINITY } else { chord_error(ring, before, after) }
    })
}

/// Indices of the vertices of a ring that are left when those are dropped whose chord, from the vertex before to the one
/// after, costs at most `tolerance`; the cheapest first, and of equals that which joins the fewest edges: chords grow evenly,
/// and a long straight line takes no longer than any other.
fn needed_by(count: usize, tolerance: f64, cost: impl Fn(usize, usize) -> f64) -> Vec<usize> {
    let mut ring = Linked::new(count);
    let removal_of = |ring: &Linked, vertex: usize| {
        let [before, after] = ring.around(vertex);
        Removal { cost: cost(before, after), joined: (after + count - before) % count, vertex }
    };
    let mut removals: Vec<Removal> = (0..count).map(|vertex| removal_of(&ring, vertex)).collect();
    // What is no longer the removal of its vertex is passed over.
    let mut queue: BinaryHeap<Reverse<Removal>> = removals.iter().copied().map(Reverse).collect();
    while ring.len() > 3 {
        let Some(Reverse(next)) = queue.pop() else { break };
        if !ring.keeps(next.vertex) || removals[next.vertex] != next {
            continue;
        }
        if next.cost.is_nan() || next.cost > tolerance {
            break;
        }
        ring.remove(next.vertex);
        for neighbour in ring.around(next.vertex) {
            removals[neighbour] = removal_of(&ring, neighbour);
            queue.push(Reverse(removals[neighbour]));
        }
    }
    ring.left()
}

/// What it costs to leave a vertex out.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Removal {
    /// How far the chord misses the vertices that it replaces, metres.
    cost: f64,
    /// How many edges of the ring the chord replaces.
    joined: usize,
    /// The vertex.
    vertex: usize,
}

impl Eq for Removal {}

impl Ord for Removal {
    fn cmp(&self, other: &Self) -> Ordering {
        self.cost.total_cmp(&other.cost).then(self.joined.cmp(&other.joined)).then(self.vertex.cmp(&other.vertex))
    }
}

impl PartialOrd for Removal {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

/// Largest distance from the chord `before → after` to the vertices of the ring between the two.
fn chord_error(ring: &[Coord<f64>], before: usize, after: usize) -> f64 {
    let (a, b) = (ring[before], ring[after]);
    let chord = b - a;
    let length2 = chord.x * chord.x + chord.y * chord.y;
    let mut worst = 0.0_f64;
    let mut i = (before + 1) % ring.len();
    while i != after {
        let d = ring[i] - a;
        let t = if length2 > 0.0 { ((d.x * chord.x + d.y * chord.y) / length2).clamp(0.0, 1.0) } else { 0.0 };
        worst = worst.max((d.x - t * chord.x).hypot(d.y - t * chord.y));
        i = (i + 1) % ring.len();
    }
    worst
}

/// One trace per edge of the (simplified) footprint.
pub fn traces(footprint: &MultiPolygon<f64>) -> Vec<Trace> {
    let point = |c: Coord<f64>| Point2::new(c.x, c.y);
    footprint
        .iter()
        .flat_map(|polygon| std::iter::once(polygon.exterior()).chain(polygon.interiors()))
        .flat_map(LineString::lines)
        .filter_map(|line| Trace::between(point(line.start), point(line.end), PrimitiveKind::FootprintEdge))
        .collect()
}

#[cfg(test)]
mod tests {
    use geo::{Area, polygon};

    use super::*;

    #[test]
    fn a_jog_smaller_than_the_tolerance_goes_and_a_larger_one_stays() {
        let ring = |jog: f64| {
            MultiPolygon(vec![polygon![
                (x: 0.0, y: 0.0), (x: 5.0, y: 0.0), (x: 5.0, y: jog), (x: 10.0, y: jog), (x: 10.0, y: 8.0), (x: 0.0, y: 8.0)
            ]])
        };
        let small = simplify(&ring(0.05), 0.1);
        assert_eq!(small.0[0].exterior().0.len(), 5);
        assert!((small.unsigned_area() - 80.0).abs() < 0.3);
        assert_eq!(simplify(&ring(0.3), 0.1), ring(0.3));
        assert_eq!(traces(&small).len(), 4);
    }

    #[test]
    fn needed_vertices_are_those_of_a_plain_search() {
        let mut random = crate::geometry::Random::new(3);
        for _ in 0..200 {
            let count = 3 + random.below(40);
            let ring: Vec<Coord<f64>> = (0..count)
                .map(|i| {
                    let angle = std::f64::consts::TAU * i as f64 / count as f64;
                    let radius = random.between(4.0, 4.3);
                    Coord { x: radius * angle.cos(), y: radius * angle.sin() }
                })
                .collect();
            let mut kept: Vec<usize> = (0..count).collect();
            while kept.len() > 3 {
                let n = kept.len();
                let cost = |i: usize| chord_error(&ring, kept[(i + n - 1) % n], kept[(i + 1) % n]);
                let cheapest = (0..n).min_by(|&a, &b| cost(a).total_cmp(&cost(b))).unwrap();
                if cost(cheapest) > 0.2 {
                    break;
                }
                kept.remove(cheapest);
            }
            assert_eq!(needed(&ring, 0.2), kept);
        }
    }

    #[test]
    fn a_ring_that_stands_back_nowhere_leaves_itself() {
        use geo::{BooleanOps, polygon};
        let jagged = polygon![
            (x: 0.0, y: 0.0), (x: 2.0, y: -0.1), (x: 4.0, y: 0.0), (x: 6.0, y: 0.1), (x: 8.0, y: 0.0), (x: 8.0, y: 6.0),
            (x: 4.0, y: 6.05), (x: 0.0, y: 6.0)
        ];
        let ring: Vec<Coord<f64>> = jagged.exterior().0[..8].to_vec();
        let left = needed_within(&ring, 0.2);
        assert_eq!(left, [0, 3, 4, 5, 7]);
        let within = Polygon::new(left.into_iter().map(|i| ring[i]).collect(), Vec::new());
        assert_eq!(within.difference(&jagged).unsigned_area(), 0.0);
    }

    #[test]
    fn a_long_shallow_arc_does_not_creep_away() {
        // Every vertex is within 1 cm of its neighbours' chord; the whole arc rises by 2 m.
        let mut coords: Vec<(f64, f64)> =
            (0..=40).map(|i| (f64::from(i), 2.0 - f64::from(i - 20).powi(2) / 200.0)).collect();
        coords.push((20.0, -30.0));
        let arc = MultiPolygon(vec![Polygon::new(LineString::from(coords.clone()), vec![])]);
        let simpler = simplify(&arc, 0.1);
        let line = simpler.0[0].exterior();
        let far = coords.iter().map(|&(x, y)| {
            use geo::{Distance, Euclidean};
            Euclidean.distance(&geo::Point::new(x, y), line)
        });
        assert!(far.fold(0.0, f64::max) <= 0.1 + 1e-9);
        assert!(line.0.len() < 16);
    }
}
