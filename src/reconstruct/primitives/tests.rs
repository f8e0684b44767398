//! Whole roofs with known planes, through both detectors.

use crate::geometry::Random;
use nalgebra::{Point3, Vector3};
use proptest::prelude::*;

use super::synthetic::{Scan, gable};
use super::*;
use crate::reconstruct::Parameters;

fn with(detector: Detector) -> Parameters {
    Parameters {
        detection: DetectionParameters { detector, ..DetectionParameters::default() },
        ..Parameters::default()
    }
}

const DETECTORS: [Detector; 2] = [Detector::RegionGrowing, Detector::Ransac];

/// The plane through a point with this gradient.
fn plane(at: [f64; 3], gradient: [f64; 2]) -> Plane {
    let normal = nalgebra::Unit::new_normalize(Vector3::new(-gradient[0], -gradient[1], 1.0));
    Plane::through(&Point3::from(at), normal)
}

/// Every known plane is found once, within this angle (degrees) and this distance (metres) at its known point, and
/// nothing else is found.
fn assert_planes(what: &str, found: &Detection, known: &[([f64; 3], [f64; 2])], degrees: f64, metres: f64) {
    let describe = || -> Vec<String> {
        let line =
            |p: &Primitive| format!("{:?} {:.3} ×{}", p.plane.normal.as_slice(), p.plane.offset, p.inliers.len());
        found.primitives.iter().map(line).collect()
    };
    for (at, gradient) in known {
        let known = plane(*at, *gradient);
        let count = found
            .primitives
            .iter()
            .filter(|p| {
                p.plane.normal.angle(&known.normal).to_degrees() <= degrees
                    && p.plane.distance(&Point3::from(*at)).abs() <= metres
            })
            .count();
        assert_eq!(count, 1, "{what}: plane at {at:?}; noise {:.3}, found {:#?}", found.noise, describe());
    }
    assert_eq!(found.primitives.len(), known.len(), "{what}: noise {:.3}, found {:#?}", found.noise, describe());
}

/// The planes of [`gable`], each at the middle of its slope.
const GABLE: [([f64; 3], [f64; 2]); 2] = [([6.0, 2.0, 5.0], [0.0, 1.0]), ([6.0, 6.0, 5.0], [0.0, -1.0])];

#[test]
fn a_gable_is_two_planes_at_any_density_and_noise() {
    for detector in DETECTORS {
        for (density, sigma) in
            [(1.5, 0.02), (4.0, 0.05), (8.0, 0.0), (8.0, 0.03), (8.0, 0.1), (15.0, 0.02), (60.0, 0.03)]
        {
            for seed in 0..4 {
                let points = gable(&Scan { density, sigma, seed });
                let found = detect(&points, &with(detector), seed);
                let what = format!("{detector:?}, {density} points per square metre, σ {sigma}, seed {seed}");
                // The standard error of a slope of 67 m² with n points: about σ/(√n · 1.6 m).
                let degrees = 0.3 + 4.0 * (sigma / ((67.0 * density / 2.0).sqrt() * 1.6)).to_degrees();
                assert_planes(&what, &found, &GABLE, degrees, 0.02 + 0.3 * sigma);
                let explained = points.len() - found.unassigned.len();
                assert!(explained * 100 >= 97 * points.len(), "{what}: {explained} of {}", points.len());
            }
        }
    }
}

#[test]
fn image_matching_with_a_noise_of_30_cm_still_shows_a_gable() {
    for density in [4.0, 10.0, 25.0, 60.0] {
        let points = gable(&Scan { density, sigma: 0.3, seed: 5 });
        let found = detect(&points, &with(Detector::RegionGrowing), 0);
        assert_planes(&format!("density {density}"), &found, &GABLE, 6.0, 0.2);
        assert!((found.noise / 0.3 - 1.0).abs() < 0.3, "noise {}", found.noise);
    }
}

fn hip(x: f64, y: f64) -> f64 {
    3.0 + 0.7 * y.min(8.0 - y).min(x).min(14.0 - x)
}

fn mansard(_: f64, y: f64) -> f64 {
    let inward = y.min(10.0 - y);
    if inward < 2.0 { 3.0 + 1.8 * inward } else { 6.6 + 0.4 * (inward - 2.0) }
}

fn dormer(x: f64, y: f64) -> f64 {
    if (5.0..7.5).contains(&x) && (1.0..3.0).contains(&y) { 6.6 } else { 7.0 - (y - 4.0).abs() }
}

