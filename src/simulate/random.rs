//! Draws of a simulation: the same on every machine, and for every scan its own sequence.

use nalgebra::{Point3, Vector3};

pub(super) use crate::geometry::{Random, hash};

/// What a simulation draws beside.
pub(super) trait Draw {
    /// A number of the normal distribution with mean 0 and standard deviation 1.
    fn normal(&mut self) -> f64;

    /// A direction, all equally likely.
    fn direction(&mut self) -> Vector3<f64>;

    /// A point of a triangle, all equally likely.
    fn in_triangle(&mut self, triangle: &[Point3<f64>; 3]) -> Point3<f64>;
}

impl Draw for Random {
    fn normal(&mut self) -> f64 {
        // Box and Muller.
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }

    fn direction(&mut self) -> Vector3<f64> {
        let z = self.between(-1.0, 1.0);
        let angle = self.between(0.0, std::f64::consts::TAU);
        let across = (1.0 - z * z).max(0.0).sqrt();
        Vector3::new(across * angle.cos(), across * angle.sin(), z)
    }

    fn in_triangle(&mut self, [a, b, c]: &[Point3<f64>; 3]) -> Point3<f64> {
        let (mut u, mut v) = (self.unit(), self.unit());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        a + (b - a) * u + (c - a) * v
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_normal_distribution_has_its_moments() {
        let mut random = Random::new(3);
        let draws: Vec<f64> = (0..20_000).map(|_| random.normal()).collect();
        let moment = |power: i32| draws.iter().map(|x| x.powi(power)).sum::<f64>() / draws.len() as f64;
        // Standard errors: 0.007, 0.01 and 0.07.
        assert!(moment(1).abs() < 0.03 && (moment(2) - 1.0).abs() < 0.04 && (moment(4) - 3.0).abs() < 0.3);
    }

    #[test]
    fn texts_have_their_own_sequences() {
        assert_ne!(hash(1, "a"), hash(2, "a"));
        assert_ne!(hash(1, "a"), hash(1, "b"));
        assert_eq!(hash(1, "a"), hash(1, "a"));
    }
}
