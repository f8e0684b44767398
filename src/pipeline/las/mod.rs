//! Point records of LAS and the dimensions that they hold, both ways.

mod extra;
mod record;

pub use extra::ExtraDimension;
pub use record::{Record, Unfit};
