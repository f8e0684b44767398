//! The shells of a solid with voids: codes 401 to 404. Exact, except for where contacts end, which is to 2⁻⁸ of a step.

use std::collections::{BTreeMap, BTreeSet};

use super::predicates::{Point2, Point3, Projection, cross, edges, orient2, orient3, subtract};
use super::triangles::{Triangle, share_area, triangles_of};
use super::{Fault, Place};
use crate::solid::Solid;

/// A fault of a shell of a solid.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ShellFault {
    /// The number of the shell; 0 is the exterior.
    pub shell: usize,
    /// The fault; its place is the shell as a whole.
    pub fault: Fault,
}

/// The faults of the shells of a solid, exterior first, each of them sound and closed by itself and all on one grid: 401 two
/// shells cross, share a piece of a face or are voids inside each other, 402 two shells are the same, 403 a void is outside
/// the exterior, 404 voids that touch along lines cut the interior in pieces.
///
/// Shells may touch in points, and along lines as long as these do not close.
pub fn check(shells: &[Solid]) -> Vec<ShellFault> {
    let mut faults = Vec::new();
    let mut contacts = Vec::new();
    let sampled: Vec<Sampled> = shells.iter().map(Sampled::new).collect();
    for (j, inner) in sampled.iter().enumerate() {
        for (i, outer) in sampled[..j].iter().enumerate() {
            let mut fault = |code, message: String| {
                faults.push(ShellFault { shell: j, fault: Fault::new(code, Place::Solid, message) });
            };
            if same(inner.solid, outer.solid) {
                fault(402, format!("the shell is the same as shell {i}"));
                continue;
            }
            let of_inner = outer.locate(inner);
            let of_outer = inner.locate(outer);
            // A void lies within the exterior, and voids lie outside each other.
            let crossed = (of_inner.within && (of_inner.outside || of_outer.within))
                || (of_outer.within && of_outer.outside)
                || outer.shares_area(inner)
                || pierced(outer, inner);
            if crossed || (i > 0 && (of_inner.within || of_outer.within)) {
                fault(401, format!("the shell and shell {i} intersect"));
            } else if i == 0 && of_inner.outside {
                fault(403, "the void is outside the exterior shell".to_owned());
            } else {
                contacts.extend(outer.contacts(inner));
            }
        }
    }
    if faults.is_empty() && closes(&contacts) {
        let message = "voids touch along a closed line, which cuts the interior in pieces";
        faults.push(ShellFault { shell: 0, fault: Fault::new(404, Place::Solid, message) });
    }
    faults
}

/// Whether two shells have the same corners and equally many faces.
pub(super) fn same(a: &Solid, b: &Solid) -> bool {
    let corners = |solid: &Solid| solid.vertices.iter().copied().collect::<BTreeSet<_>>();
    a.faces.len() == b.faces.len() && corners(a) == corners(b)
}

/// Where the points of one shell are with respect to another.
#[derive(Debug, Clone, Copy, Default)]
struct Whereabouts {
    within: bool,
    outside: bool,
}

/// A shell as triangles.
struct Sampled<'a> {
    solid: &'a Solid,
    triangles: Vec<Triangle>,
}

/// Sixfold coordinates hold the middles of edges and of triangles.
const FINER: i64 = 6;

impl<'a> Sampled<'a> {
    fn new(solid: &'a Solid) -> Self {
        Self { solid, triangles: triangles_of(solid) }
    }

    /// Corners, middles of sides and middles of the triangles, in sixfold coordinates.
    fn points(&self) -> impl Iterator<Item = Point3> + '_ {
        self.triangles.iter().flat_map(Triangle::samples)
    }

    /// Where the points of another shell are.
    fn locate(&self, other: &Self) -> Whereabouts {
        let fine: Vec<Triangle> = self.triangles.iter().map(|t| t.scaled(FINER)).collect();
        let mut found = Whereabouts::default();
        for point in other.points() {
            match inside(&fine, point) {
                Some(true) => found.within = true,
                Some(false) => found.outside = true,
                None => {}
            }
        }
        found
    }

    fn pairs<'b>(&'b self, other: &'b Self) -> impl Iterator<Item = (&'b Triangle, &'b Triangle)> {
        self.triangles.iter().flat_map(|a| other.triangles.iter().filter(|b| a.boxes_meet(b)).map(move |b| (a, b)))
    }

    fn shares_area(&self, other: &Self) -> bool {
        self.pairs(other).any(|(a, b)| share_area(a, b))
    }

    /// The pieces of edges of either shell that lie on the other.
    fn contacts(&self, other: &Self) -> Vec<[Node; 2]> {
        let of_sides =
            |a: &Triangle, b: &Triangle| a.sides().into_iter().filter_map(|s| along(s, b)).collect::<Vec<_>>();
        self.pairs(other).flat_map(|(a, b)| [of_sides(a, b), of_sides(b, a)].concat()).collect()
    }
}

