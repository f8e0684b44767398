use nalgebra::{Point3, Vector3};
use proptest::prelude::*;
use proptest::strategy::ValueTree;
use proptest::test_runner::TestRunner;

use super::super::{Complex, IntegerPlane, OUTSIDE};
use super::{arrangement, cube, depth, rectangle};
use crate::geometry::Plane;
use crate::reconstruct::primitives::{Extent, Primitive, PrimitiveKind};

/// Planes with small integers: many are parallel, equal, or share points and lines with others and with the box.
fn small_plane() -> impl Strategy<Value = IntegerPlane> {
    ([-2_i64..=2, -2_i64..=2, -2_i64..=2], -3_i64..=3)
        .prop_filter("a normal", |&(normal, _)| normal != [0; 3])
        .prop_map(|(normal, offset)| IntegerPlane::reduced(normal, offset).0)
}

/// Planes that differ from each other by a few steps of the grid: slivers of a micrometre, where floating point is of
/// no use.
fn near_plane() -> impl Strategy<Value = IntegerPlane> {
    const ONE: i64 = 1 << 20;
    (0..3_usize, [-3_i64..=3, -3_i64..=3, -3_i64..=0], -1_i64..=1, -3_i64..=3).prop_map(
        |(axis, turn, metres, shift)| {
            let mut normal = [turn[0], turn[1], turn[0] - turn[1]];
            normal[axis] = ONE + turn[2];
            IntegerPlane::reduced(normal, metres * ONE + shift).0
        },
    )
}

fn coordinate() -> impl Strategy<Value = f64> {
    prop_oneof![(-4_i32..=4).prop_map(f64::from), -4.0..4.0]
}

