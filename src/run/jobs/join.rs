//! Joining the parts of all jobs into one model and one report, building by building.

use std::collections::HashMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use tempfile::TempDir;

use super::file::JobPlan;
use super::folder::PlanFolder;
use super::shelf::Shelf;
use crate::error::{Error, InputError, Result};
use crate::report::{self, BuildingReport, Counts, JobReport, QualityTally, Report, Spool, TileReport};
use crate::run::corners::Corners;
use crate::run::files::ManyFiles;
use crate::run::journal::Journal;
use crate::run::observer::{Event, Observer, Stage};
use crate::run::records::Record;
use crate::run::template::{Files, Template};
use crate::run::write::head;
use crate::run::{exit_code, output, plan};
use crate::segment::{self, PointCounts};
use crate::sink::{self, Encoder, Format, Ids, Metadata, Sink, is_stream, temporary};
use crate::source::footprints;
use crate::source::points::Tile;

/// What is to be joined, and where it goes.
#[derive(Debug, Clone)]
pub struct Merge {
    /// The folder of the plan.
    pub plan: PlanFolder,
    /// The folders of the parts; none for the plan's own.
    pub parts: Vec<PathBuf>,
    /// The model: as [`Job::output`](crate::run::Job::output), but no folder that is to be named in.
    pub output: PathBuf,
    /// Where the report goes; `None` puts it next to the model, if that goes to a file.
    pub report: Option<PathBuf>,
    /// Whether files that exist are replaced.
    pub overwrite: bool,
    /// The command line, for the report.
    pub command: Vec<String>,
}

/// What is read of the report of a job.
#[derive(Debug, Deserialize)]
struct OfJob {
    wall_seconds: f64,
    cpu_seconds: Option<f64>,
    threads: usize,
    peak_memory_bytes: Option<u64>,
    warnings: Vec<String>,
    inputs: OfInputs,
}

#[derive(Debug, Deserialize)]
struct OfInputs {
    tiles: Vec<TileReport>,
    points: PointCounts,
}

/// Joins the parts of a plan: the same bytes as one run writes. The report that is returned has no buildings; the one that is
/// written has.
///
/// # Errors
/// A job is missing or there twice, or a footprint is; the output exists or cannot be written; no tile holds a point of the building
/// classes.
pub fn merge(merge: &Merge, observer: &dyn Observer) -> Result<Report> {
    let plan = merge.plan.read()?;
    let journal = Journal::new(observer);
    let started = report::now();
    let target = Target::of(merge)?;
    target.prepare(merge.overwrite)?;
    let arranged = target.template.as_ref().map(|template| arrange(template, &plan, &merge.plan)).transpose()?;
    let (files, order) = arranged.unzip();

    let mut ids = Ids::default();
    let mut origins = Origins::new(&plan, files.as_ref());
    let mut shelf = journal.stage(Stage::Read, plan.jobs.len() as u64, |journal| {
        let each = |index: usize, id: &str, origin: [f64; 3]| {
            ids.take(id);
            origins.see(index, id, origin);
        };
        Shelf::open(&plan, &merge.plan, &merge.parts, each, || {
            journal.event(Event::Advanced { stage: Stage::Read, by: 1 });
            if journal.interrupted() { Err(Error::Interrupted) } else { Ok(()) }
        })
    })?;
    let (inputs, jobs, warnings) = of_jobs(&plan, &shelf)?;
    plan.warnings.iter().chain(&warnings).for_each(|warning| journal.warn(warning));
    refuse_absent_classes(&plan, &inputs.points)?;

    let scratch = target.scratch()?;
    let heads = origins.heads(&plan);
    let mut outputs = Vec::new();
    let mut spool = Spool::create(scratch.path())?;
    let (counts, quality) = {
        let sink = target.sink(merge.overwrite, scratch.path(), heads, files.as_ref(), &mut outputs)?;
        let joiner = Joiner { plan: &plan, files: files.as_ref(), sink, spool: &mut spool };
        joiner.join(&mut shelf, order.as_deref(), ids, &journal)?
    };
    if files.is_none() && !is_stream(&merge.output) {
        outputs.push(merge.output.clone());
    }
    plan::warn_of_emptiness(&inputs.points, &plan.options.segmentation, &counts, &journal);
    let exit_code = exit_code(&counts, &inputs, false);
    let (warnings, stages, watch) = journal.close();
    let report = Report {
        gable: env!("CARGO_PKG_VERSION").to_owned(),
        command: merge.command.iter().map(|word| footprints::redacted(word)).collect(),
        started,
        interrupted: false,
        exit_code,
        crs: plan.crs_report.clone(),
        inputs,
        parameters: plan.options.parameters.clone(),
        field: plan.options.field.clone(),
        segmentation: plan.options.segmentation.clone(),
        counts,
        quality: quality.quality(),
        terrain: None,
        stages,
        wall_seconds: watch.wall().as_secs_f64(),
        cpu_seconds: watch.cpu().map(|time| time.as_secs_f64()),
        threads: 1,
        peak_memory_bytes: report::peak_memory(),
        jobs: Some(jobs),
        outputs: outputs.iter().chain(&target.report).map(|path| path.display().to_string()).collect(),
        warnings,
        buildings: Vec::new(),
    };
    if let Some(path) = &target.report {
        spool.write(&report, path)?;
    }
    Ok(report)
}

