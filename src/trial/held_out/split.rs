//! Which points are held out.

use geo::Area;
use nalgebra::Point3;
use serde::Serialize;

use crate::geometry::{Random, hash};
use crate::site::Site;

/// Which points are held out, and what becomes of the others.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Holding {
    /// Share of the points that are held out, 0 to 1.
    pub share: f64,
    /// To how many building points per m² of footprint the others are thinned; those of a building that has fewer stay.
    pub density: Option<f64>,
    /// The seed of the choice.
    pub seed: u64,
}

/// A site, parted. Which points are held out depends on the seed, the id and the points of the site alone.
#[derive(Debug, Clone)]
pub struct Split {
    /// What the method gets.
    pub input: Site,
    /// Building points that are held out, local metres.
    pub points: Vec<Point3<f64>>,
    /// Ground points inside the footprint that are held out, local metres.
    pub ground_points: Vec<Point3<f64>>,
}

impl Split {
    /// Parts a site.
    pub fn new(site: &Site, holding: &Holding) -> Self {
        let part = |of: &[Point3<f64>], what: &str| -> (Vec<_>, Vec<_>) {
            let mut random = Random::new(hash(holding.seed, &format!("{} {what}", site.id)));
            of.iter().partition(|_| random.unit() < holding.share)
        };
        let (points, mut kept) = part(&site.points, "points");
        let (ground_points, mut kept_ground) = part(&site.ground_points, "ground points");
        let area = site.footprint.as_ref().map_or(0.0, Area::unsigned_area);
        if let Some(density) = holding.density {
            // Drawn after the choice, so that all densities are judged by the same points.
            let share = density * area / kept.len().max(1) as f64;
            let mut random = Random::new(hash(holding.seed, &format!("{} thinned", site.id)));
            kept.retain(|_| random.unit() < share);
            kept_ground.retain(|_| random.unit() < share);
        }
        Self { input: Site { points: kept, ground_points: kept_ground, ..site.clone() }, points, ground_points }
    }
}
