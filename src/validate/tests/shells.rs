//! Shells: 301 to 307, and which way they face.

use super::*;

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