/// Where the model and the report go.
struct Target {
    model: PathBuf,
    template: Option<Template>,
    report: Option<PathBuf>,
}

impl Target {
    fn of(merge: &Merge) -> Result<Self> {
        let template = Template::of(&merge.output)?;
        let base = template.as_ref().map_or_else(|| merge.output.clone(), Template::base);
        let own_report = (!is_stream(&merge.output)).then(|| output::report_path(&base));
        let report = merge.report.clone().or(own_report);
        if report.as_ref() == Some(&merge.output) {
            let fault = InputError::new(&merge.output, "the model and the report in one file", "a file for each");
            return Err(fault.remedy("Give another name with --report").into());
        }
        Ok(Self { model: merge.output.clone(), template, report })
    }

    /// Fails before the work if something stands in the way.
    fn prepare(&self, overwrite: bool) -> Result<()> {
        if self.template.is_none() && !is_stream(&self.model) {
            Format::of(&self.model)?;
            output::prepare(&self.model, overwrite)?;
        }
        // A report that stands next to the model belongs to it and is replaced with it.
        self.report.as_deref().map_or(Ok(()), |report| output::prepare(report, true))
    }

    /// A folder for what has no name yet, on the file system of the model.
    fn scratch(&self) -> Result<TempDir> {
        let base = self.template.as_ref().map_or_else(|| self.model.clone(), Template::base);
        let folder = base.parent().filter(|folder| !folder.as_os_str().is_empty() && !is_stream(&self.model));
        let folder = folder
            .map_or_else(|| if is_stream(&self.model) { std::env::temp_dir() } else { ".".into() }, Path::to_path_buf);
        fs::create_dir_all(&folder).map_err(|e| Error::io(&folder, "create", e))?;
        temporary(0o777).tempdir_in(&folder).map_err(|e| Error::io(&folder, "write to", e))
    }

    fn sink<'a>(
        &self,
        overwrite: bool,
        scratch: &Path,
        mut heads: Vec<Metadata>,
        files: Option<&'a Files>,
        outputs: &'a mut Vec<PathBuf>,
    ) -> Result<Box<dyn Sink + 'a>> {
        if let Some(files) = files {
            let paths: Vec<&Path> = files.paths.iter().map(PathBuf::as_path).collect();
            output::prepare_all(&paths, overwrite)?;
            return Ok(Box::new(ManyFiles::new(files, heads, scratch, overwrite, outputs)));
        }
        let head = heads.pop().unwrap_or_default();
        if is_stream(&self.model) {
            return sink::stream(&self.model, head);
        }
        sink::create_in(Some(scratch), &self.model, head, overwrite).map(|sink| sink as Box<dyn Sink>)
    }
}

/// The files of a model that goes to several, as one run names them, and the places of the buildings in the order in which
/// they are written: one file after the other.
fn arrange(template: &Template, plan: &JobPlan, folder: &PlanFolder) -> Result<(Files, Vec<usize>)> {
    let mut buildings = vec![(String::new(), 0); plan.footprints];
    for job in &plan.jobs {
        let share = folder.read_share(plan, job.job)?;
        for ((&place, &tile), id) in share.places.iter().zip(&share.tiles).zip(share.ids()) {
            if let Some(building) = buildings.get_mut(place) {
                *building = (id.to_owned(), if template.is_by_tile() { tile } else { 0 });
            }
        }
    }
    let tiles: Vec<&Path> = plan.tiles.iter().map(|tile| tile.path.as_path()).collect();
    let files = template.arrange(&tiles, &buildings);
    let mut order: Vec<usize> = (0..buildings.len()).collect();
    order.sort_by_key(|&place| files.of_building.get(&buildings[place].0));
    Ok((files, order))
}

/// The corners of the model, or of its files.
struct Origins<'a> {
    files: Option<&'a Files>,
    /// From this place on there are features without a usable polygon, which have no corner.
    rejected_from: usize,
    corners: Corners,
}

impl<'a> Origins<'a> {
    fn new(plan: &JobPlan, files: Option<&'a Files>) -> Self {
        let count = files.map_or(1, |files| files.paths.len());
        let rejected_from = plan.footprints - plan.rejected.min(plan.footprints);
        Self { files, rejected_from, corners: Corners::new(count) }
    }

