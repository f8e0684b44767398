//! The tops of solids.

use crate::geometry::Cover;
use crate::solid::Solid;

/// The faces of some solids that look up, indexed by what lies below them: its highest over a place is the height of the
/// model there.
pub fn tops<'a>(solids: impl IntoIterator<Item = &'a Solid>) -> Cover {
    Cover::new(solids.into_iter().flat_map(|solid| {
        let looks_up = |ring: &Vec<u32>| solid.newell(ring).z > 0.0;
        solid
            .faces
            .iter()
            .filter(move |face| face.rings.first().is_some_and(looks_up))
            .flat_map(|face| solid.triangles(face))
    }))
}
