//! Constrained Delaunay triangulation of a face.

use std::collections::{HashMap, VecDeque};

use geo::{Coord, LineString, TriangulateEarcut};

use super::predicates::{Point2, Projection, newell, on_segment, orient2};
use crate::geometry::Scattered;
use crate::solid::{Face, Solid};

/// The circle test must be passed by more than this share of the magnitude of its terms: the four corners of a
/// rectangle lie on one circle, and their diagonal must not be flipped for ever.
const FLIP: f64 = 1e-9;

/// Triangles of a sound face, oriented like it, as vertex indices of the solid; every vertex of the face is a corner of
/// some, and none lies inside an edge of one. `None` if the triangles do not cover exactly the face.
///
/// Delaunay, because the rounding of a vertex on a straight edge makes a corner of almost 180°, which any other
/// triangulation may cut off as a triangle that lies anyhow in space.
pub(super) fn triangulate(solid: &Solid, face: &Face) -> Option<Vec<[u32; 3]>> {
    if let [ring] = &face.rings[..]
        && let [a, b, c] = ring[..]
    {
        return Some(vec![[a, b, c]]);
    }
    let projection = Projection::along(newell(solid, face.rings.first()?))?;
    let place = |v: u32| projection.point(solid.vertices[v as usize]);
    let line = |ring: &Vec<u32>| -> LineString<f64> {
        ring.iter().map(|&v| place(v)).map(|p| Coord { x: p[0] as f64, y: p[1] as f64 }).collect()
    };
    let mut lines = face.rings.iter().map(line);
    let raw = geo::Polygon::new(lines.next()?, lines.collect()).earcut_triangles_raw();
    // Closed rings may come back with their first vertex repeated at the end.
    let open: Vec<u32> = face.rings.iter().flatten().copied().collect();
    let closed: Vec<u32> = face.rings.iter().flat_map(|ring| ring.iter().chain(ring.first()).copied()).collect();
    let corners = if raw.vertices.len() == 2 * closed.len() { &closed } else { &open };
    let mut triangles: Vec<[u32; 3]> = raw
        .triangle_indices
        .chunks_exact(3)
        .filter_map(|t| {
            let [a, b, c] = [t[0], t[1], t[2]].map(|i| corners.get(i).copied());
            let [a, b, c] = [a?, b?, c?];
            match orient2(place(a), place(b), place(c)) {
                1 => Some([a, b, c]),
                -1 => Some([a, c, b]),
                _ => None,
            }
        })
        .collect();
    insert_missed(place, &open, &mut triangles);
    flip(place, &mut triangles);
    let covered: i128 = triangles.iter().map(|&[a, b, c]| twice_area([place(a), place(b), place(c)])).sum();
    let area: i128 = face
        .rings
        .iter()
        .map(|ring| ring.windows(2).map(|e| twice_area([place(ring[0]), place(e[0]), place(e[1])])).sum::<i128>())
        .sum();
    (covered == area).then_some(triangles)
}

/// The ear-clipping leaves out vertices on straight edges and draws edges through vertices in line with others: both
/// are triangles with a vertex inside an edge, and are cut there.
fn insert_missed(place: impl Fn(u32) -> Point2, vertices: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let plan = |p: Point2| p.map(|c| c as f64);
    let places = (vertices.len() > SEARCHED)
        .then(|| Scattered::new(&vertices.iter().map(|&v| plan(place(v))).collect::<Vec<_>>()));
    let mut i = 0;
    while i < triangles.len() {
        let missed = (0..3).find_map(|k| {
            let [a, b, c] = std::array::from_fn(|n| triangles[i][(k + n) % 3]);
            let [p, q] = [place(a), place(b)];
            let between = |v: u32| {
                let at = place(v);
                at != p && at != q && on_segment(p, q, at)
            };
            let first = match &places {
                None => vertices.iter().copied().find(|&v| between(v)),
                Some(places) => {
                    let mut first: Option<u32> = None;
                    places.near([plan(p), plan(q)], |at| {
                        if first.is_none_or(|first| at < first) && between(vertices[at as usize]) {
                            first = Some(at);
                        }
                    });
                    first.map(|at| vertices[at as usize])
                }
            };
            first.map(|v| ([a, v, c], [v, b, c]))
        });
        if let Some((first, second)) = missed {
            triangles[i] = first;
            triangles.push(second);
        } else {
            i += 1;
        }
    }
}

fn twice_area([a, b, c]: [Point2; 3]) -> i128 {
    let [u, v] = [b, c].map(|p| [i128::from(p[0]) - i128::from(a[0]), i128::from(p[1]) - i128::from(a[1])]);
    u[0] * v[1] - u[1] * v[0]
}

/// Flips edges between two triangles until all are Delaunay (Lawson).
fn flip(place: impl Fn(u32) -> Point2, triangles: &mut [[u32; 3]]) {
    if triangles.len() > SEARCHED {
        return flip_many(place, triangles);
    }
    // Lawson's algorithm ends by itself; the bound is for rounding in the circle test.
    for _ in 0..=triangles.len() {
        let mut flipped = false;
        for i in 0..triangles.len() {
            for side in sides(triangles[i]) {
                let other = (0..triangles.len()).find_map(|j| beyond(triangles[j], side).map(|d| (j, d)));
                let Some((j, d)) = other else { continue };
                if let Some(pair) = flipped_over(&place, triangles[i], side, d) {
                    [triangles[i], triangles[j]] = pair;
                    flipped = true;
                    break;
                }
            }
        }
        if !flipped {
            return;
        }
    }
}

