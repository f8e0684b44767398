//! The order in which primitives cut (paper, section 3.2).

use std::cmp::Reverse;

use nalgebra::{Point3, Vector3};

use super::IntegerPlane;
use crate::reconstruct::primitives::{Extent, Primitive, PrimitiveKind};

/// Verticality above which a plane counts as a wall (paper, section 3.2): within 5.7° of vertical.
const VERTICAL: f64 = 0.9;

/// Verticality is compared in steps of this size, so that rounding noise does not decide which of two walls is first.
const VERTICALITY_STEP: f64 = 1e-3;

/// Indices of the primitives in the order in which they cut.
///
/// 1. Planes that reach everywhere: they cut every cell in their way whenever they come, and the fewest when they
///    come first.
/// 2. Walls, that is planes of verticality `1 − |n_z| > 0.9`, by verticality. Of equally vertical ones, those that are
///    known best come first: footprint edges, then height jumps, then detected ones; then the longest.
/// 3. The rest by support, that is by the number of inliers; of equal ones the largest.
///
/// What is still equal is ordered by the coefficients of its plane and then by its index.
pub fn insertion_order(primitives: &[Primitive]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..primitives.len()).collect();
    order.sort_by_cached_key(|&index| {
        let primitive = &primitives[index];
        let verticality = primitive.plane.verticality();
        let wall = verticality > VERTICAL;
        let rank = match (&primitive.extent, wall) {
            (Extent::Everywhere, _) => 0,
            (Extent::Patch(_), true) => 1,
            (Extent::Patch(_), false) => 2,
        };
        let (size, knowledge, support) = match (&primitive.extent, wall) {
            (Extent::Patch(corners), true) => (length(corners), knowledge(primitive.kind), 0),
            (Extent::Patch(corners), false) => (area(corners), 0, primitive.inliers.len()),
            (Extent::Everywhere, _) => (0.0, knowledge(primitive.kind), primitive.inliers.len()),
        };
        let steps = if wall { (verticality / VERTICALITY_STEP).round() as i64 } else { 0 };
        // Millimetres: sizes that differ by less are equal.
        let size = (size * 1e3).round() as i64;
        let plane = IntegerPlane::snap(&primitive.plane).map(|(plane, _)| plane);
        (rank, Reverse(steps), knowledge, Reverse(support), Reverse(size), plane, index)
    });
    order
}

/// How well a kind of wall is known, best first.
fn knowledge(kind: PrimitiveKind) -> u8 {
    match kind {
        PrimitiveKind::FootprintEdge => 0,
        PrimitiveKind::HeightJump => 1,
        PrimitiveKind::Detected => 2,
    }
}

/// Horizontal length of a patch, metres: the longest horizontal distance from its first corner's farthest corner.
fn length(corners: &[Point3<f64>]) -> f64 {
    let farthest = |from: &Point3<f64>| {
        let distance = |p: &Point3<f64>| (p.x - from.x).hypot(p.y - from.y);
        corners.iter().map(|p| (distance(p), p)).max_by(|a, b| a.0.total_cmp(&b.0))
    };
    // On a vertical plane the horizontal positions are on a line, so that the second step finds its whole length.
    corners.first().and_then(farthest).and_then(|(_, end)| farthest(end)).map_or(0.0, |(length, _)| length)
}

/// Area of a convex patch, m².
fn area(corners: &[Point3<f64>]) -> f64 {
    let Some(first) = corners.first() else { return 0.0 };
    corners.windows(2).fold(Vector3::zeros(), |sum, w| sum + (w[0] - first).cross(&(w[1] - first))).norm() / 2.0
}
