//! Doing one job of a plan.

use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use super::file::{JobPlan, PlannedTile};
use super::folder::PlanFolder;
use super::part::{self, Head, PartWriter};
use super::share::Share;
use crate::edits::Edits;
use crate::error::{Error, InputError, Result};
use crate::reconstruct::reconstruct;
use crate::report::{self, Counts, Inputs, Quality, Report, TileReport};
use crate::run::buildings::{Told, reconstruct_all};
use crate::run::checkpoint::Checkpoint;
use crate::run::clouds::Cloud;
use crate::run::identity::Identity;
use crate::run::journal::Journal;
use crate::run::observer::{Event, Observer, Stage};
use crate::run::plan::Plan;
use crate::run::prepare::prepare;
use crate::run::records::Record;
use crate::run::{Job, MEMORY, tiles};
use crate::source::footprints;
use crate::source::points::Tile;

/// One job that is to be done.
#[derive(Debug, Clone)]
pub struct JobRun {
    /// The folder of the plan.
    pub plan: PlanFolder,
    /// The number of the job.
    pub job: usize,
    /// Where its part goes; `None` for the plan's own folder.
    pub parts: Option<PathBuf>,
    /// Number of threads; `None` for one per processor.
    pub threads: Option<NonZeroUsize>,
    /// Whether a part that is there is made anew.
    pub overwrite: bool,
    /// The command line, for the report.
    pub command: Vec<String>,
}

/// What came of a job.
#[derive(Debug)]
pub enum Outcome {
    /// Its part is written.
    Done(Box<Report>),
    /// Its part was there.
    WasDone(PathBuf),
}

/// Does a job: its part and its report appear under their names when they are whole. What an earlier attempt that was
/// killed has left is gone on from.
///
/// # Errors
/// There is no such job; the plan, a tile, the network or what else it needs is not what it was; a part of another plan
/// stands in the way; another process does the same job; it was interrupted; or the system refuses.
pub fn do_job(run: &JobRun, observer: &dyn Observer) -> Result<Outcome> {
    let plan = run.plan.read()?;
    let share = run.plan.read_share(&plan, run.job)?;
    let folder = run.parts.clone().unwrap_or_else(|| run.plan.parts());
    let path = part::path_of(&folder, run.job);
    if !run.overwrite && is_done(&path, &plan, run.job)? {
        return Ok(Outcome::WasDone(path));
    }
    std::fs::create_dir_all(&folder).map_err(|e| Error::io(&folder, "create", e))?;
    plan.check_field()?;
    let report = Worker { run, plan: &plan, path, report: part::report_of(&folder, run.job) }.work(share, observer)?;
    Ok(Outcome::Done(Box::new(report)))
}

/// Whether the part of a job is there.
fn is_done(path: &Path, plan: &JobPlan, job: usize) -> Result<bool> {
    match part::head(path) {
        Ok(Some(head)) if head.plan == plan.identity && head.job == job => Ok(true),
        Ok(Some(head)) => {
            let found = format!("the part of job {} of another plan", head.job);
            let fault = InputError::new(path, found, format!("nothing, or that of job {job} of this plan"));
            Err(fault.remedy("Give another folder with --parts, or --overwrite to replace it").into())
        }
        // What is not whole is made anew.
        Ok(None) => Ok(false),
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(false),
        Err(e) => Err(Error::io(path, "read", e)),
    }
}

/// Does one job.
struct Worker<'a> {
    run: &'a JobRun,
    plan: &'a JobPlan,
    path: PathBuf,
    report: PathBuf,
}

