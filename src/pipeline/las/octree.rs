//! The octree of a COPC file (COPC 1.0): which points go into which node.
//!
//! A node thins its points: of those in one of its 128³ cells the one nearest to the middle of the cell stays, the others
//! go to the eight nodes below. So each level shows the whole cloud, twice as fine as the one above. Small sets are not
//! parted any further.

use std::collections::HashMap;

use foldhash::fast::FixedState;
use las::copc::VoxelKey;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Cells of a node along each axis.
pub(in crate::pipeline) const CELLS: f64 = 128.0;
/// Sets of so many points stay together.
const LEAF: usize = 1 << 15;
/// Sets below a node that are smaller than this stay in it: a node of its own would cost more than it saves.
const FEWEST: usize = 256;
/// The deepest level: 2²⁰ nodes along each axis, so that points at one and the same place come to an end.
const DEEPEST: i32 = 20;

/// The cube that the root stands for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::pipeline) struct Cube {
    /// Its middle.
    pub centre: [f64; 3],
    /// Half its side.
    pub half: f64,
}

/// A node with points.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::pipeline) struct Node {
    /// Its level and place.
    pub key: VoxelKey,
    /// The numbers of its points, ascending.
    pub points: Vec<u32>,
}

impl Cube {
    /// The cube around a box, with room on all sides: `room` is less than what can be told apart.
    pub fn around(low: [f64; 3], high: [f64; 3], room: f64) -> Self {
        let side = (0..3).fold(0.0, |side: f64, axis| side.max(high[axis] - low[axis]));
        Self { centre: std::array::from_fn(|axis| low[axis].midpoint(high[axis])), half: side / 2.0 + room }
    }

    /// The distance between points in the root.
    pub fn spacing(&self) -> f64 {
        2.0 * self.half / CELLS
    }

    /// The lower corner of a node and its side.
    fn node(&self, key: VoxelKey) -> ([f64; 3], f64) {
        let side = 2.0 * self.half / f64::from(1_u32 << key.l);
        let place = [key.x, key.y, key.z].map(f64::from);
        (std::array::from_fn(|axis| self.centre[axis] - self.half + place[axis] * side), side)
    }

    /// The nodes with the points at these positions, level after level; `None` when interrupted.
    pub fn nodes(&self, positions: &[[f64; 3]], stop: &(dyn Fn() -> bool + Sync)) -> Option<Vec<Node>> {
        let mut nodes = Vec::new();
        let mut level = vec![Node { key: VoxelKey::ROOT, points: (0..positions.len() as u32).collect() }];
        while !level.is_empty() {
            let parted: Vec<Option<(Node, Vec<Node>)>> =
                level.into_par_iter().map(|node| (!stop()).then(|| self.part(node, positions))).collect();
            level = Vec::new();
            for parted in parted {
                let (node, below) = parted?;
                nodes.push(node);
                level.extend(below);
            }
        }
        Some(nodes)
    }

    /// What of a set of points stays in its node, and the sets below.
    fn part(&self, Node { key, points }: Node, positions: &[[f64; 3]]) -> (Node, Vec<Node>) {
        if points.len() <= LEAF || key.l >= DEEPEST {
            return (Node { key, points }, Vec::new());
        }
        let (low, side) = self.node(key);
        let cell = side / CELLS;
        let mut nearest: HashMap<[u8; 3], (f64, u32), FixedState> = HashMap::default();
        for &i in &points {
            let position = positions[i as usize];
            let along = [0, 1, 2].map(|axis| ((position[axis] - low[axis]) / cell).clamp(0.0, CELLS - 1.0).floor());
            let square: f64 =
                (0..3).map(|axis| (position[axis] - low[axis] - (along[axis] + 0.5) * cell).powi(2)).sum();
            let own = nearest.entry(along.map(|n| n as u8)).or_insert((square, i));
            if square < own.0 {
                *own = (square, i);
            }
        }
        let mut kept: Vec<u32> = nearest.into_values().map(|(_, i)| i).collect();
        kept.sort_unstable();
        // As the node above the middle has it, to the last bit.
        let (middle, _) = self.node(child(key, 7));
        let mut below: [Vec<u32>; 8] = std::array::from_fn(|_| Vec::new());
        for i in points {
            if kept.binary_search(&i).is_err() {
                let upper = |axis: usize| usize::from(positions[i as usize][axis] >= middle[axis]);
                below[upper(0) | upper(1) << 1 | upper(2) << 2].push(i);
            }
        }
        let mut nodes = Vec::new();
        for (octant, points) in below.into_iter().enumerate().filter(|(_, points)| !points.is_empty()) {
            if points.len() < FEWEST {
                kept.extend(points);
            } else {
                nodes.push(Node { key: child(key, octant), points });
            }
        }
        kept.sort_unstable();
        (Node { key, points: kept }, nodes)
    }
}

/// The node below another, in its octant: bit 0 for the upper half of x, 1 for that of y, 2 for that of z.
fn child(key: VoxelKey, octant: usize) -> VoxelKey {
    let place = |own: i32, axis: usize| 2 * own + (octant >> axis & 1) as i32;
    VoxelKey { l: key.l + 1, x: place(key.x, 0), y: place(key.y, 1), z: place(key.z, 2) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cloud(count: u32) -> Vec<[f64; 3]> {
        // A sheet: spread evenly, without a raster.
        let golden = 0.618_033_988_749_894_9;
        (0..count).map(|i| [f64::from(i) / 100.0, (f64::from(i) * golden).fract() * 900.0, f64::from(i % 7)]).collect()
    }

    #[test]
    fn each_point_is_in_one_node_that_holds_it() {
        let positions = cloud(90_000);
        let cube = Cube::around([0.0; 3], [900.0, 900.0, 6.0], 0.001);
        let nodes = cube.nodes(&positions, &|| false).unwrap();
        let mut all: Vec<u32> = nodes.iter().flat_map(|node| node.points.iter().copied()).collect();
        all.sort_unstable();
        assert!(all.iter().copied().eq(0..90_000));
        assert_eq!((nodes[0].key, nodes[0].points.len() > 10_000), (VoxelKey::ROOT, true));
        assert!(nodes.len() > 4);
        for node in &nodes {
            let (low, side) = cube.node(node.key);
            for &i in &node.points {
                let position = positions[i as usize];
                assert!((0..3).all(|axis| (low[axis]..=low[axis] + side).contains(&position[axis])), "{:?}", node.key);
            }
            assert!(node.points.is_sorted());
            let parent = node.key.parent();
            assert!(node.key.l == 0 || nodes.iter().any(|node| node.key == parent), "{:?}", node.key);
        }
        assert_eq!(nodes, cube.nodes(&positions, &|| false).unwrap(), "the same points, the same nodes");
        assert_eq!(cube.nodes(&positions, &|| true), None);
    }

    #[test]
    fn points_at_one_place_come_to_an_end() {
        let positions = vec![[5.0; 3]; LEAF + 100];
        let cube = Cube::around([5.0; 3], [5.0; 3], 0.001);
        let nodes = cube.nodes(&positions, &|| false).unwrap();
        assert_eq!(nodes.iter().map(|node| node.points.len()).sum::<usize>(), LEAF + 100);
        assert!(nodes.len() <= DEEPEST as usize + 1);
        let few = Cube::around([0.0; 3], [9.0; 3], 0.0).nodes(&[[1.0; 3], [9.0; 3]], &|| false).unwrap();
        assert_eq!(few, [Node { key: VoxelKey::ROOT, points: vec![0, 1] }]);
    }
}
