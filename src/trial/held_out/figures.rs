//! What the findings about many buildings come to.

use serde::Serialize;

use super::HeldOutFindings;
use crate::completeness::{Counts, Extents};
use crate::evaluate::DistanceSummary;

/// From this confidence on a building ought to have no fault.
const CONFIDENT: f64 = 0.9;
/// Faults of this area are counted against it, m².
const FAULT: f64 = 10.0;

/// The figures of a field over all buildings.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct HeldOutFigures {
    /// Buildings that were tried.
    pub buildings: usize,
    /// Those of them with a LoD 2.2 model.
    pub lod22: usize,
    /// What is missing, in excess and roofed ground.
    pub completeness: Counts,
    /// Height over the roof of all points held out of all buildings together.
    pub vertical: Option<DistanceSummary>,
    /// Mean number of faces of the LoD 2.2 models.
    pub faces: Option<f64>,
    /// Mean processor time of a building in milliseconds; where the system tells.
    pub cpu_ms: Option<f64>,
    /// How far confidence can be trusted.
    pub confident: Confident,
}

/// Buildings that the field is sure of, and what is wrong with them.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Confident {
    /// Buildings with a confidence of at least 0.9.
    pub buildings: usize,
    /// Those of them with an area of at least 10 m² that is missing, in excess or roofed ground.
    pub at_fault: usize,
    /// Their share, 0 to 1.
    pub share: Option<f64>,
}

impl HeldOutFigures {
    /// Sums up findings and the vertical distances of all points.
    pub(super) fn of(findings: &[HeldOutFindings], distances: Vec<f32>) -> Self {
        Self {
            buildings: findings.len(),
            lod22: findings.iter().filter(|found| found.faces.is_some()).count(),
            completeness: Counts::of(findings.iter().map(|found| &found.extents)),
            vertical: DistanceSummary::of(distances),
            faces: mean(findings.iter().filter_map(|found| found.faces).map(|faces| faces as f64)),
            cpu_ms: mean(findings.iter().filter_map(|found| found.cpu_ms)),
            confident: Confident::of(findings.iter().map(|found| (found.confidence, &found.extents))),
        }
    }
}

impl Confident {
    /// Counts buildings, each with its confidence and its faults.
    pub fn of<'a>(buildings: impl IntoIterator<Item = (Option<f64>, &'a Extents)>) -> Self {
        let sure = buildings.into_iter().filter(|(confidence, _)| confidence.is_some_and(|c| c >= CONFIDENT));
        let (mut buildings, mut at_fault) = (0, 0);
        for (_, extents) in sure {
            buildings += 1;
            at_fault += usize::from(extents.largest() >= FAULT);
        }
        Self { buildings, at_fault, share: (buildings > 0).then(|| at_fault as f64 / buildings as f64) }
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}
