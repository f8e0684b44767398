//! Where a network is asked: near the surface, anywhere, and in the cells that it will meet at work.

use nalgebra::Point3;

use super::super::random::Random;
use super::Sizes;
use super::answers::Answers;
use crate::reconstruct::Partitioned;

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
    /// The share of it that is inside, of what is known of it.
    pub inside: f64,
    /// The share of it that is known.
    pub known: f64,
}

/// Places in the padded box of the building, all equally likely.
pub(super) fn uniform(truth: &dyn Answers, count: usize, scale: f64, random: &mut Random) -> Vec<Point3<f64>> {
    let (aabb, padding) = (truth.aabb(), PADDING * scale);
    let place = |random: &mut Random| {
        Point3::from(std::array::from_fn(|i| random.between(aabb.min[i] - padding, aabb.max[i] + padding)))
    };
    (0..count).map(|_| place(random)).collect()
}

/// Cells whose label is not known beforehand and of which something is known in truth, the same more than once where there
/// are too few; empty without any.
pub(super) fn cells(building: &Partitioned, truth: &dyn Answers, sizes: &Sizes, random: &mut Random) -> Vec<CellQuery> {
    let volume = |cell: u32| building.volumes.get(cell as usize).copied().unwrap_or(0.0);
    // Without replacement, by weight (Efraimidis and Spirakis 2006).
    let mut keyed: Vec<(f64, u32)> = building
        .free()
        .map(|cell| (random.unit().max(f64::MIN_POSITIVE).ln() / volume(cell).max(1e-12).powf(VOLUME_POWER), cell))
        .collect();
    keyed.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let median = building.complex.median_volume();
    let found: Vec<CellQuery> = keyed
        .into_iter()
        .filter_map(|(_, cell)| {
            let mut samples = building.complex.samples(cell, median, random.bits());
            let [inside, known] = shares(building, cell, &samples, truth)?;
            if let [_, others @ ..] = samples.as_mut_slice() {
                random.shuffle(others);
            }
            let samples = samples.iter().copied().cycle().take(sizes.samples_per_cell).collect();
            Some(CellQuery { cell, samples, inside, known })
        })
        .take(sizes.cells)
        .collect();
    found.iter().cloned().cycle().take(if found.is_empty() { 0 } else { sizes.cells }).collect()
}

/// The share of the known part of a cell that is inside, and the share of it that is known: those of its samples, unless
/// the surface does not reach the cell. `None` where nothing is known.
fn shares(building: &Partitioned, cell: u32, samples: &[Point3<f64>], truth: &dyn Answers) -> Option<[f64; 2]> {
    let centroid = samples.first()?;
    let corners = building.complex.cell_vertices(cell);
    let reach = corners
        .iter()
        .filter_map(|&v| building.complex.vertices.get(v as usize))
        .map(|vertex| (vertex.position - centroid).norm())
        .fold(0.0, f64::max);
    if truth.is_exact() && truth.distance(centroid) > reach {
        return truth.inside(centroid).map(|inside| [f64::from(u8::from(inside)), 1.0]);
    }
    let known: Vec<bool> = samples.iter().filter_map(|p| truth.inside(p)).collect();
    let inside = known.iter().filter(|inside| **inside).count() as f64;
    let count = known.len() as f64;
    (count > 0.0).then(|| [inside / count, count / samples.len() as f64])
}
