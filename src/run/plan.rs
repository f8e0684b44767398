//! Reading the inputs: what there is, in which CRS, and where the result goes.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::ThreadPool;

use super::clouds::Cloud;
use super::job::{FootprintSource, Job};
use super::journal::Journal;
use super::limit::Area;
use super::observer::{Event, Observer, Stage};
use super::single::{self, Look, StandIns};
use super::template::{Files, Template};
use super::{checkpoint, classes, clouds, edited, indexed, layer, output, roofprints, terrain, tiles};
use crate::edits::Edits;
use crate::error::{InputError, Result};
use crate::record::PointCloud;
use crate::report::{Counts, CrsReport, Inputs, TileReport};
use crate::segment::{Meaning, PointCounts, SegmentOptions, Swept};
use crate::sink::{Format, refuse_web};
use crate::source::classes::class_name;
use crate::source::crs::Crs;
use crate::source::footprints::{Footprint, Rejected};
use crate::source::points::{Tile, TileProblem};
use crate::source::raster;
use crate::terrain::GroundStore;

/// What there is and where the result goes.
pub(super) struct Plan {
    pub tiles: Vec<Tile>,
    /// The clouds that the tiles are of, in the order in which they are looked at.
    pub clouds: Vec<Cloud>,
    pub crs: Crs,
    pub crs_report: CrsReport,
    /// The model's file, or what the checkpoint of a model in several files is named after; `None` when only a sink of the
    /// caller takes it.
    pub model: Option<PathBuf>,
    /// The files of a model that goes to several.
    pub files: Option<Files>,
    /// The report's file, if it has one.
    pub report: Option<PathBuf>,
    /// What the model is of: the name of the footprint file, or of the only tile.
    pub title: String,
    pub inputs: Inputs,
    pub footprints: Vec<Footprint>,
    /// Which of the footprints are to be reconstructed; the others are beside them.
    pub is_wanted: Vec<bool>,
    /// The features without a usable polygon.
    pub rejected: Vec<Rejected>,
    /// Whether the footprints are those of one job of several, and the tiles that it does not need are
    /// [elsewhere](Tile::elsewhere).
    pub is_share: bool,
    /// Whether this run goes on from one that was killed, and so may replace what that one left.
    pub continues: bool,
    /// Which points belong to a building: what the job says, but for points without classes.
    pub segmentation: SegmentOptions,
    /// Whether the footprints stand in for those that there are not.
    pub has_stand_ins: bool,
    /// Where the ground points wait for the terrain; `None` where there is to be none.
    pub ground: Option<Arc<GroundStore>>,
    /// What a person has decided about buildings.
    pub edits: Edits,
}

impl Plan {
    /// What the footprints are.
    pub(super) fn meaning(&self) -> Meaning {
        let names_buildings = self.tiles.iter().any(|tile| !tile.buildings.is_empty());
        match (self.has_stand_ins, names_buildings) {
            (false, _) if self.is_share => Meaning::OutlinesOfShare,
            (false, _) => Meaning::Outlines,
            (true, false) => Meaning::Places,
            (true, true) => Meaning::PlacesOfNamed,
        }
    }

    /// Notes what was told of the points, and that the tiles do not wholly cover so many of all footprints.
    pub(super) fn note(&mut self, swept: Swept, (incomplete, total): (usize, usize), journal: &Journal<'_>) {
        let Swept { counts, problems, warnings } = swept;
        for warning in warnings {
            journal.warn(&warning);
        }
        for problem in problems {
            journal.warn(&problem.to_string());
            let tile = problem.tile().display().to_string();
            if let Some(report) = self.inputs.tiles.iter_mut().find(|report| report.file == tile) {
                report.problems.push(problem.to_string());
                if let TileProblem::MissingPoints { expected, read, .. } = problem {
                    report.missing_points += expected.saturating_sub(read);
                }
            }
        }
        if counts.dropped.unknown_building > 0 {
            let dropped = counts.dropped.unknown_building;
            journal
                .warn(&format!("{dropped} building points name a building that has no footprint; they are left out"));
        }
        self.inputs.points = counts;
        if incomplete > 0 {
            journal.warn(&format!("{incomplete} of {total} footprints are not wholly covered by the tiles"));
        }
    }

