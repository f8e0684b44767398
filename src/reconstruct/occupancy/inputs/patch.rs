//! The local branch (paper, section 3.3): the nearest points of a place, from which the distance to the surface is told.

use nalgebra::Point3;

use super::Inputs;
use crate::reconstruct::hypotheses::WALL_VERTICALITY;

/// What is told of each of the nearest points, in this order. Lengths are divided by the distance of the farthest.
pub const PATCH_CHANNELS: [&str; 7] =
    ["offset_x", "offset_y", "offset_z", "distance", "plane_distance", "plane_upward", "on_plane"];

impl Inputs<'_> {
    /// Appends the `count` × [`PATCH_CHANNELS`] numbers of a place to `patch` and returns the distance of the farthest
    /// of the points, in metres. Where there are fewer points they are repeated.
    ///
    /// `offset` leads from the place to the point. `plane_distance` is that of the place from the plane of the point's
    /// primitive: positive above it, and without a sign for walls, of which nobody knows the outside; `plane_upward` is
    /// the z of that plane's normal.
    pub fn patch(&self, place: &Point3<f64>, count: usize, patch: &mut Vec<f32>) -> f64 {
        let nearest = self.nearest(place, count);
        let radius = nearest.last().map_or(0.0, |&(_, distance)| distance).max(1e-3);
        let points = &self.building.site.points;
        for i in 0..count {
            let Some(&(index, distance)) = nearest.get(i % nearest.len().max(1)) else {
                patch.extend([0.0; PATCH_CHANNELS.len()]);
                continue;
            };
            let offset = (points[index as usize] - place) / radius;
            let owner = self.owners[index as usize].and_then(|label| self.primitive(label));
            let [plane_distance, upward, on_plane] = owner.map_or([0.0; 3], |primitive| {
                let distance = primitive.plane.distance(place) / radius;
                if primitive.plane.verticality() > WALL_VERTICALITY {
                    [distance.abs(), 0.0, 1.0]
                } else {
                    let up = primitive.plane.normal.z;
                    [distance * up.signum(), up.abs(), 1.0]
                }
            });
            let channels = [offset.x, offset.y, offset.z, distance / radius, plane_distance, upward, on_plane];
            patch.extend(channels.map(|value| value as f32));
        }
        radius
    }

    /// Appends the offsets of the `count` nearest points, divided by the distance of the farthest, which is returned in
    /// metres: the patch of Points2Surf.
    pub fn bare_patch(&self, place: &Point3<f64>, count: usize, patch: &mut Vec<f32>) -> f64 {
        let nearest = self.nearest(place, count);
        let radius = nearest.last().map_or(0.0, |&(_, distance)| distance).max(1e-3);
        for i in 0..count {
            let offset = nearest
                .get(i % nearest.len().max(1))
                .map_or_else(nalgebra::Vector3::zeros, |&(index, _)| self.building.site.points[index as usize] - place);
            patch.extend((offset / radius).iter().map(|value| *value as f32));
        }
        radius
    }

    pub(super) fn primitive(&self, label: u32) -> Option<&crate::reconstruct::primitives::Primitive> {
        self.building.hypotheses.primitives.get(label as usize)
    }
}
