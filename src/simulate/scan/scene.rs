//! What pulses meet: the building, what stands around it, trees, the ground.

use geo::{Euclidean, InterpolatableLine, Length, MultiPolygon};
use nalgebra::{Point3, Unit, Vector3};
use parry3d_f64::math::Vector;
use parry3d_f64::query::Ray;
use parry3d_f64::shape::{CompositeShapeRef, TriMesh};

use super::super::mesh::Mesh;
use super::super::model::Placed;
use super::super::random::Random;
use super::super::span::Span;
use crate::geometry::Aabb;

/// Farther than any pulse flies, metres.
const FAR: f64 = 1e6;

/// What sent a pulse back.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Target {
    /// The building: the number of the face.
    Building(u32),
    /// What stands around it.
    Neighbour,
    /// The ground.
    Ground,
    /// A tree.
    Tree,
}

/// A pulse that came back.
#[derive(Debug, Clone, Copy)]
pub(super) struct Return {
    /// Where from, metres.
    pub position: Point3<f64>,
    /// The direction of the pulse.
    pub direction: Unit<Vector3<f64>>,
    /// What sent it back.
    pub target: Target,
    /// The number of the flight strip or of the position of the scanner.
    pub strip: u32,
}

/// A crown: an upright ellipsoid.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tree {
    /// Its centre.
    pub centre: Point3<f64>,
    /// Its radii along x, y and z, metres.
    pub radii: Vector3<f64>,
    /// The share of the pulses that it stops.
    pub opacity: f64,
}

/// All that pulses meet.
pub(super) struct Scene {
    mesh: TriMesh,
    /// The face of each triangle of the building, which are the first.
    faces: Vec<u32>,
    trees: Vec<Tree>,
    ground: Option<f64>,
    /// The box of the building.
    pub aabb: Aabb,
}

impl Scene {
    /// A scene; `None` for a building without triangles. Without `ground` there is none to stop pulses.
    pub fn new(building: &Mesh, around: &[Mesh], trees: Vec<Tree>, ground: Option<f64>) -> Option<Self> {
        let mut vertices = Vec::new();
        let mut triangles = Vec::new();
        for mesh in std::iter::once(building).chain(around) {
            let base = vertices.len() as u32;
            vertices.extend(mesh.vertices.iter().map(|p| Vector::new(p.x, p.y, p.z)));
            triangles.extend(mesh.triangles.iter().map(|t| t.map(|v| v + base)));
        }
        let mesh = TriMesh::new(vertices, triangles).ok()?;
        Some(Self { mesh, faces: building.faces.clone(), trees, ground, aabb: building.aabb()? })
    }

    /// What a pulse meets first, if anything.
    pub fn cast(
        &self,
        origin: &Point3<f64>,
        direction: Unit<Vector3<f64>>,
        strip: u32,
        random: &mut Random,
    ) -> Option<Return> {
        let ray =
            Ray::new(Vector::new(origin.x, origin.y, origin.z), Vector::new(direction.x, direction.y, direction.z));
        let mut nearest = CompositeShapeRef(&self.mesh).cast_local_ray(&ray, FAR, false).map(|(triangle, t)| {
            let face = self.faces.get(triangle as usize);
            (t, face.map_or(Target::Neighbour, |&face| Target::Building(face)))
        });
        let mut offer = |t: f64, target: Target| {
            if t > 0.0 && nearest.is_none_or(|(best, _)| t < best) {
                nearest = Some((t, target));
            }
        };
        if let Some(ground) = self.ground {
            offer((ground - origin.z) / direction.z, Target::Ground);
        }
        for tree in &self.trees {
            let Some([enter, leave]) = tree.chord(origin, &direction) else { continue };
            // What is not stopped flies on through the gaps between the leaves.
            if random.chance(tree.opacity) {
                offer(enter + (leave - enter) * random.unit().powi(2), Target::Tree);
            }
        }
        let (t, target) = nearest?;
        Some(Return { position: origin + direction.into_inner() * t, direction, target, strip })
    }
}

