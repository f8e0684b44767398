//! A run of `gable reconstruct`.

use std::path::{Path, PathBuf};

use gable::cli::{options, summary};
use gable::error::{Error, InputError, Result};
use gable::report::Report;
use gable::run::{self, Job};
use gable::serde_json;
use gable::sink::{self, Format, Sink};
use pyo3::prelude::*;

use crate::errors::exception;
use crate::points::Feed;
use crate::supervise::{Teller, supervised};

/// Reconstructs. The model stands where the options say, and where that is no CityJSON, several files or nowhere, also in
/// `scratch`.
/// Gives the file that is CityJSON, the report as JSON, and its summary for a person.
#[pyfunction]
pub fn reconstruct(
    py: Python<'_>,
    options: &str,
    crs: Option<String>,
    feed: Option<&Bound<'_, Feed>>,
    scratch: PathBuf,
    listener: &Bound<'_, PyAny>,
) -> PyResult<(PathBuf, String, String)> {
    let raise = |error: Error| exception(py, &error);
    let mut job = options::job(options).map_err(|error| raise(error.into()))?;
    if sink::is_stream(&job.output) {
        let fault = InputError::new(&job.output, "a stream as the output", "a file or a folder");
        return Err(raise(fault.remedy("The lines of a sequence are given by Model.to_cityjsonseq()").into()));
    }
    let feed = feed.and_then(|feed| feed.borrow_mut().take());
    job.fed = feed.map(|feed| feed.finish(crs.as_deref())).transpose().map_err(raise)?;
    job.crs = crs;
    job.refuse_contradictions().map_err(|error| raise(error.into()))?;
    let (model, report) = supervised(listener, |teller| run(&job, &scratch, teller))?;
    let json = serde_json::to_string(&report).map_err(|e| raise(Error::io("the report", "write", e.into())))?;
    Ok((model, json, summary::summary(&report)))
}

fn run(job: &Job, scratch: &Path, teller: &Teller<'_>) -> Result<(PathBuf, Report)> {
    let has_output = !job.output.as_os_str().is_empty();
    // A name without an extension is that of a folder, which gets CityJSON.
    let format = Format::of(&job.output).unwrap_or(Format::CityJson);
    let is_one_file = !job.crop_only && !job.goes_to_many_files()?;
    if has_output && is_one_file && matches!(format, Format::CityJson | Format::CityJsonSeq) {
        let report = run::run(job, teller)?;
        return Ok((report.outputs.first().map(PathBuf::from).unwrap_or_default(), report));
    }
    let mut own = PathBuf::new();
    let report = run::run_into(job, teller, |metadata| -> Result<Box<dyn Sink>> {
        // The page of the model names the file.
        own = scratch.join(format!("{}.city.json", metadata.title.replace(['/', '\\'], "_")));
        sink::create(&own, metadata.clone(), true)
    })?;
    Ok((own, report))
}
