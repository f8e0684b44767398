//! Errors of the library as exceptions of `gable.errors`, with the same text.

use gable::error::{Error, InputError};
use pyo3::prelude::*;

/// Where the exceptions are.
const MODULE: &str = "gable.errors";

/// The exception for an error.
pub fn exception(py: Python<'_>, error: &Error) -> PyErr {
    let text = error.to_string();
    let made = match error {
        Error::Input(InputError { file, place, found, expected, remedy }) => {
            make(py, "InputError", (text, file.display().to_string(), place, found, expected, remedy))
        }
        Error::Io { path, source, .. } => {
            make(py, "FileError", (text, source.raw_os_error(), path.display().to_string()))
        }
        _ => make(py, "GableError", (text,)),
    };
    made.unwrap_or_else(|fault| fault)
}

/// The exception for a fault of gable itself.
pub fn internal(py: Python<'_>, detail: &str) -> PyErr {
    make(py, "GableError", (format!("a fault of gable itself: {detail}"),)).unwrap_or_else(|fault| fault)
}

fn make<'py>(py: Python<'py>, class: &str, arguments: impl pyo3::call::PyCallArgs<'py>) -> PyResult<PyErr> {
    Ok(PyErr::from_value(py.import(MODULE)?.getattr(class)?.call1(arguments)?))
}
