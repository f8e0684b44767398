//! From models to scans: training and test data whose truth is known; and from real scans to training data whose truth is
//! known in parts.
//!
//! ```text
//! CityJSON, generator ─► Model ─► Placed ─► scan ─► Scan ─┬► shards for training
//!                                  (augmented)            └► LAZ + footprints + reference model
//! tiles, footprints ─► RealSite ─► thinned copy ───────────► shards for training
//! ```
//!
//! Everything follows from one seed, whatever the number of threads.

pub mod generator;
mod mesh;
mod model;
mod options;
mod plan;
mod random;
mod real;
mod scan;
pub mod scans;
pub mod shards;
mod source;
mod span;
mod split;
mod statistics;
mod truth;

pub use mesh::Mesh;
pub use model::{Model, Placed};
pub use options::{ScanOptions, Setup, SetupChoice};
pub use real::{RealOptions, RealSite, RealSource, read_tile};
pub use scan::{Scan, scan};
pub use source::{GENERATED_PER_TILE, Source, generate, read};
pub use span::Span;
pub use split::Split;
pub use statistics::{Statistics, table};
pub use truth::Truth;
