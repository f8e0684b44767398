//! What is true of a place: exactly for a model, as far as it was scanned for a real building.

use nalgebra::{Point3, Vector3};

use super::super::mesh::Mesh;
use super::super::random::{Draw, Random};
use super::super::real::Seen;
use super::super::truth::Truth;
use crate::geometry::Aabb;

/// Standard deviations of the distance of queries to the surface, in units of the scale; half of them have either.
const OFFSETS: [f64; 2] = [0.01, 0.04];

/// The truth about a building.
pub(super) trait Answers {
    /// Whether a place is inside; `None` where nobody knows.
    fn inside(&self, p: &Point3<f64>) -> Option<bool>;

    /// Distance to the surface, metres. Where the truth is not exact, only good to tell what is near it.
    fn distance(&self, p: &Point3<f64>) -> f64;

    /// Whether everything is known, distances too.
    fn is_exact(&self) -> bool;

    /// The box of the building.
    fn aabb(&self) -> &Aabb;

    /// Places near the surface.
    fn near(&self, count: usize, scale: f64, random: &mut Random) -> Vec<Point3<f64>>;
}

/// The truth about a model.
pub(super) struct Exact<'a> {
    mesh: &'a Mesh,
    truth: Truth,
}

impl<'a> Exact<'a> {
    /// `None` for a mesh without triangles.
    pub fn new(mesh: &'a Mesh) -> Option<Self> {
        Some(Self { mesh, truth: Truth::new(mesh)? })
    }
}

impl Answers for Exact<'_> {
    fn inside(&self, p: &Point3<f64>) -> Option<bool> {
        Some(self.truth.is_inside(p))
    }

    fn distance(&self, p: &Point3<f64>) -> f64 {
        self.truth.distance(p)
    }

    fn is_exact(&self) -> bool {
        true
    }

    fn aabb(&self) -> &Aabb {
        self.truth.aabb()
    }

    /// Along its normals.
    fn near(&self, count: usize, scale: f64, random: &mut Random) -> Vec<Point3<f64>> {
        let mut total = 0.0;
        let ends: Vec<f64> = self
            .mesh
            .all_corners()
            .map(|[a, b, c]| {
                total += (b - a).cross(&(c - a)).norm() / 2.0;
                total
            })
            .collect();
        (0..count)
            .map(|i| {
                let at = random.between(0.0, total);
                let triangle = ends.partition_point(|&end| end <= at).min(ends.len().saturating_sub(1));
                let corners = self.mesh.corners(triangle);
                let [a, b, c] = corners;
                let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
                random.in_triangle(&corners) + normal * (OFFSETS[i % 2] * scale * random.normal())
            })
            .collect()
    }
}

impl Answers for Seen {
    fn inside(&self, p: &Point3<f64>) -> Option<bool> {
        self.is_inside(p)
    }

    fn distance(&self, p: &Point3<f64>) -> f64 {
        self.clearance(p)
    }

    fn is_exact(&self) -> bool {
        false
    }

    fn aabb(&self) -> &Aabb {
        Self::aabb(self)
    }

    /// Around the points on top, in all directions.
    fn near(&self, count: usize, scale: f64, random: &mut Random) -> Vec<Point3<f64>> {
        let near = |i: usize| {
            let top = *self.tops().get(random.below(self.tops().len()))?;
            Some(top + Vector3::from_fn(|_, _| OFFSETS[i % 2] * scale * random.normal()))
        };
        (0..count).filter_map(near).collect()
    }
}
