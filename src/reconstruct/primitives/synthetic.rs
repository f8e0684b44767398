//! Roofs with known planes, scanned on a jittered grid: no two points coincide, and no patch is missed altogether.

use crate::geometry::Random;
use nalgebra::{Point3, Vector3};

/// How a roof is scanned.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scan {
    /// Points per square metre seen from above.
    pub density: f64,
    /// Standard deviation across the surface, metres.
    pub sigma: f64,
    /// Seed.
    pub seed: u64,
}

impl Scan {
    /// Points on the height field `z(x, y)` over the rectangle from 0, 0 to this size, with noise along its normal.
    pub fn of(&self, size: [f64; 2], height: impl Fn(f64, f64) -> f64) -> Vec<Point3<f64>> {
        let mut random = Random::new(self.seed);
        let side = self.density.sqrt().recip();
        let [columns, rows] = size.map(|length| (length / side).round().max(1.0) as usize);
        (0..columns * rows)
            .map(|cell| {
                let mut at = |place: usize| (place as f64 + 0.1 + 0.8 * random.unit()) * side;
                let (x, y) = (at(cell % columns), at(cell / columns));
                let e = 1e-4;
                let slope = Vector3::new(
                    (height(x + e, y) - height(x - e, y)) / (2.0 * e),
                    (height(x, y + e) - height(x, y - e)) / (2.0 * e),
                    0.0,
                );
                let normal = if slope.norm() > 10.0 { Vector3::z() } else { (Vector3::z() - slope).normalize() };
                Point3::new(x, y, height(x, y)) + normal * (random.bell() * self.sigma)
            })
            .collect()
    }
}

/// A gable roof of 12 × 8 m with slopes of 45° and its ridge along x at y = 4, z = 7.
pub(super) fn gable(scan: &Scan) -> Vec<Point3<f64>> {
    scan.of([12.0, 8.0], |_, y| 7.0 - (y - 4.0).abs())
}