impl Worker<'_> {
    fn work(&self, share: Share, observer: &dyn Observer) -> Result<Report> {
        let started = report::now();
        let journal = Journal::new(observer);
        let job = Job { threads: self.run.threads, ..self.plan.job() };
        let field = job.field.load()?;
        let pool = job.pool()?;
        let places = share.places.clone();
        let mut own = self.open(share, &job, &journal)?;
        let (prepared, stock) = prepare(&mut own, &pool, &journal)?;
        let supply = prepared.supply(stock, &own, None, MEMORY, &journal)?;
        let total = prepared.roster.len();

        let mut parameters = serde_json::to_value(&job.parameters).unwrap_or_default();
        parameters["field"] = self.plan.options.field_identity.clone();
        let checkpoint = Checkpoint::open(&self.path, &Identity::new(parameters), !self.run.overwrite)?;
        let head = Head { plan: self.plan.identity.clone(), job: self.run.job, buildings: total };
        let mut part = PartWriter::create(self.path.clone(), &head, checkpoint.folder())?;
        let Told { counts, buildings, .. } = journal.stage(Stage::Reconstruct, total as u64, |journal| {
            let grid_steps = job.parameters.grid_steps().unwrap_or(1);
            let method = |site: &_| reconstruct(site, &job.parameters, &*field);
            let records = (checkpoint.records(), true);
            reconstruct_all(&supply, total, &pool, journal, records, (grid_steps, method), |record| {
                let Record { index, inputs, wall, cpu, building } = *record;
                let index = places.get(index).copied().unwrap_or(usize::MAX);
                part.write(&Record { index, inputs, wall, cpu, building })
            })
        })?;
        if counts.not_reached > 0 {
            let done = checkpoint.folder().display();
            journal.warn(&format!("{done}: what is done is kept there; the same command goes on"));
            return Err(Error::Interrupted);
        }
        if let Some((swept, incomplete)) = supply.finish()? {
            own.note(swept, (incomplete, total), &journal);
        }
        let report = self.report(&own, counts, buildings, (started, pool.current_num_threads()), journal);
        // The report first: where there is a part, there is its report.
        report.write(&self.report)?;
        part.commit()?;
        checkpoint.remove()?;
        Ok(report)
    }

    /// Opens the tiles of the job: what is known before points are read, as of a run.
    fn open(&self, share: Share, job: &Job, journal: &Journal<'_>) -> Result<Plan> {
        let planned = self.plan.jobs.get(self.run.job).map_or(&[][..], |planned| &planned.tiles);
        let all = &self.plan.tiles;
        let mut reports = Vec::with_capacity(planned.len());
        let tiles = journal.stage(Stage::Read, planned.len() as u64, |journal| {
            let mut tiles = Vec::with_capacity(all.len());
            for (index, tile) in all.iter().enumerate() {
                if planned.binary_search(&index).is_err() {
                    tiles.push(Tile::elsewhere(&tile.path, tile.points, tile.extent()));
                    continue;
                }
                let opened = Tile::open(&tile.path)?;
                check(tile, &opened)?;
                reports.push(TileReport {
                    file: tile.path.display().to_string(),
                    cloud: None,
                    points: tile.points,
                    missing_points: 0,
                    left_out: false,
                    crs: opened.crs.as_ref().map(tiles::label),
                    problems: Vec::new(),
                });
                tiles.push(opened);
                journal.event(Event::Advanced { stage: Stage::Read, by: 1 });
            }
            Ok(tiles)
        })?;
        let clouds = self.plan.clouds.iter().enumerate().map(|(number, cloud)| Cloud {
            about: cloud.about.clone(),
            priority: cloud.priority,
            building_classes: cloud.building_classes.clone(),
            paths: all.iter().filter(|tile| tile.cloud == number).map(|tile| tile.path.clone()).collect(),
        });
        Ok(Plan {
            tiles,
            clouds: clouds.collect(),
            crs: self.plan.crs.clone(),
            crs_report: self.plan.crs_report.clone(),
            model: Some(self.path.clone()),
            files: None,
            report: Some(self.report.clone()),
            title: self.plan.title.clone(),
            inputs: Inputs { tiles: reports, footprints: self.plan.inputs.footprints.clone(), ..Inputs::default() },
            footprints: share.footprints,
            is_wanted: share.is_wanted,
            rejected: share.rejected,
            is_share: true,
            continues: false,
            segmentation: job.segmentation.clone(),
            has_stand_ins: false,
            ground: None,
            edits: Edits::default(),
        })
    }

    fn report(
        &self,
        own: &Plan,
        counts: Counts,
        buildings: Vec<report::BuildingReport>,
        (started, threads): (String, usize),
        journal: Journal<'_>,
    ) -> Report {
        let (warnings, stages, watch) = journal.close();
        Report {
            gable: env!("CARGO_PKG_VERSION").to_owned(),
            command: self.run.command.iter().map(|word| footprints::redacted(word)).collect(),
            started,
            interrupted: false,
            // Buildings without a model are no failure of a job: doing it again would make none.
            exit_code: 0,
            crs: own.crs_report.clone(),
            inputs: own.inputs.clone(),
            parameters: self.plan.options.parameters.clone(),
            field: self.plan.options.field.clone(),
            segmentation: self.plan.options.segmentation.clone(),
            counts,
            quality: Quality::of(&buildings),
            terrain: None,
            stages,
            wall_seconds: watch.wall().as_secs_f64(),
            cpu_seconds: watch.cpu().map(|time| time.as_secs_f64()),
            threads,
            peak_memory_bytes: report::peak_memory(),
            jobs: None,
            outputs: [&self.path, &self.report].map(|path| path.display().to_string()).to_vec(),
            warnings,
            buildings,
        }
    }
}

/// Refuses a tile that is not the one that was planned with.
fn check(planned: &PlannedTile, tile: &Tile) -> Result<()> {
    if tile.points == planned.points && tile.extent == planned.extent() {
        return Ok(());
    }
    let said = |points: u64, extent: Option<[[f64; 3]; 2]>| {
        let at =
            extent.map_or_else(String::new, |[a, b]| format!(" at x {} to {}, y {} to {}", a[0], b[0], a[1], b[1]));
        format!("{points} points{at}")
    };
    let found = said(tile.points, tile.extent.map(|extent| [extent.min, extent.max]));
    let fault = InputError::new(&tile.path, found, format!("{}, as in the plan", said(planned.points, planned.extent)));
    Err(fault.remedy("The tile was changed since: put it back, or make the plan anew").into())
}