impl Tree {
    /// Where a ray enters the crown and where it leaves it.
    fn chord(&self, origin: &Point3<f64>, direction: &Vector3<f64>) -> Option<[f64; 2]> {
        let o = (origin - self.centre).component_div(&self.radii);
        let d = direction.component_div(&self.radii);
        let (a, b, c) = (d.dot(&d), o.dot(&d), o.dot(&o) - 1.0);
        let root = (b * b - a * c).max(-1.0);
        (root > 0.0).then(|| [(-b - root.sqrt()) / a, (-b + root.sqrt()) / a])
    }

    /// Trees beside the walls of a building and over its eaves.
    pub fn grow(placed: &Placed, top: f64, count: usize, opacity: &Span, random: &mut Random) -> Vec<Self> {
        (0..count).filter_map(|_| Self::beside(&placed.footprint, placed.ground, top, opacity, random)).collect()
    }

    fn beside(outline: &MultiPolygon<f64>, ground: f64, top: f64, opacity: &Span, random: &mut Random) -> Option<Self> {
        let polygon = outline.0.get(random.below(outline.0.len()))?;
        let ring = polygon.exterior();
        let at = random.unit() * Euclidean.length(ring);
        let place = ring.point_at_distance_from_start(&Euclidean, at)?;
        let across = random.between(1.5, 4.0);
        let (angle, off) = (random.between(0.0, std::f64::consts::TAU), random.between(0.0, across + 1.0));
        let height = random.between(1.5, 4.0);
        // From a shrub to a crown that hangs over the roof.
        let middle = ground + height + random.unit() * (top - ground + 1.0 - 0.5 * height).max(0.0);
        Some(Self {
            centre: Point3::new(place.x() + off * angle.cos(), place.y() + off * angle.sin(), middle),
            radii: Vector3::new(across, across * random.between(0.8, 1.25), height),
            opacity: opacity.draw(random),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::mesh::tests::block;
    use super::*;

    fn down() -> Unit<Vector3<f64>> {
        Unit::new_normalize(-Vector3::z())
    }

    #[test]
    fn the_first_thing_in_the_way_is_met() {
        let building = Mesh::of(&block([0, 0, 0], [100, 100, 50]));
        let neighbour = Mesh::of(&block([100, 0, 0], [200, 100, 80]));
        let tree = |opacity| Tree { centre: Point3::new(1.0, 1.0, 6.0), radii: Vector3::repeat(1.0), opacity };
        let scene = Scene::new(&building, &[neighbour], vec![tree(1.0), tree(0.0)], Some(0.0)).unwrap();
        let mut random = Random::new(1);
        let mut cast = |x: f64, y: f64| scene.cast(&Point3::new(x, y, 500.0), down(), 0, &mut random).unwrap();
        let roof = cast(5.0, 5.0);
        assert_eq!(roof.target, Target::Building(1));
        assert!((roof.position - Point3::new(5.0, 5.0, 5.0)).norm() < 1e-9);
        assert_eq!(cast(15.0, 5.0).target, Target::Neighbour);
        assert!((cast(15.0, 5.0).position.z - 8.0).abs() < 1e-9);
        assert_eq!((cast(-3.0, 5.0).target, cast(-3.0, 5.0).position.z.abs() < 1e-9), (Target::Ground, true));
        let crown = cast(1.0, 1.0);
        assert!(crown.target == Target::Tree && (5.0..=7.0).contains(&crown.position.z));
        // A wall, seen at 45°.
        let oblique = Unit::new_normalize(Vector3::new(1.0, 0.0, -1.0));
        let wall = scene.cast(&Point3::new(-10.0, 5.0, 12.0), oblique, 0, &mut random).unwrap();
        assert_eq!(wall.target, Target::Building(5));
        assert!((wall.position - Point3::new(0.0, 5.0, 2.0)).norm() < 1e-9);
    }
}
