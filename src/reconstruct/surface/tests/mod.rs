mod planes;
mod wedges;

use proptest::prelude::*;

use super::boxes::{Block, MICRO, OBLIQUE, STRAIGHT, Shape, complex, grid, subdivide, volume};
use super::*;
use crate::validate::{Tolerances, check};

const STEP: [f64; 3] = [1e-4; 3];

fn run(blocks: &[Block], shape: Shape, inside: &[bool], minimum_feature: f64) -> Result<Extraction, SurfaceError> {
    let complex = complex(blocks, shape);
    let volumes: Vec<f64> = blocks.iter().map(|b| volume(b, &shape)).collect();
    let labelled = Labelled { complex: &complex, inside, occupancy: &[], volumes: &volumes, fixed: &[] };
    extract(&labelled, STEP, &SurfaceParameters { minimum_feature })
}

/// Extracts, and checks that every shell is valid and that together they hold exactly the inside cells.
fn extracted(blocks: &[Block], shape: Shape, inside: &[bool]) -> Extraction {
    let extraction = run(blocks, shape, inside, 0.0).unwrap();
    verify(blocks, shape, &extraction);
    extraction
}

fn verify(blocks: &[Block], shape: Shape, extraction: &Extraction) {
    for shell in &extraction.shells {
        let faults = check(&shell.solid, &Tolerances::default());
        assert!(faults.is_empty(), "{faults:?}\n{:#?}", shell.solid);
        assert!(shell.solid.faces.iter().all(|f| (f.surface as usize) < shell.planes.len()));
    }
    let cells: f64 = blocks.iter().zip(&extraction.inside).filter(|(_, i)| **i).map(|(b, _)| volume(b, &shape)).sum();
    let shells: f64 = extraction.shells.iter().map(|s| s.solid.volume()).sum();
    assert!((cells - shells).abs() < 1e-3 * cells.max(1.0), "cells {cells}, shells {shells}");
}

/// Labels of the unit boxes of a grid by their lowest corner.
fn labels(blocks: &[Block], inside: impl Fn(i64, i64, i64) -> bool) -> Vec<bool> {
    blocks.iter().map(|[[x, y, z], _]| inside(*x, *y, *z)).collect()
}

fn cube(n: i64) -> Vec<Block> {
    let axis: Vec<i64> = (0..=n).collect();
    grid([&axis, &axis, &axis])
}

/// Faces, vertices and holes of the only shell.
fn counts(extraction: &Extraction) -> (usize, usize, usize) {
    assert_eq!(extraction.shells.len(), 1);
    let solid = &extraction.shells[0].solid;
    (solid.faces.len(), solid.vertices.len(), solid.faces.iter().map(|f| f.rings.len() - 1).sum())
}

#[test]
fn boxes_glued_in_all_ways() {
    for shape in [STRAIGHT, OBLIQUE] {
        let blocks = cube(3);
        let case = |inside: &dyn Fn(i64, i64, i64) -> bool| extracted(&blocks, shape, &labels(&blocks, inside));
        // One cube; the whole box; a step; a stair of three.
        assert_eq!(counts(&case(&|x, y, z| (x, y, z) == (1, 1, 1))), (6, 8, 0));
        assert_eq!(counts(&case(&|_, _, _| true)), (6, 8, 0));
        assert_eq!(counts(&case(&|x, _, z| x < 2 && z == 0 || x == 0)), (8, 12, 0));
        assert_eq!(counts(&case(&|x, _, z| x + z < 3)), (10, 16, 0));
        // A courtyard and a tunnel: four more walls, a hole on both sides.
        assert_eq!(counts(&case(&|x, y, _| (x, y) != (1, 1))), (10, 16, 2));
        assert_eq!(counts(&case(&|x, _, z| (x, z) != (1, 1))), (10, 16, 2));
        // A chimney in the middle of a roof, and a pit: one hole.
        assert_eq!(counts(&case(&|x, y, z| z < 2 || (x, y) == (1, 1))), (11, 16, 1));
        assert_eq!(counts(&case(&|x, y, z| z < 2 || (x, y) != (1, 1))), (11, 16, 1));
        // A cavity is filled.
        let filled = case(&|x, y, z| (x, y, z) != (1, 1, 1));
        assert_eq!(counts(&filled), (6, 8, 0));
        assert_eq!(filled.repairs, 1);
    }
}

