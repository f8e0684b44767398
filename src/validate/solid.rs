//! The shells of a solid: codes 401 to 405.

use super::predicates::{cross, dot, edges, subtract};
use super::{Fault, Place};
use crate::solid::Solid;

pub use super::voids::check as check_voids;

/// 405 if the faces of a closed shell look the wrong way: outwards they must look from an exterior, whose volume is then
/// positive, and inwards, into the void, from the shell of a void. Exact.
pub fn check(solid: &Solid, exterior: bool) -> Vec<Fault> {
    let six_volumes = six_volumes(solid);
    if (exterior && six_volumes > 0) || (!exterior && six_volumes < 0) {
        return Vec::new();
    }
    let message = match (six_volumes, exterior) {
        (0, _) => "the shell encloses nothing",
        (_, true) => "the faces look inwards",
        (_, false) => "the faces of a void look out of it",
    };
    vec![Fault::new(405, Place::Solid, message)]
}

/// Six times the signed volume in cubic grid steps (divergence theorem).
pub(super) fn six_volumes(solid: &Solid) -> i128 {
    let Some(&anchor) = solid.vertices.first() else { return 0 };
    let mut sum = 0i128;
    for ring in solid.faces.iter().flat_map(|face| &face.rings) {
        let Some(&first) = ring.first() else { continue };
        let apex = subtract(solid.vertices[first as usize], anchor);
        for (a, b) in edges(ring) {
            let [a, b] = [a, b].map(|v| subtract(solid.vertices[v as usize], anchor));
            sum += dot(apex, cross(a, b));
        }
    }
    sum
}
