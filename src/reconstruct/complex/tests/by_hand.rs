use nalgebra::Point3;

use super::super::{Complex, ComplexError, Fault, IntegerPlane, OUTSIDE, insertion_order};
use super::{arrangement, counts, cube, depth, everywhere, primitive, rectangle, volumes};
use crate::geometry::Aabb;
use crate::reconstruct::primitives::{Extent, PrimitiveKind};

#[test]
fn the_box_alone() {
    let complex = Complex::adaptive(&[], &cube(0.0, 2.0)).unwrap();
    assert_eq!(counts(&complex), (1, 6, 8));
    assert!((complex.cell_volume(0) - 8.0).abs() < 1e-12);
    assert!((complex.cell_centroid(0) - Point3::new(1.0, 1.0, 1.0)).norm() < 1e-12);
    assert!(complex.touches_box(0) && complex.neighbours(0).next().is_none());
}

#[test]
fn one_plane() {
    let complex = Complex::adaptive(&[everywhere([0.0, 0.0, 0.5], [0.0, 0.0, 1.0])], &cube(0.0, 2.0)).unwrap();
    assert_eq!(counts(&complex), (2, 11, 12));
    assert_eq!(volumes(&complex), [2.0, 6.0]);
    let (facet, above) = complex.neighbours(0).next().unwrap();
    assert_eq!((above, complex.facets[facet as usize].cells), (1, [0, 1]));
    assert_eq!(complex.across(facet, 1), 0);
    // Counter-clockwise seen from above.
    assert!((complex.facet_area_vector(facet) - nalgebra::Vector3::new(0.0, 0.0, 4.0)).norm() < 1e-12);
    assert!((complex.facet_area(facet) - 4.0).abs() < 1e-12);
    assert_eq!(complex.cell_aabb(1), Aabb { min: [0.0, 0.0, 0.5], max: [2.0, 2.0, 2.0] });
    assert!((complex.cell_centroid(1) - Point3::new(1.0, 1.0, 1.25)).norm() < 1e-12);
    assert!((complex.median_volume() - 6.0).abs() < 1e-12);
}

#[test]
fn two_and_three_crossing_planes() {
    let mut planes = vec![everywhere([1.0; 3], [1.0, 0.0, 0.0]), everywhere([1.0; 3], [0.0, 1.0, 0.0])];
    let complex = Complex::adaptive(&planes, &cube(0.0, 3.0)).unwrap();
    assert_eq!(counts(&complex), (4, 20, 18));
    assert_eq!(volumes(&complex), [3.0, 6.0, 6.0, 12.0]);
    planes.push(everywhere([1.0; 3], [0.0, 0.0, 1.0]));
    let complex = Complex::adaptive(&planes, &cube(0.0, 3.0)).unwrap();
    assert_eq!(counts(&complex), (8, 36, 27));
    // The middle is one vertex of twelve facets.
    let middle = complex.vertices.iter().position(|v| v.homogeneous == [1, 1, 1, 1]).unwrap() as u32;
    assert_eq!(complex.facets.iter().filter(|f| f.corners.contains(&middle)).count(), 12);
}

#[test]
fn planes_that_only_touch_do_not_cut() {
    for (point, normal) in [
        ([0.0, 0.0, 0.0], [1.0, 1.0, 1.0]),
        ([0.0, 0.0, 0.0], [1.0, 1.0, 0.0]),
        ([0.0, 0.0, 2.0], [0.0, 0.0, -1.0]),
        ([0.0, 0.0, 2.5], [0.0, 0.0, 1.0]),
        ([9.0, 9.0, 9.0], [0.1, 0.2, 0.3]),
    ] {
        let complex = Complex::adaptive(&[everywhere(point, normal)], &cube(0.0, 2.0)).unwrap();
        assert_eq!(counts(&complex), (1, 6, 8), "{point:?} {normal:?}");
    }
}

