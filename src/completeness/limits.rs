//! The thresholds of the judge.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What counts as missing, excess and roofed ground. All lengths are metres, whatever the unit of the CRS.
///
/// Their names among options say what they are for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Limits {
    /// Side of the cells of the plan, metres.
    #[schemars(range(min = 0.1))]
    #[serde(rename = "judge_cell")]
    pub cell: f64,
    /// What is nearer to the outline of the footprint is not judged: points there may be on walls, metres.
    #[schemars(range(min = 0.0))]
    #[serde(rename = "judge_margin")]
    pub margin: f64,
    /// How much higher is too much, metres: points over the model, the model over points.
    #[schemars(range(min = 0.0))]
    #[serde(rename = "judge_height")]
    pub height: f64,
    /// A point with a building point more than this above it, and near in plan, is under a roof, metres.
    #[schemars(range(min = 0.0))]
    #[serde(rename = "judge_top")]
    pub top: f64,
    /// Building points this near to the centre of a cell, in plan, say how high the model may be there, metres.
    #[schemars(range(min = 0.0))]
    #[serde(rename = "judge_reach")]
    pub reach: f64,
    /// Fewer building points than this say nothing of it.
    #[schemars(range(min = 1))]
    #[serde(rename = "judge_fewest")]
    pub fewest: u32,
    /// How near in plan a building point shelters what lies below it, metres.
    #[schemars(range(min = 0.0))]
    #[serde(rename = "judge_roof_reach")]
    pub roof_reach: f64,
    /// Smaller areas are left out, m².
    #[schemars(range(min = 0.0))]
    #[serde(rename = "judge_smallest")]
    pub smallest: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { cell: 1.0, margin: 0.6, height: 1.0, top: 1.0, reach: 1.2, fewest: 3, roof_reach: 0.7, smallest: 1.0 }
    }
}
