//! **gable** turns airborne laser tiles and building footprints into LoD 2 city models.
//!
//! The road runs one way: a tile goes in at one end, a city model comes out at the other.
//!
//! ```text
//! LAS/LAZ/COPC tiles ─┐
//!                     ├─► segment ─► Site ─► reconstruct ─► Solid ─► validate ─► sink
//! footprints ─────────┘   (join)   (1 bldg)  (the method)  (labelled)            (CityJSON, …)
//! ```
//!
//! - [`source`] reads points, footprints and coordinate reference systems.
//! - [`segment`] joins them into one [`site::Site`] per footprint.
//! - [`reconstruct`] is the method of *Reconstructing Compact Building Models from Point Clouds Using Deep
//!   Implicit Fields* (Chen, Ledoux, Khademi, Nan, 2022): pure, deterministic, one building at a time.
//! - [`network`] runs the networks whose implicit field the method asks.
//! - [`edits`] are what a person decides about a building, as data that it follows.
//! - [`solid`] is what it returns, on the integer grid of the output.
//! - [`validate`] decides whether a solid may be written.
//! - [`terrain`] makes the ground between the buildings.
//! - [`sink`] writes models, one file per format.
//! - [`convert`] takes city models from format to format and joins them.
//! - [`run`] drives the road over many buildings in parallel and keeps the [`report`].
//! - [`pipeline`] runs PDAL's pipelines, with a stage that does all this.
//! - [`completeness`] finds what was scanned and not modelled, and what was modelled and not scanned.
//! - [`evaluate`] measures how good a model is.
//! - [`simulate`] makes buildings and scans of them to train and measure with.
//! - [`trial`] tries fields on such scans.
//! - [`audit`] validates city model files, from anyone.
//! - [`view`] makes a page to look at a city model in, [`explain`] one of how a building was made.
//! - [`edit`] is what a person mends single buildings with.
//! - [`capi`] is the C interface.
//!
//! A lower floor never imports a higher one: `{cli, capi} → {pipeline, trial, view, explain, edit} → {convert, run, simulate} → {source,
//! segment, terrain, sink, network} → reconstruct →
//! completeness → {solid, site} → geometry`.

// What pipelines alone use.
#![cfg_attr(not(feature = "pipelines"), allow(dead_code, unused_imports))]

pub mod audit;
pub mod building;
pub mod capi;
pub mod cli;
pub mod completeness;
pub mod convert;
pub mod edit;
pub mod edits;
pub mod error;
pub mod evaluate;
pub mod explain;
pub mod geometry;
mod guard;
pub mod network;
pub mod pipeline;
pub mod reconstruct;
pub mod record;
pub mod report;
pub mod run;
pub mod segment;
pub mod simulate;
pub mod sink;
pub mod site;
pub mod solid;
pub mod source;
pub mod terrain;
pub mod trial;
pub mod validate;
pub mod view;

// Their types stand in the interface.
pub use {geo, nalgebra, serde_json};

/// Its example is compiled by the documentation tests.
#[cfg(doctest)]
#[doc = include_str!("../docs/howto/rust.md")]
struct HowToCallItFromRust;
