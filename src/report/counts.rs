//! What came out, in numbers.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Serialize;

use super::BuildingReport;
use crate::building::{LadderStep, Outcome, Reason};

/// What came out, in numbers.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Counts {
    /// Features of the footprint file (1 for a single object without a footprint).
    pub footprints: usize,
    /// Buildings that were written, those without a model included.
    pub written: usize,
    /// Buildings that were not reached before the interruption.
    pub not_reached: usize,
    /// Buildings that were taken over from an earlier run that was killed, which this one resumed.
    pub resumed: usize,
    /// Footprints that hold building points.
    pub with_points: usize,
    /// Buildings with a LoD 2.2 model.
    pub buildings_lod22: usize,
    /// Buildings with a LoD 2.2 model of the part that the tiles cover.
    pub buildings_partial: usize,
    /// Buildings with a LoD 1.2 model only.
    pub buildings_lod12: usize,
    /// Buildings without a model that ought to have one: they hold points, or their geometry is unusable.
    pub lacking: usize,
    /// LoD 2.2 solids, that is, building parts.
    pub solids_lod22: usize,
    /// LoD 1.2 solids.
    pub solids_lod12: usize,
    /// Solids at LoD 1.3.
    #[serde(default)]
    pub solids_lod13: usize,
    /// Solids at LoD 2.3.
    #[serde(default)]
    pub solids_lod23: usize,
    /// Buildings by the step of the ladder on which they stand.
    pub ladder: BTreeMap<LadderStep, usize>,
    /// Buildings that fell back to LoD 1.2, by reason.
    pub fallbacks: BTreeMap<Reason, usize>,
    /// Buildings without a solid, by reason.
    pub skipped: BTreeMap<Reason, usize>,
    /// Building points in footprints.
    pub points: u64,
}

/// What a run amounts to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Every footprint that holds points has a model.
    Complete,
    /// Not one building has a model.
    Nothing,
    /// Some buildings lack a model that ought to have one, or were not reached.
    Partial,
}

impl Verdict {
    /// The exit code of the command line.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Complete => 0,
            Self::Nothing => 1,
            Self::Partial => 2,
        }
    }
}

impl Counts {
    /// Counts one more building that was written.
    pub fn add(&mut self, building: &BuildingReport) {
        self.written += 1;
        self.resumed += usize::from(building.resumed);
        self.with_points += usize::from(building.points > 0);
        self.points += building.points as u64;
        self.solids_lod22 += building.solids_lod22;
        self.solids_lod12 += building.solids_lod12;
        self.solids_lod13 += building.solids_lod13;
        self.solids_lod23 += building.solids_lod23;
        self.lacking += usize::from(building.lacks_model());
        if let Some(step) = building.ladder_step {
            *self.ladder.entry(step).or_default() += 1;
        }
        match &building.outcome {
            Outcome::Lod22 => self.buildings_lod22 += 1,
            Outcome::Partial { .. } => self.buildings_partial += 1,
            Outcome::Lod12 { reason, .. } => {
                self.buildings_lod12 += 1;
                *self.fallbacks.entry(*reason).or_default() += 1;
            }
            Outcome::FootprintOnly { reason, .. } | Outcome::Rejected { reason, .. } => {
                *self.skipped.entry(*reason).or_default() += 1;
            }
        }
    }

    /// What the run amounts to.
    pub fn verdict(&self) -> Verdict {
        if self.buildings_lod22 + self.buildings_partial + self.buildings_lod12 == 0 {
            Verdict::Nothing
        } else if self.lacking + self.not_reached > 0 {
            Verdict::Partial
        } else {
            Verdict::Complete
        }
    }
}
