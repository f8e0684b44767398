//! All buildings of a job, as they were scanned.

use super::buildings::Task;
use super::job::Job;
use super::journal::Journal;
use super::observer::Observer;
use super::plan::plan;
use super::prepare::collect;
use crate::error::Result;
use crate::site::Site;
use crate::source::crs::Crs;
use crate::source::points::Tile;

/// All buildings of a job, before anything is made of them.
#[derive(Debug)]
pub struct Collected {
    /// What is known of each, in the order of the footprints, with what its reader should know: repairs of the footprint, an
    /// incomplete tile.
    pub buildings: Vec<(Site, Vec<String>)>,
    /// The ids of the features without a usable polygon.
    pub rejected: Vec<String>,
    /// The tiles.
    pub tiles: Vec<Tile>,
    /// The CRS of all.
    pub crs: Crs,
}

/// Collects the points of all buildings of a job.
///
/// # Errors
/// As [`run`](super::run), as far as it concerns tiles and footprints.
pub fn collected(job: &Job, observer: &dyn Observer) -> Result<Collected> {
    let journal = Journal::new(observer);
    let pool = job.pool()?;
    let mut plan = plan(job, &pool, &journal)?;
    let tasks = collect(&mut plan, &pool, &journal)?;
    let mut buildings = Vec::with_capacity(tasks.len());
    let mut rejected = Vec::new();
    for task in tasks {
        match task {
            Task::Reconstruct { site, notes } => buildings.push((*site, notes)),
            Task::Keep(building) => rejected.push(building.id),
        }
    }
    Ok(Collected { buildings, rejected, tiles: plan.tiles, crs: plan.crs })
}