#[test]
fn hips_mansards_and_dormers_are_found_whole() {
    let hip_planes = [
        ([7.0, 2.0, 4.4], [0.0, 0.7]),
        ([7.0, 6.0, 4.4], [0.0, -0.7]),
        ([1.5, 4.0, 4.05], [0.7, 0.0]),
        ([12.5, 4.0, 4.05], [-0.7, 0.0]),
    ];
    let mansard_planes = [
        ([5.0, 1.0, 4.8], [0.0, 1.8]),
        ([5.0, 9.0, 4.8], [0.0, -1.8]),
        ([5.0, 3.5, 7.2], [0.0, 0.4]),
        ([5.0, 6.5, 7.2], [0.0, -0.4]),
    ];
    let dormer_planes = [GABLE[0], GABLE[1], ([6.25, 2.0, 6.6], [0.0, 0.0])];
    for detector in DETECTORS {
        for seed in 0..3 {
            let scan = Scan { density: 8.0, sigma: 0.025, seed };
            let run = |points: &[Point3<f64>]| detect(points, &with(detector), seed);
            let what = |roof: &str| format!("{roof}, {detector:?}, seed {seed}");
            assert_planes(&what("hip"), &run(&scan.of([14.0, 8.0], hip)), &hip_planes, 1.5, 0.04);
            assert_planes(&what("mansard"), &run(&scan.of([14.0, 10.0], mansard)), &mansard_planes, 1.5, 0.04);
            assert_planes(&what("dormer"), &run(&scan.of([12.0, 8.0], dormer)), &dormer_planes, 1.5, 0.04);
        }
    }
}

#[test]
fn the_slopes_of_two_wings_are_four_planes() {
    // Wings of 6 m along both axes; each has its ridge in the middle, and the higher surface is the roof.
    let roof = |x: f64, y: f64| {
        let along_x = if y < 6.0 { 6.0 - 0.8 * (y - 3.0).abs() } else { 0.0 };
        let along_y = if x < 6.0 { 6.0 - 0.8 * (x - 3.0).abs() } else { 0.0 };
        along_x.max(along_y)
    };
    let planes = [
        ([10.0, 1.5, 4.8], [0.0, 0.8]),
        ([10.0, 4.5, 4.8], [0.0, -0.8]),
        ([1.5, 10.0, 4.8], [0.8, 0.0]),
        ([4.5, 10.0, 4.8], [-0.8, 0.0]),
    ];
    let mut points = Scan { density: 8.0, sigma: 0.02, seed: 11 }.of([14.0, 14.0], roof);
    points.retain(|p| p.x < 6.0 || p.y < 6.0);
    for detector in DETECTORS {
        let found = detect(&points, &with(detector), 1);
        assert_planes(&format!("{detector:?}"), &found, &planes, 1.0, 0.03);
    }
}

#[test]
fn a_chimney_of_two_square_metres_is_found_on_a_flat_roof() {
    let roof = |x: f64, y: f64| {
        if (4.0..5.4).contains(&x) && (6.0..7.4).contains(&y) { 7.2 } else { 6.0 }
    };
    for seed in 0..5 {
        let points = Scan { density: 8.0, sigma: 0.02, seed }.of([12.0, 10.0], roof);
        let found = detect(&points, &with(Detector::RegionGrowing), 0);
        let planes = [([2.0, 2.0, 6.0], [0.0, 0.0]), ([4.6, 6.6, 7.2], [0.0, 0.0])];
        assert_planes(&format!("seed {seed}"), &found, &planes, 1e-9, 0.03);
    }
}

#[test]
fn a_step_of_30_cm_parts_two_flat_roofs_and_one_of_2_cm_does_not() {
    for detector in DETECTORS {
        for (sigma, seed) in [(0.0, 0), (0.02, 1), (0.04, 2), (0.08, 3)] {
            // RANSAC weighs a plane by all it catches: one tilted across both roofs wins once the noise is a quarter
            // of the step. Region growing stays on its side.
            if detector == Detector::Ransac && sigma > 0.05 {
                continue;
            }
            let step = |height: f64| {
                let points =
                    Scan { density: 8.0, sigma, seed }.of([16.0, 8.0], |x, _| if x < 8.0 { 5.0 } else { 5.0 + height });
                detect(&points, &with(detector), 0)
            };
            let what = format!("{detector:?}, σ {sigma}");
            let planes = [([4.0, 4.0, 5.0], [0.0, 0.0]), ([12.0, 4.0, 5.3], [0.0, 0.0])];
            assert_planes(&what, &step(0.3), &planes, 1e-9, 0.02 + 0.3 * sigma);
            assert_planes(&what, &step(0.02), &[([8.0, 4.0, 5.01], [0.0, 0.0])], 1e-9, 0.02);
        }
    }
}

