//! One building of a job, as it was scanned.

use geo::BoundingRect;

use super::journal::Journal;
use super::observer::Observer;
use super::plan::{Plan, plan};
use super::prepare::collect;
use super::{buildings, job::Job};
use crate::error::{Error, InputError, Result};
use crate::segment::SegmentOptions;
use crate::site::{GroundSource, Site};
use crate::source::crs::Crs;
use crate::source::points::{Extent, Tile};

/// So many ids are named where the one that is asked for is not there.
const NAMED: usize = 3;

/// One building of a job.
#[derive(Debug)]
pub struct Chosen {
    /// What is known of it.
    pub site: Site,
    /// What its reader should know: repairs of the footprint, an incomplete tile.
    pub notes: Vec<String>,
    /// The tiles at its place.
    pub tiles: Vec<Tile>,
    /// The CRS of all.
    pub crs: Crs,
    /// Which points belong to a building: what the job says, but for points without classes.
    pub segmentation: SegmentOptions,
}

/// The building of this id, as [`sites`](super::sites) has it, from the tiles at its place.
///
/// # Errors
/// As [`run`](super::run), as far as it concerns tiles and footprints; and where no usable footprint has this id.
pub fn chosen(job: &Job, id: &str, observer: &dyn Observer) -> Result<Chosen> {
    let journal = Journal::new(observer);
    let pool = job.pool()?;
    let mut all = plan(job, &pool, &journal)?;
    let place = place_of(&all, job, id)?;
    let tiles: Vec<Tile> = all.tiles.iter().filter(|tile| is_near(tile, &place)).cloned().collect();
    let (crs, segmentation) = (all.crs.clone(), all.segmentation.clone());
    // Of its surroundings a building knows no more than what is near, but for floors that are taken from its neighbours'.
    if !tiles.is_empty() && tiles.len() < all.tiles.len() {
        let mut near = all.at(tiles.clone());
        if let Ok(tasks) = collect(&mut near, &pool, &journal)
            && let Some((site, notes)) = found(tasks, id)
            && site.ground.source != GroundSource::Neighbours
        {
            return Ok(Chosen { site, notes, tiles, crs, segmentation });
        }
    }
    let tasks = collect(&mut all, &pool, &journal)?;
    let (site, notes) = found(tasks, id).ok_or_else(|| Error::Input(no_such(&all, job, id)))?;
    Ok(Chosen { site, notes, tiles, crs, segmentation })
}

fn found(tasks: Vec<buildings::Task>, id: &str) -> Option<(Site, Vec<String>)> {
    tasks.into_iter().find_map(|task| match task {
        buildings::Task::Reconstruct { site, notes } if site.id == id => Some((*site, notes)),
        _ => None,
    })
}

/// The box of the footprint of this id, and of what is around it.
fn place_of(plan: &Plan, job: &Job, id: &str) -> Result<Extent, InputError> {
    if let Some(rejected) = plan.rejected.iter().find(|feature| feature.id == id) {
        let found = format!("no usable polygon: {}", rejected.reason);
        let fault = InputError::new(source(job), found, "a footprint").at(format!("the feature {id:?}"));
        return Err(fault.remedy("Repair it: without a footprint there is nothing to reconstruct"));
    }
    let footprint = plan.footprints.iter().find(|footprint| footprint.id == id);
    let rect = footprint.and_then(|footprint| footprint.polygon.bounding_rect());
    let rect = rect.ok_or_else(|| no_such(plan, job, id))?;
    let options = &plan.segmentation;
    let reach = options.ring_limit.max(options.ring_width);
    let around = [0, 1].map(|axis| reach / plan.crs.metres_per_unit[axis]);
    Ok(Extent {
        min: [rect.min().x - around[0], rect.min().y - around[1], f64::NEG_INFINITY],
        max: [rect.max().x + around[0], rect.max().y + around[1], f64::INFINITY],
    })
}

/// Whether a tile may have points in a box.
fn is_near(tile: &Tile, place: &Extent) -> bool {
    let meets = |extent: Extent| (0..2).all(|i| extent.min[i] <= place.max[i] && place.min[i] <= extent.max[i]);
    // What names its building is given to it wherever it lies; and what a header states may be wrong.
    !tile.is_true_to_its_extent() || !tile.buildings.is_empty() || tile.extent.is_none_or(meets)
}

fn source(job: &Job) -> std::path::PathBuf {
    job.footprints.as_ref().map_or_else(|| "the points".into(), super::FootprintSource::name)
}

/// That no footprint has this id, and which ids are most like it.
fn no_such(plan: &Plan, job: &Job, id: &str) -> InputError {
    let likeness = |other: &str| strsim::jaro_winkler(&other.to_lowercase(), &id.to_lowercase());
    let mut ids: Vec<(f64, &str)> =
        plan.footprints.iter().map(|footprint| (likeness(&footprint.id), footprint.id.as_str())).collect();
    ids.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.cmp(b.1)));
    let like: Vec<String> = ids.iter().take(NAMED).map(|(_, id)| format!("{id:?}")).collect();
    let of = match &plan.inputs.footprints {
        Some(report) => match &report.id_attribute {
            Some(name) => format!(" (the attribute {name:?})"),
            None => " (made up, for want of an attribute)".to_owned(),
        },
        None => String::new(),
    };
    let expected = format!("the id of one of its {} buildings{of}, such as {}", ids.len(), like.join(", "));
    InputError::new(source(job), format!("no building with the id {id:?}"), expected)
        .remedy("Give --id one of them; --id-attribute chooses the attribute that they are in")
}