/// Rectangles with whole and with arbitrary coordinates, some of them upright, some beyond the box.
fn random_patch() -> impl Strategy<Value = Primitive> {
    let vector = || [coordinate(), coordinate(), coordinate()];
    (vector(), vector(), vector(), any::<bool>(), 0..3_u32).prop_filter_map(
        "a rectangle",
        |(centre, u, v, upright, kind)| {
            let (u, v) = (Vector3::from(u), Vector3::from(v));
            let u = if upright { Vector3::new(u.x, u.y, 0.0) } else { u };
            let v = if upright { Vector3::z() } else { v };
            (u.cross(&v).norm() > 0.1).then(|| {
                let mut patch = rectangle(centre, (u / 2.0).into(), (v / 2.0).into());
                let kinds = [PrimitiveKind::Detected, PrimitiveKind::FootprintEdge, PrimitiveKind::HeightJump];
                patch.kind = kinds[kind as usize];
                patch
            })
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    #[test]
    fn degenerate_planes_fill_the_box(planes in prop::collection::vec(prop_oneof![2 => small_plane(), 1 => near_plane()], 1..14)) {
        let complex = arrangement(&planes, &cube(-2.0, 2.0));
        prop_assert_eq!(complex.check(), Ok(()));
        // No cell is cut by any plane, and the facets of a plane cover its whole section of the box.
        let mut distinct = planes;
        distinct.sort_unstable();
        distinct.dedup();
        for (id, plane) in complex.planes.iter().enumerate().skip(6) {
            for cell in 0..complex.cells.len() as u32 {
                let sides: Vec<_> =
                    complex.cell_vertices(cell).iter().map(|&v| plane.side(&complex.vertices[v as usize])).collect();
                prop_assert!(!sides.iter().any(|s| s.is_lt()) || !sides.iter().any(|s| s.is_gt()));
            }
            let area: f64 = (0..complex.facets.len() as u32)
                .filter(|&f| complex.facets[f as usize].plane as usize == id)
                .map(|f| complex.facet_area(f))
                .sum();
            let alone = arrangement(&[*plane], &cube(-2.0, 2.0));
            let section: f64 = (0..alone.facets.len() as u32)
                .filter(|&f| alone.facets[f as usize].plane == 6)
                .map(|f| alone.facet_area(f))
                .sum();
            prop_assert!((area - section).abs() < 1e-9, "{} {}", area, section);
        }
        // The order of insertion changes ids only.
        distinct.reverse();
        let reversed = arrangement(&distinct, &cube(-2.0, 2.0));
        prop_assert_eq!(reversed.cells.len(), complex.cells.len());
        prop_assert_eq!(reversed.facets.len(), complex.facets.len());
        prop_assert_eq!(reversed.vertices.len(), complex.vertices.len());
    }

    #[test]
    fn every_patch_lies_on_facets(patches in prop::collection::vec(random_patch(), 1..16)) {
        let complex = Complex::adaptive(&patches, &cube(-3.0, 3.0)).unwrap();
        prop_assert_eq!(complex.check(), Ok(()));
        for (patch, at) in patches.iter().zip(&complex.primitive_planes) {
            let Extent::Patch(corners) = &patch.extent else { unreachable!() };
            let plane = complex.planes[at.plane as usize].to_plane();
            let same = plane.normal.dot(&patch.plane.normal) > 0.0;
            prop_assert_eq!(same, !at.flipped);
            for (s, t) in (0..5).flat_map(|s| (0..5).map(move |t| (f64::from(s) / 4.0, f64::from(t) / 4.0))) {
                let point: Point3<f64> = corners[0] + (corners[1] - corners[0]) * s + (corners[3] - corners[0]) * t;
                let point = point - plane.normal.into_inner() * plane.distance(&point);
                for cell in 0..complex.cells.len() as u32 {
                    let depth = depth(&complex, cell, &point);
                    prop_assert!(depth < 1e-6, "{} is {} deep in cell {}", point, depth, cell);
                }
            }
        }
        // Everywhere and exhaustive are the same; adaptive never has more cells.
        let open: Vec<_> = patches.iter().map(|p| Primitive { extent: Extent::Everywhere, ..p.clone() }).collect();
        let everywhere = Complex::adaptive(&open, &cube(-3.0, 3.0)).unwrap();
        let exhaustive = Complex::exhaustive(&patches, &cube(-3.0, 3.0)).unwrap();
        prop_assert_eq!(everywhere.cells.len(), exhaustive.cells.len());
        prop_assert!(complex.cells.len() <= exhaustive.cells.len());
        // The same again is the same to the bit.
        let again = Complex::adaptive(&patches, &cube(-3.0, 3.0)).unwrap();
        prop_assert_eq!(&again.vertices, &complex.vertices);
        prop_assert_eq!(&again.facets, &complex.facets);
        prop_assert_eq!(&again.cells, &complex.cells);
        let inside = complex.facets.iter().filter(|f| !f.cells.contains(&OUTSIDE)).count();
        let sides: usize = (0..complex.cells.len() as u32).map(|cell| complex.neighbours(cell).count()).sum();
        prop_assert_eq!(sides, 2 * inside);
    }

    #[test]
    fn samples_lie_in_their_cell(patches in prop::collection::vec(random_patch(), 1..10), seed in any::<u64>()) {
        let complex = Complex::adaptive(&patches, &cube(-3.0, 3.0)).unwrap();
        let median = complex.median_volume();
        for cell in 0..complex.cells.len() as u32 {
            let least = if complex.cell_volume(cell) < 1e-9 { -1e-9 } else { 0.0 };
            for point in complex.samples(cell, median, seed) {
                prop_assert!(depth(&complex, cell, &point) > least);
            }
        }
    }
}

#[test]
fn a_thousand_random_primitives_go_through() {
    let mut runner = TestRunner::deterministic();
    let patches: Vec<_> = (0..1000)
        .map(|_| {
            let mut patch = random_patch().new_tree(&mut runner).unwrap().current();
            let shift = [-40.0..40.0, -40.0..40.0, -40.0..40.0].new_tree(&mut runner).unwrap().current();
            if let Extent::Patch(corners) = &mut patch.extent {
                for corner in &mut *corners {
                    *corner += Vector3::from(shift);
                }
                patch.plane = Plane::through(&corners[0], patch.plane.normal);
            }
            patch
        })
        .collect();
    let complex = Complex::adaptive(&patches, &cube(-40.0, 40.0)).unwrap();
    assert_eq!(complex.check(), Ok(()));
    assert!((1_000..100_000).contains(&complex.cells.len()), "{}", complex.cells.len());
}
