//! The cloth simulation filter (CSF): Zhang et al. (2016), An Easy-to-Use Airborne `LiDAR` Data Filtering Method Based on
//! Cloth Simulation, Remote Sensing 8(6), 501. A cloth rises from below, where the terrain holds it up, and bridges the
//! ground under buildings; what lies near to it is ground.

use std::collections::VecDeque;

use super::Failure;
use super::raster::{plan_box, room};

/// How far below the lowest point the cloth starts.
const START: f64 = 0.05;
/// Nodes of the cloth beyond the points on each side.
const BUFFER: f64 = 2.0;
/// What drives the cloth (the gravity of the paper, which turns the terrain upside down).
const FORCE: f64 = 0.2;
/// Which part of its speed the cloth loses in each step.
const DAMPING: f64 = 0.01;
/// A cloth none of whose nodes moves further than this in a step is at rest.
const REST: f64 = 0.005;
/// The part of the difference to a neighbour that a node makes up in one go.
const PULL: f64 = 0.3;
/// The steps, in x and y, to the neighbours that pull at a node, in the order in which the program of the authors has them:
/// the sums hang on it.
const AROUND: [(isize, isize); 8] = [(-1, -1), (-1, 0), (-1, 1), (0, -1), (1, -1), (1, 0), (0, 1), (1, 1)];
/// Connected nodes that hang free and are so few stay where they are.
const FEWEST: usize = 50;

/// The parameters.
#[derive(Debug, Clone, Copy)]
pub(in crate::pipeline) struct ClothSimulation {
    /// Distance of the nodes of the cloth, CRS units.
    pub resolution: f64,
    /// How stiff the cloth is: 1 for mountains, 2 for what lies between, 3 for plains.
    pub rigidness: u32,
    /// Length of a step in time.
    pub step: f64,
    /// How far from the cloth a point may lie and be ground, CRS units.
    pub threshold: f64,
    /// Whether the cloth is laid onto the terrain at steep slopes in the end.
    pub smooth: bool,
    /// Most steps.
    pub iterations: u64,
    /// By how much the terrain may differ from node to node where the cloth is laid onto it, CRS units.
    pub hdiff: f64,
}

/// A cloth.
struct Cloth {
    columns: usize,
    /// The height of each node, row after row.
    heights: Vec<f64>,
    /// The same a step ago.
    before: Vec<f64>,
    /// The terrain at each node, which it cannot rise above.
    terrain: Vec<f64>,
    /// Whether the terrain does not hold it yet.
    is_free: Vec<bool>,
}

impl ClothSimulation {
    /// Which of the positions are ground.
    ///
    /// # Errors
    /// An interruption, or too many nodes.
    pub fn ground(&self, positions: &[[f64; 3]], stop: &(dyn Fn() -> bool + Sync)) -> Result<Vec<bool>, Failure> {
        let (low, [width, height]) = plan_box(positions);
        let origin = low.map(|low| low - BUFFER * self.resolution);
        let nodes = |side: f64| (side / self.resolution).floor() + 2.0 * BUFFER;
        let [columns, rows] = room(nodes(width), nodes(height))?;
        // In steps of the cloth from its first node on; within it, because of the buffer.
        let along = |position: &[f64; 3], axis: usize, count: usize| {
            ((position[axis] - origin[axis]) / self.resolution).clamp(0.0, count as f64 - 1.0)
        };
        let place = |position: &[f64; 3]| [along(position, 0, columns), along(position, 1, rows)];

        let mut terrain = vec![f64::NAN; columns * rows];
        let mut nearest = vec![f64::INFINITY; columns * rows];
        for position in positions {
            let place = place(position);
            let node = place.map(f64::round);
            let square = (place[0] - node[0]).powi(2) + (place[1] - node[1]).powi(2);
            let i = node[1] as usize * columns + node[0] as usize;
            if square < nearest[i] {
                (nearest[i], terrain[i]) = (square, position[2]);
            }
        }
        drop(nearest);
        fill(&mut terrain, columns);
        let lowest = positions.iter().fold(f64::INFINITY, |lowest, position| lowest.min(position[2]));
        let heights = vec![lowest - START; columns * rows];
        let is_free = vec![true; columns * rows];
        let mut cloth = Cloth { columns, before: heights.clone(), heights, terrain, is_free };
        for _ in 0..self.iterations {
            if stop() {
                return Err(Failure::Interrupted);
            }
            let moved = cloth.advance(self);
            cloth.collide();
            if moved != 0.0 && moved < REST {
                break;
            }
        }
        if self.smooth {
            cloth.lay_on_slopes(self.hdiff);
        }
        let is_ground = |position: &[f64; 3]| {
            let place = place(position);
            let [column, row] = [place[0].min(columns as f64 - 2.0), place[1].min(rows as f64 - 2.0)].map(f64::floor);
            let [u, v] = [place[0] - column, place[1] - row];
            let node = row as usize * columns + column as usize;
            let at = |i: usize| cloth.heights[i];
            let below = at(node) * (1.0 - u) + at(node + 1) * u;
            let above = at(node + columns) * (1.0 - u) + at(node + columns + 1) * u;
            (below * (1.0 - v) + above * v - position[2]).abs() < self.threshold
        };
        Ok(positions.iter().map(is_ground).collect())
    }
}

