//! Exact intersection of two triangles of a shell.

use rstar::{AABB, RTreeObject};

use super::predicates::{Meeting, Point2, Point3, Projection, cross, meet, orient2, orient3, subtract};
use super::triangulation::triangulate;
use crate::solid::Solid;

/// A triangle of a face.
#[derive(Debug, Clone)]
pub(super) struct Triangle {
    pub(super) face: u32,
    pub(super) corners: [Point3; 3],
    /// Whether the side from each corner to the next is an edge of the face, and not a diagonal of it.
    is_edge: [bool; 3],
    /// Smallest and largest coordinates.
    pub(super) min: Point3,
    pub(super) max: Point3,
}

impl RTreeObject for Triangle {
    type Envelope = AABB<Point3>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_corners(self.min, self.max)
    }
}

impl Triangle {
    pub(super) fn new(solid: &Solid, face: u32, corners: [u32; 3]) -> Self {
        let corners = corners.map(|v| solid.vertices[v as usize]);
        let fold = |pick: fn(i64, i64) -> i64| -> Point3 {
            std::array::from_fn(|axis| corners.iter().map(|c| c[axis]).fold(corners[0][axis], pick))
        };
        Self { face, corners, is_edge: [true; 3], min: fold(i64::min), max: fold(i64::max) }
    }

    /// Whether the bounding boxes have a point in common.
    pub(super) fn boxes_meet(&self, other: &Self) -> bool {
        (0..3).all(|axis| self.min[axis] <= other.max[axis] && other.min[axis] <= self.max[axis])
    }

    /// The side opposite to a corner.
    fn opposite(&self, corner: Point3) -> Option<[Point3; 2]> {
        let at = self.corners.iter().position(|&c| c == corner)?;
        Some([self.corners[(at + 1) % 3], self.corners[(at + 2) % 3]])
    }

    /// Says whether the side with these ends is an edge of the face; sides are taken for edges until something else is said.
    pub(super) fn mark(&mut self, ends: [Point3; 2], is_edge: bool) {
        if let Some(side) = self.side(ends) {
            self.is_edge[side] = is_edge;
        }
    }

    /// Whether the side with these ends is an edge of the face.
    pub(super) fn is_edge(&self, ends: [Point3; 2]) -> bool {
        self.side(ends).is_some_and(|side| self.is_edge[side])
    }

    fn side(&self, [p, q]: [Point3; 2]) -> Option<usize> {
        (0..3).find(|&k| {
            let [a, b] = [self.corners[k], self.corners[(k + 1) % 3]];
            (a == p && b == q) || (a == q && b == p)
        })
    }

    /// A corner, the middles of the sides and the middle of the triangle, in sixfold coordinates.
    pub(super) fn samples(&self) -> [Point3; 5] {
        let [a, b, c] = self.corners;
        let at = |weights: [i64; 3]| -> Point3 {
            std::array::from_fn(|i| weights[0] * a[i] + weights[1] * b[i] + weights[2] * c[i])
        };
        [[6, 0, 0], [3, 3, 0], [0, 3, 3], [3, 0, 3], [2, 2, 2]].map(at)
    }

    /// The same in coordinates `by` times as fine.
    pub(super) fn scaled(&self, by: i64) -> Self {
        let scale = |p: Point3| p.map(|c| c * by);
        Self { corners: self.corners.map(scale), min: scale(self.min), max: scale(self.max), ..*self }
    }

    /// Whether a point is on the closed triangle.
    pub(super) fn holds(&self, p: Point3) -> bool {
        let [a, b, c] = self.corners;
        if (0..3).any(|i| p[i] < self.min[i] || p[i] > self.max[i]) || orient3(a, b, c, p) != 0 {
            return false;
        }
        let Some(flat) = Projection::along(cross(subtract(b, a), subtract(c, a))) else { return false };
        let [a, b, c, p] = [a, b, c, p].map(|v| flat.point(v));
        orient2(a, b, p) >= 0 && orient2(b, c, p) >= 0 && orient2(c, a, p) >= 0
    }

    /// Whether the inside of a segment passes through the inside of the triangle.
    pub(super) fn is_pierced_by(&self, [p, q]: [Point3; 2]) -> bool {
        let [a, b, c] = self.corners;
        let hands = || [orient3(p, q, a, b), orient3(p, q, b, c), orient3(p, q, c, a)];
        orient3(a, b, c, p) * orient3(a, b, c, q) < 0 && matches!(hands(), [1, 1, 1] | [-1, -1, -1])
    }

    pub(super) fn sides(&self) -> [[Point3; 2]; 3] {
        let [a, b, c] = self.corners;
        [[a, b], [b, c], [c, a]]
    }

