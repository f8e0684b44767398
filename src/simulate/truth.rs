//! The truth about a building: inside or outside, and how far the surface is.

use nalgebra::Point3;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;

use super::mesh::Mesh;
use crate::geometry::Aabb;

/// The exact signed distance of a closed mesh.
pub struct Truth {
    mesh: TriMesh,
    /// The triangles that do not stand upright, seen from above.
    triangles: Vec<Triangle>,
    aabb: Aabb,
}

/// A triangle over the plane.
struct Triangle {
    corners: [Point3<f64>; 3],
    /// 1 when it looks up, −1 when it looks down.
    winding: i32,
    low: [f64; 2],
    high: [f64; 2],
}

impl Truth {
    /// The truth about a closed mesh whose triangles look outwards, in the frame of the mesh; `None` when it has no
    /// triangles.
    pub fn new(mesh: &Mesh) -> Option<Self> {
        let vertices = mesh.vertices.iter().map(|p| Vector::new(p.x, p.y, p.z)).collect();
        let triangles = mesh.all_corners().filter_map(|corners| {
            let [a, b, c] = corners;
            let turn = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
            let winding = if turn > 0.0 { 1 } else { -1 };
            let low = [0, 1].map(|i| a[i].min(b[i]).min(c[i]));
            let high = [0, 1].map(|i| a[i].max(b[i]).max(c[i]));
            (turn != 0.0).then_some(Triangle { corners, winding, low, high })
        });
        Some(Self {
            triangles: triangles.collect(),
            aabb: mesh.aabb()?,
            mesh: TriMesh::new(vertices, mesh.triangles.clone()).ok()?,
        })
    }

    /// Whether a point is inside: how often the surface winds around it, counted along the ray straight up.
    ///
    /// The ray belongs to one of two triangles that share an edge over the point, never to both or none, since both ask
    /// the same question of the same edge: a ray through an edge or a vertex counts as any other.
    pub fn is_inside(&self, p: &Point3<f64>) -> bool {
        if (0..3).any(|i| p[i] < self.aabb.min[i] || p[i] > self.aabb.max[i]) {
            return false;
        }
        let over = self.triangles.iter().filter(|t| t.is_over(p));
        over.map(|t| t.winding).sum::<i32>() > 0
    }

    /// Distance to the surface, metres, not negative.
    pub fn distance(&self, p: &Point3<f64>) -> f64 {
        let point = Vector::new(p.x, p.y, p.z);
        (self.mesh.project_local_point(point, false).point - point).length()
    }

    /// Signed distance to the surface, metres; positive inside, as in the paper.
    pub fn signed_distance(&self, p: &Point3<f64>) -> f64 {
        let distance = self.distance(p);
        if self.is_inside(p) { distance } else { -distance }
    }

    /// The box of the building.
    pub fn aabb(&self) -> &Aabb {
        &self.aabb
    }
}

impl Triangle {
    /// Whether the ray straight up from `p` meets the triangle.
    fn is_over(&self, p: &Point3<f64>) -> bool {
        if p.x < self.low[0] || p.x > self.high[0] || p.y < self.low[1] || p.y > self.high[1] {
            return false;
        }
        let [a, b, c] = &self.corners;
        if crosses(a, b, p) ^ crosses(b, c, p) ^ crosses(c, a, p) {
            let normal = (b - a).cross(&(c - a));
            return normal.dot(&(p - a)) * f64::from(self.winding) < 0.0;
        }
        false
    }
}

/// Whether a ray from `p` along x meets the edge in the plane; the same whichever way the edge runs.
fn crosses(a: &Point3<f64>, b: &Point3<f64>, p: &Point3<f64>) -> bool {
    if (a.y <= p.y) == (b.y <= p.y) {
        return false;
    }
    let (low, high) = if a.y < b.y { (a, b) } else { (b, a) };
    (p.x - low.x) * (high.y - low.y) < (p.y - low.y) * (high.x - low.x)
}

#[cfg(test)]
mod tests {
    use nalgebra::{Matrix3, Vector3};

    use super::super::mesh::tests::{block, house};
    use super::super::random::{Draw, Random};
    use super::*;

    /// The winding number by solid angles (van Oosterom and Strackee 1983): another road to the same.
    fn winding_number(mesh: &Mesh, p: &Point3<f64>) -> f64 {
        let angle = |corners: [Point3<f64>; 3]| {
            let [a, b, c] = corners.map(|q| q - p);
            let below =
                a.norm() * b.norm() * c.norm() + a.dot(&b) * c.norm() + b.dot(&c) * a.norm() + c.dot(&a) * b.norm();
            2.0 * a.dot(&b.cross(&c)).atan2(below)
        };
        mesh.all_corners().map(angle).sum::<f64>() / (4.0 * std::f64::consts::PI)
    }

