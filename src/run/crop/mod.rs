//! The points of each building in a file of its own, with an index of all, instead of models.
//!
//! A tile is read once. The points in a footprint and close around it are written as they stand in the tile, with all that
//! is known of each, once the last tile that may hold some of them has been read: no more is held than tiles that touch one
//! another need.

mod file;
mod near;

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use rayon::ThreadPool;
use rayon::prelude::*;

use self::file::Records;
use self::near::Near;
use super::buildings::{Task, without_model};
use super::corners::Corners;
use super::file_names;
use super::job::Job;
use super::journal::Journal;
use super::observer::{Event, Observer, Stage};
use super::plan::Plan;
use super::write::{Done, Open, metadata};
use crate::building::{Building, Outcome, Reason};
use crate::error::{Error, InputError, Result};
use crate::record::PointsFile;
use crate::report::{BuildingReport, Counts};
use crate::segment::Scanned;
use crate::sink::{self, AttributeOptions, Encoder, Names, Sink};
use crate::source::objects;
use crate::source::points::{Block, Tile};

/// The name of the index in its folder.
const INDEX: &str = "index.gpkg";
/// What is said of a building that was cropped.
const DETAIL: &str = "its points were cropped, and no model was asked for";
/// The attributes of gable's that say something of points, where no others are asked for.
const OWN: &str = "points,point_density,no_data_share,coverage,height_ground,ground_source,ground_spread,point_cloud_*,\
                   is_mutated,mutation,mutated_*,points_file,points_in_file,notes";

/// The index of a job, which stands for its model.
pub(super) fn index(output: &Path) -> PathBuf {
    output.join(INDEX)
}

/// Refuses what does not go with cropping.
///
/// # Errors
/// Which option.
pub(super) fn refuse_contradictions(job: &Job) -> Result<(), InputError> {
    let refused = |found: &str, expected: &str| Err(InputError::new("--crop-only", found, expected));
    if job.output.as_os_str().is_empty() || sink::is_stream(&job.output) {
        return refused("no folder to write to", "the name of a folder as output");
    }
    if objects::is_object(&job.output) {
        return refused("a place in object storage", "a folder of this machine, for there is a file for each building");
    }
    if job.footprints.is_none() {
        return refused("no footprints", "--footprints: each says which points are written");
    }
    if job.resume {
        return refused("--resume", "a run from the beginning: it takes no longer than reading the tiles");
    }
    if job.output.extension().is_some() && !job.output.is_dir() {
        let fault = InputError::new(&job.output, "the name of a file", "that of a folder, with --crop-only");
        return Err(fault.remedy("Its files are called after the ids of the buildings, and there is an index.gpkg"));
    }
    Ok(())
}

/// The attributes that the index has.
pub(super) fn attributes(job: &Job) -> AttributeOptions {
    let mut options = job.attributes.clone();
    if options.own == Names::All {
        options.own = OWN.parse().unwrap_or_default();
    }
    options
}

