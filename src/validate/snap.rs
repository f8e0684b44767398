//! When two places on a grid are one.

/// Beyond this share of the snap tolerance a difference is one of the places, and not of the numbers that tell the
/// tolerance and the step.
const EXACT: f64 = 1e-9;

/// The snap tolerance on a grid: places no farther apart are one.
///
/// Compared are squared distances in squared steps. On a grid whose step is the same along all axes these are whole numbers,
/// so that a distance of exactly the tolerance is one wherever the two places are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Snap {
    /// Squared steps along each axis in squares of the smallest.
    weights: [f64; 3],
    /// The most that a squared distance may be.
    most: f64,
    /// How many steps along each axis two places may be apart and one.
    reach: [i64; 3],
}

impl Snap {
    /// `snap` metres on a grid of `step` metres.
    pub(crate) fn new(step: [f64; 3], snap: f64) -> Self {
        let smallest = step.iter().fold(f64::INFINITY, |least, s| least.min(*s));
        Self {
            weights: step.map(|s| (s / smallest).powi(2)),
            most: (snap / smallest).powi(2) * (1.0 + EXACT),
            reach: step.map(|s| (snap / s * (1.0 + EXACT)) as i64),
        }
    }

    /// How many steps along each axis two places may be apart and one.
    pub(crate) fn reach(&self) -> [i64; 3] {
        self.reach
    }

    /// A measure of the distance of two places, if they are one.
    pub(crate) fn joins(&self, a: [i64; 3], b: [i64; 3]) -> Option<f64> {
        let squared: f64 = (0..3).map(|i| self.weights[i] * ((a[i] - b[i]) as f64).powi(2)).sum();
        (squared <= self.most).then_some(squared)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn exactly_the_tolerance_is_one() {
        for (step, at) in [(0.001, [1, 0, 0]), (0.0001, [0, 10, 0]), (0.0002, [3, 0, -4]), (1e-6, [600, -800, 0])] {
            let snap = Snap::new([step; 3], 0.001);
            assert!(snap.joins([0; 3], at).is_some(), "{step}");
            assert!(snap.joins([0; 3], at.map(|c: i64| c + c.signum())).is_none(), "{step}");
        }
        let none = Snap::new([0.001; 3], 0.0);
        assert!(none.joins([5; 3], [5; 3]).is_some() && none.joins([5; 3], [5, 5, 6]).is_none());
        assert_eq!(Snap::new([0.001, 0.001, 0.0005], 0.001).reach(), [1, 1, 2]);
    }

    proptest! {
        #[test]
        fn it_is_a_comparison_of_whole_numbers(
            decimals in 3..7i32,
            at in prop::array::uniform3(-1_000_000_000..1_000_000_000i64),
            by in prop::array::uniform3(-1_200..1_200i64),
        ) {
            let steps_of_snap = 10i64.pow(decimals as u32 - 3);
            let by = by.map(|b| b * 3 / 2 * steps_of_snap / 1_000);
            let snap = Snap::new([10f64.powi(-decimals); 3], 0.001);
            let there = std::array::from_fn(|i| at[i] + by[i]);
            let whole: i64 = by.iter().map(|b| b * b).sum();
            prop_assert_eq!(snap.joins(at, there).is_some(), whole <= steps_of_snap * steps_of_snap);
        }
    }
}
