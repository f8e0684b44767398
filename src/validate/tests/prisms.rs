//! Random shells with holes, rings that touch and edges inside faces, against a look at each of their smallest pieces.

use std::collections::{BTreeMap, BTreeSet};

use proptest::prelude::*;

use super::*;

/// Squares of the plan along x and along y, each cut into four triangles at its middle; and layers of prisms over them.
const SQUARES: i64 = 2;
const LAYERS: i64 = 2;
const CELLS: usize = (SQUARES * SQUARES * LAYERS * 4) as usize;

type Corner = [i64; 3];

/// The faces between the prisms that are inside and the others, each as it looks outwards.
fn pieces(inside: &[bool]) -> Vec<Vec<Corner>> {
    let mut found: BTreeMap<BTreeSet<Corner>, Option<Vec<Corner>>> = BTreeMap::new();
    for cell in (0..CELLS as i64).filter(|&cell| inside[cell as usize]) {
        let (quarter, square, layer) = (cell % 4, cell / 4 % (SQUARES * SQUARES), cell / 4 / (SQUARES * SQUARES));
        let [x, y] = [2 * (square % SQUARES), 2 * (square / SQUARES)];
        let around = [[x, y], [x + 2, y], [x + 2, y + 2], [x, y + 2]];
        let at = |i: i64| around[(i % 4) as usize];
        let plan = [at(quarter), at(quarter + 1), [x + 1, y + 1]];
        let [low, high] = [layer, layer + 1].map(|z| plan.map(|[x, y]| [x, y, z]));
        let mut faces = vec![vec![low[2], low[1], low[0]], high.to_vec()];
        faces.extend([(0, 1), (1, 2), (2, 0)].map(|(a, b)| vec![low[a], low[b], high[b], high[a]]));
        for face in faces {
            let key = face.iter().copied().collect();
            // What two prisms share is inside.
            found.entry(key).and_modify(|known| *known = None).or_insert(Some(face));
        }
    }
    found.into_values().flatten().collect()
}

fn sides(face: &[Corner]) -> impl Iterator<Item = [Corner; 2]> + '_ {
    face.iter().copied().zip(face.iter().copied().cycle().skip(1)).map(|(a, b)| [a, b])
}

/// Numbers of sets of things that hang together, by pairs of things that do.
fn groups(count: usize, pairs: impl IntoIterator<Item = (usize, usize)>) -> Vec<usize> {
    let mut set: Vec<usize> = (0..count).collect();
    for (a, b) in pairs {
        let (from, to) = (set[a].max(set[b]), set[a].min(set[b]));
        set.iter_mut().filter(|s| **s == from).for_each(|s| *s = to);
    }
    set
}

/// Whether two pieces have each edge, and those at each corner hang together by its edges.
fn is_manifold(pieces: &[Vec<Corner>]) -> bool {
    let mut at_edge: BTreeMap<[Corner; 2], Vec<usize>> = BTreeMap::new();
    for (i, piece) in pieces.iter().enumerate() {
        for [a, b] in sides(piece) {
            at_edge.entry([a.min(b), a.max(b)]).or_default().push(i);
        }
    }
    if at_edge.values().any(|pieces| pieces.len() != 2) {
        return false;
    }
    let corners: BTreeSet<Corner> = pieces.iter().flatten().copied().collect();
    corners.into_iter().all(|corner| {
        let joints = at_edge.iter().filter(|(ends, _)| ends.contains(&corner)).map(|(_, two)| (two[0], two[1]));
        let set = groups(pieces.len(), joints);
        let here: BTreeSet<usize> =
            (0..pieces.len()).filter(|&i| pieces[i].contains(&corner)).map(|i| set[i]).collect();
        here.len() == 1
    })
}

fn normal(face: &[Corner]) -> Corner {
    let [u, v]: [Corner; 2] = [1, 2].map(|k| std::array::from_fn(|i| face[k][i] - face[0][i]));
    let n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    // Of the lengths of such normals only the directions are asked for: all are 0, 1 or −1.
    n.map(i64::signum)
}

fn dot(a: Corner, b: Corner) -> i64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

