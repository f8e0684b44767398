//! A plane in floating point.

use nalgebra::{Matrix3, Point3, Unit, Vector3};

/// The plane `normal · x + offset = 0`, with a unit normal, in metres of the local frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Plane {
    /// Unit normal. Roof planes point up.
    pub normal: Unit<Vector3<f64>>,
    /// Signed distance of the plane from the origin, negated.
    pub offset: f64,
}

impl Plane {
    /// The plane through `point` with this normal.
    pub fn through(point: &Point3<f64>, normal: Unit<Vector3<f64>>) -> Self {
        Self { normal, offset: -normal.dot(&point.coords) }
    }

    /// Least-squares plane of at least three points that are not on a line, pointing up; the root mean square of the
    /// orthogonal residuals comes with it. The normal is the third principal axis (method: section 3.1 of the paper).
    pub fn fit<'a>(points: impl IntoIterator<Item = &'a Point3<f64>> + Clone) -> Option<(Self, f64)> {
        let mut count = 0.0;
        let mut sum = Vector3::zeros();
        for p in points.clone() {
            count += 1.0;
            sum += p.coords;
        }
        if count < 3.0 {
            return None;
        }
        let mean = sum / count;
        let mut covariance = Matrix3::zeros();
        for p in points {
            let d = p.coords - mean;
            covariance += d * d.transpose();
        }
        let eigen = (covariance / count).symmetric_eigen();
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let [least, middle, most] = axes;
        if eigen.eigenvalues[middle] <= 1e-9 * eigen.eigenvalues[most].max(1e-12) {
            return None;
        }
        let normal: Vector3<f64> = eigen.eigenvectors.column(least).into();
        let normal = Unit::try_new(if normal.z < 0.0 { -normal } else { normal }, 1e-12)?;
        Some((Self::through(&Point3::from(mean), normal), eigen.eigenvalues[least].max(0.0).sqrt()))
    }

    /// Signed orthogonal distance of `point`, in metres; positive on the side of the normal.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        self.normal.dot(&point.coords) + self.offset
    }

    /// The same point set seen from the other side.
    #[must_use]
    pub fn flipped(&self) -> Self {
        Self { normal: -self.normal, offset: -self.offset }
    }

    /// Height of the plane above `(x, y)`; `None` when it is vertical within 1e-6.
    pub fn height_at(&self, x: f64, y: f64) -> Option<f64> {
        let n = &self.normal;
        (n.z.abs() > 1e-6).then(|| -(n.x * x + n.y * y + self.offset) / n.z)
    }

    /// Verticality `1 − |n_z|` (paper, section 3.2): 1 for a wall, 0 for a flat roof.
    pub fn verticality(&self) -> f64 {
        1.0 - self.normal.z.abs()
    }

    /// Angle to the horizontal in degrees, 0 to 90.
    pub fn slope_degrees(&self) -> f64 {
        self.normal.z.abs().clamp(0.0, 1.0).acos().to_degrees()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fit_finds_a_tilted_plane_and_points_up() {
        let points: Vec<_> = (0..100)
            .map(|i| {
                let (x, y) = (f64::from(i % 10), f64::from(i / 10));
                Point3::new(x, y, 3.0 + 0.5 * x - 0.25 * y)
            })
            .collect();
        let (plane, rms) = Plane::fit(&points).unwrap();
        assert!(rms < 1e-7 && plane.normal.z > 0.0);
        assert!((plane.height_at(20.0, -4.0).unwrap() - 14.0).abs() < 1e-9);
    }

    #[test]
    fn fit_refuses_points_on_a_line() {
        let line: Vec<_> = (0..10).map(|i| Point3::new(f64::from(i), 2.0 * f64::from(i), 1.0)).collect();
        assert!(Plane::fit(&line).is_none());
        assert!(Plane::fit(&line[..2]).is_none());
    }
}
