//! An octree over the points that RANSAC has not used yet, for samples that lie close together.

use std::ops::Range;

use nalgebra::Point3;

use crate::geometry::Aabb;

/// A linear octree: points in Morton order, so that every cell of every level is a range.
#[derive(Debug, Clone)]
pub(super) struct Octree {
    /// Morton code at the deepest level and point index, ascending.
    entries: Vec<(u64, u32)>,
    /// Code of each point.
    codes: Vec<u64>,
    depth: u32,
}

impl Octree {
    /// The octree of some points down to cells of about `leaf` metres, at most ten levels.
    pub fn new(points: &[Point3<f64>], leaf: f64) -> Self {
        let (min, side) =
            Aabb::of(points).map_or(([0.0; 3], 1.0), |aabb| (aabb.min, aabb.extent().into_iter().fold(1e-6, f64::max)));
        let depth = (side / leaf.max(1e-6)).log2().ceil().clamp(1.0, 10.0) as u32;
        let cells = f64::from(1u32 << depth);
        let code = |p: &Point3<f64>| {
            let [x, y, z] = [0, 1, 2].map(|axis| (((p[axis] - min[axis]) / side * cells) as u64).min((1 << depth) - 1));
            (0..depth)
                .fold(0, |code, bit| code | ((x >> bit & 1) | (y >> bit & 1) << 1 | (z >> bit & 1) << 2) << (3 * bit))
        };
        let codes: Vec<u64> = points.iter().map(code).collect();
        let mut entries: Vec<(u64, u32)> = codes.iter().copied().zip(0..).collect();
        entries.sort_unstable();
        Self { entries, codes, depth }
    }

    /// Number of levels; level 0 is the whole cloud.
    pub fn levels(&self) -> usize {
        self.depth as usize + 1
    }

    /// Number of points that are left.
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// One of the points that are left, by its place in Morton order.
    pub fn point(&self, place: usize) -> u32 {
        self.entries[place].1
    }

    /// The places of the points in the cell of this level that holds a point.
    pub fn cell(&self, point: u32, level: usize) -> Range<usize> {
        let shift = 3 * (u64::from(self.depth) - level as u64);
        let cell = self.codes[point as usize] >> shift;
        let start = self.entries.partition_point(|(code, _)| code >> shift < cell);
        let end = self.entries.partition_point(|(code, _)| code >> shift <= cell);
        start..end
    }

    /// Takes out the points for which `keep` is false.
    pub fn retain(&mut self, keep: impl Fn(u32) -> bool) {
        self.entries.retain(|(_, point)| keep(*point));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_hold_exactly_the_points_of_their_octant() {
        let points: Vec<_> = (0..512)
            .map(|i| Point3::new(f64::from(i % 8) + 0.5, f64::from(i / 8 % 8) + 0.5, f64::from(i / 64) + 0.5))
            .collect();
        let mut tree = Octree::new(&points, 1.0);
        assert_eq!(tree.levels(), 4);
        // 7 m over 8 cells of 0.875 m: the first half of each axis holds the four coordinates up to 3.5 + 0.5.
        let octant: Vec<u32> = tree.cell(0, 1).map(|place| tree.point(place)).collect();
        assert_eq!(octant.len(), 64);
        assert!(octant.iter().all(|&i| points[i as usize].coords.max() < 4.0));
        assert_eq!(tree.cell(100, 0), 0..512);
        assert_eq!(tree.cell(100, 3).len(), 1);
        tree.retain(|i| i % 2 == 0);
        assert_eq!((tree.len(), tree.cell(0, 1).len()), (256, 32));
    }
}