    /// The same with these tiles alone, and without anything to be written.
    pub(super) fn at(&self, tiles: Vec<Tile>) -> Self {
        Self {
            tiles,
            clouds: self.clouds.clone(),
            crs: self.crs.clone(),
            crs_report: self.crs_report.clone(),
            model: None,
            files: None,
            report: None,
            title: self.title.clone(),
            inputs: Inputs::default(),
            footprints: self.footprints.clone(),
            is_wanted: self.is_wanted.clone(),
            rejected: Vec::new(),
            is_share: self.is_share,
            continues: false,
            segmentation: self.segmentation.clone(),
            has_stand_ins: self.has_stand_ins,
            ground: None,
            edits: self.edits.clone(),
        }
    }

    /// The cloud of a tile, where there are several.
    pub(super) fn cloud_of(&self, tile: &Tile) -> Option<&PointCloud> {
        let cloud = self.clouds.iter().find(|cloud| cloud.paths.contains(&tile.path));
        cloud.filter(|_| self.clouds.len() > 1).map(|cloud| &cloud.about)
    }
}

/// Reads headers and footprints and brings them into one CRS.
///
/// # Errors
/// As [`super::run`], as far as it can be told before the points are read.
pub(super) fn plan(job: &Job, pool: &ThreadPool, journal: &Journal<'_>) -> Result<Plan> {
    plan_listed(indexed::listed(job, journal)?.as_ref(), pool, journal)
}

