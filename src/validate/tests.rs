use super::*;
use crate::solid::Face;

/// A solid of single-ring faces unless more rings are given; coordinates in centimetres.
fn solid(vertices: &[[i64; 3]], faces: &[&[&[u32]]]) -> Solid {
    Solid {
        step: [1e-4; 3],
        vertices: vertices.iter().map(|v| v.map(|c| c * 100)).collect(),
        faces: faces
            .iter()
            .map(|rings| Face { rings: rings.iter().map(|r| r.to_vec()).collect(), surface: 0 })
            .collect(),
        surfaces: Vec::new(),
    }
}

const CUBE: [[i64; 3]; 8] =
    [[0, 0, 0], [100, 0, 0], [100, 100, 0], [0, 100, 0], [0, 0, 100], [100, 0, 100], [100, 100, 100], [0, 100, 100]];
const CUBE_FACES: [&[&[u32]]; 6] =
    [&[&[3, 2, 1, 0]], &[&[4, 5, 6, 7]], &[&[0, 1, 5, 4]], &[&[1, 2, 6, 5]], &[&[2, 3, 7, 6]], &[&[3, 0, 4, 7]]];

fn cube() -> Solid {
    solid(&CUBE, &CUBE_FACES)
}

/// A block with a vertical shaft through it: vertices 8 to 15 are the shaft's, bottom then top.
fn courtyard() -> Solid {
    let mut vertices = CUBE.to_vec();
    for z in [0, 100] {
        vertices.extend([[30, 30, z], [70, 30, z], [70, 70, z], [30, 70, z]]);
    }
    let mut faces: Vec<&[&[u32]]> = CUBE_FACES.to_vec();
    faces[0] = &[&[3, 2, 1, 0], &[8, 9, 10, 11]];
    faces[1] = &[&[4, 5, 6, 7], &[15, 14, 13, 12]];
    let walls: [&[&[u32]]; 4] = [&[&[9, 8, 12, 13]], &[&[10, 9, 13, 14]], &[&[11, 10, 14, 15]], &[&[8, 11, 15, 12]]];
    faces.extend(walls);
    solid(&vertices, &faces)
}

const NONE: [u16; 0] = [];

fn codes(solid: &Solid) -> Vec<u16> {
    let mut codes: Vec<u16> = check(solid, &Tolerances::default()).iter().map(|f| f.code).collect();
    codes.sort_unstable();
    codes.dedup();
    codes
}

/// A face alone: only the codes of rings and polygons.
fn face_codes(vertices: &[[i64; 3]], rings: &[&[u32]]) -> Vec<u16> {
    codes(&solid(vertices, &[rings])).into_iter().filter(|c| *c < 300).collect()
}

#[test]
fn sound_solids_have_no_faults() {
    assert_eq!(check(&cube(), &Tolerances::default()), []);
    assert_eq!(check(&courtyard(), &Tolerances::default()), []);
    assert!((courtyard().volume() - 0.84).abs() < 1e-12);
}

#[test]
fn rings_101_102_104() {
    let square = [[0, 0, 0], [100, 0, 0], [100, 100, 0], [0, 100, 0], [0, 50, 0], [50, 0, 0]];
    assert_eq!(face_codes(&square, &[&[0, 1, 2, 3]]), NONE);
    assert_eq!(face_codes(&square, &[&[0, 1]]), [101]);
    assert_eq!(face_codes(&square, &[&[0, 1, 1, 2, 3]]), [102]);
    // A bow tie; a spike; a ring that touches itself; a line.
    assert_eq!(face_codes(&square, &[&[0, 1, 3, 2]]), [104]);
    assert_eq!(face_codes(&square, &[&[0, 1, 2, 1, 2, 3]]), [104]);
    assert_eq!(face_codes(&square, &[&[0, 5, 1, 2, 3, 4]]), NONE);
    assert_eq!(face_codes(&square, &[&[0, 5, 1, 2, 5, 3]]), [104]);
    assert_eq!(face_codes(&square, &[&[0, 5, 1]]), [104]);
    // A vertex that does not exist is not a crash.
    assert_eq!(face_codes(&square, &[&[0, 1, 99]]), [101]);
    assert_eq!(codes(&solid(&square, &[&[]])), [101]);

    // Half a millimetre apart is the same point; two millimetres are not.
    let mut near = cube();
    for (steps, expected) in [(5, vec![102]), (20, vec![])] {
        near.vertices.truncate(8);
        near.vertices.push([steps, 0, 0]);
        near.faces[0].rings[0] = vec![3, 2, 1, 8, 0];
        near.faces[2].rings[0] = vec![0, 8, 1, 5, 4];
        assert_eq!(codes(&near), expected);
    }
}

