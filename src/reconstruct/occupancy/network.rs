//! What the method asks of a network; who runs it is no matter of the method.

use std::fmt::Debug;

/// Sizes of the inputs and outputs of a network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Interface {
    /// The field of this project: a raster that is encoded once per building, and a place that is decoded with the code
    /// found there.
    Field {
        /// Rows and columns of the raster and of the code.
        grid: usize,
        /// Channels of the code.
        code: usize,
        /// Points of a patch.
        neighbours: usize,
    },
    /// Points2Surf, the network of the paper (section 3.3): a patch and a sub-sample for every place.
    Points2Surf {
        /// Points of a patch.
        neighbours: usize,
        /// Points of the sub-sample.
        subsample: usize,
    },
}

/// Places to ask a network about, row by row.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Queries {
    /// How many places.
    pub count: usize,
    /// [count, code]: the code at each place; empty for Points2Surf.
    pub code: Vec<f32>,
    /// [count, [`PLACE_CHANNELS`](super::inputs::PLACE_CHANNELS)]; empty for Points2Surf.
    pub place: Vec<f32>,
    /// [count, neighbours, channels]: [`PATCH_CHANNELS`](super::inputs::PATCH_CHANNELS), or three for Points2Surf.
    pub patch: Vec<f32>,
    /// [count, points, 3]: the sub-sample seen from each place; empty but for Points2Surf.
    pub subsample: Vec<f32>,
}

/// What a network says of a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Answer {
    /// Logit of the probability that the place is inside.
    pub inside: f32,
    /// Distance to the surface, divided by the radius of the patch.
    pub distance: f32,
}

/// Why a network gave no answer.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("the network failed: {0}")]
pub struct NetworkError(pub String);

/// A trained network. The same queries in the same order give the same answers, on any thread.
pub trait Network: Debug + Send + Sync {
    /// Sizes of its inputs and outputs.
    fn interface(&self) -> Interface;

    /// The code [code, grid, grid] of the raster [channels, grid, grid] of a building. Not asked of Points2Surf.
    ///
    /// # Errors
    /// Fails when the raster has another size, or the network cannot run.
    fn encode(&self, raster: &[f32]) -> Result<Vec<f32>, NetworkError>;

    /// One answer per query.
    ///
    /// # Errors
    /// Fails when the queries have other sizes, or the network cannot run.
    fn decode(&self, queries: &Queries) -> Result<Vec<Answer>, NetworkError>;
}
