//! A plane through noisy heights that a few wrong ones do not move.

use nalgebra::{Matrix3, Vector3};

/// Noise below this is not believed, metres: laser points do not repeat better, and coordinates are rounded.
pub(super) const LEAST_NOISE: f64 = 0.005;
/// Turns the median distance from the fit into the standard deviation of normal noise.
const MEDIAN_TO_SIGMA: f64 = 1.4826;
/// From so many standard deviations on a point does not count: the biweight, with 95 % of the efficiency of least squares.
const BIWEIGHT: f64 = 4.685;
/// Rounds of least distances, from which the spread is known, and of the biweight after it.
const ROUNDS: [usize; 2] = [20, 6];
/// Rounds that change height (metres) and slopes by less than this are the last.
const SETTLED: f64 = 1e-3;
/// What a slope costs, square metres: where points lie on a line they say nothing of the slope across it.
const SLOPE_COST: f64 = 0.03;

/// Whether the fit may slope.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    /// Horizontal.
    Level,
    /// A plane.
    Plane,
}

/// A fitted plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Fit {
    about: [f64; 2],
    /// Height at `about`, and how much it grows per metre of x and of y.
    coefficients: [f64; 3],
    /// Lowest and highest point that counted.
    range: [f64; 2],
}

impl Fit {
    /// The fit to `points`, each with a weight; `None` without any. Places are told relative to `about`.
    ///
    /// First the plane of least distances, which a minority of wrong heights hardly moves; then, from the spread about
    /// it, least squares in which points count the less the farther they lie off, and those farther than 4.7 standard
    /// deviations not at all.
    pub fn of(points: &[([f64; 3], f64)], about: [f64; 2], shape: Shape) -> Option<Self> {
        let start = median(points.iter().map(|(p, weight)| (p[2], *weight)))?;
        let mut fit = Self { about, coefficients: [start, 0.0, 0.0], range: [f64::MIN, f64::MAX] };
        if shape == Shape::Plane {
            for _ in 0..ROUNDS[0] {
                if fit.reweighted(points, shape, |off| 1.0 / off.abs().max(LEAST_NOISE)) < SETTLED {
                    break;
                }
            }
        }
        let off = median(points.iter().map(|(p, weight)| (fit.off(p).abs(), *weight)))?;
        let limit = BIWEIGHT * (MEDIAN_TO_SIGMA * off).max(LEAST_NOISE);
        for _ in 0..ROUNDS[1] {
            if fit.reweighted(points, shape, |off| (1.0 - (off / limit).powi(2)).max(0.0).powi(2)) < SETTLED {
                break;
            }
        }
        let counted = points.iter().filter(|(p, weight)| *weight > 0.0 && fit.off(p).abs() < limit).map(|(p, _)| p[2]);
        let range = counted.fold([f64::MAX, f64::MIN], |[low, high], z| [low.min(z), high.max(z)]);
        Some(if range[0] <= range[1] { Self { range, ..fit } } else { fit })
    }

    /// The height at a place; never beyond those of the points that counted.
    pub fn at(&self, place: [f64; 2]) -> f64 {
        self.unlimited(place).clamp(self.range[0], self.range[1])
    }

    fn unlimited(&self, place: [f64; 2]) -> f64 {
        let [height, along_x, along_y] = self.coefficients;
        height + along_x * (place[0] - self.about[0]) + along_y * (place[1] - self.about[1])
    }

    fn off(&self, point: &[f64; 3]) -> f64 {
        point[2] - self.unlimited([point[0], point[1]])
    }