#[test]
fn planes_through_edges_and_corners_make_no_new_vertex() {
    // Along two opposite edges: two prisms.
    let diagonal = everywhere([0.0; 3], [1.0, -1.0, 0.0]);
    let complex = Complex::adaptive(&[diagonal], &cube(0.0, 2.0)).unwrap();
    assert_eq!(counts(&complex), (2, 9, 8));
    // Through three corners: a tetrahedron of 1/6 and the rest.
    let complex = arrangement(&[IntegerPlane::reduced([1, 1, 1], -1).0], &cube(0.0, 1.0));
    assert_eq!(counts(&complex), (2, 10, 8));
    assert!((volumes(&complex)[0] - 1.0 / 6.0).abs() < 1e-15);
    // All six diagonal planes of a cube: 24 congruent tetrahedra, and one vertex in the middle for all of them.
    let diagonals =
        [[1, 1, 0], [1, -1, 0], [1, 0, 1], [1, 0, -1], [0, 1, 1], [0, 1, -1]].map(|n| IntegerPlane::reduced(n, 0).0);
    let complex = arrangement(&diagonals, &cube(-1.0, 1.0));
    // Corners 8, face centres 6, centre 1; facets 24 on the box, 36 inside.
    assert_eq!(counts(&complex), (24, 60, 15));
    assert!(volumes(&complex).iter().all(|v| (v - 1.0 / 3.0).abs() < 1e-15));
}

#[test]
fn many_planes_through_a_point_or_a_line_have_the_known_number_of_cells() {
    // On the moment curve any three normals are independent: n² − n + 2 regions.
    let pencil: Vec<_> = (1..=12).map(|i| IntegerPlane::reduced([1, i, i * i], 0).0).collect();
    assert_eq!(counts(&arrangement(&pencil, &cube(-1.0, 1.0))).0, 12 * 12 - 12 + 2);
    let fan: Vec<_> = (-8..=8).map(|i| IntegerPlane::reduced([1, i, 0], 0).0).collect();
    assert_eq!(counts(&arrangement(&fan, &cube(-1.0, 1.0))).0, 2 * 17);
}

#[test]
fn a_plane_given_twice_is_one_plane() {
    let (up, down) = (everywhere([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]), everywhere([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]));
    let floor = everywhere([0.0; 3], [0.0, 0.0, 1.0]);
    let complex = Complex::adaptive(&[up, down, floor], &cube(0.0, 2.0)).unwrap();
    assert_eq!(counts(&complex), (2, 11, 12));
    let planes: Vec<_> = complex.primitive_planes.iter().map(|p| (p.plane, p.flipped)).collect();
    // The third is the bottom of the box.
    assert_eq!(planes, [(6, false), (6, true), (4, false)]);
}

#[test]
fn a_patch_cuts_only_the_cells_that_it_meets_and_a_shared_facet_is_cut_once() {
    let wall = rectangle([2.0, 2.0, 2.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]);
    let left = rectangle([1.0, 2.0, 1.0], [0.9, 0.0, 0.0], [0.0, 1.9, 0.0]);
    let right = rectangle([3.0, 2.0, 1.0], [0.9, 0.0, 0.0], [0.0, 1.9, 0.0]);
    let complex = Complex::adaptive(&[left.clone(), wall.clone()], &cube(0.0, 4.0)).unwrap();
    // The wall has two facets on its left and, to the right, one cell with seven facets.
    assert_eq!(counts(&complex).0, 3);
    assert_eq!(volumes(&complex), [8.0, 24.0, 32.0]);
    let right_cell = (0..3).find(|&cell| complex.cell_volume(cell) > 30.0).unwrap();
    assert_eq!(complex.cells[right_cell as usize].facets.len(), 7);
    let complex = Complex::adaptive(&[left, right, wall], &cube(0.0, 4.0)).unwrap();
    assert_eq!(counts(&complex), (4, 20, 18));
}

