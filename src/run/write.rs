//! Reconstructing and writing: buildings go to the sink as they get done.

use std::path::PathBuf;
use std::sync::Arc;

use rayon::ThreadPool;

use super::buildings::{Told, reconstruct_all};
use super::checkpoint::{self, Checkpoint};
use super::files::ManyFiles;
use super::identity::Identity;
use super::job::Job;
use super::journal::Journal;
use super::observer::{Event, Observer, Stage};
use super::plan::Plan;
use super::records::Records;
use super::roster::Roster;
use super::supply::Supply;
use super::terrain;
use crate::building::Building;
use crate::error::{Error, Result};
use crate::report::{BuildingReport, Counts, TerrainReport};
use crate::segment::Swept;
use crate::sink::{self, Encoder, Feature, Metadata, PREFIX, PREFIX_MEMBER, Sink};
use crate::site::Site;
use crate::source::cityjson::Transform;
use crate::source::crs::Crs;
use crate::terrain::{GroundStore, Outlines};

/// Opens a sink of the caller.
pub(super) type Open<'f, 'a> = Box<dyn FnOnce(&Metadata) -> Result<Box<dyn Sink + 'a>> + 'f>;

/// What came out.
pub(super) struct Done {
    pub(super) counts: Counts,
    pub(super) buildings: Vec<BuildingReport>,
    /// What the terrain came to, if there is one.
    pub(super) terrain: Option<TerrainReport>,
    /// Whether an interruption cost terrain.
    pub(super) lacks_terrain: bool,
    /// The files of the model.
    pub(super) outputs: Vec<PathBuf>,
    /// What was told of the points, and how many footprints the tiles do not wholly cover; `None` where that was told before, or an interruption left tiles unread.
    pub(super) swept: Option<(Swept, usize)>,
    /// To be removed once the report is written; `None` when the run was interrupted, and it stays for the next.
    pub(super) checkpoint: Option<Checkpoint>,
}

/// What is to be written.
pub(super) struct Work<'a> {
    pub(super) supply: Supply<'a>,
    pub(super) roster: &'a Roster,
    /// Where the ground points wait for the terrain; `None` where there is to be none.
    pub(super) ground: Option<Arc<GroundStore>>,
}

/// Reconstructs all tasks with `method` and writes the model to its file, to the sink that `open` opens, or to both.
///
/// Whatever ends the run before its time, the buildings that are done stay in the checkpoint.
///
/// # Errors
/// The model or the checkpoint cannot be written, the checkpoint is that of another run, or the run was interrupted
/// before the first building was done.
pub(super) fn write(
    job: &Job,
    plan: &Plan,
    work: Work<'_>,
    pool: &ThreadPool,
    journal: &Journal<'_>,
    method: impl Fn(&Site) -> Building + Sync,
    open: Option<Open<'_, '_>>,
) -> Result<Done> {
    let head = metadata(job, plan, work.roster.corners.of_all());
    let own = open.map(|open| open(&head)).transpose()?;
    let Some(model) = &plan.model else {
        let mut writer = Writer { job, plan, pool, sinks: own.into_iter().collect() };
        return writer.write(work, journal, method, (&Records::nameless()?, false));
    };
    let mut parameters = serde_json::to_value(&job.parameters).unwrap_or_default();
    parameters["field"] = job.field.identity()?;
    let checkpoint = Checkpoint::open(model, &Identity::new(parameters), job.resume)?;
    if job.resume {
        journal.warn(&match checkpoint.records().len() {
            0 => format!("{}: nothing to resume; this run starts from the beginning", checkpoint.folder().display()),
            n => format!(
                "{}: {n} of {} buildings are taken from there",
                checkpoint.folder().display(),
                work.roster.len()
            ),
        });
    }
    let overwrite = job.overwrite || plan.continues;
    let mut outputs = Vec::new();
    let file: Result<Box<dyn Sink + '_>> = if let Some(files) = &plan.files {
        let heads = work.roster.corners.of_files().map(|corner| metadata(job, plan, corner)).collect();
        Ok(Box::new(ManyFiles::new(files, heads, checkpoint.folder(), overwrite, &mut outputs)))
    } else {
        outputs.push(model.clone());
        sink::create_in(Some(checkpoint.folder()), model, head, overwrite).map(|sink| sink as Box<dyn Sink>)
    };
    let mut outcome = file.and_then(|file| {
        let mut writer = Writer { job, plan, pool, sinks: std::iter::once(file).chain(own).collect() };
        writer.write(work, journal, method, (checkpoint.records(), true))
    });
    if let (Some(files), Ok(done)) = (&plan.files, &mut outcome) {
        for building in &mut done.buildings {
            let file = files.of_building.get(&building.id).and_then(|&file| files.paths.get(file));
            building.file = file.map(|file| file.display().to_string());
        }
    }
    let is_whole = matches!(&outcome, Ok(done) if done.counts.not_reached == 0 && !done.lacks_terrain);
    if is_whole {
        return outcome.map(|done| Done { outputs, checkpoint: Some(checkpoint), ..done });
    }
    let folder = checkpoint.folder().display().to_string();
    drop(checkpoint);
    match checkpoint::left_over(model) {
        Ok(Some(n)) if n > 0 => {
            journal.warn(&format!("{folder}: {n} buildings are kept there; the same command with --resume goes on"));
        }
        // Nothing is lost by its end, and whatever stopped the run is what the user must be told.
        _ => drop(std::fs::remove_dir_all(&folder)),
    }
    outcome.map(|done| Done { outputs, ..done })
}