    /// Least squares with every point weighted by its distance from the fit so far, too. Returns the largest change of a
    /// coefficient.
    fn reweighted(&mut self, points: &[([f64; 3], f64)], shape: Shape, weight_of: impl Fn(f64) -> f64) -> f64 {
        let (mut normal, mut right) = (Matrix3::zeros(), Vector3::zeros());
        for (p, weight) in points {
            let weight = weight * weight_of(self.off(p));
            let row = match shape {
                Shape::Level => Vector3::new(1.0, 0.0, 0.0),
                Shape::Plane => Vector3::new(1.0, p[0] - self.about[0], p[1] - self.about[1]),
            };
            normal += weight * row * row.transpose();
            right += weight * p[2] * row;
        }
        let cost = SLOPE_COST * normal[(0, 0)] / points.len().max(1) as f64;
        for axis in 1..3 {
            normal[(axis, axis)] += cost.max(f64::MIN_POSITIVE);
        }
        if normal[(0, 0)] <= 0.0 {
            return 0.0;
        }
        if let Some(found) = normal.cholesky().map(|factors| factors.solve(&right))
            && found.iter().all(|value| value.is_finite())
        {
            let before = std::mem::replace(&mut self.coefficients, found.into());
            return before.iter().zip(&self.coefficients).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        }
        0.0
    }
}

/// The weighted median; `None` where nothing weighs.
pub(super) fn median(values: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let mut sorted: Vec<(f64, f64)> = values.filter(|(_, weight)| *weight > 0.0).collect();
    sorted.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * sorted.iter().map(|(_, weight)| weight).sum::<f64>();
    let mut sum = 0.0;
    let upper = sorted.iter().position(|(_, weight)| {
        sum += weight;
        sum >= half
    })?;
    // Halfway between two values where as much lies below as above.
    let next = if sum > half { upper } else { (upper + 1).min(sorted.len() - 1) };
    Some(0.5 * (sorted[upper].0 + sorted[next].0))
}

/// The standard deviation of normal noise with these distances from the truth.
pub(super) fn sigma(distances: impl Iterator<Item = f64>) -> f64 {
    MEDIAN_TO_SIGMA * median(distances.map(|distance| (distance.abs(), 1.0))).unwrap_or(0.0)
}

/// How much a point this far off costs, 0 to 1: 1 from where on it does not count.
pub(super) fn loss(off: f64, sigma: f64) -> f64 {
    1.0 - (1.0 - (off / (BIWEIGHT * sigma)).powi(2)).max(0.0).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Random;

    fn slope(seed: u64, noise: f64) -> Vec<([f64; 3], f64)> {
        let mut random = Random::new(seed);
        let mut point = |x: f64, y: f64| ([x, y, 3.0 + 0.2 * x - 0.5 * y + noise * random.bell()], 1.0);
        (0..80).map(|i| point(f64::from(i % 10), f64::from(i / 10))).collect()
    }

    #[test]
    fn a_plane_is_found_in_spite_of_noise_pits_and_walls() {
        let mut points = slope(7, 0.03);
        for (i, (p, _)) in points.iter_mut().enumerate().filter(|(i, _)| i % 5 == 0) {
            p[2] += if i % 2 == 0 { -20.0 } else { 1.5 };
        }
        let fit = Fit::of(&points, [5.0, 5.0], Shape::Plane).unwrap();
        assert!((fit.at([5.0, 4.0]) - 2.0).abs() < 0.015, "{fit:?}");
        // Far away it keeps to the heights that it has seen.
        assert!(fit.at([500.0, -500.0]) < 5.0);
    }

    #[test]
    fn points_on_a_line_say_nothing_of_the_slope_across() {
        let points: Vec<_> = (0..20).map(|i| ([f64::from(i) * 0.5, 0.0, 1.0 + 0.05 * f64::from(i)], 1.0)).collect();
        let fit = Fit::of(&points, [0.0; 2], Shape::Plane).unwrap();
        assert!((fit.at([5.0, 0.0]) - 1.5).abs() < 0.01 && (fit.at([5.0, 3.0]) - 1.5).abs() < 0.01, "{fit:?}");
        assert!(Fit::of(&[], [0.0; 2], Shape::Plane).is_none());
    }

    #[test]
    fn medians_lie_in_the_middle() {
        let of = |values: &[f64]| median(values.iter().map(|value| (*value, 1.0)));
        assert_eq!((of(&[3.0, 1.0, 2.0]), of(&[4.0, 1.0, 2.0, 3.0]), of(&[])), (Some(2.0), Some(2.5), None));
        assert_eq!(median([(1.0, 1.0), (5.0, 4.0)].into_iter()), Some(5.0));
    }
}
