//! The faces together: codes 301 to 307.

use std::collections::BTreeMap;

use super::polygon::triangulate;
use super::predicates::edges;
use super::triangles::{Triangle, intersect};
use super::{Fault, Place};
use crate::solid::Solid;

/// A half-edge: its ends, its face, and its place in the list of half-edges.
struct Half {
    from: u32,
    to: u32,
    face: u32,
    /// The half-edge that ends where this one starts, in the same ring.
    previous: usize,
    /// The same edge in the other direction, if there is exactly one.
    twin: Option<usize>,
}

/// The faults of a shell as a set of half-edges: 301 fewer than four faces, 302 open, 303 a non-manifold edge or vertex,
/// 305 several components, 307 neighbouring faces that turn different ways. Two vertices at the same place are the same.
pub fn check(solid: &Solid) -> Vec<Fault> {
    let mut faults = Vec::new();
    if solid.faces.len() < 4 {
        faults.push(Fault::new(301, Place::Solid, format!("{} faces; a shell needs four", solid.faces.len())));
    }
    let mut halves = half_edges(solid);
    pair(&mut halves, &mut faults);
    umbrellas(&halves, &mut faults);
    let components = components(solid, &halves);
    if components > 1 {
        faults.push(Fault::new(305, Place::Solid, format!("{components} components; a shell is one")));
    }
    faults
}

fn half_edges(solid: &Solid) -> Vec<Half> {
    let mut at: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    let name: Vec<u32> =
        solid.vertices.iter().enumerate().map(|(i, &p)| *at.entry(p).or_insert(i as u32)).collect();
    let mut halves = Vec::new();
    for (face, rings) in solid.faces.iter().enumerate() {
        for ring in &rings.rings {
            let start = halves.len();
            for (i, (a, b)) in edges(ring).enumerate() {
                let previous = start + (i + ring.len() - 1) % ring.len();
                let (from, to) = (name[a as usize], name[b as usize]);
                halves.push(Half { from, to, face: face as u32, previous, twin: None });
            }
        }
    }
    halves
}

/// Joins twins; whatever is not exactly one half-edge in each direction is a fault.
fn pair(halves: &mut [Half], faults: &mut Vec<Fault>) {
    let mut order: Vec<(u32, u32, usize)> =
        halves.iter().enumerate().map(|(i, h)| (h.from.min(h.to), h.from.max(h.to), i)).collect();
    order.sort_unstable();
    for edge in order.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (a, b, first) = edge[0];
        let place = Place::Edge(a, b);
        match edge {
            [_] => {
                let face = halves[first].face;
                faults.push(Fault::new(302, place, format!("the shell is open: only face {face} has the edge")));
            }
            [_, (.., second)] => {
                if halves[first].from == halves[*second].from {
                    let faces = (halves[first].face, halves[*second].face);
                    let message = format!("faces {} and {} turn different ways", faces.0, faces.1);
                    faults.push(Fault::new(307, place, message));
                } else {
                    halves[first].twin = Some(*second);
                    halves[*second].twin = Some(first);
                }
            }
            _ => faults.push(Fault::new(303, place, format!("{} faces have the edge", edge.len()))),
        }
    }
}

/// A vertex all whose edges are sound must have one closed fan of faces around it.
fn umbrellas(halves: &[Half], faults: &mut Vec<Fault>) {
    let mut order: Vec<(u32, usize)> = halves.iter().enumerate().map(|(i, h)| (h.from, i)).collect();
    order.sort_unstable();
    for fan in order.chunk_by(|a, b| a.0 == b.0) {
        let start = fan[0].1;
        let mut half = start;
        let mut turned = 0;
        // Around the vertex against the clock; where an edge has no twin the fault is that edge.
        while let Some(next) = halves[halves[half].previous].twin {
            turned += 1;
            half = next;
            if half == start || turned > fan.len() {
                break;
            }
        }
        let closed = half == start && turned > 0;
        if closed && turned < fan.len() {
            let message = format!("{} faces meet at the vertex in more than one fan", fan.len());
            faults.push(Fault::new(303, Place::Vertex(fan[0].0), message));
        }
    }
}

/// Number of sets of faces that hang together by shared vertices.
fn components(solid: &Solid, halves: &[Half]) -> usize {
    let mut set: Vec<usize> = (0..solid.faces.len()).collect();
    let root = |set: &[usize], mut i: usize| {
        while set[i] != i {
            i = set[i];
        }
        i
    };
    let mut at: Vec<Option<usize>> = vec![None; solid.vertices.len()];
    for half in halves {
        let face = half.face as usize;
        match at[half.from as usize] {
            None => at[half.from as usize] = Some(face),
            Some(other) => {
                let (a, b) = (root(&set, face), root(&set, other));
                set[a.max(b)] = a.min(b);
            }
        }
    }
    (0..set.len()).filter(|&i| set[i] == i).count()
}

/// 306: faces that meet elsewhere than in the vertices and edges that they share, found exactly on their triangles.
/// At most one fault per pair of faces.
pub fn self_intersections(solid: &Solid) -> Vec<Fault> {
    let mut triangles: Vec<Triangle> = Vec::new();
    for (face, f) in solid.faces.iter().enumerate() {
        for corners in triangulate(solid, f) {
            triangles.push(Triangle::new(solid, face as u32, corners));
        }
    }
    triangles.sort_by_key(|t| (t.min[0], t.face));
    let mut pairs = Vec::new();
    for (i, a) in triangles.iter().enumerate() {
        for b in triangles[i + 1..].iter().take_while(|b| b.min[0] <= a.max[0]) {
            if a.face != b.face && a.boxes_meet(b) && intersect(a, b) {
                pairs.push((a.face.min(b.face), a.face.max(b.face)));
            }
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
        .into_iter()
        .map(|(a, b)| Fault::new(306, Place::Face(a), format!("the face intersects face {b}")))
        .collect()
}
