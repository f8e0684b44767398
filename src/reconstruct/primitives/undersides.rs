//! What lies under a roof: soffits, floors of passages, and the walls that stand back under an upper storey.
//!
//! Airborne scans hardly see them, scans from the ground and from all around do. An underside is no roof, and must not
//! be taken for one by the roof map; but its plane cuts the complex, so that a field that is no height field can tell
//! what hangs over.

use std::collections::BTreeMap;

use nalgebra::{Point2, Point3};

use super::Primitive;

/// What has a roof at least this far above it is covered, metres.
const HEADROOM: f64 = 1.0;
/// A primitive lies under others when so much of its inliers is covered.
const MOST: f64 = 0.7;

/// The highest point on a primitive over each square of the plan.
#[derive(Debug)]
pub struct Tops {
    /// Side of a square, metres.
    side: f64,
    /// Per square, the highest inlier: its height and its primitive.
    highest: BTreeMap<[i64; 2], (f64, usize)>,
}

impl Tops {
    /// The highest inliers of some primitives over squares of `side` metres.
    pub fn new(points: &[Point3<f64>], primitives: &[Primitive], side: f64) -> Self {
        let mut tops = Self { side: side.max(0.1), highest: BTreeMap::new() };
        for (label, primitive) in primitives.iter().enumerate() {
            for point in primitive.inliers.iter().filter_map(|&i| points.get(i as usize)) {
                let top = tops.highest.entry(tops.square(&point.xy())).or_insert((point.z, label));
                if point.z > top.0 {
                    *top = (point.z, label);
                }
            }
        }
        tops
    }

    /// Whether most inliers of a primitive, `label` among the primitives of the tops, are covered by others.
    pub fn cover(&self, points: &[Point3<f64>], primitive: &Primitive, label: usize) -> bool {
        let inliers = primitive.inliers.iter().filter_map(|&i| points.get(i as usize));
        let covered = inliers.filter(|p| {
            let top = self.highest.get(&self.square(&p.xy()));
            top.is_some_and(|&(height, other)| other != label && height > p.z + HEADROOM)
        });
        covered.count() as f64 > MOST * primitive.inliers.len() as f64
    }

    fn square(&self, p: &Point2<f64>) -> [i64; 2] {
        [(p.x / self.side).floor() as i64, (p.y / self.side).floor() as i64]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points every half metre on a rectangle at one height, and their indices.
    fn sheet(points: &mut Vec<Point3<f64>>, x: [i32; 2], y: [i32; 2], z: f64) -> Primitive {
        let start = points.len() as u32;
        for i in 2 * x[0]..2 * x[1] {
            for j in 2 * y[0]..2 * y[1] {
                points.push(Point3::new(f64::from(i) / 2.0, f64::from(j) / 2.0, z));
            }
        }
        Primitive::from_inliers(points, (start..points.len() as u32).collect()).unwrap()
    }

    #[test]
    fn a_soffit_lies_under_the_roof_and_a_low_roof_beside_it_does_not() {
        let mut points = Vec::new();
        let roof = sheet(&mut points, [0, 10], [0, 8], 9.0);
        let soffit = sheet(&mut points, [0, 10], [0, 2], 3.0);
        let annexe = sheet(&mut points, [9, 14], [0, 8], 4.0);
        let primitives = [roof, soffit, annexe];
        let tops = Tops::new(&points, &primitives, 0.75);
        let found: Vec<bool> = primitives.iter().enumerate().map(|(i, p)| tops.cover(&points, p, i)).collect();
        assert_eq!(found, [false, true, false]);
    }
}