#[test]
fn polygons_201_202_205_206_207_208() {
    let points = [
        [0, 0, 0],
        [100, 0, 0],
        [100, 100, 0],
        [0, 100, 0],
        // 4..: a small square inside, 8..: one farther right that overlaps it, 12..: one outside, 16..: one in 4..
        [20, 20, 0],
        [60, 20, 0],
        [60, 60, 0],
        [20, 60, 0],
        [40, 30, 0],
        [80, 30, 0],
        [80, 50, 0],
        [40, 50, 0],
        [200, 0, 0],
        [230, 0, 0],
        [230, 30, 0],
        [200, 30, 0],
        [30, 30, 0],
        [50, 30, 0],
        [50, 50, 0],
        [30, 50, 0],
        // 20..: the middles of the sides
        [50, 0, 0],
        [100, 50, 0],
        [50, 100, 0],
        [0, 50, 0],
        // 24..: a square beside 4.. that shares a corner with it, 27..
        [80, 80, 0],
        [60, 80, 0],
        [80, 60, 0],
    ];
    let outer: &[u32] = &[0, 1, 2, 3];
    let case = |holes: &[&[u32]]| {
        let mut rings = vec![outer];
        rings.extend(holes);
        face_codes(&points, &rings)
    };
    assert_eq!(case(&[&[7, 6, 5, 4]]), NONE);
    assert_eq!(case(&[&[7, 6, 5, 4], &[11, 10, 9, 8]]), [201]);
    // A hole whose side lies on the exterior's.
    assert_eq!(case(&[&[0, 7, 20]]), [201]);
    assert_eq!(case(&[&[7, 6, 5, 4], &[6, 5, 4, 7]]), [202]);
    assert_eq!(case(&[&[15, 14, 13, 12]]), [206]);
    assert_eq!(case(&[&[7, 6, 5, 4], &[19, 18, 17, 16]]), [207]);
    assert_eq!(case(&[&[4, 5, 6, 7]]), [208]);
    // Touching at one point is fine, at two cuts the face in pieces; so do four holes in a ring, but not two in a row.
    assert_eq!(case(&[&[20, 7, 6]]), NONE);
    assert_eq!(case(&[&[20, 22, 6]]), [205]);
    assert_eq!(case(&[&[7, 6, 5, 4], &[6, 25, 24, 26]]), NONE);
    assert_eq!(case(&[&[23, 22, 21, 20]]), [205]);
}

#[test]
fn polygons_203_204() {
    // One corner of a roof lifted out of its plane: by 2 mm it is not planar, by 1 mm it is.
    for (lift, expected) in [(4, vec![]), (60, vec![203])] {
        let mut bent = cube();
        bent.vertices[6][2] += lift;
        assert_eq!(codes(&bent), expected, "{lift}");
    }
    // A strip 3 mm wide along an edge, folded by 0.9 mm per 3 mm: planar within tolerance, yet 17° (or 31°) steep.
    for (width, lift, expected) in [(30, 5, vec![]), (15, 9, vec![204])] {
        let mut folded = cube();
        folded.vertices.extend([[width, 0, 10_000], [width, 10_000, 10_000]]);
        folded.vertices[4][2] += lift;
        folded.vertices[7][2] += lift;
        folded.faces[1].rings[0] = vec![4, 8, 5, 6, 9, 7];
        folded.faces[2].rings[0] = vec![0, 1, 5, 8, 4];
        folded.faces[4].rings[0] = vec![2, 3, 7, 9, 6];
        assert_eq!(codes(&folded), expected, "{width}");
    }
}

