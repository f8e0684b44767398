//! The driver: from files to a city model, over many buildings in parallel.

pub mod buildings;
mod guard;
mod observer;
mod ordered;
pub mod output;

pub use observer::{Event, Observer, Silent, Stage};
