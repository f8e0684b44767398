//! Making a plan: headers and footprints are read, no points but those that opening a tile looks at.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use geo::Rect;
use rayon::prelude::*;

use super::cost::Cost;
use super::file::{JobPlan, LAYOUT, Options, PlannedCloud, PlannedJob, PlannedTile};
use super::folder::PlanFolder;
use super::share::ShareLine;
use super::split::{Item, Split, divide};
use crate::error::{Error, InputError, Result};
use crate::run::journal::Journal;
use crate::run::observer::{Event, Observer, Stage};
use crate::run::plan::{self, Plan};
use crate::run::prepare;
use crate::run::{Job, template};
use crate::segment::{self, Company, SegmentOptions, TileTree};
use crate::source::footprints;
use crate::source::points::Tile;
use crate::source::raster::Mosaic;

/// Divides a run into jobs and writes the plan into `folder`. Of the job everything counts but its output, which is for
/// [`super::merge`] to say, and what only concerns one process.
///
/// # Errors
/// As [`crate::run::run`], as far as it can be told before points are read; the job has no footprints, or asks for what only one run can
/// make; the folder holds a plan and `overwrite` is off, or something else.
pub fn make(job: &Job, split: Split, folder: &PlanFolder, overwrite: bool, observer: &dyn Observer) -> Result<JobPlan> {
    refuse_what_is_whole(job)?;
    let journal = Journal::new(observer);
    let pool = job.pool()?;
    // A network that cannot be loaded is better told now than by every job.
    job.field.load()?;
    let mut run = plan::plan(job, &pool, &journal)?;
    segment::refuse(&run.tiles, &run.footprints, &run.crs, &run.segmentation)
        .map_err(|fault| prepare::name_the_footprints(fault, &run))?;
    refuse_terrain_model(&run)?;
    folder.prepare(overwrite)?;

    let reliable: Vec<bool> = pool.install(|| run.tiles.par_iter().map(Tile::is_true_to_its_extent).collect());
    let wanted: Vec<usize> = (0..run.footprints.len()).filter(|&index| run.is_wanted[index]).collect();
    let jobs = split.jobs(wanted.len());
    let planned = journal.stage(Stage::Plan, jobs as u64, |journal| {
        let company = Company::new(&run.footprints, &run.crs, &run.segmentation);
        let tree = TileTree::new(run.tiles.iter().zip(reliable.iter().copied()));
        let cost = Cost::new(&run.tiles);
        let item = |&index: &usize| Item {
            index,
            place: company.middle(index).unwrap_or_default(),
            cost: cost.of(&run.footprints[index].polygon),
        };
        let shares = divide(wanted.iter().map(item).collect(), jobs);
        let extents = template::extents(&run.tiles);
        let maker = Maker { run: &run, wanted: &wanted, company: &company, tree: &tree, extents, cost, folder };
        let last = shares.len().saturating_sub(1);
        let all = shares.into_iter().enumerate();
        all.map(|(number, share)| {
            if journal.interrupted() {
                return Err(Error::Interrupted);
            }
            let planned = maker.job(number, &share, number == last)?;
            journal.event(Event::Advanced { stage: Stage::Plan, by: 1 });
            Ok(planned)
        })
        .collect::<Result<Vec<_>>>()
    })?;

    let (clouds, tiles) = absolute(&run, &reliable)?;
    let (warnings, ..) = journal.close();
    let mut plan = JobPlan {
        layout: LAYOUT,
        gable: env!("CARGO_PKG_VERSION").to_owned(),
        identity: String::new(),
        command: job.command.iter().map(|word| footprints::redacted(word)).collect(),
        title: run.title.clone(),
        crs: run.crs.clone(),
        crs_report: run.crs_report.clone(),
        options: options(job, &run.segmentation)?,
        clouds,
        tiles,
        inputs: std::mem::take(&mut run.inputs),
        footprints: wanted.len() + run.rejected.len(),
        rejected: run.rejected.len(),
        warnings,
        jobs: planned,
    };
    plan.identity = plan.identify().map_err(|e| Error::io(folder.path(), "write", e.into()))?;
    folder.write(&plan)?;
    Ok(plan)
}

/// Refuses what is not made building by building.
fn refuse_what_is_whole(job: &Job) -> Result<(), InputError> {
    let (option, found, remedy) = if job.footprints.is_none() {
        ("--footprints", "none", "What stands apart in the points is only found by one run: use `gable reconstruct`")
    } else if job.fed.is_some() {
        ("points", "points without a file", "Write them to a LAS or LAZ file that all jobs can read")
    } else if job.terrain.is_some() {
        ("--terrain", "a terrain", "Make it with `gable reconstruct --terrain`: it is one surface over all tiles")
    } else if job.edits.is_some() {
        (
            "--edits",
            "what a person has decided about buildings",
            "Make these buildings with `gable reconstruct --edits`",
        )
    } else if job.crop_only {
        ("--crop-only", "points instead of models", "Crop them with `gable reconstruct --crop-only`")
    } else {
        return Ok(());
    };
    Err(InputError::new(option, found, "what can be divided into jobs: buildings with footprints, tiles in files")
        .remedy(remedy))
}

/// Refuses a terrain model that jobs could not use either.
fn refuse_terrain_model(run: &Plan) -> Result<()> {
    let Some(path) = &run.segmentation.dtm else { return Ok(()) };
    let extents = run.tiles.iter().filter_map(|tile| tile.extent);
    let bounds = extents.fold([f64::MAX, f64::MAX, f64::MIN, f64::MIN], |[x0, y0, x1, y1], extent| {
        [x0.min(extent.min[0]), y0.min(extent.min[1]), x1.max(extent.max[0]), y1.max(extent.max[1])]
    });
    Mosaic::open(path, &run.crs, bounds).map(drop)
}

