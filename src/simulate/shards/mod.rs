//! Training data: what a network is asked, what it is told, and the truth, in safetensors files.

mod answers;
mod dataset;
mod file;
mod float16;
mod manifest;
mod queries;
mod sample;
#[cfg(test)]
mod tests;

use serde::{Deserialize, Serialize};

pub use dataset::{Job, Observer, run};
pub use manifest::{Manifest, SourceRecord};

/// For which network data are.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Interface {
    /// The field of this project: a raster of the building, and the place with its nearest points.
    Field,
    /// `Points2Surf`, the network of the paper: the nearest points and a sub-sample.
    Points2surf,
}

impl Interface {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Field => "field",
            Self::Points2surf => "points2surf",
        }
    }
}

/// Sizes of what is asked about one scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Sizes {
    /// Rows and columns of the raster; 0 for none.
    pub grid: usize,
    /// Points of a patch.
    pub neighbours: usize,
    /// Points of the sub-sample.
    pub subsample: usize,
    /// Queries near the surface.
    pub near: usize,
    /// Queries in the whole box.
    pub uniform: usize,
    /// Cells of the partition.
    pub cells: usize,
    /// Queries in each of them.
    pub samples_per_cell: usize,
}

impl Sizes {
    /// Those of an interface, with 256 queries a scan.
    pub fn of(interface: Interface) -> Self {
        let (grid, neighbours) = match interface {
            Interface::Field => (32, 16),
            Interface::Points2surf => (0, 300),
        };
        Self { grid, neighbours, subsample: 1000, near: 64, uniform: 48, cells: 18, samples_per_cell: 8 }
    }

    /// Queries of a scan.
    pub fn queries(&self) -> usize {
        self.near + self.uniform + self.cells * self.samples_per_cell
    }
}
