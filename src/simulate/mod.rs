//! From models to scans: training and test data whose truth is known.
//!
//! ```text
//! CityJSON, generator ─► Model ─► Placed ─► scan ─► Scan ─► shards for training
//!                                  (augmented)            └► LAZ + footprints + reference model
//! ```
//!
//! Everything follows from one seed, whatever the number of threads.

pub mod generator;
mod mesh;
mod model;
mod options;
mod random;
mod scan;
pub mod shards;
mod source;
mod span;
mod split;
mod truth;

pub use mesh::Mesh;
pub use model::{Model, Placed};
pub use options::{ScanOptions, Setup, SetupChoice};
pub use scan::{Scan, scan};
pub use source::{GENERATED_PER_TILE, Source, generate, read};
pub use span::Span;
pub use split::Split;
pub use truth::Truth;
