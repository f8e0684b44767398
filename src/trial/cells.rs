//! How well the occupancies of cells agree with the truth.

use serde::Serialize;

use super::calibration::Calibration;
use crate::reconstruct::Partitioned;

/// From which occupancy on a cell counts as inside.
const THRESHOLD: f64 = 0.5;

/// How well a field knows the cells of a building: those whose label is not known beforehand.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CellFindings {
    /// How many there are.
    pub cells: usize,
    /// Share of the cells on the right side of one half.
    pub accuracy: Option<f64>,
    /// Volume of the cells that are rightly called inside over that of those that are inside or are called so; `None`
    /// when there are none of these.
    pub iou: Option<f64>,
    /// The same for the labels of the cut.
    pub iou_after_cut: Option<f64>,
    /// Whether every cell is called outside.
    pub all_outside: bool,
    /// Occupancies against the true shares.
    #[serde(skip)]
    pub calibration: Calibration,
}

impl CellFindings {
    /// Compares the occupancies and the labels of the cut with the true inside fractions, all by cell.
    pub fn new(building: &Partitioned, occupancy: &[f64], labels: &[bool], fractions: &[f64]) -> Self {
        let mut calibration = Calibration::default();
        let (mut cells, mut right, mut inside) = (0, 0_usize, 0_usize);
        let (mut before, mut after) = (Volumes::default(), Volumes::default());
        for cell in building.free().map(|cell| cell as usize) {
            let of = |values: &[f64]| values.get(cell).copied().unwrap_or(0.0);
            let (occupancy, fraction, volume) = (of(occupancy), of(fractions), of(&building.volumes));
            let [called, truth] = [occupancy, fraction].map(|share| share > THRESHOLD);
            cells += 1;
            right += usize::from(called == truth);
            inside += usize::from(called);
            before.add(volume, called, truth);
            after.add(volume, labels.get(cell).copied().unwrap_or(false), truth);
            calibration.add(occupancy, fraction);
        }
        Self {
            cells,
            accuracy: (cells > 0).then(|| right as f64 / cells as f64),
            iou: before.iou(),
            iou_after_cut: after.iou(),
            all_outside: inside == 0,
            calibration,
        }
    }
}

/// Volumes of cells, m³.
#[derive(Debug, Clone, Copy, Default)]
struct Volumes {
    both: f64,
    either: f64,
}

impl Volumes {
    fn add(&mut self, volume: f64, called: bool, truth: bool) {
        if called && truth {
            self.both += volume;
        }
        if called || truth {
            self.either += volume;
        }
    }

    fn iou(&self) -> Option<f64> {
        (self.either > 0.0).then(|| self.both / self.either)
    }
}
