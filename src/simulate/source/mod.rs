//! Where models come from.

mod cityjson;
mod generated;
mod near;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use super::model::Model;
use crate::source::crs::Crs;

pub use cityjson::read;
pub use generated::{TILE as GENERATED_PER_TILE, generate};

/// The models of one source, and what is not among them.
#[derive(Debug, Clone)]
pub struct Source {
    /// The file, or what has made the models.
    pub name: String,
    /// Its closed and valid models.
    pub models: Vec<Model>,
    /// How many solids were left out, for each reason.
    pub left_out: BTreeMap<String, usize>,
    /// The CRS, when the source names one that can be understood.
    pub crs: Option<Crs>,
    /// How the source is divided into tiles, in a sentence.
    pub tiling: String,
}

impl Source {
    /// How many solids it has, with those that were left out.
    pub fn found(&self) -> usize {
        self.models.len() + self.left_out.values().sum::<usize>()
    }
}