#[test]
fn parts_that_touch_along_an_edge_or_at_a_vertex_are_solids_of_their_own() {
    let blocks = cube(2);
    for inside in [labels(&blocks, |x, y, z| z == 0 && x == y), labels(&blocks, |x, y, z| x == y && y == z)] {
        for shape in [STRAIGHT, OBLIQUE] {
            let extraction = extracted(&blocks, shape, &inside);
            assert_eq!((extraction.shells.len(), extraction.repairs), (2, 0));
            assert!(extraction.shells.iter().all(|s| s.solid.faces.len() == 6));
        }
    }
}

#[test]
fn a_part_that_touches_itself_is_repaired_by_the_cheapest_cell() {
    // Two towers on one base touch along an edge. Cell (0, 1) on top is the smallest of the four around it.
    let blocks = grid([&[0, 4, 6], &[0, 4, 7], &[0, 2, 4]]);
    let inside = labels(&blocks, |x, y, z| z == 0 || (x == 0) == (y == 0));
    let extraction = extracted(&blocks, STRAIGHT, &inside);
    assert_eq!(extraction.repairs, 1);
    let smallest = blocks.iter().position(|b| b[0] == [4, 4, 2]).unwrap();
    assert!(inside[smallest] && !extraction.inside[smallest]);

    // A block with two opposite corners of its middle taken away touches itself at a vertex.
    let blocks = cube(2);
    let inside = labels(&blocks, |x, y, z| !(x == y && y == z));
    let extraction = extracted(&blocks, OBLIQUE, &inside);
    assert_eq!((extraction.shells.len(), extraction.repairs), (1, 1));

    // With every cell fixed there is no way out, and that is said.
    let complex = complex(&blocks, STRAIGHT);
    let fixed: Vec<_> = inside.iter().map(|&i| Some(i)).collect();
    let labelled = Labelled { complex: &complex, inside: &inside, occupancy: &[], volumes: &[], fixed: &fixed };
    let error = extract(&labelled, STEP, &SurfaceParameters::default()).unwrap_err();
    assert_eq!(error, SurfaceError::NonManifold { at: [1.0; 3] });
}

#[test]
fn occupancy_decides_which_cell_gives_way() {
    // Of two equal outside cells, the one with the higher occupancy is filled.
    let blocks = cube(2);
    let inside = labels(&blocks, |x, y, z| z == 0 || x == y);
    let complex = complex(&blocks, STRAIGHT);
    let volumes = vec![1.0; 8];
    for favourite in [[0, 1, 1], [1, 0, 1]] {
        let occupancy: Vec<f64> = blocks
            .iter()
            .zip(&inside)
            .map(|(b, &i)| if b[0] == favourite { 0.45 } else { f64::from(u8::from(i)) })
            .collect();
        let labelled =
            Labelled { complex: &complex, inside: &inside, occupancy: &occupancy, volumes: &volumes, fixed: &[] };
        let extraction = extract(&labelled, STEP, &SurfaceParameters::default()).unwrap();
        let changed: Vec<_> = (0..8).filter(|&i| extraction.inside[i] != inside[i]).collect();
        assert_eq!(changed, [blocks.iter().position(|b| b[0] == favourite).unwrap()]);
    }
}

