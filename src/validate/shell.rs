//! The faces together as a set of edges: codes 301, 302, 303, 305 and 307.

use std::collections::BTreeMap;

use super::predicates::edges;
use super::{Fault, Place};
use crate::solid::Solid;

/// A half-edge: its ends and its face.
struct Half {
    from: u32,
    to: u32,
    face: u32,
}

/// The faults of a shell as a set of half-edges: 301 fewer than four faces, 302 open, 303 a non-manifold edge, 305 several
/// components, 307 neighbouring faces that turn different ways. Two vertices at the same place are the same. A surface that
/// need not be closed may have a border and any number of faces.
pub fn check(solid: &Solid, closed: bool) -> Vec<Fault> {
    let mut faults = Vec::new();
    if closed && solid.faces.len() < 4 {
        faults.push(Fault::new(301, Place::Solid, format!("{} faces; a shell needs four", solid.faces.len())));
    }
    let halves = half_edges(solid);
    pair(&halves, closed, &mut faults);
    let components = components(solid, &halves);
    if components > 1 {
        faults.push(Fault::new(305, Place::Solid, format!("{components} components; a shell is one")));
    }
    faults
}

fn half_edges(solid: &Solid) -> Vec<Half> {
    let mut at: BTreeMap<[i64; 3], u32> = BTreeMap::new();
    let name: Vec<u32> = solid.vertices.iter().enumerate().map(|(i, &p)| *at.entry(p).or_insert(i as u32)).collect();
    let mut halves = Vec::new();
    for (face, rings) in solid.faces.iter().enumerate() {
        for ring in &rings.rings {
            let named = |(a, b): (u32, u32)| (name[a as usize], name[b as usize]);
            // A repeated vertex is a fault of the ring (102) and opens nothing.
            let apart = edges(ring).map(named).filter(|(from, to)| from != to);
            halves.extend(apart.map(|(from, to)| Half { from, to, face: face as u32 }));
        }
    }
    halves
}

/// Whatever edge is not exactly one half-edge in each direction is a fault; those of a border are not where there may be
/// one.
fn pair(halves: &[Half], closed: bool, faults: &mut Vec<Fault>) {
    let mut order: Vec<(u32, u32, usize)> =
        halves.iter().enumerate().map(|(i, h)| (h.from.min(h.to), h.from.max(h.to), i)).collect();
    order.sort_unstable();
    for edge in order.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let (a, b, _) = edge[0];
        let place = Place::Edge(a, b);
        let mut judge = |uses: &[&Half]| match uses {
            [] => {}
            [_] if !closed => {}
            [half] => {
                let message = format!("the shell is open: only face {} has the edge", half.face);
                faults.push(Fault::new(302, place, message));
            }
            [one, other] => {
                if one.from == other.from {
                    let message = format!("faces {} and {} turn different ways", one.face, other.face);
                    faults.push(Fault::new(307, place, message));
                }
            }
            _ => faults.push(Fault::new(303, place, format!("{} faces have the edge", uses.len()))),
        };
        match *edge {
            [(.., i)] => judge(&[&halves[i]]),
            [(.., i), (.., j)] => judge(&[&halves[i], &halves[j]]),
            _ => {
                let mut uses = edge.iter().map(|&(.., i)| &halves[i]).collect();
                cancel(&mut uses);
                judge(&uses);
            }
        }
    }
}

/// Takes away pairs with which a face goes along an edge and back: it is collapsed there (a fault of the ring) and neither
/// opens nor joins anything.
fn cancel(uses: &mut Vec<&Half>) {
    let mut i = 0;
    while i < uses.len() {
        let back = |other: &&Half| other.face == uses[i].face && other.from != uses[i].from;
        if let Some(j) = uses.iter().position(back) {
            uses.remove(i.max(j));
            uses.remove(i.min(j));
        } else {
            i += 1;
        }
    }
}

/// Number of sets of faces that hang together by shared vertices; faces that collapsed to a point are nowhere.
fn components(solid: &Solid, halves: &[Half]) -> usize {
    let mut set: Vec<usize> = (0..solid.faces.len()).collect();
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
    let mut somewhere = vec![false; set.len()];
    for half in halves {
        somewhere[half.face as usize] = true;
    }
    (0..set.len()).filter(|&i| set[i] == i && somewhere[i]).count()
}

fn root(set: &[usize], mut i: usize) -> usize {
    while set[i] != i {
        i = set[i];
    }
    i
}
