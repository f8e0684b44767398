//! From the inputs to work: sites that get ready while tiles are read, or all of them at once.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, AtomicUsize};

use rayon::ThreadPool;

use super::buildings::Task;
use super::journal::Journal;
use super::observer::{Event, Observer, Stage};
use super::plan::Plan;
use super::roster::Roster;
use super::supply::{Supply, Sweeping};
use super::{edited, layer, single, surveyed};
use crate::error::{Error, Result};
use crate::report::{Scope, Stopwatch};
use crate::segment::{SegmentOptions, Segmentation, Sweep, Swept, segment_as};
use crate::site::Site;
use crate::source::footprints::Footprint;
use crate::source::points::Tile;
use crate::terrain::GroundStore;

/// What is to come out of a run, and how points are given to buildings.
pub(super) struct Prepared {
    pub(super) roster: Roster,
    options: SegmentOptions,
}

/// What a run starts from.
pub(super) enum Stock {
    /// Footprints whose points are still to be read.
    Footprints(Vec<Footprint>),
    /// All tasks, in the order of the roster.
    Tasks(Vec<Task>),
}

/// Prepares the work: where each building is made from the best of several clouds all points are collected first.
///
/// # Errors
/// What [`segment_as`] says.
pub(super) fn prepare(plan: &mut Plan, pool: &ThreadPool, journal: &Journal<'_>) -> Result<(Prepared, Stock)> {
    let (rejected, files) = (plan.rejected.clone(), plan.files.as_ref());
    let roster = Roster::new(&plan.footprints, &plan.is_wanted, rejected, files, &plan.crs);
    let Some(options) = surveyed::of_single(&plan.clouds, &plan.segmentation) else {
        let tasks = collect(plan, pool, journal)?;
        return Ok((Prepared { roster, options: plan.segmentation.clone() }, Stock::Tasks(tasks)));
    };
    edited::tell(&plan.edits, ids_of_wanted(plan), journal);
    Ok((Prepared { roster, options }, Stock::Footprints(std::mem::take(&mut plan.footprints))))
}

impl Prepared {
    /// What the run works on. Of points that wait no more than `memory` bytes are held.
    ///
    /// # Errors
    /// As [`segment_as`], as far as it can be told before the points are read.
    pub(super) fn supply<'a>(
        &'a self,
        stock: Stock,
        plan: &'a Plan,
        ground: Option<&'a GroundStore>,
        memory: usize,
        journal: &'a Journal<'_>,
    ) -> Result<Supply<'a>> {
        let footprints = match stock {
            Stock::Footprints(footprints) => footprints,
            Stock::Tasks(tasks) => return Ok(Supply::collected(tasks)),
        };
        let watch = Stopwatch::start(Scope::Process);
        let total = plan.tiles.iter().map(|tile| tile.points).sum();
        let sweep = Sweep::new(&plan.tiles, footprints, &plan.crs, &self.options, plan.meaning(), ground, memory);
        let sweep = sweep.map_err(|error| name_the_footprints(error, plan))?;
        journal.event(Event::Started { stage: Stage::Segment, total });
        Ok(Supply::Sweeping(Box::new(Sweeping {
            sweep,
            roster: &self.roster,
            has_stand_ins: plan.has_stand_ins,
            edits: &plan.edits,
            progress: Box::new(|by| journal.event(Event::Advanced { stage: Stage::Segment, by })),
            all_read: Box::new(move |cpu| journal.end(Stage::Segment, &watch, cpu)),
            incomplete: AtomicUsize::new(0),
            cpu: AtomicU64::new(0),
        })))
    }
}

