//! Solids of several shells and composites of several solids: 401 to 601.

use proptest::prelude::*;

use super::*;

/// Two pyramids on each other, looking into themselves: a square from 0 to `to` at half the height of the block.
fn spindle(to: [i64; 2]) -> Solid {
    let [x, y] = to;
    let corners = [[0, 0, 50], [x, 0, 50], [x, y, 50], [0, y, 50], [50, 50, 80], [50, 50, 20]];
    let mut faces: Vec<Vec<u32>> = Vec::new();
    for (a, b) in [(0, 1), (1, 2), (2, 3), (3, 0)] {
        faces.extend([vec![b, a, 4], vec![a, b, 5]]);
    }
    let faces = faces.into_iter().map(|ring| Face { rings: vec![ring], surface: 0 }).collect();
    Solid { faces, ..solid(&corners, &[]) }
}

#[test]
fn voids_401_402_403_404_405() {
    let shells = |voids: &[Solid]| {
        let mut shells = vec![cube()];
        shells.extend_from_slice(voids);
        let mut codes: Vec<u16> = solid::check_voids(&shells).iter().map(|f| f.fault.code).collect();
        codes.dedup();
        codes
    };
    let void = |from, to| block(from, to, true);
    let small = void([10; 3], [40; 3]);
    assert_eq!(shells(&[small.clone(), void([60; 3], [90; 3])]), NONE);
    // Through a wall; with a face on a wall; one in another; one that overlaps another.
    assert_eq!(shells(&[void([50, 10, 10], [120, 40, 40])]), [401]);
    assert_eq!(shells(&[void([50, 10, 10], [100, 40, 40])]), [401]);
    assert_eq!(shells(&[void([50, 10, 10], [99, 40, 40])]), NONE);
    assert_eq!(shells(&[small.clone(), void([20; 3], [30; 3])]), [401]);
    assert_eq!(shells(&[small.clone(), void([30; 3], [60; 3])]), [401]);
    // Corner to corner is fine, and so is edge to edge.
    assert_eq!(shells(&[small.clone(), void([40; 3], [60; 3])]), NONE);
    assert_eq!(shells(&[small.clone(), void([40, 40, 10], [60, 60, 40])]), NONE);
    assert_eq!(shells(&[small.clone(), small]), [402]);
    assert_eq!(shells(&[void([0; 3], [100; 3])]), [402]);
    assert_eq!(shells(&[void([200; 3], [240; 3])]), [403]);
    assert_eq!(shells(&[void([-10; 3], [110; 3])]), [403]);
    // A void that touches the four walls all around parts what is above from what is below; three walls do not.
    assert_eq!(shells(&[spindle([100, 100])]), [404]);
    assert_eq!(shells(&[spindle([99, 100])]), NONE);

    for (turned, expected) in [(false, vec![405]), (true, vec![])] {
        let void = block([10; 3], [40; 3], turned);
        let mut codes = Vec::new();
        let _ = visit(&void, Claim::Void, &Tolerances::default(), &mut |fault| {
            codes.push(fault.code);
            ControlFlow::Continue(())
        });
        assert_eq!(codes, expected);
    }
    assert!(check(&spindle([100, 100]), &Tolerances::default()).iter().all(|f| f.code == 405));
}

