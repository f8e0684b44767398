//! What a data set is made of.

use std::collections::BTreeMap;

use serde::Serialize;

use super::super::options::ScanOptions;
use super::super::real::RealSource;
use super::super::source::Source;
use super::super::split::Split;
use super::{Interface, Sizes};

/// What a data set is made of: `manifest.json`.
#[derive(Debug, Clone, Serialize)]
pub struct Manifest {
    /// The program and the format.
    pub gable_version: &'static str,
    /// Version of the format of the shards.
    pub format_version: &'static str,
    /// For which network.
    pub interface: Interface,
    /// Sizes of what is asked about one scan.
    pub sizes: Sizes,
    /// What everything random follows from.
    pub seed: u64,
    /// Scans of each model.
    pub variants: usize,
    /// Whether models were mirrored, turned and scaled.
    pub augmented: bool,
    /// How scans were made.
    pub options: ScanOptions,
    /// Where the models come from.
    pub sources: Vec<SourceRecord>,
    /// Which tile is of which split.
    pub tiles: BTreeMap<String, Split>,
    /// Number of scans of each split.
    pub scans: BTreeMap<Split, usize>,
    /// Number of scans that gave nothing, for each reason.
    pub failed: BTreeMap<String, usize>,
    /// The shards, in order.
    pub shards: Vec<String>,
    /// Whether it was interrupted: what is there is whole, but not all that was asked for.
    pub interrupted: bool,
}

/// What became of a source.
#[derive(Debug, Clone, Serialize)]
pub struct SourceRecord {
    /// The file, or what has made the models.
    pub name: String,
    /// Solids at the level of detail, or buildings with points.
    pub found: usize,
    /// Models that were scanned, or buildings whose scans were taken.
    pub models: usize,
    /// How many were left out, for each reason.
    pub left_out: BTreeMap<String, usize>,
    /// How it is divided into tiles.
    pub tiling: String,
}

impl SourceRecord {
    /// The record of a source of which the first `models` are scanned.
    pub fn of(source: &Source, models: usize) -> Self {
        Self {
            name: source.name.clone(),
            found: source.found(),
            models,
            left_out: source.left_out.clone(),
            tiling: source.tiling.clone(),
        }
    }

    /// The record of a tile with real scans.
    pub(super) fn of_real(source: &RealSource) -> Self {
        Self {
            name: source.name.clone(),
            found: source.sites.len() + source.left_out.values().sum::<usize>(),
            models: source.sites.len(),
            left_out: source.left_out.clone(),
            tiling: if source.held_back { "one tile, held back" } else { "one tile" }.to_owned(),
        }
    }
}
