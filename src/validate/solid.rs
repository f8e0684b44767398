//! The shell as the boundary of a solid: code 405.

use super::predicates::{cross, dot, edges, subtract};
use super::{Fault, Place};
use crate::solid::Solid;

/// 405 if the faces of a closed shell look inwards: its volume is not positive. Exact.
///
/// Inner shells (401 to 404) cannot occur: a [`Solid`] has one shell.
pub fn check(solid: &Solid) -> Vec<Fault> {
    let Some(&anchor) = solid.vertices.first() else { return Vec::new() };
    let mut six_volumes = 0i128;
    for ring in solid.faces.iter().flat_map(|face| &face.rings) {
        let Some(&first) = ring.first() else { continue };
        let apex = subtract(solid.vertices[first as usize], anchor);
        for (a, b) in edges(ring) {
            let [a, b] = [a, b].map(|v| subtract(solid.vertices[v as usize], anchor));
            six_volumes += dot(apex, cross(a, b));
        }
    }
    if six_volumes > 0 {
        return Vec::new();
    }
    let message = if six_volumes == 0 { "the shell encloses nothing" } else { "the faces look inwards" };
    vec![Fault::new(405, Place::Solid, message)]
}
