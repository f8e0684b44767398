//! The nearest neighbours of every point: the ground on which normals and connectivity stand.

use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use nalgebra::Point3;

/// The k nearest neighbours of every point of a cloud, nearest first.
#[derive(Debug, Clone)]
pub struct Neighbours {
    width: usize,
    indices: Vec<u32>,
    radii: Vec<f64>,
}

impl Neighbours {
    /// The `k` nearest neighbours of every point, itself not among them; fewer when there are not so many points.
    ///
    /// Neighbours at the same distance come in the order of their indices. The points should be finite and distinct;
    /// of more than `k` neighbours at the same distance, which are taken depends on the order of the points alone.
    pub fn new(points: &[Point3<f64>], k: usize) -> Self {
        let width = k.min(points.len().saturating_sub(1));
        let mut this = Self { width, indices: Vec::new(), radii: vec![0.0; points.len()] };
        let coordinates: Vec<[f64; 3]> = points.iter().map(|p| [p.x, p.y, p.z]).collect();
        // Construction fails for more points than `u32` can count, which no building has: without neighbours nothing
        // is detected there.
        let (Ok(tree), Some(quantity)) =
            (ImmutableKdTree::<f64, 3>::new_from_slice(&coordinates), NonZero::new(width + 1).filter(|_| width > 0))
        else {
            this.width = 0;
            return this;
        };
        this.indices.reserve_exact(points.len() * width);
        for (i, query) in coordinates.iter().enumerate() {
            let mut found = tree.query(query).nearest_n::<SquaredEuclidean<f64>>(quantity).execute();
            found.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.item.cmp(&b.item)));
            let start = this.indices.len();
            for near in found.iter().filter(|near| near.item as usize != i).take(width) {
                this.indices.push(near.item);
                this.radii[i] = near.distance.sqrt();
            }
            // A tree that found fewer would shift everything behind: repeat the point itself instead.
            this.indices.resize(start + width, i as u32);
        }
        this
    }

    /// How many neighbours each point has.
    pub fn width(&self) -> usize {
        self.width
    }

    /// The neighbours of a point, nearest first.
    pub fn of(&self, index: u32) -> &[u32] {
        let start = index as usize * self.width;
        &self.indices[start..start + self.width]
    }

    /// Distance of the farthest of the neighbours of a point, metres.
    pub fn radius(&self, index: u32) -> f64 {
        self.radii[index as usize]
    }

    /// Median density of the points on the surface they sample, in points per square metre; 0 for fewer than two
    /// points.
    pub fn density(&self) -> f64 {
        let mut radii = self.radii.clone();
        if self.width == 0 || radii.is_empty() {
            return 0.0;
        }
        let middle = radii.len() / 2;
        let (_, median, _) = radii.select_nth_unstable_by(middle, f64::total_cmp);
        self.width as f64 / (std::f64::consts::PI * median.max(1e-6).powi(2))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn brute(points: &[Point3<f64>], i: usize, k: usize) -> Vec<f64> {
        let mut all: Vec<f64> =
            (0..points.len()).filter(|&j| j != i).map(|j| (points[i] - points[j]).norm_squared()).collect();
        all.sort_by(f64::total_cmp);
        all.truncate(k);
        all
    }

    #[test]
    fn a_wall_of_points_on_one_x_is_searched_correctly() {
        // Ties everywhere and one value of x throughout: what overflows the buckets of some k-d trees.
        let wall: Vec<_> =
            (0..5_000).map(|i| Point3::new(7.0, f64::from(i % 100) * 0.5, f64::from(i / 100) * 0.5)).collect();
        let neighbours = Neighbours::new(&wall, 8);
        for i in [0usize, 99, 2_550, 4_999] {
            let found: Vec<f64> =
                neighbours.of(i as u32).iter().map(|&j| (wall[i] - wall[j as usize]).norm_squared()).collect();
            assert_eq!(found, brute(&wall, i, 8), "point {i}");
        }
        assert_eq!(neighbours.of(2_550)[..4], [2_450, 2_549, 2_551, 2_650], "ties come in the order of indices");
        assert!((neighbours.density() - 8.0 / (std::f64::consts::PI * 0.5)).abs() < 1e-9);
    }

    #[test]
    fn few_points_have_few_neighbours() {
        assert_eq!(Neighbours::new(&[], 8).width(), 0);
        assert_eq!(Neighbours::new(&[Point3::origin()], 8).width(), 0);
        let three: Vec<_> = (0..3).map(|i| Point3::new(f64::from(i), 0.0, 0.0)).collect();
        let neighbours = Neighbours::new(&three, 8);
        assert_eq!((neighbours.width(), neighbours.of(2)), (2, &[1, 0][..]));
    }
}
