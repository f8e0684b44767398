//! One HTML file that shows how a building was made: every step of the method, as it went, with its figures.
//!
//! [`build`] puts the [`Steps`] of a building into the page of `src/explain/page`, which is of one family with that of
//! [`view`](crate::view) and needs no network either.
//!
//! - `payload` is what the page is given.
//! - `drawn` is what of it is drawn, as columns of numbers: points; in `cells` the cells, in `polygons` planes and faces.
//! - `figures` are the figures and the parameters of each step.

pub(crate) mod cells;
mod drawn;
mod figures;
mod payload;
pub(crate) mod polygons;
#[cfg(test)]
mod tests;

use crate::building::Building;
use crate::error::{Error, Result};
use crate::network::FieldOptions;
use crate::reconstruct::{Steps, reconstruct_in_steps};
use crate::run::{Chosen, Job};
use crate::source::points::TileProblem;
use crate::view::{cloud, page};
use payload::Payload;

/// The page: made from `src/explain/page` by `make page`.
const TEMPLATE: &str = include_str!("page/dist/page.html");

/// The steps of the method as the page shows them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Step {
    /// What was scanned, by class, and what of it is the building's.
    Points,
    /// The planes as they were found.
    Found,
    /// The planes after refinement and regularisation.
    Refined,
    /// The planes that nobody scanned: walls from the footprint and from the steps of the roof.
    Walls,
    /// The cells that all planes cut.
    Cells,
    /// How much each cell is inside.
    Field,
    /// Which cells are inside.
    Cut,
    /// The surface between inside and outside.
    Surface,
    /// How well it fits, and whether it is valid.
    Result,
}

impl Step {
    /// All of them, in their order.
    pub const ALL: [Self; 9] = [
        Self::Points,
        Self::Found,
        Self::Refined,
        Self::Walls,
        Self::Cells,
        Self::Field,
        Self::Cut,
        Self::Surface,
        Self::Result,
    ];

    /// Whether the method got so far.
    fn is_reached(self, steps: &Steps) -> bool {
        match self {
            Self::Points => steps.site.is_some(),
            Self::Found => steps.found.is_some(),
            Self::Refined => steps.detected.is_some(),
            Self::Walls | Self::Cells => steps.partition.is_some(),
            Self::Field => steps.field.is_some(),
            Self::Cut => steps.cut.is_some(),
            Self::Surface => steps.surface.is_some(),
            Self::Result => true,
        }
    }
}

/// A page that is ready to be written.
#[derive(Debug, Clone)]
pub struct Page {
    /// The whole file.
    pub html: Vec<u8>,
    /// What is in it.
    pub contents: Contents,
    /// What is wrong with tiles whose other points are shown.
    pub problems: Vec<TileProblem>,
}

/// What is in a page. What the method did not get to is 0.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Contents {
    /// Number of building points, and of the points that are shown around them.
    pub points: [usize; 2],
    /// Number of planes as they were found, after refinement, and of all that cut.
    pub planes: [usize; 3],
    /// Number of cells, and of those inside.
    pub cells: [usize; 2],
    /// Number of faces of the surface.
    pub faces: usize,
    /// The step that was not reached, and why: what the building fell short of.
    pub failure: Option<String>,
}

/// At most so many points around the building are shown.
pub const MOST_POINTS: usize = 200_000;

/// Reconstructs a building, and makes the page of how that went. The building is that of a run.
///
/// # Errors
/// The network cannot be loaded; a tile can no longer be read.
pub fn explain(job: &Job, chosen: &Chosen) -> Result<(Building, Page)> {
    let field = job.field.load()?;
    let (building, steps) = reconstruct_in_steps(&chosen.site, &job.parameters, &*field);
    let page = build(chosen, &building, &steps, &job.field)?;
    Ok((building, page))
}

/// Makes the page of a building whose steps are known.
///
/// # Errors
/// A tile can no longer be read.
pub fn build(chosen: &Chosen, building: &Building, steps: &Steps, field: &FieldOptions) -> Result<Page> {
    let frame = &chosen.site.frame;
    let around = drawn::extent(steps, &chosen.site);
    let tiles = chosen.tiles.iter().cloned().map(Ok::<_, Error>);
    let cloud = cloud::sample(tiles, MOST_POINTS, &[around], frame)?;
    let mut payload = Payload::new(chosen, building, steps, field);
    payload.draw(steps, building, &cloud);
    let contents = contents(building, steps, cloud.points.len());
    Ok(Page { html: page::fill(TEMPLATE, &building.id, &payload.pack()?), contents, problems: cloud.problems })
}

fn contents(building: &Building, steps: &Steps, around: usize) -> Contents {
    let partition = steps.partition.as_ref();
    let failure = building.outcome.reason().map(|(_, detail)| detail.to_owned());
    let detected = steps.detected.as_ref().map_or(0, |d| d.roofs.len() + d.undersides.len() + d.walls.len());
    Contents {
        points: [steps.site.as_ref().map_or(0, |site| site.points.len()), around],
        planes: [steps.found.as_ref().map_or(0, Vec::len), detected, partition.map_or(0, |p| p.primitives.len())],
        cells: [
            partition.map_or(0, |p| p.complex.cells.len()),
            steps.cut.as_ref().map_or(0, |cut| cut.inside.iter().filter(|inside| **inside).count()),
        ],
        faces: steps.surface.as_ref().map_or(0, |surface| surface.solids.iter().map(|solid| solid.faces.len()).sum()),
        failure,
    }
}
