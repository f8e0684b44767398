//! What became of one building.

use std::time::Duration;

use schemars::JsonSchema;
use serde::Serialize;

use crate::building::{Building, EditTally, LadderStep, Outcome, Revision, Setback};
use crate::completeness::Extents;
use crate::site::GroundSource;

/// What became of one building.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct BuildingReport {
    /// The id, exactly as in the footprint file (made unique where it was not).
    pub id: String,
    /// Whether LoD 2.2 was reached, and if not, why.
    #[serde(flatten)]
    pub outcome: Outcome,
    /// Number of LoD 2.2 solids.
    pub solids_lod22: usize,
    /// Number of LoD 1.2 solids.
    pub solids_lod12: usize,
    /// Solids at LoD 1.3.
    #[serde(default)]
    pub solids_lod13: usize,
    /// Solids at LoD 2.3.
    #[serde(default)]
    pub solids_lod23: usize,
    /// Number of building points.
    pub points: usize,
    /// Number of planar primitives after refinement.
    pub primitives: usize,
    /// Number of cells of the complex.
    pub cells: usize,
    /// Where the ground height comes from.
    pub ground: Option<GroundSource>,
    /// Share of the footprint's area that the tiles cover, 0 to 1.
    pub coverage: Option<f64>,
    /// Root mean square of the distances of the building points to the nearest face at LoD 1.2, metres.
    pub rmse_lod12: Option<f64>,
    /// Root mean square of the distances of the building points to the nearest face at LoD 2.2, metres.
    pub rmse_lod22: Option<f64>,
    /// How much is scanned and not in the LoD 2.2 model, or in it and not scanned.
    pub completeness: Option<Extents>,
    /// What making the LoD 2.2 model again, with hypotheses for what it lacked, brought.
    pub revision: Option<Revision>,
    /// The step of the ladder on which the building stands; null for a feature without usable geometry.
    pub ladder_step: Option<LadderStep>,
    /// The attempts at LoD 2.2 that came to nothing, finest first.
    pub setbacks: Vec<Setback>,
    /// val3dity codes of the LoD 2.2 solid that was rejected; empty when a valid one was found.
    pub faults_lod22: Vec<u16>,
    /// Whether an earlier run that was killed made it, which this one resumed.
    pub resumed: bool,
    /// Wall time of the reconstruction in milliseconds.
    pub wall_ms: f64,
    /// Processor time of the reconstruction in milliseconds; where the system tells.
    pub cpu_ms: Option<f64>,
    /// What the reader of the result should know.
    pub notes: Vec<String>,
    /// What became of its edits, where it has any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edits: Option<EditTally>,
    /// The file that it is in, where the model goes to several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
}

impl BuildingReport {
    /// The report of a building that took this much wall and processor time.
    pub fn new(building: &Building, wall: Duration, cpu: Option<Duration>) -> Self {
        let measures = &building.measures;
        let milliseconds = |time: Duration| (time.as_secs_f64() * 1e6).round() / 1e3;
        Self {
            id: building.id.clone(),
            outcome: building.outcome.clone(),
            solids_lod22: building.model.lod22().count(),
            solids_lod12: building.model.lod12().count(),
            solids_lod13: building.model.lod13().count(),
            solids_lod23: building.model.lod23().count(),
            points: measures.points,
            primitives: measures.primitives,
            cells: measures.cells,
            ground: measures.ground.map(|ground| ground.source),
            coverage: measures.coverage.map(|coverage| coverage.share),
            rmse_lod12: measures.rmse_lod12,
            rmse_lod22: measures.rmse_lod22,
            completeness: measures.completeness,
            revision: measures.revision,
            ladder_step: building.ladder_step(),
            setbacks: measures.setbacks.clone(),
            faults_lod22: measures.faults_lod22.clone(),
            resumed: false,
            wall_ms: milliseconds(wall),
            cpu_ms: cpu.map(milliseconds),
            notes: building.notes.clone(),
            edits: measures.edits.clone(),
            file: None,
        }
    }

    /// Whether solids could be made of the building, whatever levels of detail were asked for.
    pub fn has_model(&self) -> bool {
        matches!(self.outcome, Outcome::Lod22 | Outcome::Partial { .. } | Outcome::Lod12 { .. })
    }

    /// Whether the building ought to have a model and has none: it holds points, or it could not even be told whether
    /// it does.
    pub fn lacks_model(&self) -> bool {
        !self.has_model() && (self.points > 0 || matches!(self.outcome, Outcome::Rejected { .. }))
    }
}