/// Gives nodes without terrain that of the next node with some in their row, to the right before the left; else in their
/// column, below before above; else of the nearest that has some by then.
fn fill(terrain: &mut [f64], columns: usize) {
    let rows = terrain.len() / columns;
    let known = terrain.to_vec();
    let mut carry = |line: &mut dyn Iterator<Item = usize>| {
        let mut last = f64::NAN;
        for i in line {
            if !known[i].is_nan() {
                last = known[i];
            } else if terrain[i].is_nan() {
                terrain[i] = last;
            }
        }
    };
    for row in 0..rows {
        carry(&mut (row * columns..(row + 1) * columns).rev());
        carry(&mut (row * columns..(row + 1) * columns));
    }
    for column in 0..columns {
        carry(&mut (column..rows * columns).step_by(columns));
        carry(&mut (column..rows * columns).step_by(columns).rev());
    }
    let mut queue: VecDeque<usize> = (0..terrain.len()).filter(|&i| !terrain[i].is_nan()).collect();
    while let Some(i) = queue.pop_front() {
        for next in beside(i, columns, rows) {
            if terrain[next].is_nan() {
                terrain[next] = terrain[i];
                queue.push_back(next);
            }
        }
    }
}

/// The nodes beside one, in its row and column.
fn beside(i: usize, columns: usize, rows: usize) -> impl Iterator<Item = usize> {
    let (row, column) = (i / columns, i % columns);
    let left = (column > 0).then(|| i - 1);
    let right = (column + 1 < columns).then(|| i + 1);
    let below = (row > 0).then(|| i - columns);
    let above = (row + 1 < rows).then(|| i + columns);
    [left, right, below, above].into_iter().flatten()
}

impl Cloth {
    /// A step in time: all free nodes rise, and pull at one another. Gives the largest movement.
    fn advance(&mut self, parameters: &ClothSimulation) -> f64 {
        // The force is scaled by the time once when it is stated and once when it acts, as in the program of the authors.
        let push = FORCE * parameters.step.powi(4);
        for ((height, before), is_free) in self.heights.iter_mut().zip(&mut self.before).zip(&self.is_free) {
            if *is_free {
                let now = *height;
                *height = now + (now - *before) * (1.0 - DAMPING) + push;
                *before = now;
            }
        }
        // As many pulls in a row as the cloth is stiff, in one: of two free nodes each makes up its part, so that the
        // difference shrinks by twice that; of one that is held the other does all.
        let times = i32::try_from(parameters.rigidness).unwrap_or(i32::MAX);
        let both = 0.5 * (1.0 - (1.0 - 2.0 * PULL).powi(times));
        let one = 1.0 - (1.0 - PULL).powi(times);
        let (columns, rows) = (self.columns, self.heights.len() / self.columns);
        for i in 0..self.heights.len() {
            let (row, column) = ((i / columns) as isize, (i % columns) as isize);
            for reach in [1, 2] {
                for (right, up) in AROUND {
                    let (row, column) = (row + up * reach, column + right * reach);
                    if row < 0 || column < 0 || row >= rows as isize || column >= columns as isize {
                        continue;
                    }
                    let other = row as usize * columns + column as usize;
                    let difference = self.heights[other] - self.heights[i];
                    match (self.is_free[i], self.is_free[other]) {
                        (true, true) => {
                            self.heights[i] += both * difference;
                            self.heights[other] -= both * difference;
                        }
                        (true, false) => self.heights[i] += one * difference,
                        (false, true) => self.heights[other] -= one * difference,
                        (false, false) => {}
                    }
                }
            }
        }
        let moves = self.heights.iter().zip(&self.before).zip(&self.is_free).filter(|(_, is_free)| **is_free);
        moves.fold(0.0, |most: f64, ((height, before), _)| most.max((height - before).abs()))
    }

