//! Whether what a field calls 80 % is inside in 80 % of the cases.

use serde::Serialize;

/// Number of bins between 0 and 1.
const BINS: usize = 10;

/// Predicted against true shares, bin by bin (reliability diagram).
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Calibration {
    /// Ten equal bins of the predicted value, lowest first.
    pub bins: [Bin; BINS],
}

/// The predictions in a bin.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Bin {
    /// How many.
    pub count: u64,
    /// Sum of the predicted values.
    pub predicted: f64,
    /// Sum of the true values.
    pub truth: f64,
}

impl Calibration {
    /// Counts a prediction, 0 to 1, of a true share.
    pub fn add(&mut self, predicted: f64, truth: f64) {
        let bin = ((predicted * BINS as f64) as usize).min(BINS - 1);
        if let Some(bin) = self.bins.get_mut(bin) {
            bin.count += 1;
            bin.predicted += predicted;
            bin.truth += truth;
        }
    }

    /// Counts what another has counted.
    pub fn merge(&mut self, other: &Self) {
        for (bin, other) in self.bins.iter_mut().zip(&other.bins) {
            bin.count += other.count;
            bin.predicted += other.predicted;
            bin.truth += other.truth;
        }
    }

    /// Expected calibration error: the mean over all predictions of how far the means of their bin are apart; `None`
    /// without predictions.
    pub fn error(&self) -> Option<f64> {
        let count: u64 = self.bins.iter().map(|bin| bin.count).sum();
        let off: f64 = self.bins.iter().map(|bin| (bin.predicted - bin.truth).abs()).sum();
        (count > 0).then(|| off / count as f64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_error_is_as_worked_out_by_hand() {
        let mut calibration = Calibration::default();
        assert_eq!(calibration.error(), None);
        // Two in [0.8, 0.9): mean 0.85 where 0.5 is true. One in [0.1, 0.2): 0.1 where 0.3 is. One at 1: right.
        for (predicted, truth) in [(0.8, 1.0), (0.89, 0.0), (0.11, 0.3), (1.0, 1.0)] {
            calibration.add(predicted, truth);
        }
        let expected = (2.0 * (0.845 - 0.5) + (0.3 - 0.11)) / 4.0;
        assert!((calibration.error().unwrap() - expected).abs() < 1e-12);
        let mut twice = calibration.clone();
        twice.merge(&calibration);
        assert_eq!(twice.bins[9].count, 2);
        assert!((twice.error().unwrap() - expected).abs() < 1e-12);
    }
}
