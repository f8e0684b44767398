//! The method: one [`Site`] in, one [`Building`] out.
//!
//! The modules stand in the order of the paper: [`primitives`] → [`complex`] → [`occupancy`] → [`labelling`] →
//! [`surface`]. Nothing here does I/O, starts a thread or reads a clock; random numbers are drawn from a seed derived
//! from the building id: the same site gives the same bytes.

mod as_block;
mod attempt;
pub mod blocks;
pub mod complex;
pub(crate) mod confidence;
mod decision;
mod detected;
mod edited;
mod evidence;
mod fit;
mod floor;
mod floor_depth;
mod footprint;
mod hypotheses;
pub mod labelling;
mod ladder;
mod levels;
mod means;
mod measures;
mod memory;
pub mod occupancy;
mod open_ground;
mod outline;
mod overhanging;
mod parameters;
mod partitioned;
mod patch;
pub mod primitives;
mod revision;
mod ridges;
mod rounds;
pub(crate) mod semantics;
mod solution;
mod standing;
mod stepped;
mod steps;
pub mod surface;
mod unmodelled;

use attempt::{Attempt, first_measures};
pub use detected::Detected;
pub use edited::{as_edited, equation};
pub use evidence::label;
pub use hypotheses::{Hypotheses, StrayWall, WALL_VERTICALITY};
pub use levels::{Level, Levels};
pub use memory::Memory;
pub use parameters::{OpenGround, Parameters, Partial, Partition};
pub use partitioned::Partitioned;
pub use steps::{Asked, Cut, Partitioning, Steps, Surfaced};

use std::borrow::Cow;

use geo::MultiPolygon;
use nalgebra::Point3;

use crate::building::{Building, EditTally, Measures, Outcome, Reason};
use crate::site::{GroundSource, Site};
use crate::solid::{Model, Solid};
use edited::Tally;
use fit::Fit;
use means::{Means, Telling};
use occupancy::Occupancy;
use solution::Solution;
use standing::Standing;

/// Reconstructs one building; `field` says how much its cells are inside. Whatever the site holds, a building comes back: a LoD 2.2 model, or what is left of it
/// and the reason.
///
/// Where the method comes to nothing it is tried again with coarser tolerances; the attempts that failed stand in
/// [`Measures::setbacks`].
pub fn reconstruct(site: &Site, parameters: &Parameters, field: &dyn Occupancy) -> Building {
    let means = Means { field, telling: Telling::Result, memory: None };
    reconstruct_and_tell(site, parameters, means).0
}

/// The same, with what each step made of it. The building is that of [`reconstruct`], to the last bit.
pub fn reconstruct_in_steps(site: &Site, parameters: &Parameters, field: &dyn Occupancy) -> (Building, Steps) {
    let means = Means { field, telling: Telling::Steps, memory: None };
    let (building, steps) = reconstruct_and_tell(site, parameters, means);
    (building, steps.map(|steps| *steps).unwrap_or_default())
}

/// The same by a session, which keeps in `memory` what the next solve may need again. Building and steps are those of
/// [`reconstruct_in_steps`], to the last bit.
pub fn reconstruct_again(
    site: &Site,
    parameters: &Parameters,
    field: &dyn Occupancy,
    memory: &Memory,
) -> (Building, Steps) {
    let means = Means { field, telling: Telling::Steps, memory: Some(memory) };
    let (building, steps) = reconstruct_and_tell(site, parameters, means);
    (building, steps.map(|steps| *steps).unwrap_or_default())
}