#[test]
fn a_patch_that_ends_at_a_wall_stops_there_and_one_outside_the_box_cuts_nothing() {
    let wall = rectangle([2.0, 2.0, 2.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0]);
    let short = rectangle([1.0, 2.0, 1.0], [0.999, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let long = rectangle([1.0, 2.0, 1.0], [1.001, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let away = rectangle([8.0, 2.0, 3.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let cells = |roof| Complex::adaptive(&[wall.clone(), roof, away.clone()], &cube(0.0, 4.0)).unwrap().cells.len();
    assert_eq!((cells(short), cells(long)), (3, 4));
}

#[test]
fn exhaustive_cuts_where_adaptive_does_not() {
    let patches = [
        rectangle([1.0, 1.0, 1.0], [0.0, 0.5, 0.0], [0.0, 0.0, 0.5]),
        rectangle([3.0, 3.0, 1.0], [0.5, 0.0, 0.0], [0.0, 0.0, 0.5]),
        rectangle([3.0, 1.0, 2.0], [0.5, 0.0, 0.0], [0.0, 0.5, 0.0]),
    ];
    let bounds = cube(0.0, 4.0);
    assert_eq!(counts(&Complex::exhaustive(&patches, &bounds).unwrap()), (8, 36, 27));
    assert_eq!(counts(&Complex::adaptive(&patches, &bounds).unwrap()).0, 4);
}

#[test]
fn order_is_everywhere_then_walls_then_support() {
    let wall = |kind, y: f64, half: f64, tilt: f64| {
        let mut wall = rectangle([0.0, y, 0.0], [half, 0.0, 0.0], [0.0, tilt, 1.0]);
        wall.kind = kind;
        wall
    };
    let roof = |support: u32, half: f64| {
        let mut roof = rectangle([0.0; 3], [half, 0.0, 0.3], [0.0, 1.0, 0.0]);
        roof.inliers = (0..support).collect();
        roof
    };
    let primitives = [
        roof(5, 1.0),
        wall(PrimitiveKind::Detected, 0.0, 9.0, 0.0),
        roof(8, 1.0),
        roof(5, 2.0),
        wall(PrimitiveKind::HeightJump, 1.0, 5.0, 0.0),
        wall(PrimitiveKind::FootprintEdge, 2.0, 1.0, 0.0),
        wall(PrimitiveKind::FootprintEdge, 3.0, 2.0, 1e-9),
        wall(PrimitiveKind::Detected, 4.0, 99.0, 0.05),
        everywhere([0.0; 3], [0.0, 0.0, 1.0]),
        // Steep, but no wall; and without inliers.
        rectangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.9]),
    ];
    assert_eq!(insertion_order(&primitives), [8, 6, 5, 4, 1, 7, 2, 3, 0, 9]);
}

#[test]
fn faults_of_the_input_are_named() {
    let error = |primitives: &[_], bounds: &Aabb| Complex::adaptive(primitives, bounds).unwrap_err();
    for (min, max) in [(0.0, 0.0), (1.0, 0.0), (0.0, 9000.0), (f64::NAN, 1.0), (0.0, f64::INFINITY)] {
        assert!(matches!(error(&[], &cube(min, max)), ComplexError::Bounds { .. }), "{min} {max}");
    }
    let far = everywhere([1e5; 3], [1.0, 1.0, 1.0]);
    assert_eq!(error(&[far], &cube(0.0, 1.0)), ComplexError::Plane { primitive: 0 });
    let two = primitive([0.0; 3], [0.0, 0.0, 1.0], Extent::Patch(vec![Point3::origin(); 2]));
    assert_eq!(error(&[two], &cube(0.0, 1.0)), ComplexError::Patch { primitive: 0, corners: 2 });
    let planes: Vec<_> = (1..9).map(|i| everywhere([0.0, 0.0, f64::from(i)], [0.0, 0.0, 1.0])).collect();
    let stopped = Complex::adaptive_within(&planes, &cube(0.0, 9.0), 5).unwrap_err();
    assert_eq!(stopped, ComplexError::TooManyCells { limit: 5, inserted: 4, total: 8 });
    assert_eq!(stopped.to_string(), "more than 5 cells after 4 of 8 primitives");
}

#[test]
fn samples_are_inside_and_uniform() {
    let slope = everywhere([0.0, 0.0, 1.0], [0.0, -1.0, 1.0]);
    let complex = Complex::adaptive(&[slope], &cube(0.0, 4.0)).unwrap();
    let median = complex.median_volume();
    for cell in 0..2 {
        let volume = complex.cell_volume(cell);
        let samples = complex.samples(cell, median, 7);
        assert_eq!(samples.len(), 1 + (8.0 + 8.0 * volume / median).clamp(8.0, 32.0) as usize);
        assert_eq!(samples[0], complex.cell_centroid(cell));
        assert!(samples.iter().all(|p| depth(&complex, cell, p) > 0.0));
        assert_eq!(samples, complex.samples(cell, median, 7));
        assert_ne!(samples, complex.samples(cell, median, 8));
        // The mean over many seeds is the centroid: the standard deviation of a coordinate is about 1 m, that of the
        // mean of 4 000 seeds of at least 8 samples below 6 mm.
        let drawn: Vec<_> = (0..4000).flat_map(|seed| complex.samples(cell, median, seed).split_off(1)).collect();
        let mean = drawn.iter().fold(nalgebra::Vector3::zeros(), |sum, p| sum + p.coords) / drawn.len() as f64;
        assert!((mean - samples[0].coords).norm() < 0.03, "{mean} {}", samples[0]);
    }
    // A box: the share of samples in a corner octant, shrunk by 5 %, is 1/8.
    let complex = Complex::adaptive(&[], &cube(0.0, 2.0)).unwrap();
    let drawn: Vec<_> = (0..2000).flat_map(|seed| complex.samples(0, 8.0, seed).split_off(1)).collect();
    let corner = drawn.iter().filter(|p| p.iter().all(|&c| c < 1.0)).count() as f64 / drawn.len() as f64;
    assert!((corner - 0.125).abs() < 0.006, "{corner}");
    let spread = drawn.iter().map(|p| (p.x - 1.0).powi(2)).sum::<f64>() / drawn.len() as f64;
    assert!((spread - 0.95 * 0.95 / 3.0).abs() < 0.01, "{spread}");
}

#[test]
fn every_facet_on_the_box_leads_outside() {
    let complex = Complex::adaptive(&[everywhere([1.0; 3], [1.0, 2.0, 3.0])], &cube(0.0, 2.0)).unwrap();
    counts(&complex);
    let area: f64 = (0..complex.facets.len() as u32)
        .filter(|&f| complex.facets[f as usize].cells.contains(&OUTSIDE))
        .map(|f| complex.facet_area(f))
        .sum();
    assert!((area - 24.0).abs() < 1e-9);
}

#[test]
fn the_checker_finds_what_is_wrong() {
    let planes = [everywhere([1.0; 3], [1.0, 2.0, 3.0]), everywhere([1.0; 3], [2.0, -1.0, 1.0])];
    let sound = Complex::adaptive(&planes, &cube(0.0, 2.0)).unwrap();
    let fault = |spoil: &dyn Fn(&mut Complex)| {
        let mut spoilt = sound.clone();
        spoil(&mut spoilt);
        spoilt.check().unwrap_err()
    };
    let inner = sound.facets.iter().position(|f| f.plane == 6).unwrap();
    let id = inner as u32;
    let cell = sound.facets[inner].cells[0];
    assert_eq!(fault(&|c| c.planes.push(c.planes[0])), Fault::Duplicate("planes"));
    assert_eq!(fault(&|c| c.vertices.push(c.vertices[0])), Fault::Duplicate("vertices"));
    assert!(
        matches!(fault(&|c| c.facets[inner].corners.rotate_left(1)), Fault::NotOnPlane { facet, .. } if facet == id)
    );
    let clockwise = |c: &mut Complex| {
        c.facets[inner].corners.reverse();
        c.facets[inner].edges.reverse();
        c.facets[inner].edges.rotate_left(1);
    };
    assert_eq!(fault(&clockwise), Fault::NotConvex { facet: id });
    assert_eq!(fault(&|c| c.cells[cell as usize].facets.retain(|&f| f != id)), Fault::Neighbours { facet: id });
    assert_eq!(fault(&|c| c.facets[inner].cells[0] = OUTSIDE), Fault::Box { facet: id });
    assert!(matches!(fault(&|c| c.facets[inner].cells.reverse()), Fault::CellNotConvex { facet, .. } if facet == id));
    // A facet that is missing on both sides, as if it had never been there.
    let last = sound.facets.len() as u32 - 1;
    let lost = |c: &mut Complex| {
        c.facets.pop();
        for cell in &mut c.cells {
            cell.facets.retain(|&f| f != last);
        }
    };
    assert!(matches!(fault(&lost), Fault::Open { .. }));
}
