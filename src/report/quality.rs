//! How good the models are, over all buildings.

use schemars::JsonSchema;
use serde::Serialize;

use super::BuildingReport;
use crate::building::Revision;
use crate::completeness;

/// How good the models are, over all buildings.
#[derive(Debug, Clone, Default, PartialEq, Serialize, JsonSchema)]
pub struct Quality {
    /// Root mean square of the distances of a building's points to the nearest face at LoD 2.2, metres.
    pub rmse_lod22: Option<Percentiles>,
    /// The same to the LoD 1.2 roof.
    pub rmse_lod12: Option<Percentiles>,
    /// Buildings of which something is scanned and not in the LoD 2.2 model, or in it and not scanned.
    pub completeness: completeness::Counts,
    /// Buildings whose LoD 2.2 model became better by being made again.
    pub revised: Revised,
}

/// What making models again brought, over all buildings of which it made the model better.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
pub struct Revised {
    /// Number of buildings.
    pub buildings: usize,
    /// What was missing or in excess in their first models, square metres.
    pub before: f64,
    /// What is in their last ones, square metres.
    pub after: f64,
}

impl Revised {
    fn add(&mut self, revision: Revision) {
        self.buildings += 1;
        self.before += revision.before;
        self.after += revision.after;
    }
}

/// Percentiles over buildings, by nearest rank: each is the value of one of the buildings.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Percentiles {
    /// Number of buildings.
    pub buildings: usize,
    /// Median.
    pub p50: f64,
    /// 90th percentile.
    pub p90: f64,
    /// 99th percentile.
    pub p99: f64,
    /// Largest.
    pub max: f64,
}

impl Percentiles {
    /// The percentiles of the finite ones of `values`; `None` if there are none.
    pub fn of(values: impl IntoIterator<Item = f64>) -> Option<Self> {
        let mut sorted: Vec<f64> = values.into_iter().filter(|v| v.is_finite()).collect();
        sorted.sort_by(f64::total_cmp);
        let rank = |percent: usize| sorted.get((sorted.len() * percent).div_ceil(100).saturating_sub(1)).copied();
        Some(Self { buildings: sorted.len(), p50: rank(50)?, p90: rank(90)?, p99: rank(99)?, max: rank(100)? })
    }
}

impl Quality {
    /// The quality of these buildings.
    pub fn of(buildings: &[BuildingReport]) -> Self {
        let mut tally = QualityTally::default();
        for building in buildings {
            tally.add(building);
        }
        tally.quality()
    }
}

/// The quality of buildings that come one by one: of each no more is held than its two errors.
#[derive(Debug, Clone, Default)]
pub struct QualityTally {
    rmse_lod22: Vec<f64>,
    rmse_lod12: Vec<f64>,
    completeness: completeness::Counts,
    revised: Revised,
}

impl QualityTally {
    /// Takes one more building.
    pub fn add(&mut self, building: &BuildingReport) {
        self.rmse_lod22.extend(building.rmse_lod22);
        self.rmse_lod12.extend(building.rmse_lod12);
        if let Some(extents) = &building.completeness {
            self.completeness.add(extents);
        }
        if let Some(revision) = building.revision {
            self.revised.add(revision);
        }
    }

    /// The quality of all of them.
    pub fn quality(self) -> Quality {
        Quality {
            rmse_lod22: Percentiles::of(self.rmse_lod22),
            rmse_lod12: Percentiles::of(self.rmse_lod12),
            completeness: self.completeness,
            revised: self.revised,
        }
    }
}