#[test]
fn walls_in_a_dense_cloud_are_found_and_stand_upright() {
    let mut points = Scan { density: 20.0, sigma: 0.02, seed: 2 }.of([8.0, 6.0], |_, _| 5.0);
    let wall = Scan { density: 20.0, sigma: 0.02, seed: 3 }.of([8.0, 5.0], |_, _| 0.0);
    points.extend(wall.iter().map(|p| Point3::new(p.x, p.z, p.y)));
    let found = detect(&points, &with(Detector::RegionGrowing), 0);
    let [roof, wall] = &found.primitives[..] else { panic!("{:?}", found.primitives) };
    assert_eq!(roof.plane.normal.z, 1.0);
    assert_eq!(wall.plane.normal.z, 0.0);
    assert!(wall.plane.distance(&Point3::new(4.0, 0.0, 2.0)).abs() < 0.02);
}

#[test]
fn what_bears_no_plane_yields_no_primitive() {
    let p = |x: f64, y: f64, z: f64| Point3::new(x, y, z);
    let line: Vec<_> = (0..500).map(|i| p(f64::from(i) * 0.3, f64::from(i) * 0.1, 4.0)).collect();
    let wild = vec![p(f64::NAN, 0.0, 0.0), p(f64::INFINITY, 1.0, 1.0), p(0.0, f64::NEG_INFINITY, 0.0)];
    let cases = [
        ("empty", vec![]),
        ("one", vec![p(1.0, 2.0, 3.0)]),
        ("three", vec![p(0.0, 0.0, 0.0), p(1.0, 0.0, 0.0), p(0.0, 1.0, 0.0)]),
        ("line", line),
        ("identical", vec![p(85_000.25, 447_000.75, 3.5); 10_000]),
        ("not finite", wild),
    ];
    for detector in DETECTORS {
        for (name, points) in &cases {
            let found = detect(points, &with(detector), 9);
            assert!(found.primitives.is_empty(), "{name}: {:?}", found.primitives);
            assert_eq!(found.unassigned.len(), points.len(), "{name}");
            assert_eq!(found.normals.len(), points.len(), "{name}");
            assert!(found.noise.is_finite() && found.density.is_finite(), "{name}");
        }
    }
}

#[test]
fn parameters_out_of_range_do_no_harm() {
    let points = gable(&Scan { density: 8.0, sigma: 0.02, seed: 1 });
    for detector in DETECTORS {
        for value in [0.0, -5.0, 1e300] {
            let detection = DetectionParameters {
                detector,
                neighbours: if value > 0.0 { usize::MAX } else { 0 },
                noise_factor: value,
                minimum_tolerance: value,
                maximum_tolerance: value,
                normal_deviation: value,
                minimum_area: value,
                minimum_inliers: 0,
                maximum_density: value,
                probability: value,
                merge_angle: value,
                merge_tolerance: value,
                horizontal_slope: value,
                regularise_angle: value,
                regularise_tolerance: value,
            };
            detect(&points, &Parameters { detection, ..Parameters::default() }, 1);
        }
    }
}

#[test]
fn duplicates_share_the_primitive_of_their_twin() {
    let once = gable(&Scan { density: 8.0, sigma: 0.02, seed: 1 });
    let twice = [&once[..], &once[..]].concat();
    let (a, b) = (detect(&once, &Parameters::default(), 0), detect(&twice, &Parameters::default(), 0));
    assert_eq!(a.primitives.len(), b.primitives.len());
    for (a, b) in a.primitives.iter().zip(&b.primitives) {
        let n = once.len() as u32;
        let doubled: Vec<u32> = a.inliers.iter().copied().chain(a.inliers.iter().map(|i| i + n)).collect();
        assert_eq!(doubled, b.inliers);
        assert_eq!(a.plane, b.plane);
    }
}

