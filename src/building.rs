//! What became of one building: what [`reconstruct`](mod@crate::reconstruct) returns, and what sinks and reports take.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::completeness::Extents;
use crate::record::Record;
use crate::site::{Coverage, Frame, Ground};
use crate::solid::Model;

/// One footprint after the run: with a model or with a reason.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Building {
    /// The id, exactly as in the footprint file (made unique where it was not).
    pub id: String,
    /// The local frame of the model.
    pub frame: Frame,
    /// The footprint's attributes, passed through.
    pub attributes: Map<String, Value>,
    /// The geometry, on the grid of `frame`.
    pub model: Model,
    /// Whether LoD 2.2 was reached, and if not, why.
    pub outcome: Outcome,
    /// What was measured.
    pub measures: Measures,
    /// What is known of it otherwise than by its points.
    pub record: Record,
    /// What the reader of the result should know: repairs of the footprint, a made-up id, an incomplete tile.
    pub notes: Vec<String>,
}

/// Whether LoD 2.2 was reached, and of the whole building.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "outcome")]
pub enum Outcome {
    /// Every part is a valid LoD 2.2 solid.
    Lod22,
    /// Every part is a valid LoD 2.2 solid, but only over what the tiles cover of the footprint.
    Partial {
        /// Why it is not the whole building.
        reason: Reason,
        /// The particulars, for a person.
        detail: String,
    },
    /// The building is a LoD 1.2 block.
    Lod12 {
        /// Why there is no LoD 2.2.
        reason: Reason,
        /// The particulars, for a person.
        detail: String,
    },
    /// Only the footprint is written.
    FootprintOnly {
        /// Why there is no solid.
        reason: Reason,
        /// The particulars, for a person.
        detail: String,
    },
    /// The feature has no usable geometry; only its attributes are written.
    Rejected {
        /// Why.
        reason: Reason,
        /// The particulars, for a person.
        detail: String,
    },
}

impl Outcome {
    /// The highest level of detail that was reached, overhangs aside; `None` for what has no geometry at all.
    pub fn lod(&self) -> Option<&'static str> {
        match self {
            Self::Lod22 | Self::Partial { .. } => Some("2.2"),
            Self::Lod12 { .. } => Some("1.2"),
            Self::FootprintOnly { .. } => Some("0"),
            Self::Rejected { .. } => None,
        }
    }

    /// The reason, unless LoD 2.2 of the whole building was reached.
    pub fn reason(&self) -> Option<(Reason, &str)> {
        match self {
            Self::Lod22 => None,
            Self::Partial { reason, detail }
            | Self::Lod12 { reason, detail }
            | Self::FootprintOnly { reason, detail }
            | Self::Rejected { reason, detail } => Some((*reason, detail)),
        }
    }
}

/// A step of the ladder that a building goes down until it stands on one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LadderStep {
    /// LoD 2.2 with the parameters as given.
    Lod22,
    /// LoD 2.2 with all tolerances twice as coarse.
    Lod22Coarse,
    /// LoD 2.2 with all tolerances four times as coarse.
    Lod22Coarsest,
    /// LoD 2.2 of the part of the building that the tiles cover.
    Partial,
    /// The LoD 1.2 block.
    Lod12,
    /// The footprint.
    Footprint,
}

impl LadderStep {
    /// The steps that are LoD 2.2, finest first.
    pub const LOD22: [Self; 3] = [Self::Lod22, Self::Lod22Coarse, Self::Lod22Coarsest];
}

/// An attempt at LoD 2.2 that came to nothing.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Setback {
    /// The step of the ladder that was tried.
    pub step: LadderStep,
    /// Why it was left.
    pub reason: Reason,
    /// The particulars, for a person.
    pub detail: String,
    /// val3dity codes of the faults of the solid that it would have given, ascending; empty if there was none.
    pub codes: Vec<u16>,
}

impl Building {
    /// The step of the ladder on which the building stands; `None` for a feature without usable geometry.
    pub fn ladder_step(&self) -> Option<LadderStep> {
        match self.outcome {
            Outcome::Lod22 => LadderStep::LOD22.get(self.measures.setbacks.len()).copied(),
            Outcome::Partial { .. } => Some(LadderStep::Partial),
            Outcome::Lod12 { .. } => Some(LadderStep::Lod12),
            Outcome::FootprintOnly { .. } => Some(LadderStep::Footprint),
            Outcome::Rejected { .. } => None,
        }
    }
}

/// Why a building is not a LoD 2.2 solid.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Reason {
    /// The feature has no polygon: null or empty geometry, a line, a point, or a ring beyond repair.
    NoPolygon,
    /// No building point lies in the footprint.
    NoPoints,
    /// Fewer building points than a plane needs.
    TooFewPoints,
    /// The given tiles do not cover the footprint, or not all of it.
    Incomplete,
    /// The footprint is open ground: no solid stands on it.
    OpenGround,
    /// No planar primitive was found in the points.
    NoPrimitives,
    /// The labelling found nothing inside.
    NothingInside,
    /// The solid would have been invalid.
    InvalidSolid,
    /// The partition of the building's space would have too many cells, or is out of range.
    TooComplex,
    /// The model would have risen above the highest point of the building.
    AboveEvidence,
    /// The model would have fitted its points worse than the LoD 1.2 block does.
    WorseThanBlock,
    /// The roof would have been lower above the ground than a building is.
    TooLow,
    /// The user asked for a block: by an attribute of the footprint, or because it is large.
    AsAsked,
    /// Fewer building points per square metre than were asked for.
    LowDensity,
    /// More of the footprint was not scanned than was asked for.
    MissingData,
    /// All point clouds are older than the building.
    Outdated,
    /// The method failed in a way that is a fault of the program; the detail says where.
    Internal,
}

