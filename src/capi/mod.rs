//! The C interface: what `include/gable.h` declares.
//!
//! The header is made from this module by cbindgen, documentation included; it is written for those who call from C. Here
//! stands what matters to those who change it:
//!
//! - Nothing that C hands over is trusted: pointers may be null or misaligned, lengths absurd, text no UTF-8, numbers no
//!   numbers. All but a dangling pointer is an error that the job keeps.
//! - No panic crosses the boundary: every entry point runs guarded, and a lock that a panic poisoned is used all the same.
//! - Callbacks come on the thread that called `gable_run`, one at a time; the run itself is on a thread of its own.
//!
//! This and `source::crs::proj_ffi` are the only places with `unsafe` code.
#![expect(unsafe_code, reason = "a C interface takes raw pointers and exports symbols")]
#![expect(clippy::doc_markdown, reason = "the documentation of what is exported is read in C")]

mod chunk;
mod entry;
mod job;
mod messages;
mod text;
#[cfg(feature = "pipelines")]
mod writer;

pub use chunk::GableChunk;
pub use entry::{
    gable_cover, gable_create, gable_error, gable_free, gable_push, gable_report, gable_report_part, gable_run,
    gable_version,
};
pub use job::{GableJob, GableStatus};
pub use messages::{GableLineCallback, GableProgressCallback, GableStage};
#[cfg(feature = "pipelines")]
pub use writer::{GableOption, gable_create_writer, gable_writer_options};
