//! The driver: from files to a city model, over many buildings in parallel.
//!
//! [`run`] does a [`Job`] in [stages](Stage): it opens the tiles and reads the footprints, agrees on a CRS, collects
//! the points of each footprint while a front sweeps over the tiles, reconstructs the buildings behind it in parallel, writes them in the order of the
//! footprints, and makes the terrain around them if the job asks for it. It tells an [`Observer`] how far it is, and returns a [`Report`].
//!
//! A run that is killed leaves what it has done in the folder `OUT.partial`; with [`Job::resume`] the next one goes on from
//! there.
//!
//! What is written depends on the inputs and the parameters alone, not on the number of threads. A tile, a feature or a
//! building that cannot be used is told and counted; only what leaves nothing to do is an error.

mod buildings;
mod checkpoint;
mod checks;
mod choice;
mod chosen;
mod classes;
mod clouds;
mod collected;
mod corners;
mod crop;
mod edited;
mod feed;
mod file_names;
mod files;
mod flow;
mod identity;
mod indexed;
mod job;
pub mod jobs;
mod journal;
mod layer;
mod limit;
mod observer;
mod ordered;
mod outbox;
pub mod output;
mod parts;
mod plan;
mod prepare;
mod records;
mod roofprints;
mod roster;
mod single;
mod supply;
mod surveyed;
mod template;
mod terrain;
mod tiles;
mod write;

use crate::building::Building;
use crate::error::{InputError, Result};
use crate::reconstruct::reconstruct;
use crate::report::{self, Counts, Inputs, Quality, Report, Verdict};
use crate::sink::{self, Metadata, Sink};
use crate::site::Site;
use crate::source::footprints;
use std::path::PathBuf;

use journal::Journal;

pub use checks::{MOST_THREADS, memory, recording_date, translation};
pub use chosen::{Chosen, chosen};
pub use clouds::{CloudSource, cloud};
pub use collected::{Collected, collected};
pub use edited::{name as edits_crs, of_file as edits_of_file};
pub use feed::{Fed, Feed};
pub use job::{FootprintSource, Job};
pub use limit::{Limit, bounds};
pub use observer::{Event, Observer, Silent, Stage};
pub(crate) use tiles::{agree_on_crs, place, true_to_length};

/// So many bytes of points that wait for the rest of theirs are held in memory, unless [`Job::memory`] says otherwise.
pub const MEMORY: usize = 2 << 30;

/// Does a job: reads, reconstructs, writes the model and the report.
///
/// # Errors
/// What leaves nothing to do: bad options, no tile that can be read, no CRS or several, footprints that do not overlap
/// the tiles, an output that exists or cannot be written, or an interruption before anything was written.
pub fn run(job: &Job, observer: &dyn Observer) -> Result<Report> {
    let field = job.field.load()?;
    run_with(job, observer, |site| reconstruct(site, &job.parameters, &*field))
}

/// The buildings of a job as they were scanned, in the order of the footprints and before anything is made of them.
///
/// # Errors
/// As [`run`], as far as it concerns tiles and footprints.
pub fn sites(job: &Job, observer: &dyn Observer) -> Result<Vec<Site>> {
    Ok(collected(job, observer)?.buildings.into_iter().map(|(site, _)| site).collect())
}

/// Does a job and hands the buildings to a sink of the caller, which `open` opens once it is known what is to come. Where
/// [`Job::output`] names a file, the model is written there as well.
///
/// The sink is called on the calling thread, in the order of the footprints. With [`Job::resume`] it gets all buildings,
/// those of the earlier run among them.
///
/// # Errors
/// As [`run`], and what the sink says.
pub fn run_into<'a>(job: &Job, observer: &dyn Observer, open: impl FnOnce(&Metadata) -> Opened<'a>) -> Result<Report> {
    let field = job.field.load()?;
    run_both(job, observer, |site| reconstruct(site, &job.parameters, &*field), Some(Box::new(open)))
}

/// A sink of the caller, or why there is none.
pub type Opened<'a> = Result<Box<dyn Sink + 'a>>;

