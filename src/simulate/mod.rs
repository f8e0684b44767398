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
mod span;
mod truth;

pub use mesh::Mesh;
pub use model::{Model, Placed};
pub use options::{ScanOptions, Setup, SetupChoice};
pub use scan::{Scan, scan};
pub use span::Span;
pub use truth::Truth;
