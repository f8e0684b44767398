//! A run in several jobs: making a plan, doing a job of it, and joining their parts.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use gable::cli::{options, summary};
use gable::error::{Error, InputError};
use gable::run::jobs::{self, JobRun, Merge, Outcome, PlanFolder, Split};
use pyo3::prelude::*;

use crate::errors::exception;
use crate::files::json;
use crate::supervise::supervised;

/// Makes a plan; gives it as JSON.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "they are options of the command line")]
pub fn plan(
    py: Python<'_>,
    options: &str,
    crs: Option<String>,
    output: PathBuf,
    jobs: Option<usize>,
    job_size: Option<usize>,
    overwrite: bool,
    listener: &Bound<'_, PyAny>,
) -> PyResult<String> {
    let raise = |error: Error| exception(py, &error);
    let number = |name: &str, value: Option<usize>| {
        let bad = || InputError::new("options", "0", "a whole number from 1 on").at(name);
        value.map(|value| NonZeroUsize::new(value).ok_or_else(bad)).transpose()
    };
    let split = match (number("jobs", jobs), number("job_size", job_size)) {
        (Err(fault), _) | (_, Err(fault)) => return Err(raise(fault.into())),
        (Ok(Some(jobs)), Ok(None)) => Split::Jobs(jobs),
        (Ok(None), Ok(Some(each))) => Split::Footprints(each),
        (Ok(None), Ok(None)) => Split::DEFAULT,
        (Ok(Some(_)), Ok(Some(_))) => {
            let fault = InputError::new("options", "both `jobs` and `job_size`", "one of them");
            return Err(raise(fault.into()));
        }
    };
    let mut job = options::job(options).map_err(|error| raise(error.into()))?;
    job.crs = crs;
    job.refuse_contradictions().map_err(|error| raise(error.into()))?;
    let folder = PlanFolder::new(output);
    let plan = supervised(listener, |teller| jobs::make(&job, split, &folder, overwrite, teller))?;
    json(py, &plan)
}

/// Reads a plan; gives it as JSON.
#[pyfunction]
pub fn read_plan(py: Python<'_>, plan: PathBuf) -> PyResult<String> {
    json(py, &PlanFolder::new(plan).read().map_err(|error| exception(py, &error))?)
}

/// The numbers of the jobs that have no part yet.
#[pyfunction]
pub fn missing_jobs(py: Python<'_>, plan: PathBuf, parts: Vec<PathBuf>) -> PyResult<Vec<usize>> {
    let folder = PlanFolder::new(plan);
    let missing = folder.read().and_then(|plan| jobs::missing(&plan, &folder, &parts));
    missing.map_err(|error| exception(py, &error))
}

/// Does a job; gives whether it was done before, and else its report as JSON.
#[pyfunction]
pub fn do_job(
    py: Python<'_>,
    plan: PathBuf,
    job: usize,
    parts: Option<PathBuf>,
    threads: Option<usize>,
    overwrite: bool,
    listener: &Bound<'_, PyAny>,
) -> PyResult<Option<String>> {
    let threads = threads.and_then(NonZeroUsize::new);
    let run = JobRun { plan: PlanFolder::new(plan), job, parts, threads, overwrite, command: Vec::new() };
    match supervised(listener, |teller| jobs::do_job(&run, teller))? {
        Outcome::WasDone(_) => Ok(None),
        Outcome::Done(report) => json(py, &report).map(Some),
    }
}

/// Joins the parts; gives the report as JSON, without its buildings, and its summary for a person.
#[pyfunction]
pub fn merge_parts(
    py: Python<'_>,
    plan: PathBuf,
    parts: Vec<PathBuf>,
    output: PathBuf,
    report: Option<PathBuf>,
    overwrite: bool,
    listener: &Bound<'_, PyAny>,
) -> PyResult<(String, String)> {
    let merge = Merge { plan: PlanFolder::new(plan), parts, output, report, overwrite, command: Vec::new() };
    let report = supervised(listener, |teller| jobs::merge(&merge, teller))?;
    Ok((json(py, &report)?, summary::summary(&report)))
}