    #[test]
    fn the_house_is_as_worked_out_by_hand() {
        let truth = Truth::new(&Mesh::of(&house())).unwrap();
        let signed = |x, y, z| truth.signed_distance(&Point3::new(x, y, z));
        // Under the ridge: 1 m below it, the slopes fall by 45°.
        assert!((signed(5.0, 3.0, 7.0) - 0.5_f64.sqrt()).abs() < 1e-12);
        assert!((signed(5.0, 3.0, 1.0) - 1.0).abs() < 1e-12);
        assert!((signed(5.0, 0.5, 2.0) - 0.5).abs() < 1e-12);
        assert!((signed(5.0, 3.0, 9.0) + 1.0).abs() < 1e-12);
        assert!((signed(13.0, 10.0, 2.0) + 5.0).abs() < 1e-12);
        // Over the eaves, 1 m out and 1 m up: the edge is nearest.
        assert!((signed(5.0, -1.0, 6.0) + 2.0_f64.sqrt()).abs() < 1e-12);
        assert!(signed(5.0, 3.0, -1.0) < 0.0);
    }

    #[test]
    fn rays_through_edges_and_corners_count_once() {
        let truth = Truth::new(&Mesh::of(&block([0, 0, 0], [100, 100, 100]))).unwrap();
        // The diagonal of a square is an edge of its triangles, and so are the lines through its corners.
        for i in 1..100 {
            let t = f64::from(i) / 10.0;
            assert!(truth.is_inside(&Point3::new(t, t, 5.0)) && truth.is_inside(&Point3::new(t, 10.0 - t, 5.0)));
            assert!(!truth.is_inside(&Point3::new(t, t, 10.5)) && !truth.is_inside(&Point3::new(t, t, -0.5)));
        }
    }

    #[test]
    fn the_sign_agrees_with_the_winding_number() {
        let mut random = Random::new(5);
        let tilt = Matrix3::new(1.0, 0.3, 0.1, -0.2, 0.9, 0.0, 0.1, -0.3, 1.2);
        let shapes = [Mesh::of(&house()), Mesh::of(&house()).mapped(&tilt, &Vector3::new(0.1, 0.2, 0.3)), arcade()];
        for mesh in shapes {
            let truth = Truth::new(&mesh).unwrap();
            let Aabb { min, max } = *truth.aabb();
            let mut inside = 0;
            for _ in 0..3000 {
                let p = Point3::from(std::array::from_fn(|i| random.between(min[i] - 1.0, max[i] + 1.0)));
                let expected = winding_number(&mesh, &p) > 0.5;
                assert_eq!(truth.is_inside(&p), expected, "{p}");
                inside += usize::from(expected);
            }
            assert!((500..2500).contains(&inside));
        }
    }

    /// A table: a slab on two legs, as one shell of 16 vertices, drawn from its profile.
    fn arcade() -> Mesh {
        let profile = [[0, 0], [20, 0], [20, 30], [80, 30], [80, 0], [100, 0], [100, 50], [0, 50]];
        let n = profile.len() as u32;
        let vertices = [0, 60].iter().flat_map(|&y| profile.map(|[x, z]| [x, y, z])).collect();
        let mut rings: Vec<Vec<u32>> = vec![(0..n).collect(), (n..2 * n).rev().collect()];
        rings.extend((0..n).map(|i| vec![i, i + n, (i + 1) % n + n, (i + 1) % n]));
        let faces = rings.into_iter().map(|ring| crate::solid::Face { rings: vec![ring], surface: 0 }).collect();
        Mesh::of(&crate::solid::Solid { vertices, faces, ..house() })
    }

    #[test]
    fn under_an_arcade_is_outside() {
        let truth = Truth::new(&arcade()).unwrap();
        assert!((truth.signed_distance(&Point3::new(5.0, 3.0, 2.0)) + 1.0).abs() < 1e-12);
        assert!((truth.signed_distance(&Point3::new(5.0, 3.0, 4.5)) - 0.5).abs() < 1e-12);
        assert!((truth.signed_distance(&Point3::new(1.5, 3.0, 1.5)) - 0.5).abs() < 1e-12);
    }
}
