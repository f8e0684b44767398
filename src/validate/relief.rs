//! Whether a terrain is one: codes 809 and 810, gable's own.

use super::predicates::newell;
use super::{Fault, Place};
use crate::solid::Solid;

/// The faults of the faces of a `TINRelief`, whose rings are sound: 809 a face looks down, as no ground does; 810 a face is no
/// triangle. A face may stand upright, as under a wall between two floors, and a border may be anywhere, as around buildings.
///
/// Which way a face looks is the sign of a determinant: exact.
pub fn check(faces: &Solid) -> Vec<Fault> {
    let mut faults = Vec::new();
    for (face, f) in faces.faces.iter().zip(0..) {
        let up: i128 = face.rings.iter().map(|ring| newell(faces, ring)[2]).sum();
        if up < 0 {
            faults.push(Fault::new(809, Place::Face(f), "the face of a terrain looks down"));
        }
        let corners: usize = face.rings.iter().map(Vec::len).sum();
        if face.rings.len() != 1 || corners != 3 {
            let message = format!("a face of {} rings and {corners} vertices in a TIN", face.rings.len());
            faults.push(Fault::new(810, Place::Face(f), message));
        }
    }
    faults
}

/// Whether a fault is one of the geometry; else it is one of what the geometry is called.
pub fn is_geometric(fault: &Fault) -> bool {
    fault.code == 809
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::solid::Face;

    fn faces(rings: &[&[u32]]) -> Vec<u16> {
        let vertices = vec![[0, 0, 5], [10, 0, 0], [10, 10, 0], [0, 10, 0], [10, 0, 9]];
        let faces = rings.iter().map(|ring| Face { rings: vec![ring.to_vec()], surface: 0 }).collect();
        check(&Solid { step: [1e-3; 3], vertices, faces, surfaces: Vec::new() })
            .iter()
            .map(|fault| fault.code)
            .collect()
    }

    #[test]
    fn triangles_look_up_or_stand() {
        assert!(faces(&[&[0, 1, 2], &[0, 2, 3]]).is_empty());
        assert!(faces(&[&[1, 0, 4]]).is_empty(), "upright");
        assert_eq!(faces(&[&[0, 2, 1], &[0, 2, 3]]), [809]);
        assert_eq!(faces(&[&[0, 1, 2, 3]]), [810]);
        assert_eq!(faces(&[&[3, 2, 1, 0]]), [809, 810]);
    }
}
