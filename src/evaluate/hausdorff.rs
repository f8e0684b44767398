//! Distances between two surfaces: Hausdorff and symmetric mean Hausdorff (paper, section 4.2).

use nalgebra::Point3;
use parry3d_f64::math::Vector;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::TriMesh;
use serde::Serialize;

use super::shape::Shape;
use crate::geometry::Random;

/// The faces of a shape, searchable for the one nearest to a point.
pub struct NearestFace {
    mesh: TriMesh,
}

impl NearestFace {
    /// Indexes the triangles of `shape`; `None` when it has none.
    pub fn new(shape: &Shape) -> Option<Self> {
        let corners: Vec<Vector> =
            shape.triangles.iter().flat_map(|(t, _)| t.iter().map(|p| Vector::new(p.x, p.y, p.z))).collect();
        let triangles: Vec<[u32; 3]> =
            (0..shape.triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        TriMesh::new(corners, triangles).ok().map(|mesh| Self { mesh })
    }

    /// Distance of a point to the nearest face, metres, not negative.
    pub fn distance(&self, point: &Point3<f64>) -> f64 {
        let point = Vector::new(point.x, point.y, point.z);
        (self.mesh.project_local_point(point, false).point - point).length()
    }
}

/// How far two surfaces are from one another, in metres and relative to the size of the reference.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct SurfaceDistance {
    /// The largest distance of a sample of either surface to the other.
    pub hausdorff: f64,
    /// Half the sum of the mean distances of either surface to the other (SMH of the paper).
    pub symmetric_mean: f64,
    /// `hausdorff / R`, where R is the largest side of the box of the reference.
    pub relative_hausdorff: f64,
    /// `symmetric_mean / R`.
    pub relative_symmetric_mean: f64,
}

/// Measures two surfaces against each other with `samples` points per surface, drawn uniformly by area from a generator
/// seeded with `seed`, so that the same input gives the same figures. `None` when a surface is empty or has no area.
pub fn surface_distance(shape: &Shape, reference: &Shape, samples: usize, seed: u64) -> Option<SurfaceDistance> {
    let extent = reference.aabb()?.extent().into_iter().fold(0.0, f64::max);
    let [there, back] = [(shape, reference, seed), (reference, shape, !seed)].map(|(from, to, seed)| {
        let target = NearestFace::new(to)?;
        let points = sample(from, samples, seed)?;
        let (sum, max) = points
            .iter()
            .map(|p| target.distance(p))
            .fold((0.0, 0.0), |(sum, max): (f64, f64), d| (sum + d, max.max(d)));
        // Corners are where two polyhedra part most, and sampling by area never hits them.
        let at_corners = from.triangles.iter().flat_map(|(t, _)| t).map(|p| target.distance(p)).fold(max, f64::max);
        Some((sum / points.len() as f64, at_corners))
    });
    let ((mean_there, max_there), (mean_back, max_back)) = (there?, back?);
    let hausdorff = max_there.max(max_back);
    let symmetric_mean = f64::midpoint(mean_there, mean_back);
    (extent > 0.0).then(|| SurfaceDistance {
        hausdorff,
        symmetric_mean,
        relative_hausdorff: hausdorff / extent,
        relative_symmetric_mean: symmetric_mean / extent,
    })
}

/// Points drawn uniformly by area from the triangles of a shape; `None` when it has no area.
fn sample(shape: &Shape, count: usize, seed: u64) -> Option<Vec<Point3<f64>>> {
    let mut total = 0.0;
    let ends: Vec<f64> = shape
        .triangles
        .iter()
        .map(|([a, b, c], _)| {
            total += (b - a).cross(&(c - a)).norm() / 2.0;
            total
        })
        .collect();
    if total <= 0.0 || !total.is_finite() || count == 0 {
        return None;
    }
    let mut random = Random::new(seed);
    let points = (0..count).filter_map(|_| {
        let place = random.unit() * total;
        let index = ends.partition_point(|&end| end <= place).min(ends.len() - 1);
        let ([a, b, c], _) = shape.triangles.get(index)?;
        let (mut u, mut v) = (random.unit(), random.unit());
        if u + v > 1.0 {
            (u, v) = (1.0 - u, 1.0 - v);
        }
        Some(a + (b - a) * u + (c - a) * v)
    });
    Some(points.collect())
}

#[cfg(test)]
mod tests {
    use super::super::shape::tests::block;
    use super::*;

    #[test]
    fn a_block_that_is_one_metre_taller() {
        let [low, tall] = [10.0, 11.0].map(|z| block("a", [0.0, 0.0, 0.0], [10.0, 10.0, z]));
        let found = surface_distance(&tall, &low, 40_000, 7).unwrap();
        assert!((found.hausdorff - 1.0).abs() < 1e-9 && (found.relative_hausdorff - 0.1).abs() < 1e-9);
        // Of the 640 m² of the tall block, the roof (100 m²) is 1 m away, the 40 m² of wall above 10 m are 0.5 m away in the
        // mean, the rest touches. Of the 600 m² of the low one the roof is below the tall one's by 1 m, or nearer to a wall:
        // min(1, distance to the rim) integrates over the square of side 10 to 64 + ∫ = 64 + 4·(∫₀¹ d(10 − 2d) dd) = 64 + 52/3.
        let (there, back) = ((100.0 + 20.0) / 640.0, (64.0 + 4.0 * (5.0 - 2.0 / 3.0)) / 600.0);
        assert!((found.symmetric_mean - f64::midpoint(there, back)).abs() < 0.003, "{}", found.symmetric_mean);
        assert_eq!(surface_distance(&tall, &low, 40_000, 7), Some(found));
    }

    #[test]
    fn a_point_inside_is_as_far_as_from_the_nearest_face() {
        let nearest = NearestFace::new(&block("a", [0.0; 3], [10.0; 3])).unwrap();
        assert!((nearest.distance(&Point3::new(5.0, 5.0, 8.0)) - 2.0).abs() < 1e-12);
        assert!((nearest.distance(&Point3::new(13.0, 14.0, 5.0)) - 5.0).abs() < 1e-12);
        assert!(NearestFace::new(&Shape::new("none", Vec::new(), &[])).is_none());
    }
}
