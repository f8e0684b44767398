//! Reading the inputs: what there is, in which CRS, and where the result goes.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use rayon::ThreadPool;

use super::buildings::Task;
use super::job::{FootprintSource, Job};
use super::journal::Journal;
use super::observer::{Event, Observer, Stage};
use super::single::{Look, StandIns};
use super::{checkpoint, classes, output, roofprints, single, terrain, tiles};
use crate::building::{Building, Measures, Outcome, Reason};
use crate::error::{Error, InputError, Result};
use crate::report::{Counts, CrsReport, FootprintsReport, Inputs};
use crate::segment::{SegmentOptions, Segmentation, segment, segment_named, segment_object};
use crate::sink::{Format, is_reserved};
use crate::site::{Frame, Site};
use crate::solid::Model;
use crate::source::classes::class_name;
use crate::source::crs::Crs;
use crate::source::footprints::{self, Footprint, FootprintLayer, FootprintOptions, Rejected, Within};
use crate::source::points::{self, Extent, Tile, TileProblem};
use crate::source::raster;
use crate::terrain::GroundStore;

/// So many names of attributes are shown in one warning.
const SHOWN: usize = 10;

/// What there is and where the result goes.
pub(super) struct Plan {
    pub tiles: Vec<Tile>,
    pub crs: Crs,
    pub crs_report: CrsReport,
    /// The model's file; `None` when only a sink of the caller takes it.
    pub model: Option<PathBuf>,
    /// The report's file, if it has one.
    pub report: Option<PathBuf>,
    /// What the model is of: the name of the footprint file, or of the only tile.
    pub title: String,
    pub inputs: Inputs,
    footprints: Vec<Footprint>,
    rejected: Vec<Rejected>,
    /// Whether this run goes on from one that was killed, and so may replace what that one left.
    pub continues: bool,
    /// Which points belong to a building: what the job says, but for points without classes.
    pub segmentation: SegmentOptions,
    /// Whether the footprints stand in for those that there are not.
    has_stand_ins: bool,
    /// Where the ground points wait for the terrain; `None` where there is to be none.
    pub ground: Option<GroundStore>,
}

impl Plan {
    /// The footprints whose points are to be collected.
    pub(super) fn footprints(&self) -> &[Footprint] {
        &self.footprints
    }

    /// The features without a usable polygon.
    pub(super) fn rejected(&self) -> &[Rejected] {
        &self.rejected
    }

    /// The same with these tiles alone, and without anything to be written.
    pub(super) fn at(&self, tiles: Vec<Tile>) -> Self {
        Self {
            tiles,
            crs: self.crs.clone(),
            crs_report: self.crs_report.clone(),
            model: None,
            report: None,
            title: self.title.clone(),
            inputs: Inputs::default(),
            footprints: self.footprints.clone(),
            rejected: Vec::new(),
            continues: false,
            segmentation: self.segmentation.clone(),
            has_stand_ins: self.has_stand_ins,
            ground: None,
        }
    }

    /// The files to be written.
    pub(super) fn outputs(&self) -> impl Iterator<Item = &Path> {
        self.model.iter().chain(&self.report).map(PathBuf::as_path)
    }
}

