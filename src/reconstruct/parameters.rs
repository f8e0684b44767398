//! The parameters of the method.

use serde::{Deserialize, Serialize};

use super::labelling::LabellingParameters;
use super::levels::Levels;
use super::primitives::DetectionParameters;
use super::surface::SurfaceParameters;
use crate::completeness::Limits;

/// All parameters of the method, metric whatever the units of the CRS.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Levels of detail that are made and written, parted by commas: 0 (footprint), 1.2 (blocks), 1.3 (blocks with steps),
    /// 2.2 (roofs as they are), 2.3 (roofs that reach beyond their walls, where the outline of the roof is known).
    pub lod: Levels,
    /// LoD 1.3: roofs whose heights differ by less than this where they meet share the top of a block, metres.
    #[schemars(range(min = 0.0))]
    pub block_step: f64,
    /// LoD 2.3: how thick roofs are where they reach beyond their walls, metres, measured upright.
    #[schemars(range(min = 0.0))]
    pub eaves_thickness: f64,
    /// How planar primitives are detected and refined.
    pub detection: DetectionParameters,
    /// How far the walls may stand back from the footprint's outline where that makes them simpler, metres. They never
    /// stand outside it.
    #[schemars(range(min = 0.0))]
    pub footprint_tolerance: f64,
    /// What becomes of open ground inside a footprint: seen from above, with no building point over it.
    pub open_ground: OpenGround,
    /// Smallest open ground, square metres.
    #[schemars(range(min = 0.0))]
    pub open_ground_area: f64,
    /// What becomes of a footprint that the tiles cover in part.
    pub partial: Partial,
    /// Smallest height of the middle of the roof above the ground, metres: what is lower is no building, or its ground is
    /// too high.
    #[schemars(range(min = 0.0))]
    pub minimum_height: f64,
    /// Smallest difference in height between neighbouring roofs that gets a wall, metres; never less than three standard
    /// deviations of the noise.
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

/// What becomes of open ground inside a footprint.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum OpenGround {
    /// No solid stands there.
    #[default]
    Carve,
    /// It is built over.
    Keep,
}

/// What becomes of a footprint that the tiles cover in part.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Partial {
    /// A model of the covered part.
    #[default]
    Covered,
    /// The LoD 1.2 block over the whole footprint.
    Block,
}

impl Default for Parameters {
    fn default() -> Self {
        Self {
            lod: Levels::default(),
            block_step: 3.0,
            eaves_thickness: 0.2,
            detection: DetectionParameters::default(),
            footprint_tolerance: 0.1,
            open_ground: OpenGround::default(),
            open_ground_area: 4.0,
            partial: Partial::default(),
            minimum_height: 1.0,
            step_height: 0.3,
            step_length: 0.8,
            partition: Partition::Adaptive,
            labelling: LabellingParameters::default(),
            surface: SurfaceParameters::default(),
            completeness: Limits::default(),
        }
    }
}