#[test]
fn a_neighbour_that_is_cut_leaves_no_junction() {
    // The upper half is cut in three, the lower half is one cell: its upper edges get the vertices of the steps only.
    let blocks: Vec<Block> =
        vec![[[0, 0, 0], [9, 9, 3]], [[0, 0, 3], [3, 9, 6]], [[3, 0, 3], [6, 9, 6]], [[6, 0, 3], [9, 9, 6]]];
    for shape in [STRAIGHT, OBLIQUE] {
        assert_eq!(counts(&extracted(&blocks, shape, &[true, true, true, true])), (6, 8, 0));
        assert_eq!(counts(&extracted(&blocks, shape, &[true, true, true, false])), (8, 12, 0));
        assert_eq!(counts(&extracted(&blocks, shape, &[true, false, true, false])), (10, 16, 0));
        assert_eq!(counts(&extracted(&blocks, shape, &[true, true, false, true])), (10, 16, 0));
    }
}

#[test]
fn slivers_between_nearly_equal_planes_vanish() {
    // Planes 1 µm apart along every axis; only the slabs between them differ in label.
    let axis = [0, 4_000_000, 4_000_001, 9_000_000];
    let blocks = grid([&axis, &axis, &axis]);
    for mask in 0..8u32 {
        let inside = labels(&blocks, |x, y, z| {
            [x, y, z].iter().enumerate().all(|(i, c)| *c == 0 || (*c == 4_000_000 && mask >> i & 1 == 1))
                || (x, y, z) == (4_000_000, 0, 0)
        });
        let extraction = extracted(&blocks, MICRO, &inside);
        assert_eq!(counts(&extraction), (6, 8, 0), "mask {mask}: {:?}", extraction.shells[0].solid);
    }
    // A fin of 1 µm on a roof, a slot of 1 µm in it, and one that cuts a block in two.
    for inside in
        [labels(&blocks, |x, _, z| z == 0 || x == 4_000_000), labels(&blocks, |x, _, z| z == 0 || x != 4_000_000)]
    {
        let extraction = extracted(&blocks, MICRO, &inside);
        assert_eq!(counts(&extraction), (6, 8, 0));
    }
    let halves = extracted(&blocks, MICRO, &labels(&blocks, |x, _, _| x != 4_000_000));
    assert_eq!((counts(&halves), halves.slivers), ((6, 8, 0), 9));
}

#[test]
fn a_step_of_a_fraction_of_a_millimetre_is_welded() {
    // Steps below and above the millimetre that validators take for nothing.
    for (step, faces) in [(300, 6), (900, 6), (1_500, 8), (20_000, 8)] {
        let blocks = grid([&[0, 5_000_000, 9_000_000], &[0, 7_000_000], &[0, 3_000_000, 3_000_000 + step, 6_000_000]]);
        let inside = labels(&blocks, |x, _, z| z == 0 || (z == 3_000_000 && x == 0));
        let extraction = run(&blocks, MICRO, &inside, 0.0).unwrap();
        for shell in &extraction.shells {
            assert_eq!(check(&shell.solid, &Tolerances::default()), []);
        }
        // Welding leaves a fold of less than a millimetre in a roof of two planes.
        let expected = if faces == 6 { 7 } else { 8 };
        assert!(extraction.shells[0].solid.faces.len() <= expected, "{step}");
    }
}