#[test]
fn shells_301_302_303_305_307() {
    let mut few = cube();
    few.faces.truncate(3);
    assert_eq!(codes(&few), [301, 302]);
    let mut open = cube();
    open.faces.remove(1);
    assert_eq!(codes(&open), [302]);

    // Two cubes that share an edge, then a vertex, then nothing.
    for (offset, expected) in [([100, 100, 0], vec![303, 306]), ([100, 100, 100], vec![303]), ([300, 0, 0], vec![305])]
    {
        let mut two = cube();
        let mut names = Vec::new();
        for v in CUBE {
            let v: [i64; 3] = std::array::from_fn(|i| (v[i] + offset[i]) * 100);
            let at = two.vertices.iter().position(|w| *w == v).unwrap_or_else(|| {
                two.vertices.push(v);
                two.vertices.len() - 1
            });
            names.push(at as u32);
        }
        for rings in CUBE_FACES {
            let rings = rings.iter().map(|r| r.iter().map(|&v| names[v as usize]).collect()).collect();
            two.faces.push(Face { rings, surface: 0 });
        }
        let found = codes(&two);
        assert!(found.iter().all(|c| expected.contains(c)) && found[0] == expected[0], "{found:?}");
    }

    let mut flipped = cube();
    flipped.faces[3].rings[0].reverse();
    assert_eq!(codes(&flipped), [307]);
}

#[test]
fn shell_306() {
    // A notch whose tip reaches the opposite wall, stops before it, or comes out behind it.
    for (depth, expected) in [(50, vec![]), (99, vec![]), (100, vec![306]), (120, vec![306])] {
        let mut vertices = CUBE.to_vec();
        vertices.extend([[0, 40, 0], [0, 40, 100], [0, 60, 0], [0, 60, 100], [depth, 50, 0], [depth, 50, 100]]);
        let faces: [&[&[u32]]; 9] = [
            &[&[3, 2, 1, 0, 8, 12, 10]],
            &[&[4, 5, 6, 7, 11, 13, 9]],
            &[&[0, 1, 5, 4]],
            &[&[1, 2, 6, 5]],
            &[&[2, 3, 7, 6]],
            &[&[8, 0, 4, 9]],
            &[&[12, 8, 9, 13]],
            &[&[10, 12, 13, 11]],
            &[&[3, 10, 11, 7]],
        ];
        let found = codes(&solid(&vertices, &faces));
        if depth < 100 {
            assert_eq!(found, expected);
        } else {
            // The floor and the ceiling intersect themselves too.
            assert!(found == [104] || found == expected, "{found:?}");
        }
    }
    // The tip of a pyramid-shaped pit touches the floor, goes through it, or ends above it.
    for (tip, expected) in [(10, vec![]), (0, vec![306]), (-10, vec![306])] {
        let mut vertices = CUBE.to_vec();
        vertices.push([50, 40, tip]);
        let mut faces: Vec<&[&[u32]]> = CUBE_FACES.to_vec();
        let pit: [&[&[u32]]; 4] = [&[&[4, 5, 8]], &[&[5, 6, 8]], &[&[6, 7, 8]], &[&[7, 4, 8]]];
        faces.splice(1..2, pit);
        assert_eq!(codes(&solid(&vertices, &faces)), expected, "{tip}");
    }
}

#[test]
fn solid_405() {
    let mut inward = courtyard();
    inward.faces.iter_mut().flat_map(|f| &mut f.rings).for_each(|ring| ring.reverse());
    assert_eq!(codes(&inward), [405]);
}

#[test]
fn a_repeated_vertex_opens_no_shell() {
    let mut twice = cube();
    twice.vertices.push(twice.vertices[0]);
    twice.faces[0].rings[0] = vec![3, 2, 1, 0, 8];
    assert_eq!(codes(&twice), [102]);
    // A wall of no width between two others, along an edge and back.
    let mut collapsed = cube();
    collapsed.vertices.push(collapsed.vertices[0]);
    collapsed.faces.push(Face { rings: vec![vec![0, 8, 4]], surface: 0 });
    assert_eq!(codes(&collapsed), [102]);
    collapsed.faces[6].rings[0] = vec![0, 8, 0];
    assert_eq!(codes(&collapsed), [102]);
}

#[test]
fn the_walk_stops_where_it_is_told_to() {
    let tolerances = Tolerances::default();
    assert!(is_valid(&cube(), &tolerances) && first_fault(&cube(), &tolerances).is_none());
    let mut faulty = cube();
    faulty.faces[5].rings[0].truncate(2);
    faulty.faces[1].rings[0].truncate(2);
    let all = check(&faulty, &tolerances);
    assert!(all.len() > 2 && !is_valid(&faulty, &tolerances));
    assert_eq!(first_fault(&faulty, &tolerances), Some(all[0].clone()));
    assert_eq!(all[0].place, Place::Ring(1, 0));
}

