//! What the Python package `gable` is made of: the calls into the library, for the Python beside it (`../gable`), which
//! has the documentation.
//!
//! - Options come as JSON under the names of the command line, as from C ([`gable::cli::options`]).
//! - What takes long runs on a thread of its own, without the interpreter's lock; see [`supervise`].
//! - An error keeps its text and becomes one of the exceptions of `gable.errors`; no panic gets out.

mod errors;
mod files;
mod jobs;
mod meshes;
mod pipeline;
mod points;
mod reconstruct;
mod supervise;

use pyo3::prelude::*;

/// The module `gable._gable`.
#[pymodule]
mod _gable {
    #[pymodule_export]
    use super::files::{convert, copy, evaluate, ids, page, validate};
    #[pymodule_export]
    use super::jobs::{do_job, merge_parts, missing_jobs, plan, read_plan};
    #[pymodule_export]
    use super::meshes::meshes;
    #[pymodule_export]
    use super::pipeline::pipeline;
    #[pymodule_export]
    use super::points::Feed;
    #[pymodule_export]
    use super::reconstruct::reconstruct;

    /// The version of gable.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
