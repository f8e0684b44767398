//! The points as detection sees them: in an order that does not depend on the input's, without duplicates, not denser
//! than needed.

use nalgebra::{Point3, Vector3};

/// Distinct finite points, ordered by x, y, z.
///
/// The canonical order makes detection independent of the order of the input, down to ties between neighbours. Exact
/// duplicates share one entry and hence one primitive.
#[derive(Debug, Clone)]
pub(super) struct Cloud {
    /// The distinct points.
    pub points: Vec<Point3<f64>>,
    /// For each distinct point, where its input indices start in `originals`; one more entry at the end.
    starts: Vec<u32>,
    originals: Vec<u32>,
}

impl Cloud {
    /// The cloud of some points; points that are not finite are left out.
    pub fn new(input: &[Point3<f64>]) -> Self {
        // Adding zero turns −0 into +0, which the total order below would tell apart.
        let clean = |p: &Point3<f64>| p + Vector3::zeros();
        let mut order: Vec<(Point3<f64>, u32)> = input
            .iter()
            .zip(0u32..)
            .filter(|(p, _)| p.coords.iter().all(|c| c.is_finite()))
            .map(|(p, i)| (clean(p), i))
            .collect();
        order.sort_unstable_by(|(a, i), (b, j)| {
            a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)).then(i.cmp(j))
        });
        let mut cloud = Self {
            points: Vec::with_capacity(order.len()),
            starts: Vec::with_capacity(order.len() + 1),
            originals: Vec::with_capacity(order.len()),
        };
        for (point, original) in order {
            if cloud.points.last() != Some(&point) {
                cloud.points.push(point);
                cloud.starts.push(cloud.originals.len() as u32);
            }
            cloud.originals.push(original);
        }
        cloud.starts.push(cloud.originals.len() as u32);
        cloud
    }

    /// Indices in the input of one of the distinct points.
    pub fn originals(&self, index: usize) -> &[u32] {
        &self.originals[self.starts[index] as usize..self.starts[index + 1] as usize]
    }

    /// Indices of the points to detect on, ascending, and for every point the position in that list of its
    /// representative. `None` when the cloud is sparse enough to be used whole.
    pub fn thin(&self, maximum_density: f64) -> Option<Thinned> {
        /// Below this, thinning saves less than it costs.
        const WORTHWHILE: usize = 2_000;
        if self.points.len() < WORTHWHILE {
            return None;
        }
        let metre = self.columns([1.0; 3]);
        let occupied = 1 + metre.windows(2).filter(|pair| pair[0].0 != pair[1].0).count();
        if self.points.len() as f64 <= maximum_density * occupied as f64 {
            return None;
        }
        // Flat boxes would keep every layer of a noisy surface; tall ones thin noise as well and still sample walls.
        let side = maximum_density.max(1.0).sqrt().recip();
        let mut representative = vec![0u32; self.points.len()];
        let mut keepers: Vec<u32> = Vec::new();
        let mut previous = None;
        for (key, index) in self.columns([side, side, 3.0 * side]) {
            if previous != Some(key) {
                keepers.push(index);
                previous = Some(key);
            }
            representative[index as usize] = keepers.last().copied().unwrap_or(index);
        }
        keepers.sort_unstable();
        let mut position = vec![0u32; self.points.len()];
        for (keeper, slot) in keepers.iter().zip(0u32..) {
            position[*keeper as usize] = slot;
        }
        for r in &mut representative {
            *r = position[*r as usize];
        }
        Some(Thinned { keepers, representative })
    }

    /// Every point with the box of this size that holds it, ordered by box and then by point.
    fn columns(&self, size: [f64; 3]) -> Vec<([i64; 3], u32)> {
        let cell = |p: &Point3<f64>| [0, 1, 2].map(|axis| (p[axis] / size[axis]).floor() as i64);
        let mut cells: Vec<_> = self.points.iter().zip(0u32..).map(|(p, i)| (cell(p), i)).collect();
        cells.sort_unstable();
        cells
    }
}

/// A thinned cloud.
#[derive(Debug, Clone)]
pub(super) struct Thinned {
    /// Indices of the points that were kept, ascending.
    pub keepers: Vec<u32>,
    /// For every point of the cloud, the position in `keepers` of the point that stands for it.
    pub representative: Vec<u32>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_and_duplicates_of_the_input_leave_no_trace() {
        let p = |x: f64| Point3::new(x, 0.0, -x);
        let a = Cloud::new(&[p(2.0), p(1.0), Point3::new(f64::NAN, 0.0, 0.0), p(2.0)]);
        let b = Cloud::new(&[p(1.0), p(2.0)]);
        assert_eq!(a.points, b.points);
        assert_eq!(a.originals(0), [1]);
        assert_eq!(a.originals(1), [0, 3]);
        let zeros = Cloud::new(&[Point3::new(0.0, 1.0, 0.0), Point3::new(-0.0, 1.0, -0.0)]);
        assert_eq!(zeros.points.len(), 1);
    }

    #[test]
    fn thinning_reaches_the_density_and_keeps_every_place() {
        // 100 points per square metre on 10 × 10 m.
        let points: Vec<_> =
            (0..10_000).map(|i| Point3::new(f64::from(i % 100) / 10.0, f64::from(i / 100) / 10.0, 3.0)).collect();
        let cloud = Cloud::new(&points);
        let thinned = cloud.thin(25.0).unwrap();
        assert!((2_400..=2_700).contains(&thinned.keepers.len()), "{}", thinned.keepers.len());
        for (point, &slot) in cloud.points.iter().zip(&thinned.representative) {
            let keeper = &cloud.points[thinned.keepers[slot as usize] as usize];
            assert!((point - keeper).norm() < 0.3);
        }
        assert!(cloud.thin(150.0).is_none());
    }
}
