//! Pipelines: PDAL's grammar, with the stages that a city model needs and one that makes it.
//!
//! A pipeline is an array of stages in JSON: readers give points, filters change them, writers write them and pass them
//! on. [`Plan::read`] joins the stages of a file, [`Prepared::new`] opens what they read and holds their options against
//! it, [`Prepared::run`] lets the points flow, chunk by chunk where all stages can do with chunks.
//!
//! ```
//! use std::path::Path;
//!
//! use gable::pipeline::{Context, Plan, Prepared, Silent};
//!
//! let text = r#"[
//!     "examples/data/delft_ahn3.laz", // a comment
//!     {"type": "filters.expression", "expression": "Classification == 6"},
//!     {"type": "filters.stats", "dimensions": "Z"}
//! ]"#;
//! let plan = Plan::read(text, Path::new("roofs.json"), &[])?;
//! let context = Context { observer: &Silent, command: &[] };
//! let outcome = Prepared::new(&plan, &context)?.run(&context)?;
//! assert!(outcome.metadata["stages"]["filters.stats"]["statistic"][0]["count"].as_u64() > Some(1000));
//! # Ok::<(), gable::error::Error>(())
//! ```
//!
//! | module | holds |
//! |---|---|
//! | [`spec`] | what a file says |
//! | [`plan`] | stages that are joined: inputs, tags, patterns, types by extension |
//! | [`options`] | the table of options of a stage, from which parsing, help and schema follow |
//! | [`catalogue`] | the types of stages |
//! | [`stages`] | the stages, one file each |
//! | [`points`] | points in columns |
//! | [`las`] | point records of LAS, and COPC files of them |
//! | `ept` | Entwine Point Tiles |
//! | [`expression`], [`range`], [`area`] | what `where`, `limits`, `bounds` and the like say |
//! | [`run`] | running |
//! | [`describe`] | stages in words and as JSON Schema |

#[cfg(feature = "pipelines")]
pub mod area;
#[cfg(feature = "pipelines")]
pub mod catalogue;
#[cfg(feature = "pipelines")]
pub mod describe;
#[cfg(feature = "pipelines")]
mod ept;
pub mod expression;
#[cfg(feature = "pipelines")]
mod files;
#[cfg(feature = "pipelines")]
mod ground;
#[cfg(feature = "pipelines")]
mod heights;
#[cfg(feature = "pipelines")]
mod json;
#[cfg(feature = "pipelines")]
pub mod las;
mod nearest;
pub mod options;
#[cfg(feature = "pipelines")]
mod output;
#[cfg(feature = "pipelines")]
pub mod plan;
pub mod points;
#[cfg(feature = "pipelines")]
pub mod range;
#[cfg(feature = "pipelines")]
mod returns;
#[cfg(feature = "pipelines")]
mod rows;
#[cfg(feature = "pipelines")]
pub mod run;
#[cfg(feature = "pipelines")]
mod source;
#[cfg(feature = "pipelines")]
pub mod spec;
#[cfg(feature = "pipelines")]
pub mod stage;
#[cfg(feature = "pipelines")]
pub mod stages;
#[cfg(test)]
mod tests;

#[cfg(feature = "pipelines")]
pub use plan::{Override, Plan};
#[cfg(feature = "pipelines")]
pub use run::{Outcome, Prepared, validate};
#[cfg(feature = "pipelines")]
pub use stage::{Context, Observer, Silent};
