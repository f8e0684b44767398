//! The rings of a face together: codes 201 to 208.

use nalgebra::Vector3;

use super::predicates::{Meeting, Point2, Position, Projection, edges, locate_among, meet, newell};
use super::triangulation::triangulate;
use super::{Fault, Place, Tolerances};
use crate::geometry::{Boxes, Plane};
use crate::solid::{Face, Solid};

/// The faults of a face whose rings are sound by themselves: 201 rings cross or share a piece of an edge, 202 two
/// rings are the same, 203 a vertex is off the plane, 204 the face is folded, 205 the interior is in pieces, 206 a
/// hole is outside the exterior, 207 a hole is inside another, 208 a hole turns the same way as the exterior.
pub fn check(solid: &Solid, id: u32, face: &Face, tolerances: &Tolerances) -> Vec<Fault> {
    let place = Place::Face(id);
    let mut faults = Vec::new();
    if let Some(off) = off_plane(solid, face).filter(|off| *off > tolerances.planarity) {
        faults.push(Fault::new(203, place, format!("a vertex is {off:.4} m off the plane of the face")));
    }
    if face.rings.len() > 1 {
        faults.extend(rings(solid, id, face));
    }
    if faults.is_empty()
        && let Some(turn) = steepest(solid, face, tolerances.rounding).filter(|turn| turn.angle > tolerances.normals)
    {
        let beyond = if tolerances.rounding { " beyond what rounding explains" } else { "" };
        let message = format!("part of the face turns from its plane by {:.1}°{beyond}", turn.angle);
        faults.push(Fault::new(204, place, message));
    }
    faults
}

/// Largest distance of a vertex to the least-squares plane of all vertices of the face, metres.
pub(super) fn off_plane(solid: &Solid, face: &Face) -> Option<f64> {
    let points: Vec<_> = face.rings.iter().flatten().map(|&v| solid.point(v)).collect();
    if points.len() <= 3 {
        return Some(0.0);
    }
    let (plane, _) = Plane::fit(&points)?;
    Some(points.iter().map(|p| plane.distance(p).abs()).fold(0.0, f64::max))
}

/// 201, 202, 205, 206, 207 and 208.
fn rings(solid: &Solid, id: u32, face: &Face) -> Vec<Fault> {
    let Some(projection) = Projection::along(newell(solid, &face.rings[0])) else { return Vec::new() };
    let rings: Vec<Indexed> = face.rings.iter().map(|ring| Indexed::new(projection.ring(solid, ring))).collect();
    let mut faults = Vec::new();
    let mut touches: Vec<(Point2, usize)> = Vec::new();
    for i in 0..rings.len() {
        for j in i + 1..rings.len() {
            let place = Place::Ring(id, j as u32);
            if same(&rings[i].points, &rings[j].points) {
                faults.push(Fault::new(202, place, format!("the ring is the same as ring {i}")));
                continue;
            }
            let mut crosses = false;
            for (e, f) in rings[i].meeting(&rings[j]) {
                match meet(e, f) {
                    Meeting::Apart => {}
                    Meeting::Touch(point) => touches.extend([(point, i), (point, j)]),
                    Meeting::Cross | Meeting::Overlap => crosses = true,
                }
            }
            let of_j = relation(&rings[i], &rings[j]);
            if crosses || of_j == Relation::Across {
                faults.push(Fault::new(201, place, format!("the ring crosses or overlaps ring {i}")));
            } else if i == 0 && of_j != Relation::Within {
                faults.push(Fault::new(206, place, "the hole is outside the exterior ring"));
            } else if i > 0 && (of_j == Relation::Within || relation(&rings[j], &rings[i]) == Relation::Within) {
                faults.push(Fault::new(207, place, format!("the hole and hole {i} are one inside the other")));
            }
        }
    }
    for (r, ring) in rings.iter().enumerate() {
        // In its own projection the exterior is counter-clockwise.
        if (twice_area(&ring.points) > 0) != (r == 0) {
            faults.push(Fault::new(208, Place::Ring(id, r as u32), "the hole turns the same way as the exterior"));
        }
    }
    if faults.is_empty() && splits(&mut touches, rings.len()) {
        faults.push(Fault::new(205, Place::Face(id), "holes cut the interior of the face in pieces"));
    }
    faults
}

/// From so many vertices on, a tree of the edges is faster than all of them.
const FEW: usize = 64;

/// A ring whose edges are found by their place, where they are many.
struct Indexed {
    points: Vec<Point2>,
    boxes: Option<Boxes>,
}

impl Indexed {
    fn new(points: Vec<Point2>) -> Self {
        let boxes = (points.len() > FEW).then(|| Boxes::of_segments(edges(&points).map(|(a, b)| [a, b]), 0));
        Self { points, boxes }
    }

    fn edge(&self, i: usize) -> [Point2; 2] {
        [self.points[i], self.points[(i + 1) % self.points.len()]]
    }

