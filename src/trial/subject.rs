//! A building on trial: what the scanner saw of it, and the truth.

use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

use nalgebra::Point3;

use super::fraction::inside_fraction;
use crate::evaluate::{Shape, ShapeFace};
use crate::geometry::Random;
use crate::reconstruct::Partitioned;
use crate::simulate::{Mesh, Truth};
use crate::site::Site;

/// Places of each kind at which the sign is asked.
const PLACES: usize = 512;
/// How far places near the surface are from it at most, along its normal, as a share of the largest side of the box
/// (paper, section 3.3).
const NEAR: f64 = 0.02;

/// A scan and the truth about the building.
pub struct Subject {
    /// The scan.
    pub site: Site,
    /// The truth as a shape that surfaces can be compared with.
    pub shape: Shape,
    /// Places near the surface.
    pub near: Places,
    /// Places anywhere in the building's box.
    pub uniform: Places,
    mesh: Mesh,
    truth: Truth,
    /// The cells that were met last, by their volumes, and the true inside fraction of each.
    last: Mutex<Option<Fractions>>,
}

/// The volumes of cells, and the true inside fraction of each.
type Fractions = (Vec<f64>, Arc<Vec<f64>>);

/// Places and whether each is inside.
#[derive(Debug, Clone, Default)]
pub struct Places {
    /// Local metres.
    pub places: Vec<Point3<f64>>,
    /// Whether each is inside.
    pub inside: Vec<bool>,
}

impl Subject {
    /// The truth about a site is a closed mesh in its frame; places are drawn with the seed. `None` without triangles.
    pub fn new(site: Site, mesh: Mesh, seed: u64) -> Option<Self> {
        let truth = Truth::new(&mesh)?;
        let face = |corners: [Point3<f64>; 3]| ShapeFace { rings: vec![corners.to_vec()], kind: None, solid: 0 };
        let shape = Shape::new(&site.id, mesh.all_corners().map(face).collect(), &[]);
        let mut random = Random::new(!seed);
        let near = Places::of(near_surface(&mesh, &truth, &mut random), &truth);
        let aabb = truth.aabb();
        let anywhere = (0..PLACES)
            .map(|_| Point3::from(std::array::from_fn(|i| random.between(aabb.min[i], aabb.max[i]))))
            .collect();
        let uniform = Places::of(anywhere, &truth);
        Some(Self { site, shape, near, uniform, mesh, truth, last: Mutex::new(None) })
    }

    /// The truth.
    pub fn truth(&self) -> &Truth {
        &self.truth
    }

    /// The share of each cell that is inside. Fields of one trial ask about the same cells one after the other, so that
    /// the last answer is kept.
    pub fn fractions(&self, building: &Partitioned) -> Arc<Vec<f64>> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        match &*last {
            Some((volumes, fractions)) if *volumes == building.volumes => Arc::clone(fractions),
            _ => {
                let fractions = Arc::new(inside_fraction(&building.complex, &self.mesh, &self.truth));
                *last = Some((building.volumes.clone(), Arc::clone(&fractions)));
                fractions
            }
        }
    }
}

impl fmt::Debug for Subject {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Subject").field("id", &self.site.id).finish_non_exhaustive()
    }
}

impl Places {
    fn of(places: Vec<Point3<f64>>, truth: &Truth) -> Self {
        let inside = places.iter().map(|p| truth.is_inside(p)).collect();
        Self { places, inside }
    }

    /// Share of the places that these probabilities put on the right side of one half; `None` without places.
    pub fn accuracy(&self, probabilities: &[f64]) -> Option<f64> {
        let right = self.inside.iter().zip(probabilities).filter(|(inside, p)| **inside == (**p > 0.5)).count();
        (!self.inside.is_empty()).then(|| right as f64 / self.inside.len() as f64)
    }
}

/// Places along the normals of a surface, which is met evenly by area.
fn near_surface(mesh: &Mesh, truth: &Truth, random: &mut Random) -> Vec<Point3<f64>> {
    let reach = NEAR * truth.aabb().extent().into_iter().fold(0.0, f64::max);
    let mut total = 0.0;
    let ends: Vec<f64> = mesh
        .all_corners()
        .map(|[a, b, c]| {
            total += (b - a).cross(&(c - a)).norm();
            total
        })
        .collect();
    (0..PLACES)
        .filter_map(|_| {
            let at = random.unit() * total;
            let [a, b, c] = mesh.corners(ends.partition_point(|&end| end <= at).min(ends.len().checked_sub(1)?));
            let (mut u, mut v) = (random.unit(), random.unit());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0)?;
            Some(a + (b - a) * u + (c - a) * v + normal * random.between(-reach, reach))
        })
        .collect()
}