#[test]
fn features_below_the_minimum_are_removed_and_others_stay() {
    // A roof at 3 m; a slab above it; a fin 6 m high and a slot 3 m deep, each of the same thickness.
    let case = |thickness: i64| {
        let x = [0, 2_000_000, 2_000_000 + thickness, 5_000_000, 5_000_000 + thickness, 9_000_000, 12_000_000];
        let blocks = grid([&x, &[0, 7_000_000], &[0, 3_000_000, 9_000_000]]);
        let fin_and_slot =
            labels(&blocks, |x, _, z| x < 9_000_000 && (z == 0 && x != 5_000_000 || z == 3_000_000 && x == 2_000_000));
        run(&blocks, MICRO, &fin_and_slot, 0.1).inspect(|extraction| verify(&blocks, MICRO, extraction))
    };
    let gone = case(90_000).unwrap();
    assert_eq!((gone.features, counts(&gone)), (2, (6, 8, 0)));
    let kept = case(110_000).unwrap();
    assert_eq!((kept.features, kept.shells.len()), (0, 2));

    // A step of 8 cm across a roof goes, to the side that the occupancy favours; one of 12 cm stays.
    for (step, favour, expected) in [(80_000, 0.6, 1), (80_000, 0.4, 1), (120_000, 0.6, 0)] {
        let blocks = grid([&[0, 4_000_000, 9_000_000], &[0, 7_000_000], &[0, 3_000_000, 3_000_000 + step, 9_000_000]]);
        let inside = labels(&blocks, |x, _, z| z == 0 || (z == 3_000_000 && x == 0));
        let complex = complex(&blocks, MICRO);
        let volumes: Vec<f64> = blocks.iter().map(|b| volume(b, &MICRO)).collect();
        let occupancy: Vec<f64> = blocks
            .iter()
            .zip(&inside)
            .map(|(b, &i)| if b[0][2] == 3_000_000 { favour } else { f64::from(u8::from(i)) })
            .collect();
        let fixed: Vec<Option<bool>> = blocks.iter().map(|b| (b[0][2] > 3_000_000).then_some(false)).collect();
        let labelled =
            Labelled { complex: &complex, inside: &inside, occupancy: &occupancy, volumes: &volumes, fixed: &fixed };
        let extraction = extract(&labelled, STEP, &SurfaceParameters::default()).unwrap();
        assert_eq!(extraction.features, expected);
        let thin = |x: i64| extraction.inside[blocks.iter().position(|b| b[0] == [x, 0, 3_000_000]).unwrap()];
        match (expected, favour > 0.5) {
            (0, _) => assert_eq!((thin(0), thin(4_000_000)), (true, false)),
            (_, up) => assert_eq!((thin(0), thin(4_000_000)), (up, up)),
        }
    }
}

/// Either a valid surface of the relabelled cells, or an explained error.
fn valid_or_explained(blocks: &[Block], shape: Shape, inside: &[bool]) -> Result<(), TestCaseError> {
    let extraction = match run(blocks, shape, inside, 0.0) {
        Ok(extraction) => extraction,
        Err(SurfaceError::NonManifold { .. }) => return Ok(()),
        Err(error) => return Err(TestCaseError::fail(error.to_string())),
    };
    let changed = inside.iter().zip(&extraction.inside).filter(|(a, b)| a != b).count();
    prop_assert_eq!(changed, extraction.repairs);
    let cells: f64 = blocks.iter().zip(&extraction.inside).filter(|(_, i)| **i).map(|(b, _)| volume(b, &shape)).sum();
    let shells: f64 = extraction.shells.iter().map(|s| s.solid.volume()).sum();
    prop_assert!((cells - shells).abs() < 1e-3 * cells.max(1.0), "cells {}, shells {}", cells, shells);
    for shell in &extraction.shells {
        let faults = check(&shell.solid, &Tolerances::default());
        prop_assert!(faults.is_empty(), "{:?} {:?}", faults, shell.solid);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_labels_of_a_grid(inside in prop::collection::vec(any::<bool>(), 64), oblique in any::<bool>()) {
        valid_or_explained(&cube(4), if oblique { OBLIQUE } else { STRAIGHT }, &inside)?;
    }

    #[test]
    fn random_labels_of_a_random_partition(
        cuts in prop::collection::vec((0usize..1000, 0usize..3, 0i64..1000), 0..60),
        labels in prop::collection::vec(any::<bool>(), 61),
        oblique in any::<bool>(),
    ) {
        let blocks = subdivide(16, &cuts);
        let shape = if oblique { OBLIQUE } else { STRAIGHT };
        valid_or_explained(&blocks, shape, &labels[..blocks.len()])?;
    }
}
