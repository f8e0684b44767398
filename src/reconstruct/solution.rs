//! What one attempt makes of the planes of a building, from its cells to valid solids.

use geo::MultiPolygon;

use super::confidence::Confidence;
use super::decision::Decision;
use super::edited::Tally;
use super::evidence::label;
use super::primitives::Primitive;
use super::steps::Steps;
use super::surface::{self, Labelled, SurfaceParameters};
use super::{Failure, Parameters, Partitioned, StrayWall, density, ladder, measures, overhanging, ridges, semantics};
use crate::building::{Measures, Reason};
use crate::site::Site;
use crate::solid::Solid;
use crate::validate;

/// What the method made of the planes that it was given.
#[derive(Debug, Clone, Default)]
pub(super) struct Solution {
    /// What was measured on the way.
    pub(super) measures: Measures,
    /// The outline of the roofs in local metres, for a site without a footprint.
    pub(super) outline: Option<MultiPolygon<f64>>,
    /// The solids.
    pub(super) solids: Vec<Solid>,
    /// The building points on roofs, ascending.
    pub(super) roof_points: Vec<u32>,
    /// The walls that were scanned where none is known.
    pub(super) strays: Vec<StrayWall>,
    /// Where the walls stand, where roofs reach beyond them.
    pub(super) walls: Option<MultiPolygon<f64>>,
    /// The solids on these, or why there are none.
    pub(super) overhanging: Option<Result<Vec<Solid>, String>>,
    /// What each step made of it, if that is to be told.
    pub(super) steps: Option<Box<Steps>>,
    /// What became of the edits of planes and places.
    pub(super) tally: Tally,
}

impl Solution {
    /// Notes what a building shows before anything is decided about its cells.
    pub(super) fn measure(&mut self, building: &Partitioned) {
        if let Some(steps) = &mut self.steps {
            steps.part(building);
        }
        let Partitioned { site, hypotheses, complex, .. } = building;
        if site.footprint.is_none() {
            self.outline.clone_from(&hypotheses.outline);
        }
        self.measure_roofs(site, &hypotheses.primitives[..hypotheses.roofs]);
        self.strays.clone_from(&hypotheses.strays);
        let measures = &mut self.measures;
        measures.primitives = hypotheses.detected;
        measures.no_data_share = measures::no_data_share(&hypotheses.map, &site.points);
        measures.point_density = density(site);
        measures.cells = complex.cells.len();
    }

    /// Notes where roofs were seen: a block needs no more.
    pub(super) fn measure_roofs(&mut self, site: &Site, roofs: &[Primitive]) {
        let mut inliers: Vec<u32> = roofs.iter().flat_map(|roof| roof.inliers.iter().copied()).collect();
        inliers.sort_unstable();
        let mut heights: Vec<f64> = inliers.iter().filter_map(|&i| Some(site.points.get(i as usize)?.z)).collect();
        self.measures.roof_heights = measures::roof_heights(&mut heights);
        self.roof_points = inliers;
    }

    /// Makes solids of what was decided about the cells of a building.
    pub(super) fn build(
        &mut self,
        building: &Partitioned,
        decision: &Decision,
        parameters: &Parameters,
    ) -> Result<(), Failure> {
        let Partitioned { hypotheses, complex, volumes, .. } = building;
        let Decision { occupancy, height_field, fallback } = decision;
        let measures = &mut self.measures;
        measures.field_fallback.clone_from(fallback);
        let inside = label(building, occupancy, *height_field, parameters);
        if let Some(steps) = &mut self.steps {
            steps.decide(building, decision, &inside);
        }
        if !inside.contains(&true) {
            return Err(Failure::new(Reason::NothingInside, "the labelling found no cell inside"));
        }
        let site = building.site;
        let fixed = &*building.decided();
        let labelled = Labelled { complex, inside: &inside, occupancy, volumes, fixed };
        // What is thinner than the noise was made by it.
        let minimum_feature = parameters.surface.minimum_feature.max(hypotheses.noise);
        let surface_parameters = SurfaceParameters { minimum_feature };
        let extraction =
            surface::extract(&labelled, parameters.step(&site.frame), &surface_parameters).map_err(|error| {
                Failure { codes: error.codes(), ..Failure::new(Reason::InvalidSolid, error.to_string()) }
            })?;
        building.check_marks(&extraction.inside, &mut self.tally);
        if let Some(steps) = &mut self.steps {
            steps.extract(&extraction);
        }
        let walls = self.walls.as_ref();
        self.overhanging = walls
            .map(|walls| overhanging::of_cells(building, &extraction.inside, &extraction.shells, walls, parameters));
        let confidence = Confidence::new(building, &complex.facet_areas(), occupancy, &extraction.inside);
        measures.confidence = confidence.building;
        let mut solids = Vec::with_capacity(extraction.shells.len());
        for mut shell in extraction.shells {
            semantics::assign(&mut shell.solid, &shell.planes, hypotheses.footprint.as_ref(), &confidence);
            if let Some(steps) = &mut self.steps {
                steps.close(&shell.solid);
            }
            let faults = validate::check(&shell.solid, &validate::Tolerances::written());
            if let Some(first) = faults.first() {
                let mut codes: Vec<u16> = faults.iter().map(|fault| fault.code).collect();
                codes.sort_unstable();
                codes.dedup();
                return Err(Failure { codes, ..Failure::new(Reason::InvalidSolid, first.to_string()) });
            }
            solids.push(shell.solid);
        }
        if solids.is_empty() {
            return Err(Failure::new(Reason::NothingInside, "nothing is left of the inside at the size of a feature"));
        }
        ladder::check_parts(&solids)?;
        ladder::check_top(&solids, &building.evidence_of_roofs())?;
        let middle = measures.roof_heights.map(|heights| heights.p50);
        ladder::check_height(middle, site.ground.height, parameters.minimum_height)?;
        ladder::check_eaves(measures.roof_heights.map(|heights| heights.min), &site.ground, parameters.minimum_height)?;
        measures.roof_type = measures::roof_type(&solids);
        measures.roof_planes = Some(measures::roof_surfaces(&solids).count());
        measures.ridge_height = measures::ridge_height(&solids);
        measures.ridges = Some(ridges::of(&solids));
        self.solids = solids;
        Ok(())
    }
}
