//! Detection and refinement of planar primitives: `cargo bench --bench detection`.
//!
//! The roof is synthetic, so that the figure can be repeated anywhere: a gable with a dormer and a chimney at 8 points
//! per square metre, with 2.5 cm of ripple, in the sizes of Delft (median 383 points, largest some thousand).

use gable::reconstruct::Parameters;
use gable::reconstruct::primitives::neighbours::Neighbours;
use gable::reconstruct::primitives::{DetectionParameters, Detector, Primitive, detect, refine};
use nalgebra::Point3;

fn main() {
    divan::main();
}

/// About so many points on a roof; the noise is a hash of the place.
fn roof(count: usize) -> Vec<Point3<f64>> {
    let side = (count as f64 / 8.0).sqrt();
    let steps = (count as f64).sqrt() as u32;
    let hash = |i: u32, salt: u32| {
        let mixed = (i ^ salt).wrapping_mul(0x9E37_79B1).rotate_left(13).wrapping_mul(0x85EB_CA77);
        f64::from(mixed >> 8) / f64::from(1u32 << 24) - 0.5
    };
    (0..steps * steps)
        .map(|i| {
            let place = |cell: u32, salt| (f64::from(cell) + 0.5 + 0.8 * hash(i, salt)) * side / f64::from(steps);
            let (x, y) = (place(i % steps, 1), place(i / steps, 2));
            let (u, v) = (x / side, y / side);
            let gable = 8.0 - 0.8 * (y - side / 2.0).abs();
            let dormer = if (0.3..0.5).contains(&u) && (0.1..0.3).contains(&v) { 7.5 } else { gable };
            let chimney = if (0.7..0.85).contains(&u) && (0.4..0.55).contains(&v) { 9.5 } else { dormer };
            Point3::new(x, y, chimney + 0.08 * hash(i, 3))
        })
        .collect()
}

fn parameters(detector: Detector) -> Parameters {
    Parameters {
        detection: DetectionParameters { detector, ..DetectionParameters::default() },
        ..Parameters::default()
    }
}

#[divan::bench(args = [400, 1_000, 1_700, 20_000])]
fn region_growing(bencher: divan::Bencher, count: usize) {
    let (points, parameters) = (roof(count), parameters(Detector::RegionGrowing));
    bencher.bench_local(|| detect(divan::black_box(&points), &parameters, 1));
}

#[divan::bench(args = [400, 1_000, 1_700, 20_000])]
fn ransac(bencher: divan::Bencher, count: usize) {
    let (points, parameters) = (roof(count), parameters(Detector::Ransac));
    bencher.bench_local(|| detect(divan::black_box(&points), &parameters, 1));
}

#[divan::bench(args = [400, 1_700])]
fn neighbours(bencher: divan::Bencher, count: usize) {
    let points = roof(count);
    bencher.bench_local(|| Neighbours::new(divan::black_box(&points), 10));
}

/// Algorithm 1 on so many primitives of nine points each, every tenth plane the same.
#[divan::bench(args = [20, 200, 1_000])]
fn refinement(bencher: divan::Bencher, count: u32) {
    let points: Vec<Point3<f64>> = (0..count * 9)
        .map(|i| {
            let (group, place) = (i / 9, i % 9);
            let (x, y) = (f64::from(group) + f64::from(place % 3) / 4.0, f64::from(place / 3) / 4.0);
            Point3::new(x, y, f64::from(group % 10) * (1.0 + 0.1 * x) + 0.05 * y)
        })
        .collect();
    let primitives: Vec<Primitive> =
        (0..count).filter_map(|group| Primitive::from_inliers(&points, (group * 9..group * 9 + 9).collect())).collect();
    let parameters = DetectionParameters::default();
    bencher
        .with_inputs(|| primitives.clone())
        .bench_local_values(|primitives| refine(&points, primitives, &parameters, 0.02));
}
