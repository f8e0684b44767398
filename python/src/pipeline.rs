//! A run of `gable pipeline`.

use std::path::Path;

use gable::cli::summary::summary;
use gable::error::Error;
use gable::pipeline::{Context, Override, Plan, Prepared};
use gable::serde_json;
use pyo3::prelude::*;

use crate::errors::exception;
use crate::supervise::supervised;

/// The reports of the reconstructions of a pipeline: JSON, and a summary for a person.
type Reports = Vec<(String, String)>;

/// Runs a pipeline. Gives its metadata as JSON, the reports of its reconstructions, and the exit code of the command line.
#[pyfunction]
pub fn pipeline(
    py: Python<'_>,
    text: &str,
    name: &str,
    overrides: Vec<String>,
    listener: &Bound<'_, PyAny>,
) -> PyResult<(String, Reports, u8)> {
    let raise = |error: Error| exception(py, &error);
    let outcome = supervised(listener, |teller| {
        let overrides = overrides.iter().map(|text| Override::parse(text)).collect::<Result<Vec<_>, _>>()?;
        let plan = Plan::read(text, Path::new(name), &overrides)?;
        let context = Context { observer: teller, command: &[] };
        Prepared::new(&plan, &context)?.run(&context)
    })?;
    let json = |report| serde_json::to_string(report).map_err(|e| raise(Error::io("the report", "write", e.into())));
    let reports = outcome.reports.iter().map(|report| Ok((json(report)?, summary(report))));
    Ok((outcome.metadata.to_string(), reports.collect::<PyResult<_>>()?, outcome.exit_code))
}