/// A roof with gable, dormer and chimney, in the order in which it was scanned.
fn busy_roof(seed: u64, density: f64, sigma: f64) -> Vec<Point3<f64>> {
    Scan { density, sigma, seed }
        .of([12.0, 8.0], |x, y| if (9.0..10.2).contains(&x) && (4.5..5.7).contains(&y) { 8.0 } else { dormer(x, y) })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_order_of_the_points_does_not_matter(
        seed in 0u64..1_000, density in 2.0..30.0f64, sigma in 0.0..0.1f64, ransac in any::<bool>(),
    ) {
        let parameters = with(DETECTORS[usize::from(ransac)]);
        let points = busy_roof(seed, density, sigma);
        let found = detect(&points, &parameters, seed);
        prop_assert_eq!(&found, &detect(&points, &parameters, seed));

        let mut order: Vec<u32> = (0..points.len() as u32).collect();
        Random::new(seed).shuffle(&mut order);
        let shuffled: Vec<_> = order.iter().map(|&i| points[i as usize]).collect();
        let again = detect(&shuffled, &parameters, seed);
        prop_assert_eq!(found.primitives.len(), again.primitives.len());
        for (a, b) in found.primitives.iter().zip(&again.primitives) {
            prop_assert_eq!(a.plane, b.plane);
            prop_assert_eq!(&a.extent, &b.extent);
            let mut back: Vec<u32> = b.inliers.iter().map(|&i| order[i as usize]).collect();
            back.sort_unstable();
            prop_assert_eq!(&a.inliers, &back);
        }
    }

    #[test]
    fn every_point_is_in_one_primitive_near_its_plane_or_in_none(
        seed in 0u64..1_000, density in 0.5..40.0f64, sigma in 0.0..0.4f64, ransac in any::<bool>(),
    ) {
        let points = busy_roof(seed, density, sigma);
        let found = detect(&points, &with(DETECTORS[usize::from(ransac)]), seed);
        let mut seen: Vec<u32> = found.primitives.iter().flat_map(|p| p.inliers.iter().copied()).collect();
        seen.extend(&found.unassigned);
        seen.sort_unstable();
        prop_assert_eq!(seen, (0..points.len() as u32).collect::<Vec<_>>());
        let most = DetectionParameters::default().maximum_tolerance;
        for primitive in &found.primitives {
            prop_assert!(primitive.inliers.len() >= 5 && primitive.inliers.is_sorted());
            prop_assert!(primitive.residual <= most && primitive.plane.normal.z >= 0.0);
            let Extent::Patch(corners) = &primitive.extent else { panic!("a patch") };
            prop_assert!((3..=16).contains(&corners.len()));
            for corner in corners {
                prop_assert!(primitive.plane.distance(corner).abs() < 1e-9);
            }
            for &i in &primitive.inliers {
                prop_assert!(primitive.plane.distance(&points[i as usize]).abs() <= most);
            }
        }
        prop_assert!(found.primitives.is_sorted_by_key(|p| std::cmp::Reverse(p.inliers.len())));
    }
}

/// Points on all sides of a box of this size, with the same noise along every axis.
fn box_all_round(size: [f64; 3], count: usize, sigma: f64, seed: u64) -> Vec<Point3<f64>> {
    let mut random = Random::new(seed);
    let [a, b, c] = size;
    let areas = [a * b, a * c, b * c];
    let whole: f64 = areas.iter().sum();
    (0..count)
        .map(|_| {
            let mut place = random.unit() * whole;
            let axis = 2 - areas
                .iter()
                .take(2)
                .take_while(|area| {
                    let over = place > **area;
                    if over {
                        place -= **area;
                    }
                    over
                })
                .count();
            let side = if random.unit() < 0.5 { 0.0 } else { 1.0 };
            let at: [f64; 3] = std::array::from_fn(|i| size[i] * if i == axis { side } else { random.unit() });
            Point3::from(at) + Vector3::from_fn(|_, _| random.bell()) * sigma
        })
        .collect()
}

#[test]
fn a_scan_from_all_round_shows_its_six_planes_through_any_noise() {
    for sigma in [0.0, 0.02, 0.1, 0.3, 0.6] {
        for seed in 0..3 {
            let points = box_all_round([14.0, 10.0, 8.0], 15_000, sigma, seed);
            let found = detect(&points, &Parameters::default(), seed);
            assert!((found.noise - sigma).abs() < 0.25 * sigma + 0.02, "noise {} of {sigma}", found.noise);
            for (axis, size) in [14.0, 10.0, 8.0].into_iter().enumerate() {
                for side in [0.0, size] {
                    let mut middle = [7.0, 5.0, 4.0];
                    middle[axis] = side;
                    let near = found.primitives.iter().filter(|p| {
                        p.plane.normal[axis].abs() > 0.99
                            && p.plane.distance(&Point3::from(middle)).abs() < 0.01 + 0.3 * sigma
                    });
                    assert_eq!(near.count(), 1, "σ {sigma}, seed {seed}, axis {axis} at {side}");
                }
            }
            // What the noise adds is small.
            let rest: usize = found.primitives.iter().skip(6).map(|p| p.inliers.len()).sum();
            assert!(rest * 20 < points.len(), "σ {sigma}, seed {seed}: {rest} points on other planes");
        }
    }
}

#[test]
fn walls_that_stand_at_a_small_angle_stay_two() {
    // 7° between two walls of 5 m, the planes through their corner.
    let turn = 7f64.to_radians().tan();
    let mut random = Random::new(4);
    let points: Vec<Point3<f64>> = (0..3000)
        .map(|_| {
            let (x, z) = (10.0 * random.unit(), 6.0 * random.unit());
            let y = if x < 5.0 { 0.0 } else { (x - 5.0) * turn };
            Point3::new(x, y + 0.02 * (random.unit() - 0.5), z)
        })
        .collect();
    let found = detect(&points, &Parameters::default(), 0);
    assert_eq!(found.primitives.len(), 2);
    for primitive in &found.primitives {
        let most = primitive.inliers.iter().map(|&i| primitive.plane.distance(&points[i as usize]).abs());
        assert!(most.fold(0.0, f64::max) < 0.04);
    }
}
