//! One attempt at LoD 2.2 and what came of it.

use geo::MultiPolygon;

use super::edited::Tally;
use super::fit::Fit;
use super::means::Means;
use super::steps::Steps;
use super::{Detected, Failure, Parameters, Solution, StrayWall, density};
use crate::building::Measures;
use crate::site::Site;
use crate::solid::Solid;

/// One attempt at LoD 2.2.
pub(super) struct Attempt {
    /// What was measured on the way.
    pub(super) measures: Measures,
    /// The outline of the roofs in local metres, for a site without a footprint.
    pub(super) outline: Option<MultiPolygon<f64>>,
    /// The solids, or why there are none.
    pub(super) result: Result<Vec<Solid>, Failure>,
    /// The building points on roofs, ascending.
    pub(super) roof_points: Vec<u32>,
    /// The walls that were scanned where none is known.
    pub(super) strays: Vec<StrayWall>,
    /// How well the solids fit; `None` where there are none.
    pub(super) fit: Option<Fit>,
    /// The solids of LoD 2.3, or why there are none, where they were asked for.
    pub(super) overhanging: Option<Result<Vec<Solid>, String>>,
    /// What each step made of it, if that is to be told.
    pub(super) steps: Option<Box<Steps>>,
    /// What became of the edits of planes and places.
    pub(super) tally: Tally,
}

impl Attempt {
    /// None was made.
    pub(super) fn failed(site: &Site, failure: Failure, steps: Option<Box<Steps>>) -> Self {
        Self {
            measures: first_measures(site),
            outline: None,
            result: Err(failure),
            roof_points: Vec::new(),
            strays: Vec::new(),
            fit: None,
            overhanging: None,
            steps,
            tally: Tally::default(),
        }
    }

    /// None was made; what is seen of the roofs is enough for a block.
    pub(super) fn of_roofs(site: &Site, parameters: &Parameters, failure: Failure, means: Means) -> Self {
        let steps = means.begin(site, parameters);
        let detected = match Detected::by(means, site, parameters) {
            Ok(detected) => detected,
            Err(failure) => return Self::failed(site, failure, steps),
        };
        let mut seen = Solution { measures: first_measures(site), ..Solution::default() };
        seen.measure_roofs(site, &detected.roofs);
        seen.measures.primitives = detected.count;
        seen.measures.point_density = density(site);
        let Solution { measures, outline, roof_points, strays, .. } = seen;
        let (result, tally) = (Err(failure), detected.tally);
        Self { measures, outline, result, roof_points, strays, fit: None, overhanging: None, steps, tally }
    }
}

/// What is known of a building before anything is made of it.
pub(super) fn first_measures(site: &Site) -> Measures {
    Measures {
        ground: Some(site.ground),
        coverage: Some(site.coverage),
        points: site.points.len(),
        ..Measures::default()
    }
}
