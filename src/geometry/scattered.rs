//! Points of the plan in squares.

/// Most squares along one side.
const MOST_SQUARES: f64 = 512.0;
/// How far a point may lie off a square and still be found in it, as a share of the largest coordinate: more than the
/// rounding of doubles.
const SLACK: f64 = 1e-11;

/// Points of the plan in a grid of squares: those that may lie on a segment are found without asking all.
#[derive(Debug)]
pub(crate) struct Scattered {
    corner: [f64; 2],
    /// Sides of a square.
    side: [f64; 2],
    /// Squares along a row and along a column.
    count: usize,
    slack: f64,
    /// Where the points of each square begin in `order`, and the end of the last.
    starts: Vec<u32>,
    /// Indices of points, by square and then ascending.
    order: Vec<u32>,
}

impl Scattered {
    /// Of these points.
    pub fn new(points: &[[f64; 2]]) -> Self {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for point in points {
            for axis in 0..2 {
                (low[axis], high[axis]) = (low[axis].min(point[axis]), high[axis].max(point[axis]));
            }
        }
        let count = (points.len() as f64).sqrt().ceil().clamp(1.0, MOST_SQUARES) as usize;
        let slack = SLACK * low.iter().chain(&high).map(|c| c.abs()).fold(0.0, f64::max);
        let side = [0, 1].map(|axis| ((high[axis] - low[axis]) / count as f64).max(slack).max(f64::MIN_POSITIVE));
        let mut scattered =
            Self { corner: low, side, count, slack, starts: vec![0; count * count + 1], order: Vec::new() };
        let square = |[x, y]: [f64; 2]| scattered.index(1, y) * count + scattered.index(0, x);
        let mut placed: Vec<(usize, u32)> = points.iter().map(|&point| square(point)).zip(0..).collect();
        placed.sort_unstable();
        for (square, _) in &placed {
            scattered.starts[square + 1] += 1;
        }
        for square in 0..count * count {
            scattered.starts[square + 1] += scattered.starts[square];
        }
        scattered.order = placed.into_iter().map(|(_, point)| point).collect();
        scattered
    }

    /// The column (axis 0) or row (1) of a coordinate.
    fn index(&self, axis: usize, value: f64) -> usize {
        // A cast takes what is below 0, or no number, for 0.
        (((value - self.corner[axis]) / self.side[axis]) as usize).min(self.count - 1)
    }

    /// Calls `visit` with the points in all squares that the segment passes, each once.
    pub fn near(&self, [a, b]: [[f64; 2]; 2], mut visit: impl FnMut(u32)) {
        let [a, b] = if a[0] <= b[0] { [a, b] } else { [b, a] };
        let along = b[0] - a[0];
        let height = |x: f64| a[1] + (b[1] - a[1]) * ((x - a[0]) / along).clamp(0.0, 1.0);
        for column in self.index(0, a[0] - self.slack)..=self.index(0, b[0] + self.slack) {
            // The stretch of the segment that is in the column.
            let west = self.corner[0] + column as f64 * self.side[0];
            let east = west + self.side[0];
            let ends = if along > 0.0 { [height(west - self.slack), height(east + self.slack)] } else { [a[1], b[1]] };
            let [low, high] = [ends[0].min(ends[1]) - self.slack, ends[0].max(ends[1]) + self.slack];
            for row in self.index(1, low)..=self.index(1, high) {
                let square = row * self.count + column;
                let range = self.starts[square] as usize..self.starts[square + 1] as usize;
                self.order[range].iter().copied().for_each(&mut visit);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Random;

    #[test]
    fn every_point_on_a_segment_is_found() {
        let mut random = Random::new(7);
        for scale in [1.0, 1e-3, 1e9] {
            let mut points: Vec<[f64; 2]> =
                (0..300).map(|_| [0, 1].map(|_| (random.below(40) as f64 - 20.0) * scale)).collect();
            points.extend((0..40).map(|i| [3.0 * scale, f64::from(i) * scale]));
            let scattered = Scattered::new(&points);
            for _ in 0..500 {
                let [a, b] = [0, 1].map(|_| points[random.below(points.len())]);
                let mut found = Vec::new();
                scattered.near([a, b], |point| found.push(point as usize));
                found.sort_unstable();
                assert!(found.windows(2).all(|pair| pair[0] < pair[1]), "one twice");
                for (i, p) in points.iter().enumerate() {
                    let cross = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
                    let within = (0..2).all(|k| a[k].min(b[k]) <= p[k] && p[k] <= a[k].max(b[k]));
                    if cross == 0.0 && within {
                        assert!(found.binary_search(&i).is_ok(), "{p:?} on {a:?} {b:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn points_in_one_place_and_none_at_all() {
        let scattered = Scattered::new(&[[5.0, 5.0]; 3]);
        let mut found = Vec::new();
        scattered.near([[0.0, 5.0], [9.0, 5.0]], |point| found.push(point));
        assert_eq!(found, [0, 1, 2]);
        Scattered::new(&[]).near([[0.0, 0.0], [1.0, 1.0]], |_| panic!("there is none"));
    }
}