/// Writes the points of all tasks and their index to `sinks`.
///
/// # Errors
/// A tile can no longer be opened, files that exist and shall not be replaced, or the system refuses.
pub(super) fn write(
    job: &Job,
    plan: &Plan,
    tasks: Vec<Task>,
    pool: &ThreadPool,
    journal: &Journal<'_>,
    open: Option<Open<'_, '_>>,
) -> Result<Done> {
    let mut corners = Corners::new(1);
    for site in tasks.iter().filter_map(Task::site) {
        corners.see(0, site.frame.origin);
    }
    let head = metadata(job, plan, corners.of_all());
    let names = file_names::for_ids(&tasks.iter().map(Task::id).collect::<Vec<_>>());
    let names: Vec<String> = names.into_iter().map(|name| format!("{name}.laz")).collect();
    let paths: Vec<PathBuf> = names.iter().map(|name| job.output.join(name)).collect();
    super::output::prepare_all(&paths.iter().map(PathBuf::as_path).collect::<Vec<_>>(), job.overwrite)?;
    let own = open.map(|open| open(&head)).transpose()?;
    let file: Box<dyn Sink + '_> = sink::create(&index(&job.output), head, job.overwrite)?;
    let mut sinks: Vec<Box<dyn Sink + '_>> = std::iter::once(file).chain(own).collect();
    let total = plan.tiles.iter().map(|tile| tile.points).sum();
    let written = journal.stage(Stage::Crop, total, |journal| {
        let crop = Crop { plan, tasks: &tasks, paths: &paths, overwrite: job.overwrite, pool };
        crop.points(job.segmentation.ring_width, journal)
    })?;
    let mut encoder = Encoder::new(tasks.iter().map(Task::id).collect(), job.point_cloud.clone());
    encoder = encoder.with_attributes(attributes(job));
    let mut counts = Counts { footprints: tasks.len(), ..Counts::default() };
    let mut buildings = Vec::with_capacity(tasks.len());
    journal.stage(Stage::Finish, 1, |journal| {
        for (index, task) in tasks.into_iter().enumerate() {
            let mut building = building(task, job.parameters.grid_steps().unwrap_or(1));
            let points = written.get(&index).copied();
            building.record.points_file =
                points.map(|points| PointsFile { name: names.get(index).cloned().unwrap_or_default(), points });
            let feature = encoder.feature(&building);
            sinks.iter_mut().try_for_each(|sink| sink.write(&feature))?;
            let mut report = BuildingReport::new(&building, std::time::Duration::ZERO, None);
            report.file = points.and_then(|_| paths.get(index)).map(|path| path.display().to_string());
            counts.written += 1;
            counts.with_points += usize::from(report.points > 0);
            counts.points += report.points as u64;
            if let Some((reason, _)) = report.outcome.reason() {
                *counts.skipped.entry(reason).or_default() += 1;
            }
            journal.event(Event::Building(&report));
            buildings.push(report);
        }
        for sink in sinks {
            for note in &sink.finish()?.notes {
                journal.warn(note);
            }
        }
        journal.event(Event::Advanced { stage: Stage::Finish, by: 1 });
        Ok(())
    })?;
    let outputs = vec![index(&job.output)];
    Ok(Done { counts, buildings, terrain: None, lacks_terrain: false, outputs, checkpoint: None, swept: None })
}

/// What the index has of a building.
fn building(task: Task, grid_steps: i64) -> Building {
    match task {
        Task::Keep(building) => *building,
        Task::Reconstruct { site, notes } => {
            let outcome = Outcome::FootprintOnly { reason: Reason::AsAsked, detail: DETAIL.to_owned() };
            let mut building = without_model(&site, grid_steps, outcome);
            let Scanned { density, no_data, .. } = Scanned::of(&site);
            building.measures.point_density = Some(density);
            building.measures.no_data_share = Some(no_data);
            building.notes.splice(0..0, notes);
            building
        }
    }
}

/// What is cropped.
struct Crop<'a> {
    plan: &'a Plan,
    tasks: &'a [Task],
    paths: &'a [PathBuf],
    overwrite: bool,
    pool: &'a ThreadPool,
}

/// The records of buildings by their tiles, in the order in which these were read.
type Held = BTreeMap<usize, Vec<Records>>;