#[test]
fn composites_501_502_503_601() {
    let codes = |solids: &[Solid]| {
        let solids: Vec<Vec<Solid>> = solids.iter().map(|s| vec![s.clone()]).collect();
        composite::check(&solids, 0.001).iter().map(|f| f.fault.code).collect::<Vec<u16>>()
    };
    let beside = |x| block([x, 0, 0], [x + 100, 100, 100], false);
    assert_eq!(codes(&[cube(), beside(100)]), NONE);
    assert_eq!(codes(&[cube(), block([100, 20, 20], [200, 70, 70], false)]), NONE);
    assert_eq!(codes(&[cube(), beside(99)]), [501]);
    assert_eq!(codes(&[cube(), block([20; 3], [70; 3], false)]), [501]);
    assert_eq!(codes(&[cube(), cube()]), [502]);
    assert_eq!(codes(&[cube(), beside(101)]), [503]);
    // By an edge only.
    assert_eq!(codes(&[cube(), block([100, 100, 0], [200, 200, 100], false)]), [503]);
    assert_eq!(codes(&[cube(), beside(200), beside(100)]), NONE);
    // A block in the void of another touches it all around.
    let hollow = vec![cube(), block([20; 3], [70; 3], true)];
    let inside = |to| vec![block([20; 3], [to; 3], false)];
    assert_eq!(composite::check(&[hollow.clone(), inside(70)], 0.001), []);
    assert_eq!(composite::check(&[hollow, inside(71)], 0.001)[0].fault.code, 501);

    // Parts may overlap by what their rounding explains, in every direction and on a slant.
    for axis in 0..3 {
        for (steps, expected) in [(8, None), (20, Some(601))] {
            let mut other = cube();
            other.vertices.iter_mut().for_each(|v| v[axis] += 10_000 - steps);
            assert_eq!(composite::check_parts(&[cube()], &[other], 0.001).map(|_| 601), expected, "{axis}");
        }
    }
    for (steps, expected) in [(0, None), (9, None), (40, Some(601))] {
        // Two wedges that make a cube, one of them `steps` too high.
        let wedge = [[3, 2, 1, 0].as_slice(), &[0, 1, 5], &[3, 7, 2], &[0, 5, 7, 3], &[1, 2, 7, 5]];
        let faces: Vec<&[&[u32]]> = wedge.iter().map(std::slice::from_ref).collect();
        let mut lower = solid(&CUBE, &faces);
        lower.vertices[5] = [10_000, 0, 10_000];
        lower.vertices[7] = [0, 10_000, 0];
        // Its roof runs from the edge at x = 100, up, to the edge at x = 0, down.
        lower.vertices[7] = [10_000, 10_000, 10_000];
        lower.faces[2].rings[0] = vec![3, 7, 2];
        let mut upper =
            solid(&CUBE, &[&[&[0, 4, 7, 3]], &[&[4, 5, 6, 7]], &[&[0, 5, 4]], &[&[3, 7, 6]], &[&[0, 3, 6, 5]]]);
        assert_eq!((check(&lower, &Tolerances::default()), check(&upper, &Tolerances::default())), (vec![], vec![]));
        upper.vertices.iter_mut().for_each(|v| v[2] -= steps);
        assert_eq!(composite::check_parts(&[lower], &[upper], 0.001).map(|_| 601), expected, "{steps}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    /// Long blocks beside each other that share a slab, turned in the plan by a Pythagorean angle and of any size: the
    /// thickness of the slab is known.
    #[test]
    fn slabs_are_as_thick_as_they_are(
        (p, q, length) in prop_oneof![Just((1, 0, 1)), Just((3, 4, 5)), Just((-12, 5, 13)), Just((8, -15, 17)), Just((0, 1, 1))],
        shared in 0..6i64,
        decimals in 0..5i32,
        halves in 0..12i64,
        upright: bool,
    ) {
        let step = 10f64.powi(-decimals);
        let (u, v) = ([p, q, 0], [-q, p, 0]);
        // Along the thickness, the length and the height.
        let axes: [[i64; 3]; 3] = if upright { [u, v, [0, 0, length]] } else { [[0, 0, length], u, v] };
        let block = |from: i64, to: i64| {
            let corners = CUBE.map(|corner| {
                let along = [if corner[0] == 0 { from } else { to }, corner[1], corner[2]];
                std::array::from_fn(|i| (0..3).map(|k| axes[k][i] * along[k]).sum())
            });
            Solid { step: [step; 3], vertices: corners.to_vec(), ..solid(&[], &CUBE_FACES) }
        };
        let (one, other) = (block(0, 50), block(50 - shared, 100));
        let unit = length as f64 * step;
        let found = composite::check_parts(&[one], &[other], halves as f64 / 2.0 * unit);
        prop_assert_eq!(found.is_some(), 2 * shared > halves, "{:?}", found);
        if let Some(found) = found {
            prop_assert!(found.depth <= shared as f64 * unit * (1.0 + 1e-9));
        }
    }
}
