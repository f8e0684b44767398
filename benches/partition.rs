//! The cell complex on generated primitives: a house, and random planes up to the thousand that must go through.
//!
//! `cargo bench --bench partition`

mod generated;

use divan::Bencher;
use gable::geometry::Aabb;
use gable::reconstruct::complex::Complex;
use gable::reconstruct::primitives::{Primitive, PrimitiveKind};
use generated::{random_planes, rectangle};
use nalgebra::{Point3, Vector3};

fn main() {
    divan::main();
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
