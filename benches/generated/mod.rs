//! Primitives made on the spot, the same on every machine.

use gable::geometry::{Aabb, Plane};
use gable::reconstruct::primitives::{Extent, Primitive, PrimitiveKind};
use nalgebra::{Point3, Unit, Vector3};

/// A linear congruential generator (Knuth's MMIX): the same planes on every machine.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

/// A primitive on the rectangle with this centre and these half sides.
pub fn rectangle(kind: PrimitiveKind, c: Point3<f64>, u: Vector3<f64>, v: Vector3<f64>, support: u32) -> Primitive {
    let plane = Plane::through(&c, Unit::new_normalize(u.cross(&v)));
    let extent = Extent::Patch(vec![c - u - v, c + u - v, c + u + v, c - u + v]);
    Primitive { kind, plane, inliers: (0..support).collect(), residual: 0.02, extent }
}

/// Rectangles of 5 to 20 m with random directions in a cube of 100 m.
pub fn random_planes(count: usize) -> (Vec<Primitive>, Aabb) {
    let mut random = Random(1);
    let primitives = (0..count).map(|_| {
        let mut vector = |half: f64| Vector3::from_fn(|_, _| random.between(-half, half));
        let (centre, a, b) = (vector(50.0), vector(1.0), vector(1.0));
        let (u, v) = (a.normalize(), a.cross(&b).normalize());
        let half = [random.between(2.5, 10.0), random.between(2.5, 10.0)];
        let support = (half[0] * half[1] * 32.0) as u32;
        rectangle(PrimitiveKind::Detected, Point3::from(centre), u * half[0], v * half[1], support)
    });
    (primitives.collect(), Aabb { min: [-60.0; 3], max: [60.0; 3] })
}