/// Whether an edge of one shell goes through the interior of a triangle of the other.
fn pierced(a: &Sampled, b: &Sampled) -> bool {
    let through = |a: &Triangle, b: &Triangle| a.sides().into_iter().any(|side| b.is_pierced_by(side));
    a.pairs(b).any(|(a, b)| through(a, b) || through(b, a))
}

/// Whether a point is inside a closed shell; `None` on the shell itself. By the parity of the triangles above it, seen
/// from the point moved by an infinitesimal along x and y, which is how [`crosses`] decides ties.
pub(super) fn inside(triangles: &[Triangle], p: Point3) -> Option<bool> {
    let mut within = false;
    for triangle in triangles {
        if p[0] < triangle.min[0] || p[0] > triangle.max[0] || p[1] < triangle.min[1] || p[1] > triangle.max[1] {
            continue;
        }
        if triangle.holds(p) {
            return None;
        }
        let flat = triangle.corners.map(|c| [c[0], c[1]]);
        let over = edges(&flat).filter(|&(a, b)| crosses(a, b, [p[0], p[1]])).count() % 2 == 1;
        if over {
            let [a, b, c] = triangle.corners;
            let turns = orient2(flat[0], flat[1], flat[2]);
            within ^= orient3(a, b, c, p) * turns < 0;
        }
    }
    Some(within)
}

/// Whether an edge crosses the ray from a point towards +x; the same for both directions of the edge.
fn crosses(a: Point2, b: Point2, p: Point2) -> bool {
    let (low, high) = if a[1] < b[1] { (a, b) } else { (b, a) };
    low[1] <= p[1] && p[1] < high[1] && orient2(low, high, p) > 0
}

/// A place in 256ths of a grid step.
type Node = [i64; 3];

/// The piece of a segment in the plane of a triangle that lies on the triangle, if it is longer than nothing.
fn along([p, q]: [Point3; 2], triangle: &Triangle) -> Option<[Node; 2]> {
    let [a, b, c] = triangle.corners;
    if orient3(a, b, c, p) != 0 || orient3(a, b, c, q) != 0 {
        return None;
    }
    let flat = Projection::along(cross(subtract(b, a), subtract(c, a)))?;
    let corners = [a, b, c].map(|v| flat.point(v));
    let [p2, q2] = [p, q].map(|v| flat.point(v));
    let side = |a: Point2, b: Point2, p: Point2| {
        let [u, v] = [b, p].map(|p| [i128::from(p[0]) - i128::from(a[0]), i128::from(p[1]) - i128::from(a[1])]);
        u[0] * v[1] - u[1] * v[0]
    };
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for (a, b) in edges(&corners) {
        match (side(a, b, p2), side(a, b, q2)) {
            (s, t) if s <= 0 && t <= 0 && (s < 0 || t < 0) => return None,
            (s, t) if s < 0 => from = from.max(s as f64 / (s - t) as f64),
            (s, t) if t < 0 => to = to.min(s as f64 / (s - t) as f64),
            _ => {}
        }
    }
    let at = |share: f64| -> Node {
        std::array::from_fn(|i| 256 * p[i] + (256.0 * share * (q[i] - p[i]) as f64).round() as i64)
    };
    let ends = [at(from), at(to)];
    (from < to && ends[0] != ends[1]).then_some(ends)
}

/// Whether segments close a ring, once they are cut at the ends of each other.
fn closes(segments: &[[Node; 2]]) -> bool {
    let nodes: BTreeSet<Node> = segments.iter().flatten().copied().collect();
    let mut pieces: BTreeSet<[Node; 2]> = BTreeSet::new();
    for &[a, b] in segments {
        let mut on: Vec<(f64, Node)> = nodes.iter().filter_map(|&n| Some((share(a, b, n)?, n))).collect();
        on.sort_by(|x, y| x.0.total_cmp(&y.0));
        pieces.extend(on.windows(2).map(|pair| [pair[0].1.min(pair[1].1), pair[0].1.max(pair[1].1)]));
    }
    let index: BTreeMap<Node, usize> = nodes.into_iter().zip(0..).collect();
    let mut set: Vec<usize> = (0..index.len()).collect();
    for [a, b] in pieces {
        let root = |mut i: usize| {
            while set[i] != i {
                i = set[i];
            }
            i
        };
        let (a, b) = (root(index[&a]), root(index[&b]));
        if a == b {
            return true;
        }
        set[a] = b;
    }
    false
}

/// How far along the segment a node lies that is on it, 0 to 1.
fn share(a: Node, b: Node, node: Node) -> Option<f64> {
    let [u, v] = [b, node].map(|p| -> [f64; 3] { std::array::from_fn(|i| (p[i] - a[i]) as f64) });
    let dot = |u: [f64; 3], v: [f64; 3]| u[0] * v[0] + u[1] * v[1] + u[2] * v[2];
    let at = dot(u, v) / dot(u, u);
    let off: [f64; 3] = std::array::from_fn(|i| v[i] - at * u[i]);
    // Two 256ths: both the node and the ends are rounded.
    ((0.0..=1.0).contains(&at) && dot(off, off) <= 4.0).then_some(at)
}