/// The pieces of one plane that look the same way and hang together as polygons, with all corners on their rings.
fn merged(pieces: &[Vec<Corner>]) -> Solid {
    let plane = |face: &[Corner]| (normal(face), dot(normal(face), face[0]));
    let mut of_side: BTreeMap<(Corner, i64, [Corner; 2]), usize> = BTreeMap::new();
    for (i, piece) in pieces.iter().enumerate() {
        let (n, d) = plane(piece);
        of_side.extend(sides(piece).map(|side| ((n, d, side), i)));
    }
    let twin = |&(n, d, [a, b]): &(Corner, i64, [Corner; 2])| of_side.get(&(n, d, [b, a])).copied();
    let set = groups(pieces.len(), of_side.iter().filter_map(|(side, &i)| Some((i, twin(side)?))));
    let mut borders: BTreeMap<usize, Vec<[Corner; 2]>> = BTreeMap::new();
    for (side, &i) in of_side.iter().filter(|(side, _)| twin(side).is_none()) {
        borders.entry(set[i]).or_default().push(side.2);
    }
    let corners: Vec<Corner> = pieces.iter().flatten().copied().collect::<BTreeSet<_>>().into_iter().collect();
    let mut solid = solid(&corners.iter().map(|c| c.map(|c| 20 * c)).collect::<Vec<_>>(), &[]);
    for (first, border) in borders {
        let mut rings = rings(border, normal(&pieces[first]));
        // The exterior is the ring that turns like the face: the others are holes.
        let turns = |ring: &Vec<Corner>| {
            let twice: Corner = sides(ring).fold([0; 3], |sum, [a, b]| {
                let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
                std::array::from_fn(|i| sum[i] + n[i])
            });
            dot(twice, normal(&pieces[first])) < 0
        };
        rings.sort_by_key(turns);
        let index = |c: &Corner| corners.binary_search(c).unwrap() as u32;
        let rings = rings.iter().map(|ring| ring.iter().map(index).collect()).collect();
        solid.faces.push(Face { rings, surface: 0 });
    }
    solid
}

/// The rings of a border. Where it touches itself it goes on along the same side of what is outside, so that each ring is
/// simple.
fn rings(mut border: Vec<[Corner; 2]>, normal: Corner) -> Vec<Vec<Corner>> {
    let mut rings = Vec::new();
    while let Some([start, mut at]) = border.pop() {
        let mut ring = vec![start];
        while at != start {
            let back: Corner = std::array::from_fn(|i| ring[ring.len() - 1][i] - at[i]);
            let turn = |side: &[Corner; 2]| {
                let to: Corner = std::array::from_fn(|i| side[1][i] - side[0][i]);
                let sine = [
                    back[1] * to[2] - back[2] * to[1],
                    back[2] * to[0] - back[0] * to[2],
                    back[0] * to[1] - back[1] * to[0],
                ];
                let angle =
                    (dot(sine, normal) as f64 / (dot(normal, normal) as f64).sqrt()).atan2(dot(back, to) as f64);
                // Clockwise from where it came from: the last of them is the first through what is outside.
                if angle <= 0.0 { angle + std::f64::consts::TAU } else { angle }
            };
            let onwards = (0..border.len()).filter(|&i| border[i][0] == at);
            let next = onwards.min_by(|&i, &j| turn(&border[i]).total_cmp(&turn(&border[j]))).unwrap();
            ring.push(at);
            at = border.swap_remove(next)[1];
        }
        rings.push(ring);
    }
    rings
}

#[test]
fn an_edge_inside_a_face_is_no_edge_of_it() {
    // A shaft whose corner touches a wall from inside: the wall has both ends of the edge, but not the edge.
    let mut vertices = CUBE.to_vec();
    for z in [0, 100] {
        vertices.extend([[20, 20, z], [100, 50, z], [50, 80, z]]);
    }
    let faces: [&[&[u32]]; 9] = [
        &[&[0, 3, 2, 9, 1], &[8, 9, 10]],
        &[&[4, 5, 12, 6, 7], &[11, 13, 12]],
        &[&[0, 1, 5, 4]],
        &[&[1, 9, 2, 6, 12, 5]],
        &[&[2, 3, 7, 6]],
        &[&[3, 0, 4, 7]],
        &[&[10, 9, 12, 13]],
        &[&[8, 10, 13, 11]],
        &[&[9, 8, 11, 12]],
    ];
    let mut touching = solid(&vertices, &faces);
    assert_eq!(codes(&touching), [303]);
    // With a vertex more inside the wall the edge does not go from one vertex of it to another.
    touching.vertices.push([10_000, 5_000, 5_000]);
    touching.faces[6].rings[0] = vec![10, 9, 14, 12, 13];
    touching.faces[8].rings[0] = vec![9, 8, 11, 12, 14];
    assert!(codes(&touching).contains(&306));
    // A millimetre before the wall it is a shaft like any other.
    let mut apart = solid(&vertices, &faces);
    for v in [9, 12] {
        apart.vertices.push(apart.vertices[v]);
        apart.vertices[v][0] -= 10;
    }
    apart.faces[0].rings[0] = vec![0, 3, 2, 14, 1];
    apart.faces[1].rings[0] = vec![4, 5, 15, 6, 7];
    apart.faces[3].rings[0] = vec![1, 14, 2, 6, 15, 5];
    assert_eq!(codes(&apart), NONE);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(3000))]

    #[test]
    fn what_is_no_manifold_is_found(inside in prop::collection::vec(prop::bool::weighted(0.7), CELLS)) {
        let pieces = pieces(&inside);
        prop_assume!(!pieces.is_empty());
        let shell = merged(&pieces);
        let found = codes(&shell);
        prop_assert!(found.iter().all(|code| [303, 305, 306].contains(code)), "{found:?} {shell:?}");
        let faulty = found.contains(&303) || found.contains(&306);
        prop_assert_eq!(faulty, !is_manifold(&pieces), "{:?} {:?}", check(&shell, &Tolerances::default()), shell);
    }
}
