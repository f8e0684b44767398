//! Reconstructing and writing: buildings go to the sink as they get done.

use rayon::ThreadPool;

use super::buildings::{Task, reconstruct_all};
use super::job::Job;
use super::journal::Journal;
use super::observer::{Event, Observer, Stage};
use super::plan::Plan;
use crate::building::Building;
use crate::error::{Error, Result};
use crate::report::{BuildingReport, Counts};
use crate::sink::{self, Metadata};
use crate::site::Site;

/// What came out.
pub(super) struct Done {
    pub(super) counts: Counts,
    pub(super) buildings: Vec<BuildingReport>,
}

/// Reconstructs all tasks with `method` and writes the model.
///
/// # Errors
/// The model cannot be written, or the run was interrupted before the first building was done.
pub(super) fn write(
    job: &Job,
    plan: &Plan,
    tasks: Vec<Task>,
    pool: &ThreadPool,
    journal: &mut Journal<'_>,
    method: impl Fn(&Site) -> Building + Sync,
) -> Result<Done> {
    let mut sink = sink::create(&plan.model, metadata(job, plan, &tasks), job.overwrite)?;
    let (counts, buildings) = journal.stage(Stage::Reconstruct, tasks.len() as u64, |journal| {
        reconstruct_all(tasks, pool, journal, method, |building| sink.write(building))
    })?;
    if counts.not_reached > 0 && counts.written == 0 {
        return Err(Error::Interrupted);
    }
    journal.stage(Stage::Finish, 1, |journal| {
        let written = sink.finish()?;
        journal.event(Event::Advanced { stage: Stage::Finish, by: 1 });
        Ok(written)
    })?;
    Ok(Done { counts, buildings })
}

/// What the head of the model says: nothing that differs from run to run or with the order of the tiles.
fn metadata(job: &Job, plan: &Plan, tasks: &[Task]) -> Metadata {
    // The corner of all frames depends on the footprints alone, as each frame does.
    let origins = || tasks.iter().filter_map(Task::site).map(|site| site.frame.origin);
    let corner = |axis: usize| origins().map(|o| o[axis]).fold(f64::INFINITY, f64::min);
    let translate =
        std::array::from_fn(|axis| Some(corner(axis)).filter(|c| c.is_finite()).unwrap_or(0.0).round() as i64);
    Metadata {
        title: plan.title.clone(),
        reference_system: plan.crs.reference_system(),
        translate,
        point_cloud: job.point_cloud.clone(),
        parameters: serde_json::to_value(&job.parameters).unwrap_or_default(),
        ids: tasks.iter().map(Task::id).collect(),
    }
}
