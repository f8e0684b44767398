//! How compact a model is: faces before and after coplanar neighbours are merged (paper, section 4.4, counts both).

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};
use serde::Serialize;

use super::shape::{Shape, ShapeFace};
use crate::geometry::newell;

/// Faces of one solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct FaceCount {
    /// Faces as the model has them.
    pub faces: usize,
    /// Faces once coplanar neighbours are merged.
    pub merged: usize,
    /// Triangles.
    pub triangles: usize,
}

/// Counts the faces of each solid of a shape.
///
/// Two faces are merged when they share an edge (on a grid of 1 mm), look the same way within 1° and the vertices of each
/// lie within 10 mm of the plane of the other, whatever their semantics.
pub fn count_faces(shape: &Shape) -> Vec<FaceCount> {
    (0..shape.solids)
        .map(|solid| {
            let faces: Vec<&ShapeFace> = shape.faces.iter().filter(|face| face.solid == solid).collect();
            let of_solid = |face: &u32| shape.faces.get(*face as usize).is_some_and(|f| f.solid == solid);
            FaceCount {
                faces: faces.len(),
                merged: merged(&faces),
                triangles: shape.triangles.iter().filter(|(_, face)| of_solid(face)).count(),
            }
        })
        .filter(|count| count.faces > 0)
        .collect()
}

/// Number of groups of faces that are neighbours on one plane.
fn merged(faces: &[&ShapeFace]) -> usize {
    let key = |p: &Point3<f64>| [p.x, p.y, p.z].map(|v| (v * 1000.0).round() as i64);
    let planes: Vec<_> = faces.iter().map(|face| plane(face)).collect();
    let mut edges: BTreeMap<_, usize> = BTreeMap::new();
    for (index, face) in faces.iter().enumerate() {
        for ring in &face.rings {
            for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                edges.insert((key(a), key(b)), index);
            }
        }
    }
    let mut groups = Groups::new(faces.len());
    for ((a, b), &one) in &edges {
        let Some(&other) = edges.get(&(*b, *a)) else { continue };
        if one < other && coplanar(faces[one], faces[other], planes[one], planes[other]) {
            groups.join(one, other);
        }
    }
    groups.count()
}

/// A point and the unit normal of a face; `None` when it has no area.
fn plane(face: &ShapeFace) -> Option<(Point3<f64>, Vector3<f64>)> {
    let ring = face.rings.first()?;
    Some((*ring.first()?, newell(ring).try_normalize(1e-12)?))
}

type FacePlane = Option<(Point3<f64>, Vector3<f64>)>;

fn coplanar(a: &ShapeFace, b: &ShapeFace, plane_a: FacePlane, plane_b: FacePlane) -> bool {
    let (Some((point_a, normal_a)), Some((point_b, normal_b))) = (plane_a, plane_b) else { return true };
    let on = |face: &ShapeFace, point: Point3<f64>, normal: Vector3<f64>| {
        face.rings.iter().flatten().all(|p| (p - point).dot(&normal).abs() <= 0.01)
    };
    normal_a.dot(&normal_b) >= 1.0_f64.to_radians().cos() && on(b, point_a, normal_a) && on(a, point_b, normal_b)
}

/// Disjoint sets with path halving.
struct Groups(Vec<usize>);

impl Groups {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    fn root(&mut self, mut i: usize) -> usize {
        while self.0[i] != i {
            self.0[i] = self.0[self.0[i]];
            i = self.0[i];
        }
        i
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }

    fn count(&self) -> usize {
        self.0.iter().enumerate().filter(|(i, parent)| i == *parent).count()
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::tests::block;
    use super::*;

    #[test]
    fn triangles_of_a_block_merge_into_six_faces() {
        let block = block("a", [0.0; 3], [4.0, 5.0, 6.0]);
        let faces =
            block.triangles.iter().map(|(t, _)| ShapeFace { rings: vec![t.to_vec()], kind: None, solid: 0 }).collect();
        let triangulated = Shape::new("a", faces, &[]);
        assert_eq!(count_faces(&triangulated), [FaceCount { faces: 12, merged: 6, triangles: 12 }]);
        assert_eq!(count_faces(&block), [FaceCount { faces: 6, merged: 6, triangles: 12 }]);
    }

    #[test]
    fn faces_on_one_plane_that_do_not_touch_stay_two_and_solids_are_apart() {
        let near = block("a", [0.0; 3], [1.0; 3]);
        let mut far = block("a", [3.0, 0.0, 0.0], [4.0, 1.0, 1.0]);
        far.faces.iter_mut().for_each(|f| f.solid = 1);
        let faces = near.faces.iter().chain(&far.faces).cloned().collect();
        assert_eq!(count_faces(&Shape::new("a", faces, &[])).iter().map(|c| c.merged).collect::<Vec<_>>(), [6, 6]);
    }
}