/// Writes a model to all of its sinks.
struct Writer<'a> {
    job: &'a Job,
    plan: &'a Plan,
    pool: &'a ThreadPool,
    sinks: Vec<Box<dyn Sink + 'a>>,
}

impl Writer<'_> {
    /// Reads what is still to be read, reconstructs, makes the terrain, and writes both.
    fn write(
        &mut self,
        Work { supply, roster, ground }: Work<'_>,
        journal: &Journal<'_>,
        method: impl Fn(&Site) -> Building + Sync,
        records: (&Records, bool),
    ) -> Result<Done> {
        let Self { job, plan, pool, sinks } = self;
        let encoder = Encoder::new(roster.ids.clone(), job.point_cloud.clone());
        let mut encoder = encoder.with_attributes(job.attributes.clone());
        let mut outlines = ground.is_some().then(Outlines::default);
        let Told { counts, buildings, outdated } =
            journal.stage(Stage::Reconstruct, roster.len() as u64, |journal| {
                let grid_steps = job.parameters.grid_steps().unwrap_or(1);
                reconstruct_all(&supply, roster.len(), pool, journal, records, (grid_steps, method), |record| {
                    let building = record.building;
                    if let Some(outlines) = &mut outlines {
                        outlines.add(building);
                    }
                    let feature = encoder.feature(building);
                    sinks.iter_mut().try_for_each(|sink| sink.write(&feature))
                })
            })?;
        if outdated > 0 {
            journal.warn(&format!(
                "{outdated} of the buildings of the earlier run were made from other points, footprints or classes: they are \
                 made anew"
            ));
        }
        if counts.not_reached > 0 && counts.written == 0 {
            return Err(Error::Interrupted);
        }
        // Of tiles that were not all read nothing can be told.
        let swept = if counts.not_reached == 0 { supply.finish()? } else { None };
        let terrain = match (ground, outlines) {
            (Some(store), Some(outlines)) if !journal.interrupted() => {
                let terrain = terrain::lay(job, plan, (store, outlines), journal)?;
                let mut write = |feature: &mut Feature| {
                    encoder.rename(feature);
                    sinks.iter_mut().try_for_each(|sink| sink.write(feature))
                };
                Some(terrain::write(&terrain, pool, journal, &mut write)?)
            }
            (Some(_), _) => {
                journal.warn("the run was interrupted before the terrain was made: the model has none");
                None
            }
            _ => None,
        };
        journal.stage(Stage::Finish, 1, |journal| {
            for sink in std::mem::take(sinks) {
                let written = sink.finish()?;
                for note in &written.notes {
                    journal.warn(&format!("{}: {note}", written.path.display()));
                }
            }
            journal.event(Event::Advanced { stage: Stage::Finish, by: 1 });
            Ok(())
        })?;
        let lacks_terrain = job.terrain.is_some() && terrain.as_ref().is_none_or(|terrain| terrain.not_reached > 0);
        Ok(Done { counts, buildings, terrain, lacks_terrain, outputs: Vec::new(), checkpoint: None, swept })
    }
}

/// What the head of the model says: nothing that differs from run to run or with the order of the tiles.
/// `corner` is that of the frames of its buildings.
pub(super) fn metadata(job: &Job, plan: &Plan, corner: [f64; 3]) -> Metadata {
    head(job, &plan.crs, &plan.title, corner)
}

/// The head of a model in `crs` with this title; `translate` where the job says nothing of it.
pub(super) fn head(job: &Job, crs: &Crs, title: &str, translate: [f64; 3]) -> Metadata {
    let is_local = crs.is_local();
    let mut others = Metadata::making(parameters(job));
    if is_local {
        others.insert("gable_coordinates".to_owned(), crs.name.clone().into());
    }
    // Whoever reads the model finds gable's attributes by it.
    if job.attributes.prefix != PREFIX {
        others.insert(PREFIX_MEMBER.to_owned(), job.attributes.prefix.clone().into());
    }
    Metadata {
        title: title.to_owned(),
        reference_system: crs.reference_system(),
        crs: (!is_local).then(|| crs.clone()),
        transform: Transform { scale: [job.parameters.grid_scale; 3], translate: job.translation.unwrap_or(translate) },
        others,
        extensions: None,
    }
}

/// The parameters that the model tells, its field among them.
fn parameters(job: &Job) -> serde_json::Value {
    let mut parameters = serde_json::to_value(&job.parameters).unwrap_or_default();
    parameters["field"] = job.field.field.name().into();
    parameters
}