/// What was measured of a building. Heights are metres in the local frame.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Measures {
    /// The ground.
    pub ground: Option<Ground>,
    /// Least and greatest depth of the floor under the ground along the outline, metres: the floor is level, and the ground
    /// may not be. Negative where the floor hangs above it; `None` where no ground was seen.
    pub floor_depth: Option<[f64; 2]>,
    /// How far the tiles cover the footprint.
    pub coverage: Option<Coverage>,
    /// Number of building points.
    pub points: usize,
    /// Building points per square metre of footprint.
    pub point_density: Option<f64>,
    /// Share of the footprint's area farther than 1 m from any building point, 0 to 1.
    pub no_data_share: Option<f64>,
    /// Number of detected planar primitives after refinement.
    pub primitives: usize,
    /// Number of cells of the complex.
    pub cells: usize,
    /// Open ground in the footprint, square metres; `None` where no ground points could tell.
    pub open_ground: Option<f64>,
    /// How far the LoD 2.2 model can be trusted, 0 to 1: how sure the field is of its surface above the ground, less what
    /// is missing, in excess, without data or not covered.
    pub confidence: Option<f64>,
    /// Why the height-field vote decided although another field was asked for; `None` where the field that was asked
    /// for decided.
    pub field_fallback: Option<String>,
    /// The shape of the roof.
    pub roof_type: Option<RoofType>,
    /// Number of distinct roof planes of the LoD 2.2 model.
    pub roof_planes: Option<usize>,
    /// Heights of the roof: lowest, median, 70th and 98th percentile of the building points on roofs, and the highest, of the
    /// LoD 2.2 model where there is one. What is too small to stand, or hovers, and is not modelled does not count.
    pub roof_heights: Option<RoofHeights>,
    /// Height of the highest edge between two roof planes.
    pub ridge_height: Option<f64>,
    /// The ridges of the LoD 2.2 model.
    #[serde(default)]
    pub ridges: Option<Ridges>,
    /// Root mean square of the distances of the building points to the nearest face of the LoD 1.2 model, metres.
    pub rmse_lod12: Option<f64>,
    /// Root mean square of the distances of the building points to the nearest face of the LoD 1.3 model, metres.
    pub rmse_lod13: Option<f64>,
    /// Root mean square of the distances of the building points to the nearest face of the LoD 2.2 model, metres.
    pub rmse_lod22: Option<f64>,
    /// Root mean square of the distances of the building points to the nearest face of the LoD 2.3 model, metres.
    #[serde(default)]
    pub rmse_lod23: Option<f64>,
    /// Volume in cubic metres.
    pub volume_lod12: Option<f64>,
    /// Volume in cubic metres.
    pub volume_lod13: Option<f64>,
    /// Volume in cubic metres.
    pub volume_lod22: Option<f64>,
    /// Volume in cubic metres.
    #[serde(default)]
    pub volume_lod23: Option<f64>,
    /// How much is scanned and not in the LoD 2.2 model, or in it and not scanned; `None` without such a model.
    pub completeness: Option<Extents>,
    /// What making the LoD 2.2 model again, with hypotheses for what it lacked, brought; `None` where it was not or brought
    /// nothing.
    pub revision: Option<Revision>,
    /// val3dity codes of the LoD 2.2 solid that was rejected; empty when a valid one was found.
    pub faults_lod22: Vec<u16>,
    /// The attempts at LoD 2.2 that came to nothing, finest first.
    pub setbacks: Vec<Setback>,
    /// What became of the edits of the building; `None` where it has none.
    #[serde(default)]
    pub edits: Option<EditTally>,
}

/// What became of the edits of a building.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct EditTally {
    /// How many apply.
    pub applied: usize,
    /// Those that no longer apply, or never did.
    pub refused: Vec<RefusedEdit>,
}

impl EditTally {
    /// What its reader should know.
    pub fn notes(&self) -> impl Iterator<Item = String> + '_ {
        let note = |RefusedEdit { number, action, why }: &RefusedEdit| {
            format!("edit {number} ({action}) does not apply: {why}")
        };
        self.refused.iter().map(note)
    }
}

/// An edit that does not apply.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct RefusedEdit {
    /// Its number among the edits of the building, from 1.
    pub number: usize,
    /// Its action, as it stands in the file of edits.
    pub action: String,
    /// Why it does not apply.
    pub why: String,
}

/// What making a model again brought.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, schemars::JsonSchema)]
pub struct Revision {
    /// How many times it was made again and became better.
    pub rounds: u32,
    /// What was missing or in excess in the first model, square metres.
    pub before: f64,
    /// What is in the last one, square metres.
    pub after: f64,
}

/// Level lines from which two roof planes fall.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Ridges {
    /// How many; all pieces between the same two planes are one.
    pub count: usize,
    /// Their length together, metres.
    pub length: f64,
}

/// Percentiles of the roof height, metres in the local frame.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RoofHeights {
    /// Lowest.
    pub min: f64,
    /// Median.
    pub p50: f64,
    /// 70th percentile: the height of the LoD 1.2 block.
    pub p70: f64,
    /// 98th percentile: the top without what stands out of it.
    pub p98: f64,
    /// Highest.
    pub max: f64,
}

/// The shape of a roof.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RoofType {
    /// One horizontal plane.
    Flat,
    /// Several horizontal planes at different heights.
    MultipleFlat,
    /// At least one sloped plane.
    Slanted,
}
