//! The ridges of a roof: level lines from which two roof planes fall.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::Vector3;

use crate::building::Ridges;
use crate::solid::{Face, Solid, SurfaceType};

/// An edge that rises by more than this is a hip, and a plane that falls by less is flat: sine of 4 degrees, as for flat
/// roofs.
const FLAT: f64 = 0.0698;

/// One side of an edge: its roof surface, and how much that falls from the edge (sine, positive downwards).
type Side = (u32, f64);

/// The ridges of some solids. All edges of the same two roof planes are one line, with whatever interrupts it.
pub(super) fn of(solids: &[Solid]) -> Ridges {
    let mut ridges = Ridges::default();
    for solid in solids {
        let mut edges: BTreeMap<[u32; 2], Vec<Side>> = BTreeMap::new();
        for face in solid.faces.iter().filter(|face| solid.kind(face) == SurfaceType::Roof) {
            sides(solid, face, &mut edges);
        }
        let mut lines: BTreeSet<[u32; 2]> = BTreeSet::new();
        for ([a, b], sides) in edges {
            let [(one, falls), (other, falls_too)] = sides[..] else { continue };
            let along = solid.point(b) - solid.point(a);
            let is_level = along.z.abs() <= FLAT * along.norm();
            if one != other && is_level && falls > FLAT && falls_too > FLAT {
                lines.insert([one.min(other), one.max(other)]);
                ridges.length += along.norm();
            }
        }
        ridges.count += lines.len();
    }
    ridges
}

/// Adds the sides of a face to the edges that they are of.
fn sides(solid: &Solid, face: &Face, edges: &mut BTreeMap<[u32; 2], Vec<Side>>) {
    let normal: Vector3<f64> = face.rings.iter().map(|ring| solid.newell(ring)).sum();
    let Some(normal) = normal.try_normalize(0.0) else { return };
    for ring in &face.rings {
        for (&a, &b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let Some(along) = (solid.point(b) - solid.point(a)).try_normalize(0.0) else { continue };
            // Seen from outside the face lies to the left of its edges.
            let inwards = normal.cross(&along);
            edges.entry([a.min(b), a.max(b)]).or_default().push((face.surface, -inwards.z));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::Surface;

    /// Roof faces over places in metres.
    fn roofs(vertices: &[[i64; 3]], faces: &[(&[u32], u32)]) -> Solid {
        let count = faces.iter().map(|(_, surface)| surface + 1).max().unwrap_or_default();
        Solid {
            step: [1e-4; 3],
            vertices: vertices.iter().map(|v| v.map(|c| c * 10_000)).collect(),
            faces: faces.iter().map(|(ring, surface)| Face { rings: vec![ring.to_vec()], surface: *surface }).collect(),
            surfaces: vec![Surface::of(SurfaceType::Roof); count as usize],
        }
    }

    #[test]
    fn a_gable_has_one_ridge_and_a_valley_none() {
        let gable = [[0, 0, 3], [2, 0, 5], [4, 0, 3], [4, 3, 3], [2, 3, 5], [0, 3, 3]];
        let faces: [(&[u32], u32); 2] = [(&[0, 1, 4, 5], 0), (&[1, 2, 3, 4], 1)];
        assert_eq!(of(&[roofs(&gable, &faces)]), Ridges { count: 1, length: 3.0 });
        let valley = gable.map(|[x, y, z]| [x, y, 8 - z]);
        assert_eq!(of(&[roofs(&valley, &faces)]), Ridges::default());
        let shed = [[0, 0, 3], [2, 0, 4], [4, 0, 4], [4, 3, 4], [2, 3, 4], [0, 3, 3]];
        assert_eq!(of(&[roofs(&shed, &faces)]), Ridges::default(), "one side is flat");
    }

    #[test]
    fn hips_are_no_ridges_and_an_interrupted_ridge_is_one() {
        // A hipped roof of 8 m by 4 m, its ridge from 2 m to 6 m.
        let hipped = [[0, 0, 3], [8, 0, 3], [8, 4, 3], [0, 4, 3], [2, 2, 5], [6, 2, 5]];
        let faces: [(&[u32], u32); 4] = [(&[0, 1, 5, 4], 0), (&[1, 2, 5], 1), (&[2, 3, 4, 5], 2), (&[3, 0, 4], 3)];
        assert_eq!(of(&[roofs(&hipped, &faces)]), Ridges { count: 1, length: 4.0 });
        // The same planes twice, with nothing between them.
        let two: Vec<[i64; 3]> = [0, 6]
            .into_iter()
            .flat_map(|y| [[0, y, 3], [2, y, 5], [4, y, 3], [4, y + 3, 3], [2, y + 3, 5], [0, y + 3, 3]])
            .collect();
        let faces: [(&[u32], u32); 4] =
            [(&[0, 1, 4, 5], 0), (&[1, 2, 3, 4], 1), (&[6, 7, 10, 11], 0), (&[7, 8, 9, 10], 1)];
        assert_eq!(of(&[roofs(&two, &faces)]), Ridges { count: 1, length: 6.0 });
    }
}
