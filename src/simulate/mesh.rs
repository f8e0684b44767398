//! Triangle meshes of buildings, in metres.

use std::collections::BTreeMap;

use geo::{BooleanOps, Coord, LineString, MultiPolygon, Polygon, Simplify};
use nalgebra::{Matrix3, Point3, Vector3};

use crate::evaluate::triangulate;
use crate::geometry::Aabb;
use crate::solid::Solid;

/// Faces with less slope than this from the vertical are walls (cosine of the normal to the vertical).
const WALL: f64 = 0.1;
/// Holes and slivers of an outline that are smaller are of the rounding, square metres.
const SLIVER: f64 = 0.05;
/// Vertices of an outline nearer than this to the line between their neighbours are not corners, metres.
const STRAIGHT: f64 = 0.005;

/// A closed shell of triangles that look outwards, with the face that each is of.
#[derive(Debug, Clone, Default)]
pub struct Mesh {
    /// Vertices in metres of the frame of its [`Model`](super::Model).
    pub vertices: Vec<Point3<f64>>,
    /// Vertex indices of the triangles, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The number of the face of each triangle; its parts in one plane need not be one face.
    pub faces: Vec<u32>,
}

impl Mesh {
    /// The mesh of a solid.
    pub fn of(solid: &Solid) -> Self {
        let mut mesh =
            Self { vertices: (0..solid.vertices.len() as u32).map(|v| solid.point(v)).collect(), ..Self::default() };
        // Triangles come back with coordinates, and no two vertices of a solid have the same.
        let bits = |p: &Point3<f64>| p.coords.data.0[0].map(f64::to_bits);
        let indices: BTreeMap<[u64; 3], u32> = mesh.vertices.iter().map(bits).zip(0..).collect();
        for (face, number) in solid.faces.iter().zip(0..) {
            let rings: Vec<Vec<Point3<f64>>> =
                face.rings.iter().map(|ring| ring.iter().map(|&v| solid.point(v)).collect()).collect();
            for triangle in triangulate(&rings) {
                let [a, b, c] = triangle.map(|p| indices.get(&bits(&p)).copied());
                if let (Some(a), Some(b), Some(c)) = (a, b, c) {
                    mesh.triangles.push([a, b, c]);
                    mesh.faces.push(number);
                }
            }
        }
        mesh
    }

    /// The corners of a triangle; the origin for those that do not exist.
    pub fn corners(&self, triangle: usize) -> [Point3<f64>; 3] {
        let corner = |v: u32| self.vertices.get(v as usize).copied().unwrap_or_else(Point3::origin);
        self.triangles.get(triangle).map_or([Point3::origin(); 3], |t| t.map(corner))
    }

    /// The corners of all triangles.
    pub fn all_corners(&self) -> impl ExactSizeIterator<Item = [Point3<f64>; 3]> + '_ {
        (0..self.triangles.len()).map(|t| self.corners(t))
    }

    /// The box around it; `None` without vertices.
    pub fn aabb(&self) -> Option<Aabb> {
        Aabb::of(&self.vertices)
    }

    /// The mesh under an affine map; a map that mirrors turns the triangles around, so that they still look outwards.
    #[must_use]
    pub fn mapped(&self, linear: &Matrix3<f64>, shift: &Vector3<f64>) -> Self {
        let mirrors = linear.determinant() < 0.0;
        Self {
            vertices: self.vertices.iter().map(|p| linear * p + shift).collect(),
            triangles: self.triangles.iter().map(|&[a, b, c]| if mirrors { [a, c, b] } else { [a, b, c] }).collect(),
            faces: self.faces.clone(),
        }
    }

    /// The outline of what is under its roofs: the union of the faces that look up, seen from above.
    pub fn outline(&self) -> MultiPolygon<f64> {
        let looking_up = self.all_corners().filter(|[a, b, c]| {
            let normal = (b - a).cross(&(c - a));
            normal.z > WALL * normal.norm()
        });
        let triangles: Vec<Polygon<f64>> = looking_up
            .map(|corners| Polygon::new(corners.iter().map(|p| Coord { x: p.x, y: p.y }).collect(), Vec::new()))
            .collect();
        let union = geo::unary_union(&triangles);
        let cleaned = union.into_iter().filter(|p| is_area(p.exterior())).map(|polygon| {
            let (exterior, holes) = polygon.into_inner();
            Polygon::new(exterior, holes.into_iter().filter(is_area).collect()).simplify(STRAIGHT)
        });
        // A union with nothing puts the rings into the order and direction that footprints have.
        MultiPolygon::new(cleaned.collect()).union(&MultiPolygon::new(Vec::new()))
    }
}