    /// Nodes that have risen above the terrain are held by it.
    fn collide(&mut self) {
        for ((height, terrain), is_free) in self.heights.iter_mut().zip(&self.terrain).zip(&mut self.is_free) {
            if *height > *terrain {
                if *is_free {
                    *height = *terrain;
                }
                *is_free = false;
            }
        }
    }

    /// Lays free nodes onto the terrain that can be reached from held ones by steps of less than `most` in height, but for
    /// those of small groups (section 3.4 of the paper).
    fn lay_on_slopes(&mut self, most: f64) {
        let (columns, rows) = (self.columns, self.heights.len() / self.columns);
        let mut is_seen = vec![false; self.heights.len()];
        for seed in 0..self.heights.len() {
            if !self.is_free[seed] || is_seen[seed] {
                continue;
            }
            is_seen[seed] = true;
            let mut group = vec![seed];
            let mut at = 0;
            while let Some(&member) = group.get(at) {
                at += 1;
                for next in beside(member, columns, rows) {
                    if self.is_free[next] && !std::mem::replace(&mut is_seen[next], true) {
                        group.push(next);
                    }
                }
            }
            if group.len() <= FEWEST {
                continue;
            }
            let terrain = &self.terrain;
            let is_step = |i: usize, j: usize| (terrain[i] - terrain[j]).abs() < most;
            let is_held = |i: &usize| beside(*i, columns, rows).any(|next| !self.is_free[next] && is_step(*i, next));
            let mut queue: VecDeque<usize> = group.iter().copied().filter(is_held).collect();
            for &i in &queue {
                self.is_free[i] = false;
            }
            while let Some(i) = queue.pop_front() {
                self.heights[i] = terrain[i];
                for next in beside(i, columns, rows) {
                    if self.is_free[next] && is_step(i, next) {
                        self.is_free[next] = false;
                        queue.push_back(next);
                    }
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEFAULT: ClothSimulation = ClothSimulation {
        resolution: 1.0,
        rigidness: 3,
        step: 0.65,
        threshold: 0.5,
        smooth: true,
        iterations: 500,
        hdiff: 0.3,
    };

    /// A point on each of 40 × 40 nodes, at this height.
    fn scene(height: impl Fn(f64, f64) -> f64) -> Vec<[f64; 3]> {
        (0..40)
            .flat_map(|y| (0..40).map(move |x| (f64::from(x), f64::from(y))))
            .map(|(x, y)| [x, y, height(x, y)])
            .collect()
    }

    fn others(method: &ClothSimulation, positions: &[[f64; 3]]) -> usize {
        method.ground(positions, &|| false).unwrap().into_iter().filter(|is_ground| !is_ground).count()
    }

    #[test]
    fn a_block_stands_on_the_cloth() {
        let stands = |x: f64, y: f64| (15.0..25.0).contains(&x) && (15.0..25.0).contains(&y);
        let positions = scene(|x, y| if stands(x, y) { 8.0 } else { 2.0 });
        let is_ground = DEFAULT.ground(&positions, &|| false).unwrap();
        for ([x, y, _], is_ground) in positions.iter().zip(&is_ground) {
            assert_eq!(*is_ground, !stands(*x, *y), "{x} {y}");
        }
        assert_eq!(DEFAULT.ground(&positions, &|| true), Err(Failure::Interrupted));
    }

    #[test]
    fn slopes_take_the_cloth_with_them_in_the_end() {
        // A dyke of 6 m with slopes of 1 : 4, which the cloth cannot follow.
        let positions = scene(|x, _| (6.0 - (x - 20.0).abs() / 4.0).max(2.0));
        assert_eq!(others(&DEFAULT, &positions), 0);
        assert!(others(&ClothSimulation { smooth: false, ..DEFAULT }, &positions) > 100);
        // One point is its own terrain.
        assert_eq!(DEFAULT.ground(&[[5.0, 5.0, 5.0]], &|| false).unwrap(), [true]);
    }

    #[test]
    fn gaps_are_filled_along_rows_then_columns() {
        let gap = f64::NAN;
        let mut terrain = vec![gap, 1.0, gap, gap, gap, gap, gap, gap, 2.0];
        fill(&mut terrain, 3);
        // The middle row has nothing: its first column nothing either.
        assert_eq!(terrain, [1.0, 1.0, 1.0, 1.0, 1.0, 2.0, 2.0, 2.0, 2.0]);
    }
}
