//! Shards: safetensors files with the samples of many scans.
//!
//! They are written here and not by the crate `safetensors`, whose metadata are a hash map and so in another order in every
//! run: the same scans shall give the same bytes.

use std::path::Path;

use serde_json::{Map, Value, json};

use super::sample::Sample;
use super::{Interface, Sizes};
use crate::error::{Error, Result};
use crate::reconstruct::occupancy::inputs::{PATCH_CHANNELS, PLACE_CHANNELS, RASTER_CHANNELS};
use crate::simulate::options::Setup;
use crate::simulate::split::Split;
use crate::sink::write_whole;

/// The version of the format of shards.
pub(super) const VERSION: &str = "2";
/// What the channels of the bare inputs of `Points2Surf` are called.
const OFFSETS: [&str; 3] = ["offset_x", "offset_y", "offset_z"];

/// What is written into the head of every shard.
pub(super) struct Head<'a> {
    pub interface: Interface,
    pub sizes: &'a Sizes,
    pub split: Split,
    pub seed: u64,
}

impl Head<'_> {
    fn place_channels(&self) -> &'static [&'static str] {
        match self.interface {
            Interface::Field => &PLACE_CHANNELS,
            Interface::Points2surf => &PLACE_CHANNELS[..3],
        }
    }

    fn patch_channels(&self) -> &'static [&'static str] {
        match self.interface {
            Interface::Field => &PATCH_CHANNELS,
            Interface::Points2surf => &OFFSETS,
        }
    }

    fn raster_channels(&self) -> &'static [&'static str] {
        if self.sizes.grid == 0 { &[] } else { &RASTER_CHANNELS }
    }

    fn metadata(&self) -> Value {
        let setups: Vec<&str> = Setup::ALL.iter().map(|setup| setup.name()).chain(["real"]).collect();
        json!({
            "format": "gable-shard",
            "version": VERSION,
            "interface": self.interface.name(),
            "split": self.split.name(),
            "seed": self.seed.to_string(),
            "near": self.sizes.near.to_string(),
            "uniform": self.sizes.uniform.to_string(),
            "cells": self.sizes.cells.to_string(),
            "samples_per_cell": self.sizes.samples_per_cell.to_string(),
            "raster_channels": self.raster_channels().join(","),
            "place_channels": self.place_channels().join(","),
            "patch_channels": self.patch_channels().join(","),
            "setups": setups.join(","),
        })
    }

    /// Writes a shard.
    ///
    /// # Errors
    /// The system refuses to write.
    pub fn write(&self, path: &Path, samples: &[Sample]) -> Result<()> {
        let Sizes { grid, neighbours, subsample, cells, .. } = *self.sizes;
        let (n, q) = (samples.len(), self.sizes.queries());
        let [raster, place, patch] =
            [self.raster_channels(), self.place_channels(), self.patch_channels()].map(<[_]>::len);
        let mut body = Body::default();
        let floats = |values: &[f32]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        let halves = |values: &[u16]| values.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
        // Wide numbers first, so that every tensor starts at a multiple of the size of its numbers.
        body.add("place", "F32", &[n, q, place], samples, |s| floats(&s.place));
        body.add("radius", "F32", &[n, q], samples, |s| floats(&s.radius));
        body.add("distance", "F32", &[n, q], samples, |s| floats(&s.distance));
        body.add("cell_inside", "F32", &[n, cells], samples, |s| floats(&s.cell_inside));
        body.add("cell_known", "F32", &[n, cells], samples, |s| floats(&s.cell_known));
        body.add("cell_volume", "F32", &[n, cells], samples, |s| floats(&s.cell_volume));
        body.add("cell_vote", "F32", &[n, cells], samples, |s| floats(&s.cell_vote));
        body.add("scale", "F32", &[n], samples, |s| floats(&[s.scale]));
        body.add("noise", "F32", &[n], samples, |s| floats(&[s.noise]));
        body.add("density", "F32", &[n], samples, |s| floats(&[s.density]));
        if raster > 0 {
            body.add("raster", "F16", &[n, raster, grid, grid], samples, |s| halves(&s.raster));
        }
        body.add("subsample", "F16", &[n, subsample, 3], samples, |s| halves(&s.subsample));
        body.add("patch", "F16", &[n, q, neighbours, patch], samples, |s| halves(&s.patch));
        body.add("inside", "U8", &[n, q], samples, |s| s.inside.clone());
        body.add("known", "U8", &[n, q], samples, |s| s.known.clone());
        body.add("exact", "U8", &[n], samples, |s| vec![s.exact]);
        body.add("setup", "U8", &[n], samples, |s| vec![s.setup]);
        body.write(path, self.metadata())
    }
}

/// The tensors of a file.
#[derive(Default)]
struct Body {
    tensors: Map<String, Value>,
    bytes: Vec<u8>,
}

impl Body {
    /// Appends a tensor, sample by sample.
    fn add(&mut self, name: &str, kind: &str, shape: &[usize], samples: &[Sample], of: impl Fn(&Sample) -> Vec<u8>) {
        let start = self.bytes.len();
        for sample in samples {
            self.bytes.extend(of(sample));
        }
        let offsets = [start, self.bytes.len()];
        self.tensors.insert(name.to_owned(), json!({"dtype": kind, "shape": shape, "data_offsets": offsets}));
    }

    /// The length of the head, the head, the tensors.
    fn write(self, path: &Path, metadata: Value) -> Result<()> {
        let mut head = Map::new();
        head.insert("__metadata__".to_owned(), metadata);
        head.extend(self.tensors);
        let mut head = serde_json::to_vec(&head).map_err(|e| Error::io(path, "write", e.into()))?;
        head.resize(head.len().next_multiple_of(8), b' ');
        let mut bytes = (head.len() as u64).to_le_bytes().to_vec();
        bytes.extend(head);
        bytes.extend(self.bytes);
        write_whole(path, &bytes)
    }
}
