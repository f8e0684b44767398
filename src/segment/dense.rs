//! Buildings that hold far more points than their planes need: they are thinned before anything costs.
//!
//! What a plane is, is known from some dozens of points a square metre; every step behind takes time by the point, and some
//! by the pair of neighbours. Of the points in a cube of a lattice the one nearest to its middle stays: real points with
//! their noise, evenly spread over roofs and walls, whatever their order.

use std::collections::HashMap;

use foldhash::fast::FixedState;
use geo::{Area, MultiPolygon};

/// A building with fewer points is never thinned.
const FEW: usize = 200_000;
/// Nor one with fewer points per square metre of its footprint, as far as they are spread over its roof alone.
const MOST_DENSITY: f64 = 40.0;

/// Thins the `points` of a building on this footprint, local metres, sorted; how many are taken away.
pub(super) fn thin(points: &mut Vec<[f64; 3]>, polygon: &MultiPolygon<f64>) -> u64 {
    if points.len() < FEW || points.len() as f64 <= MOST_DENSITY * polygon.unsigned_area() {
        return 0;
    }
    let side = MOST_DENSITY.sqrt().recip();
    // The best of each cube, and how far it is from the middle of it, squared.
    let mut best: HashMap<[i64; 3], (usize, f64), FixedState> = HashMap::default();
    for (index, point) in points.iter().enumerate() {
        let cube = point.map(|value| (value / side).floor());
        let off: f64 = (0..3).map(|axis| (point[axis] / side - cube[axis] - 0.5).powi(2)).sum();
        let own = best.entry(cube.map(|value| value as i64)).or_insert((index, off));
        if off < own.1 {
            *own = (index, off);
        }
    }
    let before = points.len();
    let mut stays: Vec<usize> = best.into_values().map(|(index, _)| index).collect();
    stays.sort_unstable();
    *points = stays.into_iter().map(|index| points[index]).collect();
    (before - points.len()) as u64
}

/// What is told of a building that was thinned.
pub(super) fn note(thinned: u64, kept: u64) -> String {
    format!(
        "of its {} points {kept} were used: more than {MOST_DENSITY} per square metre tell nothing new",
        thinned + kept
    )
}

#[cfg(test)]
mod tests {
    use geo::Rect;

    use super::*;
    use crate::geometry::Random;

    fn roof(side: f64, count: usize) -> (Vec<[f64; 3]>, MultiPolygon<f64>) {
        let mut random = Random::new(7);
        let mut points: Vec<[f64; 3]> = (0..count)
            .map(|_| {
                let [x, y] = [0, 1].map(|_| side * random.unit());
                [x, y, 8.0 + 0.02 * random.unit()]
            })
            .collect();
        points.sort_unstable_by(super::super::lexicographic);
        (points, MultiPolygon(vec![Rect::new([0.0, 0.0], [side, side]).to_polygon()]))
    }

    #[test]
    fn a_dense_roof_keeps_points_everywhere_and_their_order() {
        let (all, polygon) = roof(50.0, 500_000);
        let mut points = all.clone();
        let thinned = thin(&mut points, &polygon);
        assert_eq!(thinned as usize + points.len(), all.len());
        let density = points.len() as f64 / 2500.0;
        assert!((30.0..=45.0).contains(&density), "{density}");
        assert!(points.is_sorted_by(|a, b| super::super::lexicographic(a, b).is_lt()));
        let mut cells = [0; 2500];
        for point in &points {
            assert!(all.binary_search_by(|other| super::super::lexicographic(other, point)).is_ok());
            cells[point[0] as usize * 50 + point[1] as usize] += 1;
        }
        assert!(cells.iter().all(|&n| n >= 20), "{:?}", cells.iter().min());
        assert_eq!(thin(&mut points, &polygon), 0);
    }

    #[test]
    fn usual_buildings_keep_every_point() {
        for (side, count) in [(10.0, FEW - 1), (100.0, 390_000)] {
            let (all, polygon) = roof(side, count);
            let mut points = all.clone();
            assert_eq!(thin(&mut points, &polygon), 0);
            assert_eq!(points, all);
        }
    }
}