/// Whether a ring encloses more than the rounding could.
fn is_area(ring: &LineString<f64>) -> bool {
    geo::Area::unsigned_area(&Polygon::new(ring.clone(), Vec::new())) > SLIVER
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::solid::{Face, Surface, SurfaceType};

    /// A block with its lowest corner at `low` and its highest at `high`, in decimetres.
    pub fn block(low: [i64; 3], high: [i64; 3]) -> Solid {
        let vertices = (0..8).map(|i| std::array::from_fn(|a| if i >> a & 1 == 1 { high[a] } else { low[a] }));
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
        Solid {
            step: [0.1; 3],
            vertices: vertices.collect(),
            faces: quads.map(|quad| Face { rings: vec![quad.to_vec()], surface: 0 }).to_vec(),
            surfaces: vec![Surface::of(SurfaceType::Wall)],
        }
    }

    /// A house of 10 m by 6 m, eaves at 5 m and the ridge, along x, at 8 m.
    pub fn house() -> Solid {
        let vertices = vec![
            [0, 0, 0],
            [100, 0, 0],
            [100, 60, 0],
            [0, 60, 0],
            [0, 0, 50],
            [100, 0, 50],
            [100, 60, 50],
            [0, 60, 50],
            [0, 30, 80],
            [100, 30, 80],
        ];
        let rings: [&[u32]; 7] = [
            &[0, 3, 2, 1],
            &[0, 1, 5, 4],
            &[1, 2, 6, 9, 5],
            &[2, 3, 7, 6],
            &[3, 0, 4, 8, 7],
            &[4, 5, 9, 8],
            &[6, 7, 8, 9],
        ];
        Solid {
            step: [0.1; 3],
            vertices,
            faces: rings.iter().map(|ring| Face { rings: vec![ring.to_vec()], surface: 0 }).collect(),
            surfaces: vec![Surface::of(SurfaceType::Wall)],
        }
    }

    #[test]
    fn a_mesh_keeps_the_volume_and_is_closed() {
        let mesh = Mesh::of(&house());
        // 10 · 6 · 5 and a prism of 10 · 6 · 3 / 2.
        let volume = |mesh: &Mesh| {
            mesh.all_corners().map(|[a, b, c]| a.coords.dot(&b.coords.cross(&c.coords)) / 6.0).sum::<f64>()
        };
        assert!((volume(&mesh) - 390.0).abs() < 1e-9);
        let mirrored =
            mesh.mapped(&Matrix3::from_diagonal(&Vector3::new(-2.0, 1.0, 0.5)), &Vector3::new(1.0, 2.0, 3.0));
        assert!((volume(&mirrored) - 390.0).abs() < 1e-9);
        let mut edges: Vec<[u32; 2]> = mesh.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        edges.sort_unstable();
        assert!(edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok()));
    }

    #[test]
    fn the_outline_is_what_the_roofs_cover() {
        use geo::{Area, CoordsIter};
        let outline = Mesh::of(&house()).outline();
        assert!((outline.unsigned_area() - 60.0).abs() < 1e-9);
        assert_eq!(outline.coords_count(), 5, "the ends of the ridge are no corners");
    }
}