fn reconstruct_and_tell(site: &Site, parameters: &Parameters, means: Means) -> (Building, Option<Box<Steps>>) {
    let mut notes = Vec::new();
    let site = &*with_finite_points(site, &mut notes);
    let mut tally = Tally::default();
    let site = &*edited::of_site(site, &mut tally);
    let parameters = &*edited::parameters(site, parameters);
    let site = &*footprint::without_slivers(site, &mut notes);
    let site = &*floor::found(site, parameters, means, &mut notes);
    let step = parameters.step(&site.frame);
    let (standing, stands) = Standing::new(site, parameters, &mut notes);
    let Attempt { mut measures, outline, result, roof_points, strays, fit, steps, tally: own, .. } = match stands {
        Ok(()) => {
            let whole = edited::parts(footprint::parted(&standing.site, step), &mut tally);
            let asked = as_block::asked(site, &whole, parameters);
            ladder::descend(parameters, |parameters| match &asked {
                Some(failure) => Attempt::of_roofs(&whole, parameters, failure.clone(), means),
                None => attempt(&standing.site, &whole, None, parameters, means),
            })
        }
        Err(failure) => Attempt::failed(site, failure, means.begin(site, parameters)),
    };
    tally.merge(&own);
    measures.edits = tally.told(site);
    notes.extend(measures.edits.iter().flat_map(EditTally::notes));
    measures.open_ground = standing.open_ground;
    measures.floor_depth = floor_depth::range(site);
    if let Some(why) = &measures.field_fallback {
        notes.push(format!("the height-field vote decided, not the field that was asked for: {why}"));
    }
    notes.extend(of_strays(&strays));
    let (solids, failure) = match result {
        Ok(solids) => {
            measures.faults_lod22.clear();
            (solids, None)
        }
        Err(failure) => (Vec::new(), Some(failure)),
    };
    let footprint = match &site.footprint {
        Some(footprint) => blocks::footprint(footprint, step, &mut notes),
        None => outline::footprint(&solids, outline.as_ref(), step, &mut notes),
    };
    let share = format!("the tiles cover only {:.1} % of the footprint", 100.0 * site.coverage.share);
    if !site.coverage.is_complete() {
        notes.push(share.clone());
    }
    let is_block = standing.is_partial && parameters.partial == Partial::Block;
    let failure = failure.or(is_block.then(|| Failure::new(Reason::Incomplete, share.clone())));
    let solids = if failure.is_some() { Vec::new() } else { solids };
    let Fit { left_out, roof_heights, blocks, rmse_lod12, rmse_lod22 } = match fit {
        Some(fit) if failure.is_none() => fit,
        _ => {
            // What was made of it, or of its covered part, says nothing of a block.
            let Measures { roof_type, roof_planes, ridge_height, completeness, confidence, .. } = &mut measures;
            (*roof_type, *roof_planes, *ridge_height, *completeness, *confidence) = (None, None, None, None, None);
            (measures.ridges, measures.revision) = (None, None);
            let scanned = fit::Scanned {
                site: &standing.site,
                roof_points: &roof_points,
                roof_heights: measures.roof_heights,
                outline: outline.as_ref(),
                step,
                stated_top: stated_top(site),
            };
            Fit::of_blocks(&scanned, parameters)
        }
    };
    if roof_heights.is_none() && !blocks.is_empty() {
        notes.push("the height of its block is the one that is stated: no point was scanned on its roof".to_owned());
    }
    if !left_out.is_empty() {
        let count = left_out.len();
        notes.push(format!(
            "{count} point(s) are of what is too small to stand or hovers, and in no height and no RMSE"
        ));
    }
    let mut stepped = Vec::new();
    if parameters.lod.has(Level::Stepped) || parameters.lod.has(Level::RoofParts) {
        let counting = fit::counting(&site.points, &left_out);
        stepped = stepped::of(&solids, &blocks, &standing.site, &counting, parameters, &mut notes);
        measures.rmse_lod13 = measures::rmse(stepped.iter().flatten(), &counting);
    }
    let mut overhanging = Vec::new();
    if parameters.lod.has(Level::Overhanging) && failure.is_none() {
        overhanging = overhanging::of_site(&standing, parameters, means).unwrap_or_else(|reason| {
            notes.push(format!("it has no LoD 2.3: {reason}"));
            Vec::new()
        });
        measures.rmse_lod23 = measures::rmse(overhanging.iter(), &fit::counting(&site.points, &left_out));
    }
    let mut parts = levels::parts(solids, blocks, stepped, overhanging);
    for part in &mut parts {
        let solids = [&mut part.lod12, &mut part.lod13, &mut part.lod22, &mut part.lod23];
        solids.into_iter().flatten().for_each(|solid| floor_depth::tell(solid, site));
    }
    let ground = grid_height(site.ground.height, step);
    if let Some(of_model) = measures.ground.as_mut().filter(|_| parameters.grid_steps().is_some_and(|steps| steps > 1))
    {
        // On a coarse grid it is not where it was measured.
        of_model.height = ground as f64 * step[2];
    }
    let mut model = Model { footprint, ground, parts, ..Model::default() };
    measures.roof_heights = roof_heights;
    if let (Some(heights), Some(top)) = (&mut measures.roof_heights, measures::top(model.lod22())) {
        heights.max = top;
    }
    (measures.rmse_lod12, measures.rmse_lod22) = (rmse_lod12, rmse_lod22);
    (measures.volume_lod12, measures.volume_lod13) = (volume(model.lod12()), volume(model.lod13()));
    (measures.volume_lod22, measures.volume_lod23) = (volume(model.lod22()), volume(model.lod23()));
    measures.confidence = confidence::of_model(&measures, area(standing.site.footprint.as_ref()));
    let outcome = match failure {
        None if standing.is_partial => Outcome::Partial { reason: Reason::Incomplete, detail: share },
        None => Outcome::Lod22,
        Some(Failure { reason, detail, .. }) if model.parts.is_empty() => Outcome::FootprintOnly { reason, detail },
        Some(Failure { reason, detail, .. }) => Outcome::Lod12 { reason, detail },
    };
    parameters.lod.lay_flat(&mut model);
    parameters.lod.keep(&mut model);
    // All models speak of steps of the finest grid.
    model.refine(parameters.grid_steps().unwrap_or(1));
    let (id, attributes, record) = (site.id.clone(), site.attributes.clone(), site.record.clone());
    (Building { id, frame: site.frame, attributes, model, outcome, measures, record, notes }, steps)
}