/// The same for many triangles: edges wait in a queue until they are looked at, and those around a flip once more.
fn flip_many(place: impl Fn(u32) -> Point2, triangles: &mut [[u32; 3]]) {
    // The triangle of each directed edge; only looked up.
    let mut owner: HashMap<[u32; 2], usize> = HashMap::with_capacity(3 * triangles.len());
    owner.extend(triangles.iter().enumerate().flat_map(|(i, &t)| sides(t).map(|side| (side, i))));
    let mut waiting: VecDeque<[u32; 2]> = triangles.iter().flat_map(|&t| sides(t)).collect();
    // For rounding in the circle test: no triangulation takes more flips than it has pairs of triangles.
    let mut left = triangles.len().saturating_mul(triangles.len());
    while let Some(side @ [a, b]) = waiting.pop_front() {
        let pair = owner.get(&side).zip(owner.get(&[b, a]));
        let Some((&i, &j)) = pair.filter(|(i, _)| sides(triangles[**i]).contains(&side)) else { continue };
        let Some(d) = beyond(triangles[j], side) else { continue };
        let Some(pair) = flipped_over(&place, triangles[i], side, d) else { continue };
        [triangles[i], triangles[j]] = pair;
        owner.remove(&[a, b]);
        owner.remove(&[b, a]);
        for index in [i, j] {
            owner.extend(sides(triangles[index]).map(|side| (side, index)));
            waiting.extend(sides(triangles[index]));
        }
        left -= 1;
        if left == 0 {
            return;
        }
    }
}

fn sides([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// The corner of a triangle that lies beyond a side of its neighbour.
fn beyond(t: [u32; 3], [a, b]: [u32; 2]) -> Option<u32> {
    (0..3).find(|&m| t[m] == b && t[(m + 1) % 3] == a).map(|m| t[(m + 2) % 3])
}

/// A triangle with this side and the one beyond it, whose third corner is `d`, parted by their other diagonal, if that is
/// the better one.
fn flipped_over(place: &impl Fn(u32) -> Point2, t: [u32; 3], [a, b]: [u32; 2], d: u32) -> Option<[[u32; 3]; 2]> {
    let c = t.into_iter().find(|&v| v != a && v != b)?;
    let [p, q, r, s] = [a, b, c, d].map(place);
    let is_better = in_circle(p, q, r, s) && orient2(p, s, r) > 0 && orient2(s, q, r) > 0;
    is_better.then_some([[a, d, c], [d, b, c]])
}

/// Up to so many triangles, or vertices, are searched one by one.
const SEARCHED: usize = 64;

/// Whether `d` lies clearly inside the circle through `a`, `b` and `c`, which are counter-clockwise.
fn in_circle(a: Point2, b: Point2, c: Point2, d: Point2) -> bool {
    let [a, b, c] = [a, b, c].map(|p| {
        let [x, y] = [(p[0] - d[0]) as f64, (p[1] - d[1]) as f64];
        [x, y, x * x + y * y]
    });
    let terms = [
        a[0] * b[1] * c[2],
        b[0] * c[1] * a[2],
        c[0] * a[1] * b[2],
        -a[0] * c[1] * b[2],
        -b[0] * a[1] * c[2],
        -c[0] * b[1] * a[2],
    ];
    terms.iter().sum::<f64>() > FLIP * terms.iter().map(|t| t.abs()).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn face_of(vertices: &[[i64; 2]], rings: &[&[u32]]) -> (Solid, Face) {
        let vertices = vertices.iter().map(|p| [p[0], p[1], 0]).collect();
        let solid = Solid { step: [1e-4; 3], vertices, faces: Vec::new(), surfaces: Vec::new() };
        (solid, Face { rings: rings.iter().map(|r| r.to_vec()).collect(), surface: 0 })
    }

    #[test]
    fn a_vertex_beside_a_straight_edge_is_no_ear() {
        // Vertex 1 sticks out by one step: no triangle consists of it and its neighbours.
        let (solid, face) = face_of(&[[0, 0], [500, -1], [1000, 0], [1000, 700], [0, 700]], &[&[0, 1, 2, 3, 4]]);
        let triangles = triangulate(&solid, &face).unwrap();
        assert_eq!(triangles.len(), 3);
        assert!(!triangles.iter().any(|t| t.contains(&0) && t.contains(&1) && t.contains(&2)));
    }

    #[test]
    fn holes_stay_empty_and_every_vertex_counts() {
        let square = [[0, 0], [90, 0], [90, 90], [0, 90], [30, 30], [60, 30], [60, 60], [30, 60]];
        let (solid, face) = face_of(&square, &[&[0, 1, 2, 3], &[7, 6, 5, 4]]);
        let triangles = triangulate(&solid, &face).unwrap();
        // Vertices + 2 × holes − 2, whatever is in line.
        assert_eq!(triangles.len(), 8);
        let straight = [[0, 0], [30, 0], [60, 0], [90, 0], [90, 90], [0, 90]];
        let (solid, face) = face_of(&straight, &[&[0, 1, 2, 3, 4, 5]]);
        assert_eq!(triangulate(&solid, &face).unwrap().len(), 4);
    }
}
