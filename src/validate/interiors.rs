//! Whether the interiors of two solids meet. Exact.

use super::predicates::Point3;
use super::triangles::{Triangle, same_side, share_area, triangles_of};
use super::voids::inside;
use crate::solid::Solid;

/// Sixfold coordinates hold the middles of edges and of triangles.
const FINER: i64 = 6;

/// A place in metres where the interiors of two solids meet, or that is as near to one as their triangles are small; `None`
/// if they do not meet. Each solid is its shells, and both are on one grid.
///
/// Interiors meet where an edge of one goes through a face of the other, where faces of both lie on each other and look the
/// same way, and where a point of the surface of one is inside the other.
pub(super) fn shared_place(a: &[Solid], b: &[Solid]) -> Option<[f64; 3]> {
    let step = a.first()?.step;
    let [of_a, of_b] = [a, b].map(|shells| shells.iter().flat_map(triangles_of).collect::<Vec<_>>());
    let place = met(&of_a, &of_b).or_else(|| within(&of_a, &of_b)).or_else(|| within(&of_b, &of_a))?;
    Some(std::array::from_fn(|i| place[i] as f64 / FINER as f64 * step[i]))
}

/// A corner, in sixfold coordinates, of a triangle that cuts or covers one of the other solid.
fn met(a: &[Triangle], b: &[Triangle]) -> Option<Point3> {
    let through = |a: &Triangle, b: &Triangle| a.sides().into_iter().any(|side| b.is_pierced_by(side));
    let meet = |a: &Triangle, b: &Triangle| {
        a.boxes_meet(b) && (through(a, b) || through(b, a) || (share_area(a, b) && same_side(a, b)))
    };
    a.iter().find(|one| b.iter().any(|other| meet(one, other))).map(|one| one.corners[0].map(|c| FINER * c))
}

/// A corner, the middle of a side or the middle of a triangle of `a` that is inside the solid with the triangles `b`, in
/// sixfold coordinates.
fn within(a: &[Triangle], b: &[Triangle]) -> Option<Point3> {
    let fine: Vec<Triangle> = b.iter().map(|t| t.scaled(FINER)).collect();
    let corners = || fine.iter().flat_map(|t| t.corners);
    let ends = |axis: usize| (corners().map(|c| c[axis]).min(), corners().map(|c| c[axis]).max());
    let ends = [ends(0), ends(1), ends(2)];
    let is_near = |point: &Point3| {
        ends.iter()
            .zip(point)
            .all(|((low, high), value)| low.is_some_and(|low| low <= *value) && high.is_some_and(|high| *value <= high))
    };
    a.iter().flat_map(Triangle::samples).filter(is_near).find(|&point| inside(&fine, point) == Some(true))
}