/// What there is to be told of walls that contradict the footprint.
fn of_strays(strays: &[StrayWall]) -> Option<String> {
    let stray = strays.iter().max_by(|a, b| a.length.total_cmp(&b.length))?;
    Some(format!(
        "{} wall(s) were scanned where the footprint has none, the longest ({:.0} m) {:.1} m from the nearest: the \
         footprint may be displaced or out of date",
        strays.len(),
        stray.length,
        stray.distance
    ))
}

/// Area of a footprint in square metres, if there is one.
fn area(footprint: Option<&MultiPolygon<f64>>) -> Option<f64> {
    footprint.map(geo::Area::unsigned_area).filter(|area| *area > 0.0)
}

/// Building points per square metre of footprint, if there is one.
fn density(site: &Site) -> Option<f64> {
    area(site.footprint.as_ref()).map(|area| site.points.len() as f64 / area)
}

/// The site without the points whose coordinates are not numbers, or not within reach of the local frame.
fn with_finite_points<'a>(site: &'a Site, notes: &mut Vec<String>) -> Cow<'a, Site> {
    let usable = |p: &Point3<f64>| p.iter().all(|c| c.abs() <= complex::REACH);
    let unusable = site.points.iter().filter(|p| !usable(p)).count();
    if unusable == 0 {
        return Cow::Borrowed(site);
    }
    notes.push(format!("{unusable} point(s) with coordinates that are absurd or no numbers: left out"));
    let mut site = site.clone();
    site.points.retain(usable);
    Cow::Owned(site)
}

/// Why there is no LoD 2.2 model.
#[derive(Debug, Clone, PartialEq)]
pub struct Failure {
    /// The kind of failure.
    pub reason: Reason,
    /// What was found.
    pub detail: String,
    /// val3dity codes of the solid that was not good enough, ascending.
    pub codes: Vec<u16>,
}

impl Failure {
    fn new(reason: Reason, detail: impl Into<String>) -> Self {
        Self { reason, detail: detail.into(), codes: Vec::new() }
    }
}

/// An attempt at a site. The solids are made of `whole`, which is the same without touching parts. With `walls` (local
/// metres) there is LoD 2.3 as well: roofs that reach from these to the footprint's outline.
///
/// Where they fit the points worse than the block does, the vote is asked instead of the field: it is what the points say.
fn attempt(
    site: &Site,
    whole: &Site,
    walls: Option<&MultiPolygon<f64>>,
    parameters: &Parameters,
    means: Means,
) -> Attempt {
    let steps = means.begin(whole, parameters);
    let detected = match Detected::by(means, whole, parameters) {
        Ok(detected) => detected,
        Err(failure) => return Attempt::failed(site, failure, steps),
    };
    let first = attempt_with(site, whole, walls, detected.clone(), parameters, means, steps.clone());
    let Err(worse) = &first.result else { return first };
    let by_vote = means.field.is_height_field() || first.measures.field_fallback.is_some();
    if worse.reason != Reason::WorseThanBlock || by_vote {
        return first;
    }
    let mut second = attempt_with(site, whole, walls, detected, parameters, means.by_vote(), steps);
    if second.result.is_err() {
        return first;
    }
    second.measures.field_fallback = Some(format!("by its answers {}", worse.detail));
    second
}

/// An attempt with planes that were found and a field to ask.
fn attempt_with(
    site: &Site,
    whole: &Site,
    walls: Option<&MultiPolygon<f64>>,
    detected: Detected,
    parameters: &Parameters,
    means: Means,
    steps: Option<Box<Steps>>,
) -> Attempt {
    let mut solution =
        Solution { measures: first_measures(whole), walls: walls.cloned(), steps, ..Solution::default() };
    let solved = rounds::solve(whole, detected, parameters, means, &mut solution);
    let Solution { measures, outline, solids, roof_points, strays, overhanging, steps, tally, .. } = solution;
    let scanned = fit::Scanned {
        site,
        roof_points: &roof_points,
        roof_heights: measures.roof_heights,
        outline: outline.as_ref(),
        step: parameters.step(&site.frame),
        stated_top: None,
    };
    let fit = solved.is_ok().then(|| Fit::of_model(&scanned, &solids, parameters));
    // What a person has edited is as that person wants it.
    let judged = fit.as_ref().filter(|_| site.edits.is_empty());
    let result = solved.and_then(|()| judged.map_or(Ok(()), Fit::check)).map(|()| solids);
    Attempt { measures, outline, result, roof_points, strays, fit, overhanging, steps, tally }
}

/// The top of the block of a building without points on its roof (local metres), if it is stated and anything is known of
/// its ground.
fn stated_top(site: &Site) -> Option<f64> {
    site.record.roof_height.filter(|_| !site.points.is_empty() || site.ground.source != GroundSource::BoundingBox)
}

/// A height in steps of a grid.
fn grid_height(height: f64, step: [f64; 3]) -> i64 {
    (height / step[2]).round() as i64
}

fn volume<'a>(solids: impl Iterator<Item = &'a Solid>) -> Option<f64> {
    solids.map(Solid::volume).reduce(|a, b| a + b)
}

#[cfg(test)]
mod object_tests;
#[cfg(test)]
mod tests;
