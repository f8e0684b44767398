//! The cell complex on generated primitives: a house, and random planes up to the thousand that must go through.
//!
//! `cargo bench --bench partition`

use divan::Bencher;
use gable::geometry::{Aabb, Plane};
use gable::reconstruct::complex::Complex;
use gable::reconstruct::primitives::{Extent, Primitive, PrimitiveKind};
use nalgebra::{Point3, Unit, Vector3};

fn main() {
    divan::main();
}

/// A linear congruential generator (Knuth's MMIX): the same planes on every machine.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * ((self.0 >> 11) as f64 / (1_u64 << 53) as f64)
    }
}

/// A primitive on the rectangle with this centre and these half sides.
fn rectangle(kind: PrimitiveKind, c: Point3<f64>, u: Vector3<f64>, v: Vector3<f64>, support: u32) -> Primitive {
    let plane = Plane::through(&c, Unit::new_normalize(u.cross(&v)));
    let extent = Extent::Patch(vec![c - u - v, c + u - v, c + u + v, c - u + v]);
    Primitive { kind, plane, inliers: (0..support).collect(), residual: 0.02, extent }
}

/// Rectangles of 5 to 20 m with random directions in a cube of 100 m.
fn random_planes(count: usize) -> (Vec<Primitive>, Aabb) {
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

/// A row of wings with walls, gables and dormers: `8 wings + 4` primitives.
fn house(wings: usize) -> (Vec<Primitive>, Aabb) {
    use PrimitiveKind::{Detected, FootprintEdge, HeightJump};
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let mut primitives = Vec::new();
    let length = 8.0 * wings as f64;
    for (side, half) in [(-5.0, length / 2.0), (5.0, length / 2.0)] {
        let centre = Point3::new(length / 2.0, side, 6.0);
        primitives.push(rectangle(FootprintEdge, centre, x * half, z * 6.0, 0));
    }
    for end in [0.0, length] {
        primitives.push(rectangle(FootprintEdge, Point3::new(end, 0.0, 6.0), y * 5.0, z * 6.0, 0));
    }
    for wing in 0..wings {
        let (west, eave) = (8.0 * wing as f64, 5.0 + 0.7 * (wing % 3) as f64);
        primitives.push(rectangle(HeightJump, Point3::new(west + 8.0, 0.0, 6.0), y * 5.0, z * 6.0, 0));
        for side in [-1.0, 1.0] {
            let roof = Point3::new(west + 4.0, side * 2.5, eave + 1.25);
            primitives.push(rectangle(Detected, roof, x * 3.9, (y * side - z * 0.5) * 2.4, 400));
            let dormer = Point3::new(west + 4.0, side * 3.0, eave + 2.0);
            primitives.push(rectangle(Detected, dormer, x, y, 40));
            primitives.push(rectangle(HeightJump, dormer - x, y, z, 0));
        }
        primitives.push(rectangle(HeightJump, Point3::new(west + 4.0, -4.0, eave + 1.0), x, z, 0));
    }
    (primitives, Aabb { min: [-1.0, -6.0, -1.0], max: [length + 1.0, 6.0, 13.0] })
}

#[divan::bench(args = [30, 100, 300, 1000], sample_count = 5, sample_size = 1)]
fn adaptive_random(bencher: Bencher, count: usize) {
    let (primitives, bounds) = random_planes(count);
    bencher.bench_local(|| Complex::adaptive(&primitives, &bounds).map(|c| c.cells.len()));
}

#[divan::bench(args = [1, 2, 4, 7])]
fn adaptive_house(bencher: Bencher, wings: usize) {
    let (primitives, bounds) = house(wings);
    bencher.bench_local(|| Complex::adaptive(&primitives, &bounds).map(|c| c.cells.len()));
}

#[divan::bench(args = [10, 30])]
fn exhaustive_random(bencher: Bencher, count: usize) {
    let (primitives, bounds) = random_planes(count);
    bencher.bench_local(|| Complex::exhaustive(&primitives, &bounds).map(|c| c.cells.len()));
}

#[divan::bench]
fn samples_of_a_house(bencher: Bencher) {
    let (primitives, bounds) = house(4);
    let complex = Complex::adaptive(&primitives, &bounds).unwrap_or_default();
    bencher.bench_local(|| {
        let median = complex.median_volume();
        (0..complex.cells.len() as u32).map(|cell| complex.samples(cell, median, 1).len()).sum::<usize>()
    });
}
