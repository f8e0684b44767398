//! A building of a city model, ready for measuring.

use nalgebra::{Point3, Vector3};

use crate::building::Building;
use crate::geometry::{Aabb, Cover, newell, triangulate};
use crate::solid::{Solid, SurfaceType};

/// A planar polygon of a [`Shape`].
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeFace {
    /// Exterior ring, counter-clockwise seen from outside, then holes; first vertex not repeated; local metres.
    pub rings: Vec<Vec<Point3<f64>>>,
    /// What the face is; `None` when the model does not say, and then its slope decides.
    pub kind: Option<SurfaceType>,
    /// Which solid of the building it belongs to, counted from 0.
    pub solid: u32,
}

/// A building of a city model in one level of detail, in local metres: all faces of all its parts.
#[derive(Debug, Clone)]
pub struct Shape {
    /// The building's id.
    pub id: String,
    /// The faces as the model has them.
    pub faces: Vec<ShapeFace>,
    /// The type of each face.
    pub kinds: Vec<SurfaceType>,
    /// Triangles of the faces, turning the same way, each with the index of its face.
    pub triangles: Vec<([Point3<f64>; 3], u32)>,
    /// Triangles of the outline: those of the LoD 0 footprint, else of the ground faces, else of the roofs.
    pub outline: Vec<[Point3<f64>; 3]>,
    /// Number of solids.
    pub solids: u32,
}

impl Shape {
    /// A shape of these faces. `footprint` are the polygons of the LoD 0 footprint, if there is one.
    pub fn new(id: impl Into<String>, faces: Vec<ShapeFace>, footprint: &[Vec<Vec<Point3<f64>>>]) -> Self {
        let lowest = faces.iter().flat_map(|f| f.rings.iter().flatten()).map(|p| p.z).fold(f64::INFINITY, f64::min);
        let kinds: Vec<SurfaceType> =
            faces.iter().map(|face| face.kind.unwrap_or_else(|| kind_by_slope(face, lowest))).collect();
        let triangles: Vec<_> = faces
            .iter()
            .zip(0_u32..)
            .flat_map(|(face, index)| triangulate(&face.rings).into_iter().map(move |t| (t, index)))
            .collect();
        let of_kind = |kind: SurfaceType| -> Vec<[Point3<f64>; 3]> {
            let is_kind = |index: u32| kinds.get(index as usize) == Some(&kind);
            triangles.iter().filter(|(_, face)| is_kind(*face)).map(|(t, _)| *t).collect()
        };
        let mut outline: Vec<_> = footprint.iter().flat_map(|polygon| triangulate(polygon)).collect();
        for kind in [SurfaceType::Ground, SurfaceType::Roof] {
            if outline.is_empty() {
                outline = of_kind(kind);
            }
        }
        let solids = faces.iter().map(|f| f.solid + 1).max().unwrap_or(0);
        Self { id: id.into(), faces, kinds, triangles, outline, solids }
    }

    /// The shape of a reconstructed building, in its own frame: LoD 2.2 where it has one, else LoD 1.2. `None` when it
    /// has no solid.
    pub fn of_building(building: &Building) -> Option<Self> {
        let solids: Vec<&Solid> =
            building.model.parts.iter().filter_map(|p| p.lod22.as_ref().or(p.lod12.as_ref())).collect();
        let mut faces = Vec::new();
        for (solid, index) in solids.iter().zip(0_u32..) {
            faces.extend(solid.faces.iter().map(|face| ShapeFace {
                rings: face.rings.iter().map(|ring| ring.iter().map(|&v| solid.point(v)).collect()).collect(),
                kind: Some(solid.kind(face)),
                solid: index,
            }));
        }
        let step = building.frame.step();
        let ground = building.model.ground as f64 * step[2];
        let lift = |p: &[i64; 2]| Point3::new(p[0] as f64 * step[0], p[1] as f64 * step[1], ground);
        let footprint: Vec<Vec<Vec<Point3<f64>>>> = building
            .model
            .footprint
            .iter()
            .map(|polygon| polygon.iter().map(|ring| ring.iter().map(lift).collect()).collect())
            .collect();
        (!faces.is_empty()).then(|| Self::new(&building.id, faces, &footprint))
    }

    /// The type of a face.
    pub fn kind(&self, face: u32) -> SurfaceType {
        self.kinds.get(face as usize).copied().unwrap_or(SurfaceType::Wall)
    }

    /// The triangles of one type of face.
    pub fn triangles_of(&self, kind: SurfaceType) -> impl Iterator<Item = [Point3<f64>; 3]> + '_ {
        self.triangles.iter().filter(move |(_, face)| self.kind(*face) == kind).map(|(t, _)| *t)
    }

    /// The roofs, indexed by what lies below them.
    pub fn roofs(&self) -> Cover {
        Cover::new(self.triangles_of(SurfaceType::Roof))
    }

    /// The box of all vertices; `None` without faces.
    pub fn aabb(&self) -> Option<Aabb> {
        Aabb::of(self.faces.iter().flat_map(|face| face.rings.iter().flatten()))
    }

    /// Volume by the divergence theorem in cubic metres; meaningful for closed shells only.
    pub fn volume(&self) -> f64 {
        let Some((first, _)) = self.triangles.first() else { return 0.0 };
        let anchor = first[0];
        let six: f64 =
            self.triangles.iter().map(|([a, b, c], _)| (b - anchor).cross(&(c - anchor)).dot(&(a - anchor))).sum();
        six / 6.0
    }
}

/// The type of a face without semantics, from where it looks: up is roof, down is ground when it touches the lowest
/// height of the building and an underside otherwise, and what is steeper than 84° is wall.
fn kind_by_slope(face: &ShapeFace, lowest: f64) -> SurfaceType {
    let vector: Vector3<f64> = face.rings.first().map_or_else(Vector3::zeros, |ring| newell(ring));
    let up = if vector.norm() > 0.0 { vector.z / vector.norm() } else { 0.0 };
    let touches_lowest = face.rings.iter().flatten().any(|p| p.z < lowest + 0.01);
    match up {
        _ if up > 0.1 => SurfaceType::Roof,
        _ if up < -0.1 && touches_lowest => SurfaceType::Ground,
        _ if up < -0.1 => SurfaceType::OuterCeiling,
        _ => SurfaceType::Wall,
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;

    /// An axis-aligned block without semantics, as one solid.
    pub fn block(id: &str, min: [f64; 3], max: [f64; 3]) -> Shape {
        let corner = |i: usize| {
            let pick = |axis: usize| if i >> axis & 1 == 1 { max[axis] } else { min[axis] };
            Point3::new(pick(0), pick(1), pick(2))
        };
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
        let faces = quads
            .map(|quad| ShapeFace { rings: vec![quad.iter().map(|&i| corner(i)).collect()], kind: None, solid: 0 })
            .to_vec();
        Shape::new(id, faces, &[])
    }

    #[test]
    fn a_block_without_semantics_is_understood() {
        use SurfaceType::{Ground, Roof, Wall};
        let shape = block("a", [0.0, 0.0, 1.0], [2.0, 3.0, 5.0]);
        assert_eq!(shape.kinds, [Ground, Roof, Wall, Wall, Wall, Wall]);
        assert!((shape.volume() - 24.0).abs() < 1e-12);
        assert_eq!(shape.roofs().nearest_height(1.0, 1.0, 0.0), Some(5.0));
        assert_eq!((shape.triangles.len(), shape.outline.len(), shape.solids), (12, 2, 1));
        assert_eq!(shape.aabb().unwrap().extent(), [2.0, 3.0, 4.0]);
    }
}
