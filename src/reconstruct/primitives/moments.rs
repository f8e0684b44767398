//! Sums from which a least-squares plane follows: planes are refitted and merged without visiting the points again.

use nalgebra::{Matrix3, Point3, Unit, Vector3};

use crate::geometry::Plane;

/// Count, sum and sum of products of some points, relative to an anchor near them (for the sake of precision: CRS
/// coordinates squared would leave centimetres of rounding). Only moments with the same anchor can be merged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Moments {
    anchor: Point3<f64>,
    count: f64,
    sum: Vector3<f64>,
    products: Matrix3<f64>,
}

/// A least-squares plane and how well the points determine it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Fit {
    /// The plane, pointing up.
    pub plane: Plane,
    /// Root mean square of the orthogonal residuals, metres.
    pub rms: f64,
    /// Standard deviation of the points along the minor axis in the plane, metres: how wide the patch is.
    pub width: f64,
}

impl Moments {
    /// Of no point.
    pub fn new(anchor: Point3<f64>) -> Self {
        Self { anchor, count: 0.0, sum: Vector3::zeros(), products: Matrix3::zeros() }
    }

    /// Of the points with these indices.
    pub fn of(anchor: Point3<f64>, points: &[Point3<f64>], indices: &[u32]) -> Self {
        let mut moments = Self::new(anchor);
        for &i in indices {
            moments.add(&points[i as usize]);
        }
        moments
    }

    /// Adds a point.
    pub fn add(&mut self, point: &Point3<f64>) {
        let d = point - self.anchor;
        self.count += 1.0;
        self.sum += d;
        // Six products instead of an outer product: this is the innermost loop of every fit.
        let p = &mut self.products;
        p.m11 += d.x * d.x;
        p.m12 += d.x * d.y;
        p.m13 += d.x * d.z;
        p.m22 += d.y * d.y;
        p.m23 += d.y * d.z;
        p.m33 += d.z * d.z;
    }

    /// Adds the points of another set with the same anchor.
    pub fn merge(&mut self, other: &Self) {
        debug_assert_eq!(self.anchor, other.anchor);
        self.count += other.count;
        self.sum += other.sum;
        self.products += other.products;
    }

    /// Number of points.
    pub fn count(&self) -> f64 {
        self.count
    }

    /// Mean of the points; the anchor without any.
    pub fn mean(&self) -> Point3<f64> {
        self.anchor + self.sum / self.count.max(1.0)
    }

    fn covariance(&self) -> Matrix3<f64> {
        let n = self.count.max(1.0);
        let m = self.sum / n;
        let p = &self.products;
        let (xy, xz, yz) = (p.m12 / n - m.x * m.y, p.m13 / n - m.x * m.z, p.m23 / n - m.y * m.z);
        let (xx, yy, zz) = (p.m11 / n - m.x * m.x, p.m22 / n - m.y * m.y, p.m33 / n - m.z * m.z);
        Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)
    }

    /// Least-squares plane; `None` for fewer than three points or points on a line (method, section 2: the third
    /// principal axis is the normal).
    pub fn fit(&self) -> Option<Fit> {
        if self.count < 3.0 {
            return None;
        }
        let eigen = self.covariance().symmetric_eigen();
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
        let [least, middle, most] = axes.map(|axis| eigen.eigenvalues[axis].max(0.0));
        if middle <= 1e-9 * most.max(1e-9) {
            return None;
        }
        let normal: Vector3<f64> = eigen.eigenvectors.column(axes[0]).into();
        let normal = Unit::try_new(if points_down(&normal) { -normal } else { normal }, 1e-12)?;
        Some(Fit { plane: Plane::through(&self.mean(), normal), rms: least.sqrt(), width: middle.sqrt() })
    }

    /// Mean square of the orthogonal distances to a plane, square metres.
    pub fn mean_square(&self, plane: &Plane) -> f64 {
        let n = plane.normal.as_ref();
        let offset = plane.distance(&self.mean());
        (n.dot(&(self.covariance() * n)) + offset * offset).max(0.0)
    }
}

/// Whether a normal is the wrong one of the two: roofs point up, and vertical planes to a side that does not depend on
/// rounding.
fn points_down(normal: &Vector3<f64>) -> bool {
    if normal.z.abs() > 1e-9 { normal.z < 0.0 } else { normal.x + 1e-9 * normal.y < 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_from_the_origin_a_fit_keeps_its_millimetres() {
        let anchor = Point3::new(446_000.0, 5_500_000.0, 40.0);
        let mut moments = [Moments::new(anchor), Moments::new(anchor)];
        for i in 0..200 {
            let (x, y) = (f64::from(i % 20), f64::from(i / 20));
            let z = 0.5 * x - 0.25 * y + if i % 2 == 0 { 0.01 } else { -0.01 };
            moments[usize::from(i >= 90)].add(&(anchor + Vector3::new(x, y, z)));
        }
        let [mut all, rest] = moments;
        all.merge(&rest);
        let fit = all.fit().unwrap();
        // ±1 cm along z is ±1 cm · n_z across the plane; the alternation correlates a little with x.
        let vertical = fit.rms / fit.plane.normal.z;
        assert!((vertical - 0.01).abs() < 1e-4, "{vertical}");
        assert!((all.mean_square(&fit.plane).sqrt() - fit.rms).abs() < 1e-6);
        let raised = Plane { offset: fit.plane.offset - 0.3, ..fit.plane };
        assert!((all.mean_square(&raised) - fit.rms.powi(2) - 0.09).abs() < 1e-6);
    }
}
