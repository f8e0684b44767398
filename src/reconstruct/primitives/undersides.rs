//! What lies under a roof: soffits, floors of passages, and the walls that stand back under an upper storey.
//!
//! Airborne scans hardly see them, scans from the ground and from all around do. An underside is no roof, and must not
//! be taken for one by the roof map; but its plane cuts the complex, so that a field that is no height field can tell
//! what hangs over.

use std::collections::HashMap;
use std::f64::consts::PI;

use geo::{Area, ConvexHull, MultiPoint};
use nalgebra::{Point2, Point3};

use super::Primitive;

/// What has a roof at least this far above it is covered, metres.
const HEADROOM: f64 = 1.0;
/// A primitive lies under others when so much of its inliers is covered.
const MOST: f64 = 0.5;
/// A roof is looked for so far around a point, in spacings of the points of that roof: far enough to find a dozen of them
/// however they lie, near enough for the bottom of a light well to stay open.
const REACH: f64 = 2.0;
/// But never nearer or farther than this, metres.
const LEAST: f64 = 0.1;
const FARTHEST: f64 = 3.0;
/// So many inliers of a primitive are asked at most.
const ASKED: usize = 256;

/// The points on primitives, sorted by squares of the plan.
#[derive(Debug)]
pub struct Tops<'a> {
    points: &'a [Point3<f64>],
    /// Per primitive, how far around a point its inliers are looked for, metres.
    reach: Vec<f64>,
    /// Side of a square, metres: the farthest reach.
    side: f64,
    squares: HashMap<[i64; 2], Square>,
}

/// What stands on a square of the plan.
#[derive(Debug)]
struct Square {
    /// Height of the highest inlier.
    highest: f64,
    /// The inliers, and their primitives.
    inliers: Vec<(u32, usize)>,
}

impl<'a> Tops<'a> {
    /// The inliers of some primitives.
    pub fn new(points: &'a [Point3<f64>], primitives: &[Primitive]) -> Self {
        let reach: Vec<f64> = primitives.iter().map(|primitive| reach(points, primitive)).collect();
        let side = reach.iter().copied().fold(LEAST, f64::max);
        let mut tops = Self { points, reach, side, squares: HashMap::new() };
        for (label, primitive) in primitives.iter().enumerate() {
            for &index in &primitive.inliers {
                let Some(point) = points.get(index as usize) else { continue };
                let empty = Square { highest: f64::NEG_INFINITY, inliers: Vec::new() };
                let square = tops.squares.entry(tops.square(&point.xy())).or_insert(empty);
                square.highest = square.highest.max(point.z);
                square.inliers.push((index, label));
            }
        }
        tops
    }

    /// Whether most inliers of a primitive, `label` among the primitives of the tops, are covered by others.
    pub fn cover(&self, primitive: &Primitive, label: usize) -> bool {
        let step = primitive.inliers.len().div_ceil(ASKED).max(1);
        let (mut asked, mut covered) = (0.0, 0.0);
        for point in primitive.inliers.iter().step_by(step).filter_map(|&i| self.points.get(i as usize)) {
            asked += 1.0;
            covered += f64::from(u8::from(self.is_covered(point, label)));
        }
        covered > MOST * asked
    }

    /// Whether higher points of other primitives stand around a point, so that in the plan it lies in their convex hull:
    /// those of a high roof beside it all lie on one side.
    fn is_covered(&self, point: &Point3<f64>, label: usize) -> bool {
        let [column, row] = self.square(&point.xy());
        let mut directions: Vec<f64> = Vec::new();
        for square in (-1..=1).flat_map(|i| (-1..=1).map(move |j| [column + i, row + j])) {
            let Some(Square { highest, inliers }) = self.squares.get(&square) else { continue };
            if *highest <= point.z + HEADROOM {
                continue;
            }
            for &(index, other) in inliers.iter().filter(|(_, other)| *other != label) {
                let top = &self.points[index as usize];
                let offset = top.xy() - point.xy();
                if top.z > point.z + HEADROOM && offset.norm() <= self.reach[other] {
                    directions.push(offset.y.atan2(offset.x));
                }
            }
        }
        directions.sort_by(f64::total_cmp);
        let (Some(first), Some(last)) = (directions.first(), directions.last()) else { return false };
        let widest = directions.windows(2).map(|pair| pair[1] - pair[0]).fold(first + 2.0 * PI - last, f64::max);
        widest < PI
    }

    fn square(&self, p: &Point2<f64>) -> [i64; 2] {
        [(p.x / self.side).floor() as i64, (p.y / self.side).floor() as i64]
    }
}

/// How far around a point the inliers of a primitive are looked for, metres.
fn reach(points: &[Point3<f64>], primitive: &Primitive) -> f64 {
    let inliers = primitive.inliers.iter().filter_map(|&i| points.get(i as usize));
    let plan: MultiPoint<f64> = inliers.map(|p| (p.x, p.y)).collect();
    let spacing = (plan.convex_hull().unsigned_area() / plan.0.len().max(1) as f64).sqrt();
    (REACH * spacing).clamp(LEAST, FARTHEST)
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
        // As narrow as the neighbourhood of a point reaches: high roofs on both sides, but not above.
        let strip = sheet(&mut points, [14, 16], [0, 8], 2.0);
        let other = sheet(&mut points, [16, 20], [0, 8], 9.0);
        let primitives = [roof, soffit, annexe, strip, other];
        let tops = Tops::new(&points, &primitives);
        let found: Vec<bool> = primitives.iter().enumerate().map(|(i, p)| tops.cover(p, i)).collect();
        assert_eq!(found, [false, true, false, false, false]);
    }
}