/// The same of a job of which all tiles are named.
fn plan_listed(job: &Job, pool: &ThreadPool, journal: &Journal<'_>) -> Result<Plan> {
    let fed = job.fed.as_ref();
    let clouds = clouds::of_job(job)?;
    let names: Vec<PathBuf> = clouds.iter().flat_map(|cloud| &cloud.paths).cloned().collect();
    let is_file = |path: &&PathBuf| fed.is_none_or(|fed| fed.name() != path.as_path());
    let paths: Vec<PathBuf> = names.iter().filter(is_file).cloned().collect();
    let footprint_path = job.footprints.as_ref().map(|source| source.path.as_path());
    let footprint_name = job.footprints.as_ref().map(FootprintSource::name);
    let has_model = !job.output.as_os_str().is_empty();
    let template = Template::of(&job.output)?.filter(|_| !job.crop_only);
    let model = has_model.then(|| job.base(&names)).transpose()?;
    // A report that stands next to the model belongs to it and is replaced with it.
    let report = job.report.clone().or_else(|| model.as_deref().map(output::report_path));
    let files = names.len() + usize::from(job.footprints.is_some()) + usize::from(job.roofprints.is_some());

    journal.stage(Stage::Read, files as u64, |journal| {
        spare_inputs(job, &paths, (model.as_deref(), report.as_deref()))?;
        let continues = match &model {
            Some(model) => {
                refuse_web(model)?;
                if template.is_none() {
                    Format::of(model)?;
                }
                goes_on(job, model, journal)?
            }
            None => false,
        };
        if let Some(model) = model.as_ref().filter(|_| template.is_none()) {
            output::prepare(model, job.overwrite || continues)?;
        }
        if let Some(report) = &report {
            output::prepare(report, job.overwrite || continues || job.report.is_none())?;
        }
        let tiles::OpenTiles { tiles, mut reports } = tiles::open(&paths, fed, pool, journal)?;
        name_clouds(&clouds, &mut reports);
        let area = match tiles::agree_on_crs(&tiles, job.crs.as_deref(), None) {
            Ok((crs, ..)) if !job.limit.is_none() => Area::open(&job.limit, &crs, journal)?,
            _ => None,
        };
        let outlines = job
            .footprints
            .as_ref()
            .map(|source| layer::read(job, source, &tiles, area.as_ref(), journal))
            .transpose()?;
        let own_crs = outlines.as_ref().and_then(|layer| layer.crs.clone());
        tiles::refuse_emptiness(&tiles)?;
        let mut tiles = tiles.into_iter().map(|tile| tiles::place(tile, job.placement)).collect::<Result<Vec<_>>>()?;
        let (crs, source, warnings) = match &outlines {
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

        let (segmentation, warning) = classes::of_points(&tiles, &job.segmentation, outlines.is_some());
        if let Some(warning) = warning {
            journal.warn(&warning);
        }
        let ground = terrain::store(job, model.as_deref(), &crs)?;
        let edits = edited::read(job, &crs)?;
        let crs_report = CrsReport { name: crs.name.clone(), code: crs.code.clone(), source };
        let name =
            stem(footprint_name.as_deref().or(names.first().map(PathBuf::as_path)).unwrap_or(Path::new("model")));
        let mut inputs = Inputs { tiles: reports, ..Inputs::default() };
        let (footprints, is_wanted, rejected, has_stand_ins) = if let Some(outlines) = outlines {
            let mut outlines = layer::bring(outlines, &crs, area.as_ref(), job, journal)?;
            journal.event(Event::Advanced { stage: Stage::Read, by: 1 });
            if let Some(path) = &job.roofprints {
                let roofs = layer::read(job, &roofprints::source(path), &tiles, area.as_ref(), journal)?;
                inputs.roofprints = Some(roofprints::give(roofs, &mut outlines, &crs, job, journal)?);
                journal.event(Event::Advanced { stage: Stage::Read, by: 1 });
            }
            inputs.footprints = Some(outlines.report);
            (outlines.footprints, outlines.is_wanted, outlines.rejected, false)
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
            let is_wanted = vec![true; footprints.len()];
            (footprints, is_wanted, Vec::new(), true)
        };
        let files = template.map(|template| template.files(&tiles, &footprints, &is_wanted, &rejected));
        if let Some(files) = &files {
            let outputs: Vec<&Path> = files.paths.iter().map(PathBuf::as_path).collect();
            output::spare_inputs(&outputs, paths.iter().map(PathBuf::as_path).chain(footprint_path))?;
            output::prepare_all(&outputs, job.overwrite || continues)?;
        }
        Ok(Plan {
            tiles,
            clouds,
            crs,
            crs_report,
            model,
            files,
            report,
            title: job.title.clone().unwrap_or(name),
            inputs,
            footprints,
            is_wanted,
            rejected,
            is_share: false,
            continues,
            segmentation,
            has_stand_ins,
            ground,
            edits,
        })
    })
}

/// Refuses outputs that stand where inputs do, the tiles at `paths` among them, or where each other does.
///
/// # Errors
/// Which of them.
fn spare_inputs(job: &Job, paths: &[PathBuf], (model, report): (Option<&Path>, Option<&Path>)) -> Result<()> {
    if let Some(report) = report.filter(|_| report == model) {
        let fault = InputError::new(report, "the model and the report in one file", "a file for each");
        return Err(fault.remedy("Give another name with --report").into());
    }
    let outputs: Vec<&Path> = model.into_iter().chain(report).collect();
    let sheets = job.segmentation.dtm.as_deref().map(raster::sheets).transpose()?.unwrap_or_default();
    let files = paths.iter().chain(&sheets).chain(&job.roofprints).chain(&job.edits).map(PathBuf::as_path);
    output::spare_inputs(&outputs, files.chain(job.footprints.as_ref().map(|source| source.path.as_path())))
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

/// Says of each tile of which cloud it is, where there are several.
fn name_clouds(clouds: &[Cloud], reports: &mut [TileReport]) {
    for cloud in clouds.iter().filter(|_| clouds.len() > 1) {
        let own: Vec<String> = cloud.paths.iter().map(|path| path.display().to_string()).collect();
        for report in reports.iter_mut().filter(|report| own.contains(&report.file)) {
            report.cloud = Some(cloud.name().to_owned());
        }
    }
}

/// The name of a file up to its first dot.
fn stem(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.split('.').find(|part| !part.is_empty()).unwrap_or("model").to_owned()
}

/// Says which classes there are when no footprint holds a point of those that were asked for.
pub(super) fn warn_of_emptiness(
    points: &PointCounts,
    segmentation: &SegmentOptions,
    counts: &Counts,
    journal: &Journal<'_>,
) {
    if counts.with_points > 0 || counts.written == 0 {
        return;
    }
    let classes = points.classes.iter();
    let classes: Vec<String> = classes.map(|(&class, n)| format!("{class} ({}): {n}", class_name(class))).collect();
    let dropped = points.dropped;
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
        segmentation.building_classes,
        if classes.is_empty() { "none".to_owned() } else { classes.join(", ") }
    ));
}
