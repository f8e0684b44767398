//! Planes on the integer grid.

use nalgebra::{Unit, Vector3};

use super::IntegerPlane;
use crate::geometry::Plane;

/// Grid steps per unit of a normal and per metre of an offset.
pub(super) const SCALE: f64 = (1_u64 << 20) as f64;

/// How far a vertex may lie from the origin along any axis, metres.
pub const REACH: f64 = 8192.0;

/// How far a plane may lie from the origin, metres; every plane that meets the cube of ±[`REACH`] is nearer, as
/// √3 · 2¹³ < 2¹⁴.
const FARTHEST: f64 = 16384.0;

impl IntegerPlane {
    /// The nearest plane on the grid, and whether its positive side is the negative side of `plane`.
    ///
    /// The offset is scaled by the length of the rounded normal, so that the plane keeps its distance from the origin
    /// to 2⁻²⁰ m and turns by at most 2⁻²⁰ about its point nearest to the origin: within 100 m of it no point of the
    /// plane moves by more than 0.1 mm.
    ///
    /// `None` when the plane is not finite or more than 2¹⁴ m away from the origin.
    pub fn snap(plane: &Plane) -> Option<(Self, bool)> {
        // NaN fails every comparison, so it must fail into `None`.
        if !(plane.offset.abs() <= FARTHEST && plane.normal.iter().all(|c| c.abs() <= 1.0 + 1e-9)) {
            return None;
        }
        let normal = plane.normal.map(|c| (c * SCALE).round().clamp(-SCALE, SCALE));
        if normal == Vector3::zeros() {
            return None;
        }
        let offset = (plane.offset * normal.norm()).round();
        Some(Self::reduced([normal.x as i64, normal.y as i64, normal.z as i64], offset as i64))
    }

    /// The plane on which the coordinate `axis` (0 to 2) is `steps` · 2⁻²⁰ m; the coordinate grows towards its
    /// positive side.
    pub(super) fn across(axis: usize, steps: i64) -> Self {
        let mut normal = [0; 3];
        normal[axis] = SCALE as i64;
        Self::reduced(normal, -steps).0
    }

    /// The canonical form of a plane whose normal is not zero, and whether that turned the normal around.
    pub(super) fn reduced(normal: [i64; 3], offset: i64) -> (Self, bool) {
        let divisor = normal.iter().fold(offset.unsigned_abs(), |g, c| gcd(g, c.unsigned_abs())) as i64;
        let flipped = normal.iter().rev().find(|&&c| c != 0).is_some_and(|&c| c < 0);
        let divisor = if flipped { -divisor } else { divisor };
        (Self { normal: normal.map(|c| c / divisor), offset: offset / divisor }, flipped)
    }

    /// The plane in floating point, with a unit normal, in local metres.
    pub fn to_plane(&self) -> Plane {
        let (normal, length) = Unit::new_and_get(Vector3::from(self.normal.map(|c| c as f64)));
        Plane { normal, offset: self.offset as f64 / length }
    }
}

/// The greatest common divisor; `gcd(0, b) = b`.
pub(super) fn gcd(mut a: u64, mut b: u64) -> u64 {
    if a == 0 || b == 0 {
        return a | b;
    }
    let shared = (a | b).trailing_zeros();
    a >>= a.trailing_zeros();
    while b != 0 {
        b >>= b.trailing_zeros();
        if a > b {
            std::mem::swap(&mut a, &mut b);
        }
        b -= a;
    }
    a << shared
}
