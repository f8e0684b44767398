//! Straight walls from an outline of pixels.

use geo::{Area, BooleanOps, Coord, LineString, MultiPolygon, Polygon};
use nalgebra::{Point2, Vector2};

use crate::geometry::validity;
use crate::reconstruct::primitives::footprint_edges;

/// How far the pixels may lie from the wall that they show, metres: about the distance between points.
const TOLERANCE: f64 = 0.6;
/// Nothing shorter than this says anything about a direction: the sine of the largest turn that an edge is given.
const LARGEST_TURN: f64 = 0.42;
/// Lines at an angle with less than this sine do not meet in a corner.
const LEAST_SINE: f64 = 0.17;
/// A corner lies at most this far from where the pixels turn, metres.
const MOST_MOVED: f64 = 4.0 * TOLERANCE;
/// The straight outline differs from that of the pixels by at most this share of the area.
const MOST_CHANGED: f64 = 0.25;

/// The outline with straight edges, which take one of the `main` directions where they may. What does not come out well
/// is only simplified.
pub(super) fn straightened(outline: &MultiPolygon<f64>, main: &[Vector2<f64>]) -> MultiPolygon<f64> {
    let straight = |polygon: &Polygon<f64>| {
        let ring = |ring: &LineString<f64>| straight_ring(ring, main);
        let exterior = ring(polygon.exterior())?;
        let interiors = polygon.interiors().iter().map(ring).collect::<Option<Vec<_>>>()?;
        let straight = Polygon::new(exterior, interiors);
        let changed = |straight: &Polygon<f64>| straight.xor(polygon).unsigned_area();
        (validity::is_valid_polygon(&straight) && changed(&straight) <= MOST_CHANGED * polygon.unsigned_area())
            .then_some(straight)
    };
    let simplified = |polygon: &Polygon<f64>| footprint_edges::simplify(&polygon.clone().into(), TOLERANCE).0;
    MultiPolygon(outline.iter().flat_map(|p| straight(p).map_or_else(|| simplified(p), |p| vec![p])).collect())
}

/// A directed line that stands for a stretch of the outline.
struct Edge {
    along: Vector2<f64>,
    /// Distance from the origin along the normal, metres.
    offset: f64,
    length: f64,
    /// Where its stretch begins.
    start: Point2<f64>,
}

impl Edge {
    fn normal(&self) -> Vector2<f64> {
        Vector2::new(-self.along.y, self.along.x)
    }
}

fn straight_ring(ring: &LineString<f64>, main: &[Vector2<f64>]) -> Option<LineString<f64>> {
    let mut coords: Vec<Coord<f64>> = ring.coords().copied().collect();
    coords.pop();
    let kept = footprint_edges::needed(&coords, TOLERANCE);
    let point = |i: usize| Point2::new(coords[i % coords.len()].x, coords[i % coords.len()].y);
    let edges = (0..kept.len()).filter_map(|i| {
        let (from, to) = (kept[i], kept[(i + 1) % kept.len()]);
        let count = (to + coords.len() - from) % coords.len();
        let chain: Vec<Point2<f64>> = (0..=count).map(|k| point(from + k)).collect();
        edge(&chain, main)
    });
    let edges = joined(edges.collect());
    if edges.len() < 3 {
        return None;
    }
    let corners = (0..edges.len()).map(|i| corner(&edges[(i + edges.len() - 1) % edges.len()], &edges[i]));
    let corners: Vec<Coord<f64>> = corners.map(|p| p.map(|p| Coord { x: p.x, y: p.y })).collect::<Option<_>>()?;
    let mut straight = LineString(corners);
    straight.close();
    Some(straight)
}

/// The line of a stretch of the outline: its direction one of `main` if that is as good, its place in the midst of the
/// steps of the pixels.
fn edge(chain: &[Point2<f64>], main: &[Vector2<f64>]) -> Option<Edge> {
    let (start, end) = (*chain.first()?, *chain.last()?);
    let chord = end - start;
    let length = chord.norm();
    let own = chord.try_normalize(1e-9)?;
    let turn = |direction: &Vector2<f64>| own.perp(direction).abs();
    let nearest = main.iter().min_by(|a, b| turn(a).total_cmp(&turn(b)));
    let most = (2.0 * TOLERANCE / length).min(LARGEST_TURN);
    let along = nearest.filter(|d| turn(d) <= most).map_or(own, |d| if d.dot(&own) < 0.0 { -d } else { *d });
    let normal = Vector2::new(-along.y, along.x);
    let (mut sum, mut weights) = (0.0, 0.0);
    for pair in chain.windows(2) {
        let weight = along.dot(&(pair[1] - pair[0])).abs();
        sum += weight * normal.dot(&nalgebra::center(&pair[0], &pair[1]).coords);
        weights += weight;
    }
    (weights > 0.0).then(|| Edge { along, offset: sum / weights, length, start })
}

