//! Reconstructing and writing: buildings go to the sink as they get done.

use std::path::PathBuf;

use rayon::ThreadPool;

use super::buildings::{Task, reconstruct_all};
use super::checkpoint::{self, Checkpoint};
use super::files::ManyFiles;
use super::identity::{Identity, hash_of};
use super::job::Job;
use super::journal::Journal;
use super::observer::{Event, Observer, Stage};
use super::plan::Plan;
use super::template::Files;
use super::terrain;
use crate::building::Building;
use crate::error::{Error, Result};
use crate::report::{BuildingReport, Counts, TerrainReport};
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
    let mut outputs = Vec::new();
    let file: Result<Box<dyn Sink + '_>> = if let Some(files) = &plan.files {
        let heads = heads_of_files(job, plan, &tasks, files);
        Ok(Box::new(ManyFiles::new(files, heads, checkpoint.folder(), overwrite, &mut outputs)))
    } else {
        outputs.push(model.clone());
        sink::create_in(Some(checkpoint.folder()), model, head, overwrite).map(|sink| sink as Box<dyn Sink>)
    };
    let mut outcome = file.and_then(|file| {
        let mut writer = Writer { job, plan, pool, sinks: std::iter::once(file).chain(own).collect() };
        writer.write((tasks, ground), journal, method, Some(&checkpoint))
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
    /// Reconstructs, makes the terrain, and writes both.
    fn write(
        &mut self,
        (tasks, ground): (Vec<Task>, Option<GroundStore>),
        journal: &mut Journal<'_>,
        method: impl Fn(&Site) -> Building + Sync,
        checkpoint: Option<&Checkpoint>,
    ) -> Result<Done> {
        let Self { job, plan, pool, sinks } = self;
        let encoder = Encoder::new(tasks.iter().map(Task::id).collect(), job.point_cloud.clone());
        let mut encoder = encoder.with_attributes(job.attributes.clone());
        let mut outlines = ground.is_some().then(Outlines::default);
        let (counts, buildings) = journal.stage(Stage::Reconstruct, tasks.len() as u64, |journal| {
            let grid_steps = job.parameters.grid_steps().unwrap_or(1);
            reconstruct_all(tasks, pool, journal, checkpoint, grid_steps, method, |record| {
                let building = record.building;
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
        Ok(Done { counts, buildings, terrain, lacks_terrain, outputs: Vec::new(), checkpoint: None })
    }
}

/// What the head of the model says: nothing that differs from run to run or with the order of the tiles.
pub(super) fn metadata(job: &Job, plan: &Plan, tasks: &[Task]) -> Metadata {
    head(job, &plan.crs, &plan.title, corner(tasks.iter().filter_map(Task::site).map(|site| site.frame.origin)))
}

/// The heads of the files of a model: each as if its buildings were all.
fn heads_of_files(job: &Job, plan: &Plan, tasks: &[Task], files: &Files) -> Vec<Metadata> {
    let mut of_file: Vec<Vec<&Task>> = vec![Vec::new(); files.paths.len()];
    for task in tasks {
        if let Some(tasks) = files.of_building.get(task.id()).and_then(|&file| of_file.get_mut(file)) {
            tasks.push(task);
        }
    }
    let origins = |tasks: Vec<&Task>| corner(tasks.into_iter().filter_map(Task::site).map(|site| site.frame.origin));
    of_file.into_iter().map(|tasks| head(job, &plan.crs, &plan.title, origins(tasks))).collect()
}

/// The corner of all frames. It depends on the footprints alone, as each frame does.
pub(super) fn corner(origins: impl Iterator<Item = [f64; 3]>) -> [f64; 3] {
    let corner = origins.fold([f64::INFINITY; 3], |a, b| std::array::from_fn(|axis| a[axis].min(b[axis])));
    corner.map(|c| if c.is_finite() { c.round() } else { 0.0 })
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
