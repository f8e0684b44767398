//! What is done with files of models.

use std::path::{Path, PathBuf};

use gable::cli::options::{self, Heard};
use gable::convert::{Conversion, Converted, Pass};
use gable::error::{Error, Result};
use gable::run::output::{prepare, spare_inputs};
use gable::source::cityjson;
use gable::{audit, serde_json, sink, view};
use pyo3::prelude::*;

use crate::errors::exception;
use crate::supervise::{file_size, supervised, tiles};

/// Checks a file; gives the report as JSON.
#[pyfunction]
pub fn validate(py: Python<'_>, model: PathBuf, options: &str, listener: &Bound<'_, PyAny>) -> PyResult<String> {
    let options = options::validation(options).map_err(|error| exception(py, &error))?;
    let report = supervised(listener, |teller| {
        teller.start("validating", "byte", file_size(&model));
        audit::audit(&model, &options, &mut |_, bytes| {
            teller.heed();
            teller.advance(bytes);
        })
    })?;
    json(py, &report)
}

/// Measures a model; gives the figures as JSON.
#[pyfunction]
pub fn evaluate(
    py: Python<'_>,
    model: PathBuf,
    points: Vec<String>,
    options: &str,
    listener: &Bound<'_, PyAny>,
) -> PyResult<String> {
    let evaluation = supervised(listener, |teller| {
        teller.start("evaluating", "point", 0);
        options::evaluation(&model, &points, options, &mut |heard| {
            teller.heed();
            match heard {
                Heard::Warning(text) => teller.warn(text),
                Heard::Points(count) => teller.advance(count as u64),
                _ => {}
            }
        })
    })?;
    json(py, &evaluation)
}

/// Converts or joins models; gives the output.
#[pyfunction]
pub fn convert(
    inputs: Vec<PathBuf>,
    output: PathBuf,
    overwrite: bool,
    crs: Option<String>,
    lods: Vec<String>,
    listener: &Bound<'_, PyAny>,
) -> PyResult<PathBuf> {
    supervised(listener, |teller| {
        // They are read once for their ids and once to be written.
        teller.start("converting", "byte", inputs.iter().map(|path| file_size(path)).sum::<u64>() * 2);
        let conversion = Conversion { inputs, output, overwrite, crs, lods };
        let Converted { written, warnings, .. } = gable::convert::convert(&conversion, &mut |at| {
            teller.heed();
            if at.pass != Pass::Compare {
                teller.advance(at.bytes);
            }
        })?;
        for warning in &warnings {
            teller.warn(warning);
        }
        Ok(written.path)
    })
}

/// Copies the file of a model.
#[pyfunction]
pub fn copy(from: PathBuf, to: PathBuf, overwrite: bool, listener: &Bound<'_, PyAny>) -> PyResult<PathBuf> {
    supervised(listener, |_| {
        spare_inputs(&[&to], std::iter::once(from.as_path()))?;
        prepare(&to, overwrite)?;
        sink::copy_whole(&from, &to)?;
        Ok(to)
    })
}

/// Writes a page to look at a model in. Gives its path.
#[pyfunction]
#[expect(clippy::too_many_arguments, reason = "they are options of the command line")]
pub fn page(
    model: PathBuf,
    output: PathBuf,
    overwrite: bool,
    points: Vec<String>,
    max_points: Option<usize>,
    trust_tiles: bool,
    report: Option<PathBuf>,
    listener: &Bound<'_, PyAny>,
) -> PyResult<PathBuf> {
    supervised(listener, |teller| {
        prepare(&output, overwrite)?;
        let most_points = max_points.unwrap_or(view::Options::MOST_POINTS);
        let options = view::Options { tiles: tiles(&points)?, most_points, trust_tiles, report };
        teller.start("checking", "byte", file_size(&model));
        let page = view::build(&model, &options, &mut |_, bytes| {
            teller.heed();
            teller.advance(bytes);
        })?;
        for problem in &page.problems {
            teller.warn(&problem.to_string());
        }
        if page.contents.unreadable > 0 {
            let (name, count) = (model.display(), page.contents.unreadable);
            teller.warn(&format!("{name}: {count} features could not be read; the page lists them"));
        }
        sink::write_whole(&output, &page.html)?;
        Ok(output)
    })
}

/// The ids of the buildings of a model, in the order of the file.
#[pyfunction]
pub fn ids(model: PathBuf, listener: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
    supervised(listener, |teller| {
        teller.start("reading", "byte", file_size(&model));
        buildings(&model, &mut || teller.heed())
    })
}

fn buildings(model: &Path, heed: &mut dyn FnMut()) -> Result<Vec<String>> {
    let mut ids = Vec::new();
    for piece in cityjson::features(model)? {
        let piece = piece?;
        heed();
        let tops = piece.groups().into_iter().filter_map(|group| piece.objects.get(*group.first()?));
        ids.extend(tops.filter(|top| top.kind == "Building").map(|top| top.id.clone()));
    }
    Ok(ids)
}

/// A value as JSON.
pub fn json(py: Python<'_>, value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|e| exception(py, &Error::io("the answer", "write", e.into())))
}