/// The edges with those joined that follow each other on one line, and a step between those that do so on parallel ones.
fn joined(edges: Vec<Edge>) -> Vec<Edge> {
    let mut out: Vec<Edge> = Vec::with_capacity(edges.len());
    let is_one = |a: &Edge, b: &Edge| a.along.dot(&b.along) > 1.0 - 1e-6 && (a.offset - b.offset).abs() < TOLERANCE;
    let merge = |into: &mut Edge, other: &Edge| {
        let length = into.length + other.length;
        into.offset = (into.offset * into.length + other.offset * other.length) / length;
        into.length = length;
    };
    let push = |out: &mut Vec<Edge>, next: Edge| {
        if let Some(last) = out.last() {
            let rise = next.offset - last.offset;
            if last.along.dot(&next.along) > 1.0 - LEAST_SINE && last.along.perp(&next.along).abs() < LEAST_SINE {
                let along = last.normal() * rise.signum();
                let normal = Vector2::new(-along.y, along.x);
                let offset = normal.dot(&next.start.coords);
                out.push(Edge { along, offset, length: rise.abs(), start: next.start });
            }
        }
        out.push(next);
    };
    for next in edges {
        match out.last_mut() {
            Some(last) if is_one(last, &next) => merge(last, &next),
            _ => push(&mut out, next),
        }
    }
    while out.len() > 3 {
        let [Some(first), Some(last)] = [out.first(), out.last()] else { break };
        if !is_one(last, first) {
            break;
        }
        let Some(last) = out.pop() else { break };
        if let Some(first) = out.first_mut() {
            merge(first, &last);
            first.start = last.start;
        }
    }
    out
}

/// Where two edges that follow each other meet.
fn corner(one: &Edge, two: &Edge) -> Option<Point2<f64>> {
    let sine = one.along.perp(&two.along);
    if sine.abs() < LEAST_SINE {
        return None;
    }
    let (a, b) = (one.normal(), two.normal());
    let meet = Point2::new((one.offset * b.y - two.offset * a.y) / sine, (two.offset * a.x - one.offset * b.x) / sine);
    ((meet - two.start).norm() <= MOST_MOVED).then_some(meet)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pixels of 0.25 m whose centres lie in a rectangle from (2, 1) to (10, 7) that is turned by `angle`, and the sides of
    /// the pixels shaken by up to `noise` metres.
    fn pixels(angle: f64) -> MultiPolygon<f64> {
        let (sin, cos) = f64::sin_cos(angle);
        let inside = |x: f64, y: f64| {
            let (u, v) = (cos * x + sin * y, cos * y - sin * x);
            (2.0..10.0).contains(&u) && (1.0..7.0).contains(&v)
        };
        let centre = |i: i32| 0.25 * f64::from(i) + 0.125;
        let pixels =
            (-60..60).flat_map(|i| (-60..60).map(move |j| (centre(i), centre(j)))).filter(|&(x, y)| inside(x, y));
        let square = |(x, y): (f64, f64)| geo::Rect::new((x - 0.125, y - 0.125), (x + 0.125, y + 0.125)).to_polygon();
        geo::unary_union(&pixels.map(square).collect::<Vec<_>>())
    }

    #[test]
    fn walls_of_a_courtyard_come_out_straight() {
        for angle in [0.0, 0.3, 0.7, 2.0] {
            let (sin, cos) = f64::sin_cos(angle);
            let main = [Vector2::new(cos, sin), Vector2::new(-sin, cos)];
            let straight = straightened(&pixels(angle), &main);
            assert_eq!((straight.0.len(), straight.0[0].exterior().0.len()), (1, 5), "{angle}: {straight:?}");
            assert!((straight.unsigned_area() - 48.0).abs() < 1.5, "{angle}: {}", straight.unsigned_area());
            for line in straight.0[0].exterior().lines() {
                let along = Vector2::new(line.dx(), line.dy()).normalize();
                assert!(main.iter().any(|m| m.perp(&along).abs() < 1e-6), "{angle}: {straight:?}");
            }
        }
    }

    #[test]
    fn without_directions_to_follow_it_stays_near_the_pixels() {
        let pixels = pixels(0.3);
        let straight = straightened(&pixels, &[]);
        assert!(validity::is_valid(&straight));
        assert!(straight.xor(&pixels).unsigned_area() < 3.0);
    }
}
