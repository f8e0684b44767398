//! The faces of a shell together as a point set: codes 303 and 306. Exact, on triangles of the faces.

use rstar::{RTree, RTreeObject};

use super::predicates::{Point2, Point3, Position, Projection, edges, locate, newell, on_segment3};
use super::triangles::{Triangle, intersect};
use super::triangulation::triangulate;
use super::{Fault, Place};
use crate::solid::Solid;

/// The faults of a shell of sound polygons as a point set: 303 where more than one fan of faces meets at a vertex or an
/// edge runs through a face from one vertex of it to another, 306 where faces meet otherwise elsewhere than in the vertices
/// and edges that they share; at most one 306 per pair of faces.
///
/// What is shared is a matter of the polygons: a diagonal of their triangulation joins the triangles of its own face and
/// nothing else.
pub fn check(solid: &Solid) -> Vec<Fault> {
    let mut faults = Vec::new();
    let mut triangles: Vec<Triangle> = Vec::new();
    for (face, f) in solid.faces.iter().enumerate() {
        let face = face as u32;
        match triangulate(solid, f) {
            Some(found) => triangles.extend(found.into_iter().map(|t| Triangle::new(solid, face, t))),
            None => faults.push(Fault::new(306, Place::Face(face), "the face cannot be triangulated")),
        }
    }
    let spokes = spokes(&mut triangles);
    if faults.is_empty() {
        fans(solid, &triangles, &spokes, &mut faults);
    }
    let mut pairs = if triangles.len() > SWEPT { by_tree(triangles) } else { by_sweep(triangles) };
    pairs.sort_unstable();
    pairs.dedup();
    for (a, b) in pairs {
        let through = through(solid, a, b).into_iter().chain(through(solid, b, a));
        let before = faults.len();
        faults.extend(through.map(|(edge, [of, in_face])| {
            let message = format!("the edge of face {of} runs through face {in_face}");
            Fault::new(303, Place::Edge(edge[0], edge[1]), message)
        }));
        if faults.len() == before {
            faults.push(Fault::new(306, Place::Face(a), format!("the face intersects face {b}")));
        }
    }
    faults
}

/// An end of a side of a triangle, its other end, and the triangle.
type Spoke = (Point3, Point3, usize);

/// The sides of all triangles, each from both ends, in the order of the ends; and marks the sides that are edges of faces:
/// a diagonal has two triangles of its face.
fn spokes(triangles: &mut [Triangle]) -> Vec<Spoke> {
    let mut spokes: Vec<Spoke> = Vec::with_capacity(6 * triangles.len());
    for (i, triangle) in triangles.iter().enumerate() {
        for (a, b) in edges(&triangle.corners) {
            spokes.extend([(a, b, i), (b, a, i)]);
        }
    }
    spokes.sort_unstable();
    for side in spokes.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)).filter(|side| side[0].0 < side[0].1) {
        for &(a, b, i) in side {
            let face = triangles[i].face;
            let inner = side.iter().any(|&(.., j)| j != i && triangles[j].face == face);
            triangles[i].mark([a, b], !inner);
        }
    }
    spokes
}

/// Up to so many triangles a sweep along x is faster than a tree of boxes; the result is the same.
const SWEPT: usize = 256;

/// The pairs of faces that intersect, lower index first, by a sweep along x.
fn by_sweep(mut triangles: Vec<Triangle>) -> Vec<(u32, u32)> {
    triangles.sort_by_key(|t| (t.min[0], t.face));
    let mut pairs = Vec::new();
    for (i, a) in triangles.iter().enumerate() {
        for b in triangles[i + 1..].iter().take_while(|b| b.min[0] <= a.max[0]) {
            if a.face != b.face && a.boxes_meet(b) && intersect(a, b) {
                pairs.push((a.face.min(b.face), a.face.max(b.face)));
            }
        }
    }
    pairs
}

/// The same by a tree of bounding boxes.
fn by_tree(triangles: Vec<Triangle>) -> Vec<(u32, u32)> {
    let tree = RTree::bulk_load(triangles);
    let meeting = |a: &Triangle| {
        let found = tree.locate_in_envelope_intersecting(&RTreeObject::envelope(a));
        found.filter(|b| a.face < b.face && intersect(a, b)).map(|b| (a.face, b.face)).collect::<Vec<_>>()
    };
    tree.iter().flat_map(meeting).collect()
}

/// The triangles at a vertex must hang together: those of a face by their diagonals, the faces by their edges.
fn fans(solid: &Solid, triangles: &[Triangle], spokes: &[Spoke], faults: &mut Vec<Fault>) {
    let mut set: Vec<usize> = (0..triangles.len()).collect();
    for at_vertex in spokes.chunk_by(|a, b| a.0 == b.0) {
        for &(.., i) in at_vertex {
            set[i] = i;
        }
        for spoke in at_vertex.chunk_by(|a, b| a.1 == b.1) {
            let (from, to) = (spoke[0].0, spoke[0].1);
            let is_edge = |i: usize| triangles[i].is_edge([from, to]);
            for (k, &(.., i)) in spoke.iter().enumerate() {
                for &(.., j) in &spoke[k + 1..] {
                    if triangles[i].face == triangles[j].face || (is_edge(i) && is_edge(j)) {
                        let (a, b) = (root(&set, i), root(&set, j));
                        set[a.max(b)] = a.min(b);
                    }
                }
            }
        }
        // Each triangle has two spokes at the vertex.
        let fans = at_vertex.iter().filter(|&&(.., i)| set[i] == i).count() / 2;
        if fans > 1 {
            let vertex = solid.vertices.iter().position(|v| *v == at_vertex[0].0).unwrap_or(0);
            let message = format!("{fans} separate fans of faces meet at the vertex");
            faults.push(Fault::new(303, Place::Vertex(vertex as u32), message));
        }
    }
}

fn root(set: &[usize], mut i: usize) -> usize {
    while set[i] != i {
        i = set[i];
    }
    i
}

/// The edges of face `a` that run through the inside of face `b` from one vertex of it to another.
fn through(solid: &Solid, a: u32, b: u32) -> Vec<([u32; 2], [u32; 2])> {
    let [edges_of, within] = [a, b].map(|face| &solid.faces[face as usize]);
    let Some(projection) = within.rings.first().and_then(|ring| Projection::along(newell(solid, ring))) else {
        return Vec::new();
    };
    let place = |v: u32| solid.vertices[v as usize];
    let corners: Vec<Point3> = within.rings.iter().flatten().map(|&v| place(v)).collect();
    // Doubled, so that the middle of an edge is on the grid.
    let doubled = |p: Point3| -> Point2 { projection.point(p).map(|c| 2 * c) };
    let rings: Vec<Vec<Point2>> =
        within.rings.iter().map(|ring| ring.iter().map(|&v| doubled(place(v))).collect()).collect();
    let holds = |p: Point2| {
        let mut places = rings.iter().map(|ring| locate(ring, p));
        places.next() == Some(Position::Inside) && places.all(|place| place == Position::Outside)
    };
    let runs = |&(u, v): &(u32, u32)| {
        let [p, q] = [place(u), place(v)];
        let middle = std::array::from_fn(|i| p[i] + q[i]);
        corners.contains(&p)
            && corners.contains(&q)
            && !corners.iter().any(|&c| c != p && c != q && on_segment3(p, q, c))
            && holds(projection.point(middle))
    };
    edges_of.rings.iter().flat_map(|ring| edges(ring)).filter(runs).map(|(u, v)| ([u, v], [a, b])).collect()
}