/// Collects the points of each footprint, on the threads of `pool`.
///
/// # Errors
/// What [`segment_as`] says.
pub(super) fn collect(plan: &mut Plan, pool: &ThreadPool, journal: &Journal<'_>) -> Result<Vec<Task>> {
    edited::tell(&plan.edits, ids_of_wanted(plan), journal);
    let footprints = std::mem::take(&mut plan.footprints);
    let total = plan.tiles.iter().map(|tile| tile.points).sum();
    let Segmentation { sites, notes, counts, problems, warnings } =
        journal.stage(Stage::Segment, total, |journal| {
            let progress = |by| journal.event(Event::Advanced { stage: Stage::Segment, by });
            let (meaning, ground) = (plan.meaning(), plan.ground.as_deref());
            let of_tiles = |tiles: &[Tile], footprints, options: &SegmentOptions| {
                segment_as(tiles, footprints, &plan.crs, options, meaning, &progress, ground)
            };
            pool.install(|| surveyed::segment(&plan.clouds, &plan.tiles, footprints, &plan.segmentation, of_tiles))
                .map_err(|error| name_the_footprints(error, plan))
        })?;
    let (mut sites, notes) = wanted(sites, notes, &plan.is_wanted);
    let incomplete = sites.iter().filter(|site| !plan.has_stand_ins && !site.coverage.is_complete()).count();
    let total = sites.len();
    plan.note(Swept { counts, problems, warnings }, (incomplete, total), journal);
    for site in &mut sites {
        edited::give(&plan.edits, site);
    }
    let mut tasks = boxed(sites, notes, plan.has_stand_ins);
    tasks.extend(
        std::mem::take(&mut plan.rejected)
            .into_iter()
            .map(|feature| Task::Keep(Box::new(layer::rejected(feature, &plan.crs)))),
    );
    if let Some(files) = &plan.files {
        // One file is written after the other.
        tasks.sort_by_key(|task| files.of_building.get(task.id()));
    }
    Ok(tasks)
}

/// The ids of the footprints that are wanted.
fn ids_of_wanted(plan: &Plan) -> impl Iterator<Item = &str> {
    let wanted = plan.footprints.iter().zip(&plan.is_wanted).filter(|(_, is_wanted)| **is_wanted);
    wanted.map(|(footprint, _)| footprint.id.as_str())
}

/// The sites that are wanted, with their notes.
fn wanted(sites: Vec<Site>, notes: Vec<Vec<String>>, is_wanted: &[bool]) -> (Vec<Site>, Vec<Vec<String>>) {
    if is_wanted.iter().all(|is_wanted| *is_wanted) {
        return (sites, notes);
    }
    let both = sites.into_iter().zip(notes).zip(is_wanted).filter(|(_, is_wanted)| **is_wanted);
    both.map(|(both, _)| both).unzip()
}

/// The sites as tasks. They are taken from the end and their memory is given back on the way: of a city, both lists would
/// be among the largest things there are.
fn boxed(mut sites: Vec<Site>, mut notes: Vec<Vec<String>>, has_stand_ins: bool) -> Vec<Task> {
    const AT_ONCE: usize = 4096;
    let mut tasks = Vec::with_capacity(sites.len());
    while !sites.is_empty() {
        let from = sites.len().saturating_sub(AT_ONCE);
        let some = sites.drain(from..).zip(notes.drain(from.min(notes.len())..)).rev().map(|(site, notes)| {
            let site = if has_stand_ins { single::without_footprint(site) } else { site };
            Task::Reconstruct { site: Box::new(site), notes }
        });
        tasks.extend(some);
        sites.shrink_to_fit();
        notes.shrink_to_fit();
    }
    tasks.reverse();
    tasks
}

/// Segmentation knows footprints, not their file: a fault of theirs gets its name and the CRS that it came in.
pub(super) fn name_the_footprints(error: Error, plan: &Plan) -> Error {
    match (error, &plan.inputs.footprints) {
        (Error::Input(mut fault), Some(report)) if fault.file == Path::new("footprints") => {
            fault.file = PathBuf::from(&report.file);
            fault.place = format!("in {}", report.crs.as_deref().unwrap_or("a CRS that it does not name"));
            fault.into()
        }
        (error, _) => error,
    }
}
