//! Real scans as training data: what was measured is asked about, what was not is left unknown.
//!
//! ```text
//! tiles, footprints ─► segment ─► RealSite ─┬─► a thinned, cropped, holed copy ─► what the network gets
//!                                           └─► all its points ─► Seen: free, inside or unknown
//! ```
//!
//! A site is of the tile that it was scanned in: every tile is read on its own, so that clouds of the same place from
//! different years are never mixed.

mod copy;
mod seen;
mod source;
#[cfg(test)]
pub(super) mod tests;

use std::sync::Arc;

use nalgebra::{Matrix3, Point3, Vector3};

use super::model::map_outline;
use super::random::Random;
use crate::site::Site;

pub(super) use seen::Seen;
pub use source::{RealOptions, RealSource, read_tile};

/// A building as it was really scanned.
#[derive(Debug, Clone)]
pub struct RealSite {
    /// The tile that it was scanned in.
    pub tile: Arc<str>,
    /// All its points, its footprint and its ground.
    pub site: Site,
}

impl RealSite {
    /// The site mirrored or not and turned about the vertical by any angle. Lengths stay: what is special about real scans
    /// is their spacing and noise.
    pub(super) fn turned(&self, random: &mut Random) -> Self {
        let (sin, cos) = random.between(0.0, std::f64::consts::TAU).sin_cos();
        let mirror = if random.chance(0.5) { -1.0 } else { 1.0 };
        let turn = Matrix3::new(cos * mirror, -sin, 0.0, sin * mirror, cos, 0.0, 0.0, 0.0, 1.0);
        let all = |points: &[Point3<f64>]| points.iter().map(|p| turn * p).collect();
        Self {
            tile: Arc::clone(&self.tile),
            site: Site {
                points: all(&self.site.points),
                ground_points: all(&self.site.ground_points),
                footprint: self.site.footprint.as_ref().map(|outline| map_outline(outline, &turn, &Vector3::zeros())),
                ..self.site.clone()
            },
        }
    }
}