    /// Whether all of `other` is strictly on one side of this triangle's plane.
    fn separates(&self, other: &Self) -> bool {
        let [a, b, c] = self.corners;
        let sides = other.corners.map(|p| orient3(a, b, c, p));
        sides == [1; 3] || sides == [-1; 3]
    }
}

/// The triangles of all faces of a solid whose polygons are sound.
pub(super) fn triangles_of(solid: &Solid) -> Vec<Triangle> {
    let faces = solid.faces.iter().zip(0..).filter_map(|(face, f)| Some((f, triangulate(solid, face)?)));
    faces.flat_map(|(f, found)| found.into_iter().map(move |t| Triangle::new(solid, f, t))).collect()
}

/// Whether two triangles in one plane overlap by an area: no side of either has all of the other beyond it.
pub(super) fn share_area(a: &Triangle, b: &Triangle) -> bool {
    let [p, q, r] = a.corners;
    if b.corners.iter().any(|&c| orient3(p, q, r, c) != 0) {
        return false;
    }
    let Some(flat) = Projection::along(cross(subtract(q, p), subtract(r, p))) else { return false };
    let a = a.corners.map(|v| flat.point(v));
    let mut b = b.corners.map(|v| flat.point(v));
    if orient2(b[0], b[1], b[2]) < 0 {
        b.reverse();
    }
    let parted =
        |a: [Point2; 3], b: [Point2; 3]| (0..3).any(|i| b.iter().all(|&p| orient2(a[i], a[(i + 1) % 3], p) <= 0));
    !parted(a, b) && !parted(b, a)
}

/// Whether two triangles in one plane look the same way.
pub(super) fn same_side(a: &Triangle, b: &Triangle) -> bool {
    let [p, q, r] = a.corners;
    let Some(flat) = Projection::along(cross(subtract(q, p), subtract(r, p))) else { return false };
    let [p, q, r] = b.corners.map(|v| flat.point(v));
    orient2(p, q, r) > 0
}

/// Whether two triangles of different faces have points in common other than corners, or a side that is an edge of both
/// faces.
pub(super) fn intersect(a: &Triangle, b: &Triangle) -> bool {
    if a.separates(b) || b.separates(a) {
        return false;
    }
    let shared: Vec<Point3> = a.corners.into_iter().filter(|c| b.corners.contains(c)).collect();
    match shared[..] {
        [] => a.sides().iter().any(|&s| meets(s, b)) || b.sides().iter().any(|&s| meets(s, a)),
        // What they share beyond the corner begins there and ends on a side opposite to it.
        [corner] => a.opposite(corner).is_some_and(|s| meets(s, b)) || b.opposite(corner).is_some_and(|s| meets(s, a)),
        [p, q] => !a.is_edge([p, q]) || !b.is_edge([p, q]) || folded(a, b, [p, q]),
        _ => true,
    }
}

/// Whether two triangles with a common side lie on each other: in one plane, on the same side of it.
fn folded(a: &Triangle, b: &Triangle, [p, q]: [Point3; 2]) -> bool {
    let third = |t: &Triangle| t.corners.into_iter().find(|&c| c != p && c != q);
    let (Some(r), Some(s)) = (third(a), third(b)) else { return true };
    let normal = cross(subtract(q, p), subtract(r, p));
    if orient3(p, q, r, s) != 0 {
        return false;
    }
    let Some(flat) = Projection::along(normal) else { return true };
    let [p, q, r, s] = [p, q, r, s].map(|v| flat.point(v));
    orient2(p, q, r) == orient2(p, q, s)
}

/// Whether a closed segment and a closed triangle meet.
fn meets([p, q]: [Point3; 2], triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.corners;
    let (of_p, of_q) = (orient3(a, b, c, p), orient3(a, b, c, q));
    if of_p * of_q > 0 {
        return false;
    }
    if of_p == 0 && of_q == 0 {
        let Some(flat) = Projection::along(cross(subtract(b, a), subtract(c, a))) else { return true };
        let [p, q, a, b, c] = [p, q, a, b, c].map(|v| flat.point(v));
        let inside = orient2(a, b, p) >= 0 && orient2(b, c, p) >= 0 && orient2(c, a, p) >= 0;
        return inside || [[a, b], [b, c], [c, a]].into_iter().any(|side| meet([p, q], side) != Meeting::Apart);
    }
    // The line through the segment passes all sides on the same hand where it passes through the triangle.
    let hands = [orient3(p, q, a, b), orient3(p, q, b, c), orient3(p, q, c, a)];
    hands.iter().all(|&h| h >= 0) || hands.iter().all(|&h| h <= 0)
}