impl Crop<'_> {
    /// Writes the points of each building and gives their number, for those that have any.
    fn points(&self, width: f64, journal: &Journal<'_>) -> Result<BTreeMap<usize, u64>> {
        let near = Near::new(self.tasks.iter().map(Task::site), width);
        let tiles: Vec<(&Tile, Vec<usize>)> =
            self.plan.tiles.iter().map(|tile| (tile, self.buildings_of(tile, &near))).collect();
        // How many tiles that may hold points of a building have not been read.
        let mut waiting: BTreeMap<usize, usize> = BTreeMap::new();
        for index in tiles.iter().flat_map(|(_, buildings)| buildings) {
            *waiting.entry(*index).or_default() += 1;
        }
        let mut held = Held::new();
        let mut written = BTreeMap::new();
        for (tile, buildings) in tiles {
            if journal.interrupted() {
                return Err(Error::Interrupted);
            }
            if buildings.is_empty() {
                journal.event(Event::Advanced { stage: Stage::Crop, by: tile.points });
                continue;
            }
            read(tile, &buildings, &near, &mut held, journal)?;
            let mut ready = Vec::new();
            for index in buildings {
                let left = waiting.entry(index).or_default();
                *left = left.saturating_sub(1);
                if *left == 0 {
                    ready.extend(held.remove(&index).map(|parts| (index, parts)));
                }
            }
            written.extend(self.write(ready)?);
        }
        Ok(written)
    }

    /// The buildings that a tile may hold points of, sorted: those in reach of its extent, and that are made from its cloud.
    fn buildings_of(&self, tile: &Tile, near: &Near) -> Vec<usize> {
        let mut buildings: Vec<usize> = match tile.extent.filter(|_| tile.is_true_to_its_extent()) {
            Some(extent) => near.touching([extent.min[0], extent.min[1]], [extent.max[0], extent.max[1]]).collect(),
            None if tile.points == 0 => Vec::new(),
            None => (0..self.tasks.len()).collect(),
        };
        let cloud = self.plan.cloud_of(tile);
        buildings.retain(|&index| {
            let site = self.tasks.get(index).and_then(Task::site);
            let own = site.and_then(|site| site.record.cloud.as_ref());
            own.is_none_or(|own| cloud.is_none_or(|cloud| own.cloud == *cloud))
        });
        buildings.sort_unstable();
        buildings
    }

    /// Writes the files of some buildings.
    fn write(&self, ready: Vec<(usize, Vec<Records>)>) -> Result<Vec<(usize, u64)>> {
        let one = |(index, parts): (usize, Vec<Records>)| {
            let points = parts.iter().map(Records::len).sum();
            let path = self.paths.get(index).map_or(Path::new("points.laz"), PathBuf::as_path);
            file::write(path, parts, &self.plan.crs, self.overwrite).map(|()| (index, points))
        };
        self.pool.install(|| ready.into_par_iter().map(one).collect())
    }
}

/// Reads a tile and holds what of it is of `buildings`.
fn read(tile: &Tile, buildings: &[usize], near: &Near, held: &mut Held, journal: &Journal<'_>) -> Result<()> {
    let mut own: BTreeMap<usize, Records> = BTreeMap::new();
    let mut lookup = near.lookup();
    let mut fault = None;
    let mut told = 0;
    let wanted = |low: [f64; 2], high: [f64; 2]| near.touching(low, high).next().is_some();
    tile.stream_records(Some(&wanted), &mut |block: &Block| {
        for (record, point) in block.records().zip(block.points()) {
            lookup.at(point.position, |index| {
                if buildings.binary_search(&index).is_err() {
                    return;
                }
                let taken = take(tile, own.entry(index), record, &point);
                if let Err(e) = taken {
                    fault.get_or_insert(e);
                }
            });
        }
        told += block.len() as u64;
        journal.event(Event::Advanced { stage: Stage::Crop, by: block.len() as u64 });
        if fault.is_some() || journal.interrupted() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    if journal.interrupted() {
        return Err(Error::Interrupted);
    }
    if let Some(fault) = fault {
        return Err(Error::io(&tile.path, "crop", std::io::Error::other(fault)));
    }
    journal.event(Event::Advanced { stage: Stage::Crop, by: tile.points.saturating_sub(told) });
    for (index, records) in own {
        held.entry(index).or_default().push(records);
    }
    Ok(())
}

/// Takes a point of a tile for a building.
fn take(
    tile: &Tile,
    entry: std::collections::btree_map::Entry<'_, usize, Records>,
    record: &[u8],
    point: &crate::source::points::ScanPoint,
) -> las::Result<()> {
    use std::collections::btree_map::Entry;
    let records = match entry {
        Entry::Occupied(taken) => taken.into_mut(),
        Entry::Vacant(free) if tile.is_las() => free.insert(Records::of_las(&tile.header)),
        Entry::Vacant(free) => free.insert(Records::plain(point.position)?),
    };
    if tile.is_las() {
        records.push(record);
        Ok(())
    } else {
        records.push_plain(point)
    }
}
