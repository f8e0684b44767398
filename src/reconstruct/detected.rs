//! The planes that were found in the points of a building, before anything is concluded from them.

use std::cmp::Reverse;
use std::sync::Arc;

use nalgebra::Point3;

use super::edited::Tally;
use super::hypotheses::WALL_VERTICALITY;
use super::means::Means;
use super::primitives::undersides::Tops;
use super::primitives::{Primitive, connected};
use super::{Failure, Parameters};
use crate::building::Reason;
use crate::geometry::{Plane, seed_of};
use crate::site::Site;

/// An underside with a point lower than this above the ground is the floor, metres.
const GROUND_FLOOR: f64 = 0.5;

/// The planes of a building by what they are parts of.
#[derive(Debug, Clone, PartialEq)]
pub struct Detected {
    /// Planes seen from above; those that a revision added come last.
    pub roofs: Vec<Primitive>,
    /// Planes that look down.
    pub undersides: Vec<Primitive>,
    /// Planes that stand.
    pub walls: Vec<Primitive>,
    /// For each of the walls, whether it stands under a roof.
    pub covered: Vec<bool>,
    /// How many planes were detected in the first place.
    pub count: usize,
    /// How many of the roofs were added: by a person, or because a model had left their points unexplained.
    pub revised: usize,
    /// Walls that a person added.
    pub added_walls: Vec<Primitive>,
    /// The planes that a person switched off.
    pub off_planes: Vec<Primitive>,
    /// The points of these, ascending: no plane is made of them anew.
    pub off: Vec<u32>,
    /// The planes as a person added, turned or moved them.
    pub edited: Vec<Plane>,
    /// Standard deviation of the points across the surfaces that they sample, metres.
    pub noise: f64,
    /// What became of the edits of planes.
    pub(super) tally: Tally,
}

impl Detected {
    /// Detects the planes of a site (paper, section 3.1), and applies its edits to them.
    ///
    /// # Errors
    /// Fails where there is no point.
    pub fn new(site: &Site, parameters: &Parameters) -> Result<Self, Failure> {
        Self::by(Means::plain(), site, parameters)
    }

    /// The same by what the method has at hand.
    pub(super) fn by(means: Means, site: &Site, parameters: &Parameters) -> Result<Self, Failure> {
        if site.points.is_empty() {
            if let Some(outdated) = site.record.cloud.as_ref().and_then(|of| of.outdated.as_ref()) {
                return Err(Failure::new(Reason::Outdated, outdated));
            }
            let reason = if site.coverage.is_complete() { Reason::NoPoints } else { Reason::Incomplete };
            return Err(Failure::new(reason, "no building point lies in the footprint"));
        }
        let detection = Arc::unwrap_or_clone(means.detect(&site.points, parameters, seed_of(&site.id)));
        let (mut roofs, walls): (Vec<Primitive>, Vec<Primitive>) =
            detection.primitives.into_iter().partition(|p| p.plane.verticality() <= WALL_VERTICALITY);
        let count = roofs.len() + walls.len();
        let spacing = detection.density.max(1e-6).sqrt().recip();
        roofs = roofs.into_iter().flat_map(|roof| connected::parts(&site.points, roof, spacing)).collect();
        roofs.sort_by_key(|roof| Reverse(roof.inliers.len()));
        let (undersides, covered) = take_covered(&site.points, site.ground.height, &mut roofs, &walls);
        let mut detected = Self {
            roofs,
            undersides,
            walls,
            covered,
            count,
            revised: 0,
            added_walls: Vec::new(),
            off_planes: Vec::new(),
            off: Vec::new(),
            edited: Vec::new(),
            noise: detection.noise,
            tally: Tally::default(),
        };
        detected.edit(site);
        Ok(detected)
    }
}

/// Takes the undersides out of the roofs, and says which of the walls stand under a roof. What lies at the height of the
/// ground is neither: the box has its own bottom.
fn take_covered(
    points: &[Point3<f64>],
    ground: f64,
    roofs: &mut Vec<Primitive>,
    walls: &[Primitive],
) -> (Vec<Primitive>, Vec<bool>) {
    let tops = Tops::new(points, roofs);
    let covered: Vec<bool> = (0..).zip(&*roofs).map(|(label, roof)| tops.cover(roof, label)).collect();
    let (below, above): (Vec<_>, Vec<_>) =
        std::mem::take(roofs).into_iter().zip(covered).partition(|(_, covered)| *covered);
    *roofs = above.into_iter().map(|(roof, _)| roof).collect();
    let is_floor = |underside: &Primitive| {
        underside.inliers.iter().filter_map(|&i| points.get(i as usize)).any(|p| p.z < ground + GROUND_FLOOR)
    };
    let undersides =
        below.into_iter().map(|(underside, _)| underside).filter(|underside| !is_floor(underside)).collect();
    (undersides, walls.iter().map(|wall| tops.cover(wall, usize::MAX)).collect())
}
