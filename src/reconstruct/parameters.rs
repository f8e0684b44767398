//! The parameters of the method.

use serde::{Deserialize, Serialize};

use super::labelling::LabellingParameters;
use super::levels::Levels;
use super::primitives::DetectionParameters;
use super::surface::SurfaceParameters;
use crate::completeness::Limits;
use crate::site::{Frame, QUANTUM};

/// All parameters of the method, metric whatever the units of the CRS.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Parameters {
    /// Levels of detail that are made and written, parted by commas: 0 (footprint), 0.1 (what the roofs cover, at one
    /// height), 0.3 (what each roof covers, at its height), 1.2 (blocks), 1.3 (blocks with steps), 2.2 (roofs as they are),
    /// 2.3 (roofs that reach beyond their walls, where the outline of the roof is known).
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
    /// Buildings with fewer points than this per square metre of footprint become blocks (LoD 1.2).
    #[schemars(range(min = 0.0))]
    pub minimum_density: f64,
    /// Buildings of whose footprint a larger share than this (0 to 1) is farther than 1 m from any building point become
    /// blocks.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub maximum_no_data: f64,
    /// Attribute of the footprints that says which buildings become blocks whatever their points show: those where it is
    /// true, yes or a number other than 0.
    pub block_attribute: Option<String>,
    /// Buildings whose footprint is larger than this become blocks, square metres.
    #[schemars(range(min = 0.0))]
    pub block_above: Option<f64>,
    /// Attribute of the footprints that says which buildings have roofs of glass: those where it is true, yes or a number
    /// other than 0. What is scanned of the ground through such a roof makes no hole in it.
    pub glass_attribute: Option<String>,
    /// Step of the grid on which models stand and are checked, units of the CRS: 0.0001, or a multiple of it that divides 1,
    /// such as 0.001. It is the scale of the transform of CityJSON.
    #[schemars(range(min = 0.0001, max = 0.1))]
    pub grid_scale: f64,
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

impl Parameters {
    /// How many steps of the finest grid ([`QUANTUM`]) a step of the grid of the models is; `None` where that is no whole
    /// number, or does not divide a unit of the CRS: then the models of two buildings would not share a grid.
    pub fn grid_steps(&self) -> Option<i64> {
        let of_unit = (1.0 / QUANTUM).round() as i64;
        let steps = (self.grid_scale / QUANTUM).round();
        let is_whole = (steps * QUANTUM - self.grid_scale).abs() < 1e-9 && steps >= 1.0;
        Some(steps as i64).filter(|steps| is_whole && of_unit % steps == 0)
    }

    /// The step of the grid of the models in a local frame, metres along x, y and z.
    pub(super) fn step(&self, frame: &Frame) -> [f64; 3] {
        frame.step().map(|step| step * self.grid_steps().unwrap_or(1) as f64)
    }
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
            minimum_density: 0.0,
            maximum_no_data: 1.0,
            block_attribute: None,
            block_above: None,
            glass_attribute: None,
            grid_scale: QUANTUM,
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
