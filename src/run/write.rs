//! Reconstructing and writing: buildings go to the sink as they get done.

use rayon::ThreadPool;

use super::buildings::{Task, reconstruct_all};
use super::checkpoint::{self, Checkpoint};
use super::identity::{Identity, hash_of};
use super::job::Job;
use super::journal::Journal;
use super::observer::{Event, Observer, Stage};
use super::plan::Plan;
use super::terrain;
use crate::building::Building;
use crate::error::{Error, Result};
use crate::report::{BuildingReport, Counts, TerrainReport};
use crate::sink::{self, Encoder, Feature, Metadata, Sink};
use crate::site::{QUANTUM, Site};
use crate::source::cityjson::Transform;
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
    /// To be removed once the report is written; `None` when the run was interrupted, and it stays for the next.
    pub(super) checkpoint: Option<Checkpoint>,
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
    (tasks, ground): (Vec<Task>, Option<GroundStore>),
    pool: &ThreadPool,
    journal: &mut Journal<'_>,
    method: impl Fn(&Site) -> Building + Sync,
    open: Option<Open<'_, '_>>,
) -> Result<Done> {
    let head = metadata(job, plan, &tasks);
    let own = open.map(|open| open(&head)).transpose()?;
    let Some(model) = &plan.model else {
        let mut writer = Writer { job, plan, pool, sinks: own.into_iter().collect() };
        return writer.write((tasks, ground), journal, method, None);
    };
    let mut parameters = serde_json::to_value(&job.parameters).unwrap_or_default();
    parameters["field"] = job.field.identity()?;
    let identity = Identity::new(parameters, hash_of(&tasks, pool));
    let checkpoint = Checkpoint::open(model, &identity, job.resume)?;
    if job.resume {
        journal.warn(&match checkpoint.len() {
            0 => format!("{}: nothing to resume; this run starts from the beginning", checkpoint.folder().display()),
            n => format!("{}: {n} of {} buildings are taken from there", checkpoint.folder().display(), tasks.len()),
        });
    }
    let overwrite = job.overwrite || plan.continues;
    let outcome = sink::create_in(Some(checkpoint.folder()), model, head, overwrite).and_then(|file| {
        let mut writer = Writer { job, plan, pool, sinks: std::iter::once(file).chain(own).collect() };
        writer.write((tasks, ground), journal, method, Some(&checkpoint))
    });
    let is_whole = matches!(&outcome, Ok(done) if done.counts.not_reached == 0 && !done.lacks_terrain);
    if is_whole {
        return outcome.map(|done| Done { checkpoint: Some(checkpoint), ..done });
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
    outcome
}

/// Writes a model to all of its sinks.
struct Writer<'a> {
    job: &'a Job,
    plan: &'a Plan,
    pool: &'a ThreadPool,
    sinks: Vec<Box<dyn Sink + 'a>>,
}

impl Writer<'_> {
    /// Reconstructs, makes the terrain, and writes both.
    fn write(
        &mut self,
        (tasks, ground): (Vec<Task>, Option<GroundStore>),
        journal: &mut Journal<'_>,
        method: impl Fn(&Site) -> Building + Sync,
        checkpoint: Option<&Checkpoint>,
    ) -> Result<Done> {
        let Self { job, plan, pool, sinks } = self;
        let mut encoder = Encoder::new(tasks.iter().map(Task::id).collect(), job.point_cloud.clone());
        let mut outlines = ground.is_some().then(Outlines::default);
        let (counts, buildings) = journal.stage(Stage::Reconstruct, tasks.len() as u64, |journal| {
            reconstruct_all(tasks, pool, journal, checkpoint, method, |building| {
                if let Some(outlines) = &mut outlines {
                    outlines.add(building);
                }
                let feature = encoder.feature(building);
                sinks.iter_mut().try_for_each(|sink| sink.write(&feature))
            })
        })?;
        if counts.not_reached > 0 && counts.written == 0 {
            return Err(Error::Interrupted);
        }
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
        Ok(Done { counts, buildings, terrain, lacks_terrain, checkpoint: None })
    }
}

/// What the head of the model says: nothing that differs from run to run or with the order of the tiles.
fn metadata(job: &Job, plan: &Plan, tasks: &[Task]) -> Metadata {
    // The corner of all frames depends on the footprints alone, as each frame does.
    let origins = || tasks.iter().filter_map(Task::site).map(|site| site.frame.origin);
    let corner = |axis: usize| origins().map(|o| o[axis]).fold(f64::INFINITY, f64::min);
    let translate = std::array::from_fn(|axis| Some(corner(axis)).filter(|c| c.is_finite()).unwrap_or(0.0).round());
    let is_local = plan.crs.is_local();
    let mut others = Metadata::making(parameters(job));
    if is_local {
        others.insert("gable_coordinates".to_owned(), plan.crs.name.clone().into());
    }
    Metadata {
        title: plan.title.clone(),
        reference_system: plan.crs.reference_system(),
        crs: (!is_local).then(|| plan.crs.clone()),
        transform: Transform { scale: [QUANTUM; 3], translate },
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