#[test]
fn surfaces_may_be_open_but_not_torn() {
    let codes = |solid: &Solid, claim| {
        let mut codes = Vec::new();
        let _ = visit(solid, claim, &Tolerances::default(), &mut |fault| {
            codes.push(fault.code);
            ControlFlow::Continue(())
        });
        codes
    };
    let mut open = cube();
    open.faces.truncate(3);
    // Floor and ceiling hang together by the wall.
    assert_eq!((codes(&open, Claim::Surface), codes(&open, Claim::Faces)), (vec![], vec![]));
    open.faces.truncate(2);
    assert_eq!((codes(&open, Claim::Surface), codes(&open, Claim::Faces)), (vec![305], vec![]));
    let mut flipped = cube();
    flipped.faces.truncate(3);
    flipped.faces[2].rings[0].reverse();
    assert_eq!(codes(&flipped, Claim::Surface), [307, 307]);
}

/// A box in centimetres; the faces of a void look into it.
fn block(from: [i64; 3], to: [i64; 3], void: bool) -> Solid {
    let corners = CUBE.map(|v| std::array::from_fn(|i| if v[i] == 0 { from[i] } else { to[i] }));
    let mut block = solid(&corners, &CUBE_FACES);
    if void {
        turn(&mut block);
    }
    block
}

fn turn(solid: &mut Solid) {
    solid.faces.iter_mut().flat_map(|f| &mut f.rings).for_each(|ring| ring.reverse());
}

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

#[test]
fn labels_801_to_805() {
    use crate::solid::SurfaceType::{Ground, OuterCeiling, Roof, Wall};
    use semantics::Label;
    let known = |kinds: [crate::solid::SurfaceType; 6]| kinds.map(Label::Known);
    let codes = |shell: &Solid, labels: &[Label]| {
        let mut shell = shell.clone();
        shell.faces.iter_mut().zip(0..).for_each(|(face, i)| face.surface = i);
        let label = |face: &Face| labels.get(face.surface as usize).copied().unwrap_or(Label::Known(Wall));
        let faults = semantics::check(&shell, label);
        faults.into_iter().chain(semantics::check_ground(&shell, label)).map(|f| f.code).collect::<Vec<_>>()
    };
    let right = known([Ground, Roof, Wall, Wall, Wall, Wall]);
    assert_eq!(codes(&cube(), &right), NONE);
    assert_eq!(codes(&courtyard(), &right), NONE);
    let mut labels = right;
    labels[3] = Label::None;
    assert_eq!(codes(&cube(), &labels), [801]);
    labels[3] = Label::Other;
    assert_eq!(codes(&cube(), &labels), NONE);
    assert_eq!(codes(&cube(), &known([Ground, Roof, Roof, Wall, Wall, Wall])), [802]);
    assert_eq!(codes(&cube(), &known([Roof, Roof, Wall, Wall, Wall, Wall])), [802]);
    assert_eq!(codes(&cube(), &known([Wall, Roof, Wall, Wall, Wall, Wall])), [803]);
    assert_eq!(codes(&cube(), &known([OuterCeiling, Roof, Wall, Wall, Wall, Wall])), NONE);
    assert_eq!(codes(&cube(), &known([Ground, OuterCeiling, Wall, Wall, Wall, Wall])), [804]);
    assert_eq!(codes(&cube(), &known([Ground, Roof, Wall, Ground, Wall, Wall])), [804]);
    // A bridge: two feet on the ground, a ceiling between them.
    let profile = [[0, 0], [30, 0], [30, 50], [70, 50], [70, 0], [100, 0], [100, 90], [0, 90]];
    let mut vertices = Vec::new();
    for y in [0, 50] {
        vertices.extend(profile.map(|[x, z]| [x, y, z]));
    }
    let sides: Vec<Vec<u32>> = (0..8).map(|i| vec![(i + 1) % 8, i, i + 8, (i + 1) % 8 + 8]).collect();
    let mut bridge = solid(&vertices, &[&[&[0, 1, 2, 3, 4, 5, 6, 7]], &[&[15, 14, 13, 12, 11, 10, 9, 8]]]);
    bridge.faces.extend(sides.into_iter().map(|ring| Face { rings: vec![ring], surface: 0 }));
    assert_eq!(check(&bridge, &Tolerances::default()), []);
    let [g, c, r, w] = [Ground, OuterCeiling, Roof, Wall].map(Label::Known);
    assert_eq!(codes(&bridge, &[w, w, g, w, c, w, g, w, r, w]), [805]);
    assert_eq!(codes(&bridge, &[w, w, c, w, c, w, g, w, r, w]), NONE);
}

mod mutations;
