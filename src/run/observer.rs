//! What a run tells while it runs, and how it is stopped.

use serde::Serialize;

use crate::report::BuildingReport;

/// The stages of a run, in order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Stage {
    /// Opens the tiles, reads the footprints and brings them into the CRS of the tiles.
    Read,
    /// Divides the footprints into jobs, where a run is to be done in several.
    Plan,
    /// Streams the points of the tiles to the footprints that they belong to.
    Segment,
    /// Reconstructs the buildings in parallel and writes them as they get done.
    Reconstruct,
    /// Makes the terrain around the buildings, tile by tile in parallel, and writes it behind them.
    Terrain,
    /// Writes the points of each building to a file of its own, instead of reconstructing it.
    Crop,
    /// Joins the parts of the jobs of a run into one model.
    Merge,
    /// Completes the output file and gives it its name.
    Finish,
}

impl Stage {
    /// What it does, for a progress bar or a table.
    pub fn label(self) -> &'static str {
        match self {
            Self::Read => "reading inputs",
            Self::Plan => "dividing the footprints",
            Self::Segment => "collecting points",
            Self::Reconstruct => "reconstructing",
            Self::Terrain => "making the terrain",
            Self::Crop => "cropping points",
            Self::Merge => "joining the parts",
            Self::Finish => "finishing the file",
        }
    }

    /// What its progress is counted in, as a noun in the singular.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Read | Self::Finish => "file",
            Self::Segment | Self::Crop => "point",
            Self::Plan => "job",
            Self::Reconstruct | Self::Merge => "building",
            Self::Terrain => "tile",
        }
    }
}

/// Something that happened in a run.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Event<'a> {
    /// A stage began; `total` counts what it is going to do in its [unit](Stage::unit).
    Started {
        /// The stage.
        stage: Stage,
        /// How much there is to do.
        total: u64,
    },
    /// `by` more units of a stage are done.
    Advanced {
        /// The stage.
        stage: Stage,
        /// How much was done since the last event.
        by: u64,
    },
    /// A stage is over; one that fails never is.
    Finished {
        /// The stage.
        stage: Stage,
    },
    /// A building was written; buildings come in the order of the footprints.
    Building(&'a BuildingReport),
    /// Something that the user should know and that stops nothing.
    Warning(&'a str),
}

/// Listens to a run. Events come from several threads.
pub trait Observer: Sync {
    /// Takes notice of an event.
    fn event(&self, event: Event<'_>);

    /// Whether the run is to stop: buildings under way are completed and what is done is written.
    fn interrupted(&self) -> bool {
        false
    }
}

/// Listens to nothing and never interrupts.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Observer for Silent {
    fn event(&self, _event: Event<'_>) {}
}
