//! Corners where roofs touch along an upright edge.

use super::*;

/// Extracts with a field that is sure of its labels, so that no cell may be given away.
fn certain(blocks: &[Block], shape: Shape, inside: &[bool]) -> Result<Extraction, SurfaceError> {
    let complex = complex(blocks, shape);
    let volumes: Vec<f64> = blocks.iter().map(|b| volume(b, &shape)).collect();
    let occupancy: Vec<f64> = inside.iter().map(|&label| f64::from(u8::from(label))).collect();
    let labelled = Labelled { complex: &complex, inside, occupancy: &occupancy, volumes: &volumes, fixed: &[] };
    extract(&labelled, STEP, &SurfaceParameters { minimum_feature: 0.0 })
}

fn inside_volume(blocks: &[Block], inside: &[bool]) -> f64 {
    blocks.iter().zip(inside).filter(|(_, inside)| **inside).map(|(block, _)| volume(block, &STRAIGHT)).sum()
}

#[test]
fn four_roofs_at_a_corner_keep_their_heights() {
    // Towers of 8, 3, 4 and 7 m, the high ones across from each other.
    let axis: &[i64] = &[0, 8, 16];
    let blocks = grid([axis, axis, &[0, 3, 4, 7, 8, 10]]);
    let height = |x: i64, y: i64| [[8, 3], [4, 7]][usize::from(x > 0)][usize::from(y > 0)];
    let inside = labels(&blocks, |x, y, z| z < height(x, y));
    let extraction = certain(&blocks, STRAIGHT, &inside).unwrap();
    assert_eq!((extraction.shells.len(), extraction.repairs), (1, 0));
    assert!(extraction.wedges >= 1);
    assert_eq!(extraction.inside, inside);
    let solid = &extraction.shells[0].solid;
    let faults = check(solid, &Tolerances::default());
    assert!(faults.is_empty(), "{faults:?}");
    // A wedge of 0.1 by 0.1 m, halved, over the 3 m between the roofs.
    let more = solid.volume() - inside_volume(&blocks, &inside);
    assert!((0.01..0.03).contains(&more), "{more}");
    // Ground, four roofs, four walls outside and four inside: the wedge is flush with the roof of 7 m and shows one side.
    assert_eq!(solid.faces.len(), 14);
}

#[test]
fn a_hall_of_many_heights_is_one_valid_solid() {
    let axis: Vec<i64> = (0..=8).map(|i| 8 * i).collect();
    let heights: Vec<i64> = (0..=8).collect();
    let blocks = grid([&axis, &axis, &heights]);
    let inside = labels(&blocks, |x, y, z| z < 2 + (x / 8 * 7 + y / 8 * 3) % 5);
    let extraction = certain(&blocks, STRAIGHT, &inside).unwrap();
    assert!(extraction.wedges > 5 && extraction.inside == inside, "{}", extraction.wedges);
    let [Shell { solid, .. }] = &extraction.shells[..] else { panic!("one shell") };
    let faults = check(solid, &Tolerances::default());
    assert!(faults.is_empty(), "{faults:?}");
    let more = solid.volume() - inside_volume(&blocks, &inside);
    assert!(more > 0.0 && more < 0.02 * 5.0 * extraction.wedges as f64, "{more}");
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn labels_that_are_certain_make_valid_shells_or_say_why(
        inside in prop::collection::vec(any::<bool>(), 64),
        oblique in any::<bool>(),
    ) {
        let shape = if oblique { OBLIQUE } else { STRAIGHT };
        match certain(&cube(4), shape, &inside) {
            Ok(extraction) => for shell in &extraction.shells {
                let faults = check(&shell.solid, &Tolerances::default());
                prop_assert!(faults.is_empty(), "{:?} {:?}", faults, shell.solid);
            },
            Err(SurfaceError::NonManifold { .. }) => {}
            Err(error) => return Err(TestCaseError::fail(error.to_string())),
        }
    }
}