/// Makes one job after the other.
struct Maker<'a> {
    run: &'a Plan,
    /// The footprints that are reconstructed, by their places in the model.
    wanted: &'a [usize],
    company: &'a Company,
    tree: &'a TileTree,
    /// Where the tiles lie, for names of files.
    extents: Vec<Option<Rect<f64>>>,
    cost: Cost,
    folder: &'a PlanFolder,
}

impl Maker<'_> {
    /// Writes the footprints of a job; the last one takes the features without a usable polygon as well, which cost
    /// nothing.
    fn job(&self, job: usize, share: &[usize], is_last: bool) -> Result<PlannedJob> {
        let Self { run, wanted, company, tree, extents, cost, folder } = self;
        let beside = company.beside(share);
        let mut all = [share, &beside].concat();
        all.sort_unstable();
        let tiles = company.tiles(all.iter().copied(), tree);
        let lines = all.iter().map(|&index| {
            let footprint = &run.footprints[index];
            let place = share.binary_search(&index).ok().and_then(|_| wanted.binary_search(&index).ok());
            let tile = if place.is_some() { template::tile_of(footprint, extents) } else { 0 };
            ShareLine::footprint(footprint, place, tile)
        });
        let rejected = if is_last { run.rejected.as_slice() } else { &[] };
        let last = rejected.iter().enumerate().map(|(n, feature)| ShareLine::rejected(feature, wanted.len() + n));
        let checksum = folder.write_share(job, lines.chain(last))?;
        let metres = run.crs.metres_per_unit;
        let middles = share.iter().filter_map(|&index| company.middle(index));
        let extent = middles.map(|[x, y]| [x / metres[0], y / metres[1]]).fold(None, |extent, [x, y]| {
            let [x0, y0, x1, y1] = extent.unwrap_or([x, y, x, y]);
            Some([x.min(x0), y.min(y0), x.max(x1), y.max(y1)])
        });
        Ok(PlannedJob {
            job,
            footprints: share.len() + rejected.len(),
            beside: beside.len(),
            extent,
            points: tiles.iter().map(|&tile| run.tiles[tile].points).sum(),
            tiles,
            cost: share.iter().map(|&index| cost.of(&run.footprints[index].polygon)).sum(),
            checksum,
        })
    }
}

/// The clouds and tiles by absolute paths: jobs may run in any folder.
fn absolute(run: &Plan, reliable: &[bool]) -> Result<(Vec<PlannedCloud>, Vec<PlannedTile>)> {
    let clouds = run.clouds.iter().map(|cloud| PlannedCloud {
        about: cloud.about.clone(),
        priority: cloud.priority,
        building_classes: cloud.building_classes.clone(),
    });
    let tiles = run.tiles.iter().zip(reliable).map(|(tile, is_reliable)| {
        Ok(PlannedTile {
            path: absolute_path(&tile.path)?,
            cloud: run.clouds.iter().position(|cloud| cloud.paths.contains(&tile.path)).unwrap_or_default(),
            points: tile.points,
            extent: tile.extent.map(|extent| [extent.min, extent.max]),
            is_reliable: *is_reliable,
        })
    });
    Ok((clouds.collect(), tiles.collect::<Result<_>>()?))
}

fn options(job: &Job, segmentation: &SegmentOptions) -> Result<Options> {
    let absolute = |path: &Option<PathBuf>| path.as_deref().map(absolute_path).transpose();
    let mut field = job.field.clone();
    field.model = absolute(&field.model)?;
    field.onnxruntime = absolute(&field.onnxruntime)?;
    Ok(Options {
        parameters: job.parameters.clone(),
        field_identity: field.identity()?,
        field,
        segmentation: SegmentOptions { dtm: absolute(&segmentation.dtm)?, ..segmentation.clone() },
        attributes: job.attributes.clone(),
        point_cloud: job.point_cloud.clone(),
        translation: job.translation,
    })
}

fn absolute_path(path: &Path) -> Result<PathBuf> {
    std::path::absolute(path).map_err(|e| Error::io(path, "find", e))
}

/// What a plan comes to, for a person.
impl JobPlan {
    /// How often a point of the tiles is read, on average over the tiles that are read at all; more than once where jobs
    /// share tiles.
    pub fn readings(&self) -> f64 {
        let mut is_read = vec![false; self.tiles.len()];
        self.jobs.iter().flat_map(|job| &job.tiles).for_each(|&tile| is_read[tile] = true);
        let once: u64 =
            self.tiles.iter().zip(is_read).filter(|(_, is_read)| *is_read).map(|(tile, _)| tile.points).sum();
        let all: u64 = self.jobs.iter().map(|job| job.points).sum();
        if once > 0 { all as f64 / once as f64 } else { 0.0 }
    }

    /// The footprints of the smallest and of the largest job.
    pub fn sizes(&self) -> (usize, usize) {
        let sizes = || self.jobs.iter().map(|job| job.footprints);
        (sizes().min().unwrap_or_default(), sizes().max().unwrap_or_default())
    }
}

impl Split {
    /// What is done where the user says nothing: about a quarter of a minute of one core each.
    pub const DEFAULT: Self = match NonZeroUsize::new(1000) {
        Some(each) => Self::Footprints(each),
        None => Self::Jobs(NonZeroUsize::MIN),
    };
}