    fn see(&mut self, index: usize, id: &str, origin: [f64; 3]) {
        let file = self.files.map_or(Some(0), |files| files.of_building.get(id).copied());
        if let Some(file) = file.filter(|_| index < self.rejected_from) {
            self.corners.see(file, origin);
        }
    }

    fn heads(&self, plan: &JobPlan) -> Vec<Metadata> {
        let job = plan.job();
        self.corners.of_files().map(|corner| head(&job, &plan.crs, &plan.title, corner)).collect()
    }
}

/// What the reports of the jobs come to: what came in, what each cost, and their warnings.
fn of_jobs(plan: &JobPlan, shelf: &Shelf) -> Result<(report::Inputs, Vec<JobReport>, Vec<String>)> {
    let mut inputs = plan.inputs.clone();
    // The plan's tiles are those of the report that could be opened, in their order.
    let opened = inputs.tiles.iter().enumerate().filter(|(_, tile)| !tile.left_out).map(|(index, _)| index);
    let names = plan.tiles.iter().map(|tile| tile.path.display().to_string());
    let of_tile: HashMap<String, usize> = names.zip(opened).collect();
    let mut jobs = Vec::with_capacity(plan.jobs.len());
    let mut warnings = Vec::new();
    for ((job, path), planned) in shelf.reports().zip(&plan.jobs) {
        let text = fs::read(&path).map_err(|e| Error::io(&path, "read", e))?;
        let own: OfJob = serde_json::from_slice(&text).map_err(|e| {
            let fault = InputError::new(&path, e.to_string(), "the report of a job");
            fault.remedy("It is damaged: do the job again with --overwrite")
        })?;
        inputs.points.add(&own.inputs.points);
        for tile in own.inputs.tiles {
            let Some(report) = of_tile.get(&tile.file).and_then(|&index| inputs.tiles.get_mut(index)) else { continue };
            report.missing_points = report.missing_points.max(tile.missing_points);
            for problem in tile.problems {
                if !report.problems.contains(&problem) {
                    report.problems.push(problem);
                }
            }
        }
        warnings.extend(own.warnings.into_iter().map(|warning| format!("job {job}: {warning}")));
        jobs.push(JobReport {
            job,
            footprints: planned.footprints,
            wall_seconds: own.wall_seconds,
            cpu_seconds: own.cpu_seconds,
            threads: own.threads,
            peak_memory_bytes: own.peak_memory_bytes,
        });
    }
    Ok((inputs, jobs, warnings))
}

/// As one run refuses tiles in which the classes that were asked for do not occur.
fn refuse_absent_classes(plan: &JobPlan, points: &PointCounts) -> Result<()> {
    if plan.clouds.len() > 1 {
        return Ok(());
    }
    let tiles: Vec<Tile> =
        plan.tiles.iter().map(|tile| Tile::elsewhere(&tile.path, tile.points, tile.extent())).collect();
    segment::refuse_classes(&tiles, points, &plan.options.segmentation)
}

/// Gives building after building to the sink and to the report.
struct Joiner<'a, 's> {
    plan: &'a JobPlan,
    files: Option<&'a Files>,
    sink: Box<dyn Sink + 's>,
    spool: &'a mut Spool,
}

impl Joiner<'_, '_> {
    /// `order` says in which order the places of the model are gone through, where it is not their own.
    fn join(
        mut self,
        shelf: &mut Shelf,
        order: Option<&[usize]>,
        ids: Ids,
        journal: &Journal<'_>,
    ) -> Result<(Counts, QualityTally)> {
        let options = &self.plan.options;
        let encoder = Encoder::new(ids, options.point_cloud.clone());
        let mut encoder = encoder.with_attributes(options.attributes.clone());
        let total = self.plan.footprints;
        let mut counts = Counts { footprints: total, ..Counts::default() };
        let mut quality = QualityTally::default();
        journal.stage(Stage::Merge, total as u64, |journal| {
            for number in 0..total {
                let index = order.map_or(number, |order| order[number]);
                if journal.interrupted() {
                    return Err(Error::Interrupted);
                }
                let Record { wall, cpu, building, .. } = shelf.read(index)?;
                self.sink.write(&encoder.feature(&building))?;
                let file = self.files.and_then(|files| files.paths.get(*files.of_building.get(&building.id)?));
                let file = file.map(|file| file.display().to_string());
                let report = BuildingReport { file, ..BuildingReport::new(&building, wall, cpu) };
                counts.add(&report);
                quality.add(&report);
                self.spool.add(&report)?;
                journal.event(Event::Building(&report));
                journal.event(Event::Advanced { stage: Stage::Merge, by: 1 });
            }
            Ok(())
        })?;
        journal.stage(Stage::Finish, 1, |journal| {
            let written = self.sink.finish()?;
            for note in &written.notes {
                journal.warn(&format!("{}: {note}", written.path.display()));
            }
            journal.event(Event::Advanced { stage: Stage::Finish, by: 1 });
            Ok(())
        })?;
        Ok((counts, quality))
    }
}
