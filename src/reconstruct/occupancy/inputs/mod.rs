//! The inputs of a network (paper, section 3.3): what is known of a building and of a place in it, as numbers.
//!
//! Training sets and reconstruction take them from here alike, so that a network meets at work what it was trained on.
//!
//! The *field frame* of a building: x and y are 0 at the centre of the outline's box (without a footprint, of the
//! points'), z is 0 at the ground, and lengths are divided by the scale, the largest side of the box from the ground to
//! the highest roof point. Buildings that are too large for a raster are looked at through `windows`, each with a field
//! frame of its own.

mod outline;
mod patch;
mod place;
mod raster;
mod subsample;
#[cfg(test)]
mod tests;
mod windows;

use std::num::NonZero;
use std::sync::Arc;

use kiddo::ImmutableKdTree;
use nalgebra::{Point3, Vector3};

use super::height_field::RoofEvidence;
use crate::geometry::Aabb;
use crate::reconstruct::Partitioned;
pub(crate) use outline::Outline;
pub use patch::PATCH_CHANNELS;
pub use place::PLACE_CHANNELS;
pub use raster::{HALF_WIDTH, RASTER_CHANNELS, lookup};
pub(super) use windows::Windows;

/// Everything that the networks may ask about one building.
#[derive(Debug, Clone)]
pub struct Inputs<'a> {
    building: &'a Partitioned<'a>,
    evidence: RoofEvidence<'a>,
    outline: Option<Arc<Outline>>,
    tree: Option<Arc<ImmutableKdTree<f64, 3>>>,
    /// For each point, the primitive that it lies on.
    owners: Arc<[Option<u32>]>,
    /// The origin of the field frame, local metres.
    origin: Point3<f64>,
    /// Metres per unit of the field frame.
    scale: f64,
    /// Typical distance between neighbouring points in the plan, metres.
    spacing: f64,
    /// Root mean square distance of the points from their primitives, metres.
    noise: f64,
}

impl<'a> Inputs<'a> {
    /// Prepares to answer for a building.
    pub fn new(building: &'a Partitioned) -> Self {
        let site = building.site;
        let hypotheses = &building.hypotheses;
        let coordinates: Vec<[f64; 3]> = site.points.iter().map(|p| [p.x, p.y, p.z]).collect();
        let mut owners = vec![None; site.points.len()];
        let (mut squares, mut count) = (0.0, 0.0);
        for (label, primitive) in (0u32..).zip(&hypotheses.primitives) {
            squares += primitive.residual.powi(2) * primitive.inliers.len() as f64;
            count += primitive.inliers.len() as f64;
            for &inlier in &primitive.inliers {
                if let Some(owner) = owners.get_mut(inlier as usize) {
                    *owner = Some(label);
                }
            }
        }
        let bounds = &hypotheses.bounds;
        let extent = bounds.extent();
        let area = site.footprint.as_ref().map_or(extent[0] * extent[1], geo::Area::unsigned_area);
        Self {
            building,
            evidence: RoofEvidence::new(hypotheses),
            outline: site.footprint.as_ref().map(Outline::new).map(Arc::new),
            tree: ImmutableKdTree::new_from_slice(&coordinates).ok().filter(|_| !coordinates.is_empty()).map(Arc::new),
            owners: owners.into(),
            origin: origin(bounds, site.ground.height),
            scale: scale(bounds),
            spacing: (area / count.max(1.0)).sqrt().clamp(0.05, 5.0),
            noise: (squares / f64::max(count, 1.0)).sqrt(),
        }
    }

    /// The same building seen through a window: with the field frame of this box.
    fn window(&self, bounds: &Aabb) -> Self {
        Self { origin: origin(bounds, self.origin.z), scale: scale(bounds), ..self.clone() }
    }

    /// Metres per unit of the field frame.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// A local point in the field frame.
    pub fn to_field(&self, p: &Point3<f64>) -> Vector3<f64> {
        (p - self.origin) / self.scale
    }

    /// The `count` nearest points of a place and their distances in metres, nearest first; of two at the same distance
    /// the one with the smaller index. Fewer when there are not so many points.
    fn nearest(&self, place: &Point3<f64>, count: usize) -> Vec<(u32, f64)> {
        let (Some(tree), Some(count)) = (&self.tree, NonZero::new(count.min(self.building.site.points.len()))) else {
            return Vec::new();
        };
        let found = tree.query(&[place.x, place.y, place.z]).nearest_n::<kiddo::SquaredEuclidean<f64>>(count).execute();
        let mut found: Vec<(u32, f64)> = found.iter().map(|near| (near.item, near.distance.sqrt())).collect();
        found.sort_unstable_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        found
    }
}

/// The origin of the field frame of a box over the ground, local metres.
fn origin(bounds: &Aabb, ground: f64) -> Point3<f64> {
    let [x, y] = [0, 1].map(|axis| f64::midpoint(bounds.min[axis], bounds.max[axis]));
    Point3::new(x, y, ground)
}

/// Metres per unit of the field frame of a box.
fn scale(bounds: &Aabb) -> f64 {
    bounds.extent().into_iter().fold(1.0, f64::max)
}
