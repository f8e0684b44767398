//! The parameters of the method.

use serde::{Deserialize, Serialize};

use super::labelling::LabellingParameters;
use super::primitives::DetectionParameters;
use super::surface::SurfaceParameters;
use crate::completeness::Limits;

/// All parameters of the method, metric whatever the units of the CRS.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// How planar primitives are detected and refined.
    pub detection: DetectionParameters,
    /// How far the walls may stand back from the footprint's outline where that makes them simpler, metres. They never
    /// stand outside it.
    #[schemars(range(min = 0.0))]
    pub footprint_tolerance: f64,
    /// Smallest difference in height between neighbouring roofs that gets a wall, metres.
    #[schemars(range(min = 0.0))]
    pub step_height: f64,
    /// Shortest wall between neighbouring roofs, metres.
    #[schemars(range(min = 0.0))]
    pub step_length: f64,
    /// How the primitives cut space into cells.
    pub partition: Partition,
    /// How cells become inside or outside.
    pub labelling: LabellingParameters,
    /// How the surface of the inside cells is cleaned.
    pub surface: SurfaceParameters,
    /// What counts as scanned and not modelled, or modelled and not scanned.
    pub completeness: Limits,
}

/// How the primitives cut space into cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Partition {
    /// A primitive cuts only the cells that it reaches (paper, section 3.2).
    #[default]
    Adaptive,
    /// Every primitive cuts every cell; for comparison.
    Exhaustive,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            detection: DetectionParameters::default(),
            footprint_tolerance: 0.1,
            step_height: 0.3,
            step_length: 0.8,
            partition: Partition::Adaptive,
            labelling: LabellingParameters::default(),
            surface: SurfaceParameters::default(),
            completeness: Limits::default(),
        }
    }
}
