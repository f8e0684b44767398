//! Percentiles and shares of many distances.

use serde::Serialize;

/// What many distances come to. All in metres but for the shares, which are 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct DistanceSummary {
    /// How many.
    pub count: usize,
    /// Median of the absolute distances.
    pub median: f64,
    /// 90th percentile of the absolute distances.
    pub p90: f64,
    /// Root mean square.
    pub rmse: f64,
    /// Median of the signed distances: the systematic offset.
    pub offset: f64,
    /// Share of the absolute distances up to 0.1 m.
    pub within_0_1: f64,
    /// Share of the absolute distances up to 0.2 m.
    pub within_0_2: f64,
    /// Share of the absolute distances up to 0.5 m.
    pub within_0_5: f64,
}

impl DistanceSummary {
    /// Sums up signed distances in metres; `None` without any.
    pub fn of(distances: impl IntoIterator<Item = f32>) -> Option<Self> {
        let mut signed: Vec<f32> = distances.into_iter().collect();
        let count = signed.len();
        signed.sort_unstable_by(f32::total_cmp);
        // Summed in sorted order, so that the order of tiles changes no digit.
        let squares: f64 = signed.iter().map(|&d| f64::from(d).powi(2)).sum();
        let offset = percentile(&signed, 0.5)?;
        let mut absolute: Vec<f32> = signed.iter().map(|d| d.abs()).collect();
        absolute.sort_unstable_by(f32::total_cmp);
        let within = |limit: f32| absolute.partition_point(|&d| d <= limit) as f64 / count as f64;
        Some(Self {
            count,
            median: percentile(&absolute, 0.5)?,
            p90: percentile(&absolute, 0.9)?,
            rmse: (squares / count as f64).sqrt(),
            offset,
            within_0_1: within(0.1),
            within_0_2: within(0.2),
            within_0_5: within(0.5),
        })
    }
}

/// The percentile `q` (0 to 1) of sorted values, interpolated linearly between neighbours; `None` without values.
pub fn percentile(sorted: &[f32], q: f64) -> Option<f64> {
    let last = sorted.len().checked_sub(1)?;
    let place = q.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let [a, b] = [sorted.get(below)?, sorted.get((below + 1).min(last))?].map(|&v| f64::from(v));
    Some(a + (b - a) * (place - below as f64))
}

/// The median of some values; `None` without any or when one is not a number.
pub fn median(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_unstable_by(f64::total_cmp);
    let last = values.len().checked_sub(1)?;
    let [a, b] = [values.get(last / 2)?, values.get(last.div_ceil(2))?];
    let middle = f64::midpoint(*a, *b);
    middle.is_finite().then_some(middle)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_of_a_known_list() {
        let summary = DistanceSummary::of([-0.3, 0.1, 0.2, 0.0, 1.0]).unwrap();
        assert_eq!(summary.count, 5);
        // Absolute values 0, 0.1, 0.2, 0.3, 1; signed -0.3, 0, 0.1, 0.2, 1.
        assert!((summary.median - 0.2).abs() < 1e-6);
        assert!((summary.offset - 0.1).abs() < 1e-6);
        assert!((summary.p90 - 0.72).abs() < 1e-6);
        assert!((summary.rmse - (1.14_f64 / 5.0).sqrt()).abs() < 1e-6);
        assert_eq!([summary.within_0_1, summary.within_0_2, summary.within_0_5], [0.4, 0.6, 0.8]);
        assert!(DistanceSummary::of([]).is_none());
    }

    #[test]
    fn the_median_of_an_even_number_is_the_middle() {
        assert_eq!(median([4.0, 1.0, 3.0, 2.0]), Some(2.5));
        assert_eq!(median([7.0]), Some(7.0));
        assert_eq!(median([]), None);
    }
}
