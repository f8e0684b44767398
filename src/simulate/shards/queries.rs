//! Where a network is asked: near the surface, anywhere, and in the cells that it will meet at work.

use nalgebra::Point3;

use super::super::mesh::Mesh;
use super::super::random::{Draw, Random};
use super::super::truth::Truth;
use super::Sizes;
use crate::reconstruct::Partitioned;

/// Standard deviations of the distance of queries to the surface, in units of the scale; half of them have either.
const OFFSETS: [f64; 2] = [0.01, 0.04];
/// How far the box of the uniform queries reaches beyond the building, in units of the scale.
const PADDING: f64 = 0.1;
/// Cells are drawn with a weight of this power of their volume: large ones decide the shape, small ones are many.
const VOLUME_POWER: f64 = 1.0 / 3.0;

/// A cell that is asked about.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CellQuery {
    /// Its number in the complex.
    pub cell: u32,
    /// Where it is asked: the centroid first.
    pub samples: Vec<Point3<f64>>,
    /// The true share of it that is inside.
    pub inside: f64,
}

/// Places near the surface, along its normals.
pub(super) fn near(mesh: &Mesh, count: usize, scale: f64, random: &mut Random) -> Vec<Point3<f64>> {
    let mut total = 0.0;
    let ends: Vec<f64> = mesh
        .all_corners()
        .map(|[a, b, c]| {
            total += (b - a).cross(&(c - a)).norm() / 2.0;
            total
        })
        .collect();
    (0..count)
        .map(|i| {
            let at = random.between(0.0, total);
            let corners = mesh.corners(ends.partition_point(|&end| end <= at).min(ends.len().saturating_sub(1)));
            let [a, b, c] = corners;
            let normal = (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_default();
            random.in_triangle(&corners) + normal * (OFFSETS[i % 2] * scale * random.normal())
        })
        .collect()
}

/// Places in the padded box of the building, all equally likely.
pub(super) fn uniform(truth: &Truth, count: usize, scale: f64, random: &mut Random) -> Vec<Point3<f64>> {
    let (aabb, padding) = (truth.aabb(), PADDING * scale);
    let place = |random: &mut Random| {
        Point3::from(std::array::from_fn(|i| random.between(aabb.min[i] - padding, aabb.max[i] + padding)))
    };
    (0..count).map(|_| place(random)).collect()
}

/// Cells whose label is not known beforehand, the same more than once where there are too few; empty without any.
pub(super) fn cells(building: &Partitioned, truth: &Truth, sizes: &Sizes, random: &mut Random) -> Vec<CellQuery> {
    let volume = |cell: u32| building.volumes.get(cell as usize).copied().unwrap_or(0.0);
    // Without replacement, by weight (Efraimidis and Spirakis 2006).
    let mut keyed: Vec<(f64, u32)> = building
        .free()
        .map(|cell| (random.unit().max(f64::MIN_POSITIVE).ln() / volume(cell).max(1e-12).powf(VOLUME_POWER), cell))
        .collect();
    keyed.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    keyed.truncate(sizes.cells);
    let median = building.complex.median_volume();
    let found: Vec<CellQuery> = keyed
        .into_iter()
        .map(|(_, cell)| {
            let mut samples = building.complex.samples(cell, median, random.bits());
            let inside = share_inside(building, cell, &samples, truth);
            if let [_, others @ ..] = samples.as_mut_slice() {
                random.shuffle(others);
            }
            let samples = samples.iter().copied().cycle().take(sizes.samples_per_cell).collect();
            CellQuery { cell, samples, inside }
        })
        .collect();
    found.iter().cloned().cycle().take(if found.is_empty() { 0 } else { sizes.cells }).collect()
}

/// The share of a cell that is inside: that of its samples, unless the surface does not reach it.
fn share_inside(building: &Partitioned, cell: u32, samples: &[Point3<f64>], truth: &Truth) -> f64 {
    let Some(centroid) = samples.first() else { return 0.0 };
    let corners = building.complex.cell_vertices(cell);
    let reach = corners
        .iter()
        .filter_map(|&v| building.complex.vertices.get(v as usize))
        .map(|vertex| (vertex.position - centroid).norm())
        .fold(0.0, f64::max);
    if truth.distance(centroid) > reach {
        return f64::from(u8::from(truth.is_inside(centroid)));
    }
    samples.iter().filter(|p| truth.is_inside(p)).count() as f64 / samples.len() as f64
}