/// Reads headers and footprints and brings them into one CRS.
///
/// # Errors
/// As [`super::run`], as far as it can be told before the points are read.
pub(super) fn plan(job: &Job, journal: &mut Journal<'_>) -> Result<Plan> {
    let fed = job.fed.as_ref();
    let paths = if job.tiles.is_empty() && fed.is_some() { Vec::new() } else { points::expand(&job.tiles)? };
    let names: Vec<PathBuf> = paths.iter().cloned().chain(fed.map(|fed| fed.name().to_path_buf())).collect();
    let footprint_path = job.footprints.as_ref().map(|source| source.path.as_path());
    let footprint_name = job.footprints.as_ref().map(FootprintSource::name);
    let has_model = !job.output.as_os_str().is_empty();
    let model = has_model.then(|| output::model_path(&job.output, &names, footprint_name.as_deref()));
    // A report that stands next to the model belongs to it and is replaced with it.
    let report = job.report.clone().or_else(|| model.as_deref().map(output::report_path));
    let files = names.len() + usize::from(job.footprints.is_some()) + usize::from(job.roofprints.is_some());

    journal.stage(Stage::Read, files as u64, |journal| {
        if let Some(report) = report.as_deref().filter(|_| report == model) {
            let fault = InputError::new(report, "the model and the report in one file", "a file for each");
            return Err(fault.remedy("Give another name with --report").into());
        }
        let outputs: Vec<&Path> = model.iter().chain(&report).map(PathBuf::as_path).collect();
        let sheets = job.segmentation.dtm.as_deref().map(raster::sheets).transpose()?.unwrap_or_default();
        let inputs = paths.iter().chain(&sheets).chain(&job.roofprints).map(PathBuf::as_path).chain(footprint_path);
        output::spare_inputs(&outputs, inputs)?;
        let continues = match &model {
            Some(model) => {
                Format::of(model)?;
                goes_on(job, model, journal)?
            }
            None => false,
        };
        if let Some(model) = &model {
            output::prepare(model, job.overwrite || continues)?;
        }
        if let Some(report) = &report {
            output::prepare(report, job.overwrite || continues || job.report.is_none())?;
        }
        let tiles::OpenTiles { tiles, reports } = tiles::open(&paths, fed, journal)?;
        let read = |source: &FootprintSource| read_footprints(job, source, &tiles, journal);
        let layer = job.footprints.as_ref().map(read).transpose()?;
        let own_crs = layer.as_ref().and_then(|layer| layer.crs.clone());
        tiles::refuse_emptiness(&tiles)?;
        let mut tiles = tiles.into_iter().map(|tile| tiles::place(tile, job.placement)).collect::<Result<Vec<_>>>()?;
        let (crs, source, warnings) = match &layer {
            Some(_) => tiles::agree_on_crs(&tiles, job.crs.as_deref(), own_crs.as_ref())?,
            None => tiles::agree_on_crs_or_none(&tiles, job.crs.as_deref(), job.placement.is_some())?,
        };
        for warning in &warnings {
            journal.warn(warning);
        }

        let (crs, warning) = tiles::true_to_length(crs, &tiles);
        if let Some(warning) = &warning {
            journal.warn(warning);
        }

        let (segmentation, warning) = classes::of_points(&tiles, &job.segmentation, layer.is_some());
        if let Some(warning) = warning {
            journal.warn(&warning);
        }
        let ground = terrain::store(job, model.as_deref(), &crs)?;
        let crs_report = CrsReport { name: crs.name.clone(), code: crs.code.clone(), source };
        let name =
            stem(footprint_name.as_deref().or(names.first().map(PathBuf::as_path)).unwrap_or(Path::new("model")));
        let mut inputs = Inputs { tiles: reports, ..Inputs::default() };
        let (footprints, rejected, has_stand_ins) = if let Some(layer) = layer {
            let (mut footprints, rejected, report) = bring(layer, &crs, journal)?;
            journal.event(Event::Advanced { stage: Stage::Read, by: 1 });
            if let Some(path) = &job.roofprints {
                inputs.roofprints = Some(bring_roofs(job, path, &tiles, &mut footprints, &report, &crs, journal)?);
                journal.event(Event::Advanced { stage: Stage::Read, by: 1 });
            }
            inputs.footprints = Some(report);
            (footprints, rejected, false)
        } else {
            let look = Look {
                options: &segmentation,
                is_unclassified: segmentation != job.segmentation,
                metres_per_unit: crs.metres_per_unit,
            };
            let StandIns { footprints, warnings } = single::stand_ins(&mut tiles, &name, look)?;
            for warning in &warnings {
                journal.warn(warning);
            }
            (footprints, Vec::new(), true)
        };
        Ok(Plan {
            tiles,
            crs,
            crs_report,
            model,
            report,
            title: job.title.clone().unwrap_or(name),
            inputs,
            footprints,
            rejected,
            continues,
            segmentation,
            has_stand_ins,
            ground,
        })
    })
}

/// Reads the footprints; those far from all tiles only where the format cannot tell which they are.
fn read_footprints(
    job: &Job,
    source: &FootprintSource,
    tiles: &[Tile],
    journal: &Journal<'_>,
) -> Result<FootprintLayer> {
    let mut options = source.options.clone();
    if footprints::is_read_in_part(&source.path) {
        let with_points = tiles.iter().filter(|tile| tile.points > 0);
        let all: Option<Vec<Extent>> =
            with_points.map(|tile| tile.extent.filter(|_| tile.is_true_to_its_extent())).collect();
        let agreed = tiles::agree_on_crs(tiles, job.crs.as_deref(), None).ok();
        if let (Some((crs, ..)), Some(all)) = (agreed, all.filter(|all| !all.is_empty())) {
            let mut whole = Extent::EMPTY;
            for extent in &all {
                whole.join(extent);
            }
            let extent = [whole.min[0], whole.min[1], whole.max[0], whole.max[1]];
            options.within = Some(Within { crs, extent });
        }
    }
    footprints::read_until(&source.path, &options, &|| journal.interrupted())
}