    /// The pairs of an edge of either that may meet.
    fn meeting(&self, other: &Self) -> Vec<([Point2; 2], [Point2; 2])> {
        if let (None, None) = (&self.boxes, &other.boxes) {
            let others = || edges(&other.points).map(|(c, d)| [c, d]);
            return edges(&self.points).flat_map(|(a, b)| others().map(move |f| ([a, b], f))).collect();
        }
        let boxes = |ring: &Self| Boxes::of_segments(edges(&ring.points).map(|(a, b)| [a, b]), 0);
        let pairs = boxes(self).meeting(&boxes(other)).collect::<Vec<_>>();
        pairs.into_iter().map(|(i, j)| (self.edge(i), other.edge(j))).collect()
    }

    /// Where a place is with respect to the ring, in halves of a step.
    fn locate_half(&self, place: Point2) -> Position {
        let double = |(a, b): (Point2, Point2)| (a.map(|c| 2 * c), b.map(|c| 2 * c));
        let Some(boxes) = &self.boxes else { return locate_among(edges(&self.points).map(double), place) };
        let [x, y] = place.map(|c| c as f64 / 2.0);
        let on_ray = boxes.at([[x, y], [f64::MAX, y]]);
        locate_among(on_ray.into_iter().map(|i| double(self.edge(i).into())), place)
    }
}

fn same(a: &[Point2], b: &[Point2]) -> bool {
    let sorted = |ring: &[Point2]| {
        let mut ring = ring.to_vec();
        ring.sort_unstable();
        ring
    };
    a.len() == b.len() && sorted(a) == sorted(b)
}

fn twice_area(ring: &[Point2]) -> i128 {
    edges(ring).map(|(a, b)| i128::from(a[0]) * i128::from(b[1]) - i128::from(a[1]) * i128::from(b[0])).sum()
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Relation {
    Within,
    Apart,
    Across,
}

/// Where the vertices of `inner` are with respect to `outer`: those on its border say nothing. The rings do not cross,
/// so a ring with all its vertices on the border is judged by the middle of its edges.
fn relation(outer: &Indexed, inner: &Indexed) -> Relation {
    let (mut within, mut apart) = (false, false);
    for (a, b) in edges(&inner.points) {
        for probe in [a.map(|c| 2 * c), [a[0] + b[0], a[1] + b[1]]] {
            match outer.locate_half(probe) {
                Position::Inside => within = true,
                Position::Outside => apart = true,
                Position::Border => {}
            }
        }
    }
    match (within, apart) {
        (true, true) => Relation::Across,
        (true, false) => Relation::Within,
        _ => Relation::Apart,
    }
}

/// Whether rings that touch at points enclose a piece of the interior: whether the graph of rings and the points where
/// they touch has a cycle.
fn splits(touches: &mut Vec<(Point2, usize)>, rings: usize) -> bool {
    touches.sort_unstable();
    touches.dedup();
    let mut set: Vec<usize> = (0..rings).collect();
    let root = |set: &[usize], mut i: usize| {
        while set[i] != i {
            i = set[i];
        }
        i
    };
    for at_point in touches.chunk_by(|a, b| a.0 == b.0) {
        let first = root(&set, at_point[0].1);
        for &(_, ring) in &at_point[1..] {
            let other = root(&set, ring);
            if other == root(&set, first) {
                return true;
            }
            let first = root(&set, first);
            set[other] = first;
        }
    }
    false
}

/// A triangle of a face and how far it turns from the plane of the face.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Turn {
    /// Its corners.
    pub(crate) triangle: [u32; 3],
    /// The angle, degrees.
    pub(crate) angle: f64,
}

/// The triangle of the face that turns most from the plane of the face.
///
/// If `rounding` is forgiven, that much of the angle does not count which the rounding of the vertices to the grid can make:
/// each is off by up to half a step along each axis, which is δ = ½ Σ stepᵢ |nᵢ| along the normal; the apex and the longest
/// side, both off by δ in opposite directions, turn a triangle of height h by atan(2δ / h). On a grid of 1 mm that is 11° for a
/// triangle 5 mm high.
pub(crate) fn steepest(solid: &Solid, face: &Face, rounding: bool) -> Option<Turn> {
    if face.rings.len() == 1 && face.rings[0].len() == 3 {
        return None;
    }
    let normal: Vector3<f64> = face.rings.iter().map(|ring| solid.newell(ring)).sum();
    let normal = normal.try_normalize(0.0)?;
    let off: f64 = if rounding { (0..3).map(|i| solid.step[i] * normal[i].abs()).sum() } else { 0.0 };
    let turn = |triangle: [u32; 3]| {
        let [a, b, c] = triangle.map(|v| solid.point(v));
        let turned = (b - a).cross(&(c - a));
        let longest = (b - a).norm().max((c - b).norm()).max((a - c).norm());
        let height = turned.norm() / longest;
        Turn { triangle, angle: (turned.angle(&normal) - off.atan2(height)).to_degrees() }
    };
    triangulate(solid, face)?.into_iter().map(turn).max_by(|a, b| a.angle.total_cmp(&b.angle))
}