/// Does a job with another method.
///
/// # Errors
/// As [`run`].
pub fn run_with(job: &Job, observer: &dyn Observer, method: impl Fn(&Site) -> Building + Sync) -> Result<Report> {
    if !sink::is_stream(&job.output) {
        return run_both(job, observer, method, None);
    }
    // A stream has no name that could appear late, and nothing beside it.
    if job.resume {
        let fault = InputError::new(&job.output, "a stream that is to be resumed", "a file");
        return Err(fault.remedy("What a stream has carried away cannot be gone on from: write a file").into());
    }
    let streamed = Job { output: PathBuf::new(), ..job.clone() };
    run_both(&streamed, observer, method, Some(Box::new(|head| sink::stream(&job.output, head.clone()))))
}

/// Does a job with another method and, if there is one, into a sink of the caller.
fn run_both(
    job: &Job,
    observer: &dyn Observer,
    method: impl Fn(&Site) -> Building + Sync,
    open: Option<write::Open<'_, '_>>,
) -> Result<Report> {
    if job.output.as_os_str().is_empty() && (open.is_none() || job.resume) {
        let fault = InputError::new("the output", "no name", "the name of a file or folder");
        return Err(fault.remedy("Name it, or run into a sink of your own and without resuming").into());
    }
    if job.crop_only {
        crop::refuse_contradictions(job)?;
    }
    let started = report::now();
    let journal = Journal::new(observer);
    let pool = job.pool()?;
    let mut plan = plan::plan(job, &pool, &journal)?;
    let mut done = if job.crop_only {
        let tasks = prepare::collect(&mut plan, &pool, &journal)?;
        crop::write(job, &plan, tasks, &pool, &journal, open)?
    } else {
        let (prepared, stock) = prepare::prepare(&mut plan, &pool, &journal)?;
        let ground = plan.ground.take();
        let memory = job.memory.unwrap_or(MEMORY);
        let supply = prepared.supply(stock, &plan, ground.as_deref(), memory, &journal)?;
        let work = write::Work { supply, roster: &prepared.roster, ground: ground.clone() };
        write::write(job, &plan, work, &pool, &journal, method, open)?
    };
    if let Some((swept, incomplete)) = done.swept.take() {
        plan.note(swept, (incomplete, done.counts.footprints), &journal);
    }
    plan::warn_of_emptiness(&plan.inputs.points, &plan.segmentation, &done.counts, &journal);

    edited::warn_of_refusals(&done.buildings, &journal);
    let quality = Quality::of(&done.buildings);
    let exit_code = if job.crop_only {
        whole_or_partial(&plan.inputs)
    } else {
        exit_code(&done.counts, &plan.inputs, done.lacks_terrain)
    };
    let outputs = done.outputs.iter().chain(&plan.report).map(|path| path.display().to_string()).collect();
    let (warnings, stages, watch) = journal.close();
    let report = Report {
        gable: env!("CARGO_PKG_VERSION").to_owned(),
        command: job.command.iter().map(|word| footprints::redacted(word)).collect(),
        started,
        interrupted: done.counts.not_reached > 0 || done.lacks_terrain,
        exit_code,
        crs: plan.crs_report,
        inputs: plan.inputs,
        parameters: job.parameters.clone(),
        field: job.field.clone(),
        segmentation: plan.segmentation.clone(),
        counts: done.counts,
        quality,
        terrain: done.terrain,
        stages,
        wall_seconds: watch.wall().as_secs_f64(),
        cpu_seconds: watch.cpu().map(|time| time.as_secs_f64()),
        threads: pool.current_num_threads(),
        peak_memory_bytes: report::peak_memory(),
        jobs: None,
        outputs,
        warnings,
        buildings: done.buildings,
    };
    if let Some(path) = &plan.report {
        report.write(path)?;
    }
    // Only now is there nothing left that a kill could take.
    if let Some(checkpoint) = done.checkpoint {
        checkpoint.remove()?;
    }
    Ok(report)
}

/// What the exit code of a run is of which no model was asked for.
fn whole_or_partial(inputs: &Inputs) -> u8 {
    if inputs.is_whole() { Verdict::Complete } else { Verdict::Partial }.exit_code()
}

/// What the exit code of a run is: a model of tiles that could not all be read is not what was asked for, nor one whose terrain
/// was cut short.
fn exit_code(counts: &Counts, inputs: &Inputs, lacks_terrain: bool) -> u8 {
    match counts.verdict() {
        Verdict::Complete if lacks_terrain || !inputs.is_whole() => Verdict::Partial,
        verdict => verdict,
    }
    .exit_code()
}