/// Whether the run goes on from what another has left for `model`.
///
/// # Errors
/// There is something, and nothing says what to do about it.
fn goes_on(job: &Job, model: &Path, journal: &Journal<'_>) -> Result<bool> {
    if job.resume && checkpoint::is_bare(model) {
        return Ok(true);
    }
    let Some(n) = checkpoint::left_over(model)?.filter(|&n| n > 0) else { return Ok(false) };
    if job.resume {
        return Ok(true);
    }
    let folder = checkpoint::folder_of(model);
    if !job.overwrite {
        let fault = InputError::new(folder, format!("{n} buildings of a run that did not end"), "nothing");
        return Err(fault.remedy("Give --resume to go on from there, or --overwrite to start anew").into());
    }
    journal.warn(&format!("{}: {n} buildings of a run that did not end are removed", folder.display()));
    Ok(false)
}

/// The name of a file up to its first dot.
fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.split('.').find(|part| !part.is_empty()).unwrap_or("model").to_owned()
}

/// Brings footprints into the CRS of the tiles and says what is odd about them.
fn bring(
    mut layer: FootprintLayer,
    crs: &Crs,
    journal: &Journal<'_>,
) -> Result<(Vec<Footprint>, Vec<Rejected>, FootprintsReport)> {
    let file = layer.path.display().to_string();
    let own_crs = layer.crs.as_ref().map(tiles::label);
    for warning in &layer.warnings {
        journal.warn(&format!("{file}: {warning}"));
    }
    if layer.footprints.is_empty() && layer.rejected.is_empty() && layer.has_more {
        let fault = InputError::new(&layer.path, "no feature at the tiles", "footprints where the tiles are");
        let remedy = "See whether they are of one place, and whether --crs and --footprint-crs are right";
        return Err(fault.remedy(remedy).into());
    }
    if layer.footprints.is_empty() && layer.rejected.is_empty() {
        let fault = InputError::new(&layer.path, "no feature", "footprints of buildings");
        return Err(fault.remedy("Check --layer and --filter").into());
    }
    if let Some(clashes) = reserved(&layer) {
        journal.warn(&format!("{file}: {clashes}"));
    }
    for warning in layer.reproject(crs)? {
        journal.warn(&warning);
    }
    layer.reject_giants(crs);
    if let Some(first) = layer.rejected.first() {
        let (count, total) = (layer.rejected.len(), layer.rejected.len() + layer.footprints.len());
        journal.warn(&format!(
            "{file}: {count} of {total} features have no usable polygon and are written without geometry, the first of \
             them {}: {}",
            first.id, first.reason
        ));
    }
    let report = FootprintsReport {
        file,
        footprints: layer.footprints.len(),
        rejected: layer.rejected.len(),
        missing: layer.missing,
        is_damaged: layer.is_damaged,
        crs: own_crs,
        id_attribute: layer.id_attribute,
    };
    Ok((layer.footprints, layer.rejected, report))
}

/// Reads the outlines of roofs and gives them to their footprints, of which `known` tells what was read.
fn bring_roofs(
    job: &Job,
    path: &Path,
    tiles: &[Tile],
    footprints: &mut [Footprint],
    known: &FootprintsReport,
    crs: &Crs,
    journal: &Journal<'_>,
) -> Result<FootprintsReport> {
    let source = FootprintSource { path: path.to_path_buf(), options: FootprintOptions::default() };
    let mut layer = read_footprints(job, &source, tiles, journal)?;
    if layer.crs.is_none() {
        layer.crs = job.footprints.as_ref().and_then(|source| source.options.crs.clone());
    }
    let (roofs, _, report) = bring(layer, crs, journal)?;
    for warning in roofprints::attach(footprints, &roofs, known.id_attribute.as_deref()) {
        journal.warn(&format!("{}: {warning}", report.file));
    }
    Ok(report)
}

/// What is to be told of attributes whose names are gable's own, such as those of a model that it made before.
fn reserved(layer: &FootprintLayer) -> Option<String> {
    let footprints = layer.footprints.iter().map(|footprint| &footprint.attributes);
    let all = footprints.chain(layer.rejected.iter().map(|feature| &feature.attributes));
    let names: BTreeSet<&str> = all.flat_map(|attributes| attributes.keys()).map(String::as_str).collect();
    let names: Vec<&str> = names.into_iter().filter(|name| is_reserved(name)).collect();
    let rest = names.len().saturating_sub(SHOWN);
    let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    (!names.is_empty()).then(|| {
        format!(
            "the attributes {}{more} have names that are gable's or those of an Extension: they are written as `source_…`, \
             and the notes of each building say so",
            names.iter().take(SHOWN).map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ")
        )
    })
}

