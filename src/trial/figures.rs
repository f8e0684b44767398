//! What the findings about many buildings come to.

use serde::Serialize;

use super::calibration::Calibration;
use super::watched::{Findings, SurfaceFindings};

/// The figures of a field over all buildings of a column. Means and medians are over buildings; a building without a
/// LoD 2.2 model shares no volume with the truth and is infinitely far from it, so that giving up never pays.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Figures {
    /// Buildings.
    pub buildings: usize,
    /// Those of them that have cells.
    pub with_cells: usize,
    /// Mean share of the cells on the right side of one half.
    pub cell_accuracy: Option<f64>,
    /// Mean volume-weighted intersection over union of the cells called inside.
    pub cell_iou: Option<f64>,
    /// The same after the cut.
    pub cell_iou_after_cut: Option<f64>,
    /// Expected calibration error over the cells of all buildings, each cell alike.
    pub calibration_error: Option<f64>,
    /// Share of the buildings with cells of which all are called outside.
    pub all_outside: Option<f64>,
    /// Mean share of the places near the surface whose side is right.
    pub sign_near: Option<f64>,
    /// Mean share of the places in the box whose side is right.
    pub sign_uniform: Option<f64>,
    /// Mean intersection over union of the volumes.
    pub volume_iou: Option<f64>,
    /// Median Hausdorff distance over R.
    pub hausdorff: Option<f64>,
    /// Median symmetric mean Hausdorff distance over R.
    pub symmetric_mean: Option<f64>,
    /// Median of the root mean square distance between the roofs, metres.
    pub roof_rmse: Option<f64>,
    /// Mean number of faces of the LoD 2.2 models.
    pub faces_mean: Option<f64>,
    /// Median number of faces of the LoD 2.2 models.
    pub faces_median: Option<f64>,
    /// Share of the buildings with a closed and valid LoD 2.2 model.
    pub lod22: Option<f64>,
    /// Share of the buildings in which the vote decided in place of the field.
    pub fallback: Option<f64>,
    /// The bins behind the calibration error.
    pub calibration: Calibration,
}

impl Figures {
    /// Sums up.
    pub fn of(findings: &[Findings]) -> Self {
        let mut calibration = Calibration::default();
        let cells: Vec<_> = findings.iter().filter_map(|f| f.cells.as_ref()).collect();
        for cells in &cells {
            calibration.merge(&cells.calibration);
        }
        let surfaces = || findings.iter().filter_map(|f| f.surface.as_ref());
        let distance = |of: fn(&SurfaceFindings) -> Option<f64>| {
            median(findings.iter().map(|f| f.surface.as_ref().and_then(of).unwrap_or(f64::INFINITY)))
        };
        let truth = |is: bool| f64::from(u8::from(is));
        Self {
            buildings: findings.len(),
            with_cells: cells.len(),
            cell_accuracy: mean(cells.iter().filter_map(|c| c.accuracy)),
            cell_iou: mean(cells.iter().filter_map(|c| c.iou)),
            cell_iou_after_cut: mean(cells.iter().filter_map(|c| c.iou_after_cut)),
            calibration_error: calibration.error(),
            all_outside: mean(cells.iter().map(|c| truth(c.all_outside))),
            sign_near: mean(findings.iter().filter_map(|f| f.near)),
            sign_uniform: mean(findings.iter().filter_map(|f| f.uniform)),
            volume_iou: mean(findings.iter().map(|f| f.surface.as_ref().and_then(|s| s.volume_iou).unwrap_or(0.0))),
            hausdorff: distance(|s| s.hausdorff),
            symmetric_mean: distance(|s| s.symmetric_mean),
            roof_rmse: distance(|s| s.roof_rmse),
            faces_mean: mean(surfaces().map(|s| s.faces as f64)),
            faces_median: median(surfaces().map(|s| s.faces as f64)),
            lod22: mean(findings.iter().map(|f| truth(f.surface.is_some()))),
            fallback: mean(findings.iter().map(|f| truth(f.fallback.is_some()))),
            calibration,
        }
    }
}

fn mean(values: impl Iterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.fold((0.0, 0_u32), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / f64::from(count))
}

/// The median; `None` without values, and when it would lie beyond what was measured.
fn median(values: impl Iterator<Item = f64>) -> Option<f64> {
    crate::evaluate::median(values)
}
