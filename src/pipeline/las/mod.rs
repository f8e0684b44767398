//! Point records of LAS and the dimensions that they hold, both ways; and COPC files of them.

pub(super) mod copc;
mod extra;
pub(super) mod octree;
mod record;

pub use extra::ExtraDimension;
pub use record::{Record, Unfit};
