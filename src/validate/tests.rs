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
