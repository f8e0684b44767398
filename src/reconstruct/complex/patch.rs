//! The part of its plane that a primitive reaches.

use nalgebra::Point3;

use crate::geometry::Plane;

/// A patch also meets what is this near to it, metres: far above the rounding errors of its corners, far below
/// anything that is measured, so that no true meeting is lost.
pub(super) const TOLERANCE: f64 = 1e-6;

/// A convex polygon, or what is left of one.
#[derive(Debug, Clone)]
pub(super) struct Patch(Vec<Point3<f64>>);

impl Patch {
    /// The polygon with these corners, laid onto `plane` (the corners of a detected patch are off it by the residual).
    pub(super) fn on_plane(corners: &[Point3<f64>], plane: &Plane) -> Self {
        Self(corners.iter().map(|p| p - plane.normal.into_inner() * plane.distance(p)).collect())
    }

    /// What lies on the negative and on the positive side of `plane`; either may be missing, not both.
    pub(super) fn divide(self, plane: &Plane) -> (Option<Self>, Option<Self>) {
        let distances: Vec<f64> = self.0.iter().map(|p| plane.distance(p)).collect();
        let least = distances.iter().copied().fold(f64::INFINITY, f64::min);
        let most = distances.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if least > TOLERANCE {
            return (None, Some(self));
        }
        if most < -TOLERANCE {
            return (Some(self), None);
        }
        let negative = if most > TOLERANCE { self.beyond(&distances, -1.0) } else { self.clone() };
        let positive = if least < -TOLERANCE { self.beyond(&distances, 1.0) } else { self };
        (Some(negative), Some(positive))
    }

    /// The part whose distances, times `sign`, are at least −[`TOLERANCE`] (Sutherland and Hodgman 1974).
    fn beyond(&self, distances: &[f64], sign: f64) -> Self {
        let count = self.0.len();
        let mut kept = Vec::with_capacity(count + 1);
        for i in 0..count {
            let next = if i + 1 == count { 0 } else { i + 1 };
            let (from, to) = (sign * distances[i] + TOLERANCE, sign * distances[next] + TOLERANCE);
            if from >= 0.0 {
                kept.push(self.0[i]);
            }
            if (from < 0.0) != (to < 0.0) {
                kept.push(self.0[i] + (self.0[next] - self.0[i]) * (from / (from - to)));
            }
        }
        Self(kept)
    }
}