/// Collects the points of each footprint, on the threads of `pool`.
///
/// # Errors
/// What [`segment()`] says.
pub(super) fn collect(plan: &mut Plan, pool: &ThreadPool, journal: &mut Journal<'_>) -> Result<Vec<Task>> {
    let footprints = std::mem::take(&mut plan.footprints);
    let total = plan.tiles.iter().map(|tile| tile.points).sum();
    let Segmentation { sites, notes, counts, problems, warnings } =
        journal.stage(Stage::Segment, total, |journal| {
            let progress = |by| journal.event(Event::Advanced { stage: Stage::Segment, by });
            let names_buildings = plan.tiles.iter().any(|tile| !tile.buildings.is_empty());
            let segment = match (plan.has_stand_ins, names_buildings) {
                (false, _) => segment,
                (true, false) => segment_object,
                (true, true) => segment_named,
            };
            let ground = plan.ground.as_ref();
            pool.install(|| segment(&plan.tiles, footprints, &plan.crs, &plan.segmentation, &progress, ground))
                .map_err(|error| name_the_footprints(error, plan))
        })?;
    for warning in warnings {
        journal.warn(&warning);
    }
    for problem in problems {
        journal.warn(&problem.to_string());
        let tile = problem.tile().display().to_string();
        if let Some(report) = plan.inputs.tiles.iter_mut().find(|report| report.file == tile) {
            report.problems.push(problem.to_string());
            if let TileProblem::MissingPoints { expected, read, .. } = problem {
                report.missing_points += expected.saturating_sub(read);
            }
        }
    }
    if counts.dropped.unknown_building > 0 {
        let dropped = counts.dropped.unknown_building;
        journal.warn(&format!("{dropped} building points name a building that has no footprint; they are left out"));
    }
    plan.inputs.points = counts;
    let incomplete = sites.iter().filter(|site| !plan.has_stand_ins && !site.coverage.is_complete()).count();
    if incomplete > 0 {
        let total = sites.len();
        journal.warn(&format!("{incomplete} of {total} footprints are not wholly covered by the tiles"));
    }
    let mut tasks = boxed(sites, notes, plan.has_stand_ins);
    tasks.extend(std::mem::take(&mut plan.rejected).into_iter().map(|feature| rejected(feature, &plan.crs)));
    Ok(tasks)
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
fn name_the_footprints(error: Error, plan: &Plan) -> Error {
    match (error, &plan.inputs.footprints) {
        (Error::Input(mut fault), Some(report)) if fault.file == Path::new("footprints") => {
            fault.file = PathBuf::from(&report.file);
            fault.place = format!("in {}", report.crs.as_deref().unwrap_or("a CRS that it does not name"));
            fault.into()
        }
        (error, _) => error,
    }
}

/// What is written of a feature without a usable polygon: its attributes and what is wrong with it.
fn rejected(feature: Rejected, crs: &Crs) -> Task {
    let Rejected { id, attributes, reason, .. } = feature;
    Task::Keep(Box::new(Building {
        id,
        frame: Frame { origin: [0.0; 3], metres_per_unit: crs.metres_per_unit },
        attributes,
        model: Model::default(),
        outcome: Outcome::Rejected { reason: Reason::NoPolygon, detail: reason },
        measures: Measures::default(),
        notes: Vec::new(),
    }))
}

/// Says which classes there are when no footprint holds a point of those that were asked for.
pub(super) fn warn_of_emptiness(plan: &Plan, counts: &Counts, journal: &Journal<'_>) {
    if counts.with_points > 0 || counts.written == 0 {
        return;
    }
    let classes = plan.inputs.points.classes.iter();
    let classes: Vec<String> = classes.map(|(&class, n)| format!("{class} ({}): {n}", class_name(class))).collect();
    let dropped = plan.inputs.points.dropped;
    let flagged = match (dropped.synthetic, dropped.withheld) {
        (0, 0) => String::new(),
        (synthetic, withheld) => format!(
            "; {synthetic} points marked as synthetic and {withheld} as withheld are among them, which count only with \
             --use-flagged"
        ),
    };
    journal.warn(&format!(
        "no footprint holds a point of building class {} that counts; points by class: {}{flagged}; other classes are chosen \
         by --building-class",
        plan.segmentation.building_classes,
        if classes.is_empty() { "none".to_owned() } else { classes.join(", ") }
    ));
}
