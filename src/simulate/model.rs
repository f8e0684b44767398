//! The models that are scanned, whatever they come from.

use std::sync::Arc;

use geo::{MapCoords, MultiPolygon};
use nalgebra::{Matrix3, Point3, Vector3};

use super::mesh::Mesh;
use super::random::Random;
use crate::site::Frame;
use crate::solid::Solid;

/// A closed building with what stands around it.
#[derive(Debug, Clone)]
pub struct Model {
    /// Its id, unique in its source.
    pub id: String,
    /// The tile that it is of: buildings of one tile are never in two splits.
    pub tile: Arc<str>,
    /// What kind of roof it has, where the source says so.
    pub shape: Option<String>,
    /// The local frame of everything below; may be shared by all models of a source.
    pub frame: Frame,
    /// The closed, outward solid on the grid of the frame.
    pub solid: Arc<Solid>,
    /// The same as triangles, local metres.
    pub mesh: Arc<Mesh>,
    /// The outline of its roofs, local metres.
    pub footprint: MultiPolygon<f64>,
    /// Height of the ground, metres in the local frame.
    pub ground: f64,
    /// What stands so near that it hides parts of the building or touches it.
    pub neighbours: Vec<Arc<Mesh>>,
}

/// A model where it is scanned: the building near the origin of a frame of its own, augmented or as it stands.
#[derive(Debug, Clone)]
pub struct Placed {
    /// The local frame of everything below; its origin is near the centre of the footprint.
    pub frame: Frame,
    /// The building, local metres.
    pub mesh: Mesh,
    /// The outline of its roofs, local metres.
    pub footprint: MultiPolygon<f64>,
    /// Height of the ground, metres in the local frame.
    pub ground: f64,
    /// What stands around it, local metres.
    pub neighbours: Vec<Mesh>,
}

impl Model {
    /// The model as it stands.
    pub fn placed(&self) -> Placed {
        self.mapped(&Matrix3::identity())
    }

    /// The model mirrored or not, turned about the vertical by any angle, and scaled by 0.8 to 1.25 along x and y and by
    /// 0.7 to 1.4 along z: another building that is as closed as the first.
    pub(super) fn augmented(&self, random: &mut Random) -> Placed {
        let (sin, cos) = random.between(0.0, std::f64::consts::TAU).sin_cos();
        let [x, y] = [random.between(0.8, 1.25), random.between(0.8, 1.25)];
        let z = random.between(0.7, 1.4);
        let x = if random.chance(0.5) { -x } else { x };
        let turn = Matrix3::new(cos, -sin, 0.0, sin, cos, 0.0, 0.0, 0.0, 1.0);
        self.mapped(&(turn * Matrix3::from_diagonal(&Vector3::new(x, y, z))))
    }

    /// The model under a linear map about a whole CRS place near the centre of its footprint, at the ground.
    fn mapped(&self, linear: &Matrix3<f64>) -> Placed {
        let centre = geo::BoundingRect::bounding_rect(&self.footprint).map_or_else(Point3::origin, |rect| {
            let centre = rect.center();
            Point3::new(centre.x, centre.y, self.ground)
        });
        let units: [f64; 3] = std::array::from_fn(|i| (centre[i] / self.frame.metres_per_unit[i]).round());
        let origin = std::array::from_fn(|i| self.frame.origin[i] + units[i]);
        let centre = Vector3::from_fn(|i, _| units[i] * self.frame.metres_per_unit[i]);
        let shift = -(linear * centre);
        Placed {
            frame: Frame { origin, ..self.frame },
            mesh: self.mesh.mapped(linear, &shift),
            footprint: map_outline(&self.footprint, linear, &shift),
            ground: linear.m33 * self.ground + shift.z,
            neighbours: self.neighbours.iter().map(|mesh| mesh.mapped(linear, &shift)).collect(),
        }
    }
}

/// An outline under an affine map that leaves the vertical alone; exteriors stay counter-clockwise.
pub(super) fn map_outline(
    outline: &MultiPolygon<f64>,
    linear: &Matrix3<f64>,
    shift: &Vector3<f64>,
) -> MultiPolygon<f64> {
    use geo::Orient;
    let mapped = outline.map_coords(|c| {
        let p = linear * Point3::new(c.x, c.y, 0.0) + shift;
        geo::Coord { x: p.x, y: p.y }
    });
    mapped.orient(geo::orient::Direction::Default)
}

#[cfg(test)]
pub(super) mod tests {
    use geo::Area;

    use super::super::mesh::tests::house;
    use super::*;

    /// The house of the tests of [`Mesh`], 3 km from the origin of its frame.
    pub fn model() -> Model {
        let solid =
            Solid { vertices: house().vertices.iter().map(|[x, y, z]| [x + 30_000, *y, z + 70]).collect(), ..house() };
        let mesh = Arc::new(Mesh::of(&solid));
        Model {
            id: "house".into(),
            tile: "tile".into(),
            shape: None,
            frame: Frame { origin: [1000.0, 2000.0, 0.0], metres_per_unit: [1.0; 3] },
            solid: Arc::new(solid),
            footprint: mesh.outline(),
            mesh,
            ground: 7.0,
            neighbours: Vec::new(),
        }
    }

    #[test]
    fn a_placed_model_is_where_it_was() {
        let model = model();
        let placed = model.placed();
        assert_eq!(placed.frame.origin, [4005.0, 2003.0, 7.0]);
        assert_eq!(placed.ground, 0.0);
        for (there, here) in model.mesh.vertices.iter().zip(&placed.mesh.vertices) {
            assert_eq!(model.frame.to_crs(there), placed.frame.to_crs(here));
        }
    }

    #[test]
    fn augmentation_changes_the_size_within_bounds_and_keeps_the_solid_outward() {
        let model = model();
        for seed in 0..20 {
            let placed = model.augmented(&mut Random::new(seed));
            let outside: f64 =
                placed.mesh.all_corners().map(|[a, b, c]| a.coords.dot(&b.coords.cross(&c.coords)) / 6.0).sum();
            let ratio = outside / 390.0;
            assert!((0.7 * 0.64..1.4 * 1.5625).contains(&ratio), "{ratio}");
            assert!(placed.footprint.signed_area() > 0.0);
            assert!((placed.footprint.unsigned_area() - placed.mesh.outline().unsigned_area()).abs() < 1e-6);
            assert!(placed.mesh.aabb().unwrap().min[2].abs() < 1e-9 && placed.ground.abs() < 1e-9);
        }
    }
}
