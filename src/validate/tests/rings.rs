//! Rings and polygons: 101 to 208.

use super::*;

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
fn a_fold_is_one_however_lenient_planarity_is() {
    // A face that falls by 2 mm within 2 mm, in the middle of a metre: planar to 1 cm, and yet it turns by 45°.
    let mut folded = cube();
    folded.step = [1e-6; 3];
    folded.vertices.iter_mut().flatten().for_each(|c| *c *= 100);
    let across = [[1_000_000, 499_000, 1_001_000], [1_000_000, 501_000, 999_000]];
    folded.vertices.extend(across);
    folded.vertices.extend(across.iter().rev().map(|&[_, y, z]| [0, y, z]));
    folded.faces[1].rings[0] = vec![4, 5, 8, 9, 6, 7, 10, 11];
    folded.faces[3].rings[0] = vec![1, 2, 6, 9, 8, 5];
    folded.faces[5].rings[0] = vec![3, 0, 4, 11, 10, 7];
    for planarity in [0.01, 0.001_5] {
        let found = check(&folded, &Tolerances { planarity, ..Tolerances::default() });
        assert_eq!(found.iter().map(|f| (f.code, f.place)).collect::<Vec<_>>(), [(204, Place::Face(1))], "{planarity}");
    }
}

#[test]
fn rounding_explains_a_fold_where_it_is_forgiven() {
    // A notch whose tip ends a step of the grid before the opposite edge of the roof, and a step too high: 45° of nothing.
    let mut rounded = cube();
    let plan = [[4_000, 0], [6_000, 0], [5_000, 9_999]];
    rounded.vertices.extend([0, 10_000].iter().flat_map(|&z| plan.map(|[x, y]| [x, y, z])));
    rounded.vertices[13][2] += 1;
    let rings: [&[u32]; 9] = [
        &[3, 2, 1, 9, 10, 8, 0],
        &[4, 11, 13, 12, 5, 6, 7],
        &[0, 8, 11, 4],
        &[9, 1, 5, 12],
        &[8, 10, 13, 11],
        &[10, 9, 12, 13],
        &[1, 2, 6, 5],
        &[2, 3, 7, 6],
        &[3, 0, 4, 7],
    ];
    rounded.faces = rings.iter().map(|ring| Face { rings: vec![ring.to_vec()], surface: 0 }).collect();
    assert_eq!(check(&rounded, &Tolerances::default()), []);
    let written = check(&rounded, &Tolerances::written());
    assert_eq!(written.iter().map(|f| (f.code, f.place)).collect::<Vec<_>>(), [(204, Place::Face(1))]);
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
