//! Solids together: codes 501 to 503 of a `CompositeSolid`, and 601 of the parts of a building.

use nalgebra::{Point3, Vector3};

pub use super::overlap::Overlap;
use super::overlap::{NARROW, near, overlap};
use super::triangles::{Triangle, triangles_of};
use super::voids::same;
use super::{Fault, Place};
use crate::solid::Solid;

/// A fault between solids.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SolidFault {
    /// The number of the later solid of a pair; 0 when it concerns all.
    pub solid: usize,
    /// The fault; its place is the solid as a whole.
    pub fault: Fault,
}

/// The faults of the solids of a `CompositeSolid`, each its shells, sound by itself and all on one grid: 501 two overlap,
/// 502 two are the same, 503 they do not hang together by faces. What is no thicker than `tolerance` metres is no
/// overlap, and faces no farther apart than that touch.
pub fn check(solids: &[Vec<Solid>], tolerance: f64) -> Vec<SolidFault> {
    let mut faults = Vec::new();
    let mut set: Vec<usize> = (0..solids.len()).collect();
    for (j, later) in solids.iter().enumerate() {
        for (i, earlier) in solids[..j].iter().enumerate() {
            let (code, message) = if is_same(earlier, later) {
                (502, format!("the solid is the same as solid {i}"))
            } else if let Some(found) = overlap(earlier, later, tolerance) {
                (501, format!("the solid and solid {i} overlap by {:.4} m at least", found.depth))
            } else if touch(earlier, later, tolerance) {
                join(&mut set, i, j);
                continue;
            } else {
                continue;
            };
            join(&mut set, i, j);
            faults.push(SolidFault { solid: j, fault: Fault::new(code, Place::Solid, message) });
        }
    }
    let pieces = (0..set.len()).filter(|&i| set[i] == i).count();
    if pieces > 1 {
        let message = format!("the solids hang together by faces in {pieces} pieces; they must in one");
        faults.push(SolidFault { solid: 0, fault: Fault::new(503, Place::Solid, message) });
    }
    faults
}

/// The fault 601: how two parts of a building, each its shells, sound by itself and on one grid, overlap, if they do by more
/// than `tolerance` metres. The vertices of parts are rounded one by one: parts that touch along a slanted wall overlap by up
/// to the diagonal of a grid cell, and a tolerance below that finds them.
pub fn check_parts(one: &[Solid], other: &[Solid], tolerance: f64) -> Option<Overlap> {
    overlap(one, other, tolerance)
}

fn join(set: &mut [usize], i: usize, j: usize) {
    let root = |set: &[usize], mut i: usize| {
        while set[i] != i {
            i = set[i];
        }
        i
    };
    let (a, b) = (root(set, i), root(set, j));
    set[a.max(b)] = a.min(b);
}

fn is_same(a: &[Solid], b: &[Solid]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| same(a, b))
}

/// Whether two solids have faces that lie on each other, within the tolerance, over an area wider than it.
fn touch(a: &[Solid], b: &[Solid], tolerance: f64) -> bool {
    if !near(a, b, tolerance) {
        return false;
    }
    let [ours, theirs] = [a, b].map(|shells| shells.iter().flat_map(flat).collect::<Vec<_>>());
    ours.iter().any(|a| theirs.iter().any(|b| faces_touch(a, b, tolerance)))
}

/// A triangle in metres with its unit normal.
struct Flat {
    corners: [Point3<f64>; 3],
    normal: Vector3<f64>,
}

fn flat(shell: &Solid) -> Vec<Flat> {
    let metres = |t: &Triangle| t.corners.map(|c| Point3::from(std::array::from_fn(|i| c[i] as f64 * shell.step[i])));
    let with_normal = |corners: [Point3<f64>; 3]| {
        let [a, b, c] = corners;
        Some(Flat { corners, normal: (b - a).cross(&(c - a)).try_normalize(0.0)? })
    };
    triangles_of(shell).iter().filter_map(|t| with_normal(metres(t))).collect()
}

/// Faces that touch look at each other.
const FACING: f64 = -0.999;

fn faces_touch(a: &Flat, b: &Flat, tolerance: f64) -> bool {
    if a.normal.dot(&b.normal) > FACING {
        return false;
    }
    // What of b lies over a and within the tolerance of its plane.
    let [p, q, r] = a.corners;
    let mut piece: Vec<Point3<f64>> = b.corners.to_vec();
    for (from, to) in [(p, q), (q, r), (r, p)] {
        let inwards = a.normal.cross(&(to - from));
        piece = clip(&piece, |x| inwards.dot(&(x - from)));
    }
    for side in [1.0, -1.0] {
        piece = clip(&piece, |x| tolerance + NARROW + side * a.normal.dot(&(x - p)));
    }
    let Some(&first) = piece.first() else { return false };
    let area: Vector3<f64> = piece.windows(2).map(|e| (e[0] - first).cross(&(e[1] - first))).sum();
    let around: f64 = super::predicates::edges(&piece).map(|(a, b)| (b - a).norm()).sum();
    // A strip of width w has twice the area w times its length, which is half of the way around.
    area.norm() > around * tolerance
}

/// The part of a convex polygon where `inside` is not negative.
fn clip(polygon: &[Point3<f64>], inside: impl Fn(&Point3<f64>) -> f64) -> Vec<Point3<f64>> {
    let mut out = Vec::with_capacity(polygon.len() + 1);
    for (a, b) in super::predicates::edges(polygon) {
        let (of_a, of_b) = (inside(&a), inside(&b));
        if of_a >= 0.0 {
            out.push(a);
        }
        if (of_a < 0.0) != (of_b < 0.0) {
            out.push(a + (b - a) * (of_a / (of_a - of_b)));
        }
    }
    out
}
