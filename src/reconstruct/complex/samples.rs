//! Points in a cell at which the occupancy is asked.

use nalgebra::Point3;

use super::{CellId, Complex};
use crate::geometry::Random;

/// The fewest and the most samples of a cell beside its centroid.
const COUNT: [f64; 2] = [8.0, 32.0];

/// By how much samples are drawn towards the centroid, so that none lies on a facet.
const SHRINK: f64 = 0.05;

impl Complex {
    /// Points in a cell, local metres: its centroid first, then `8 + 8 V / V_median`, at least 8 and at most 32,
    /// uniformly distributed in its volume and drawn towards the centroid by 5 %.
    ///
    /// `median_volume` is that of the complex ([`Self::median_volume`]), in m³. The same seed gives the same points. A
    /// cell too thin to have a volume in floating point has its centroid only.
    pub fn samples(&self, cell: CellId, median_volume: f64, seed: u64) -> Vec<Point3<f64>> {
        let centroid = self.cell_centroid(cell);
        let (mut tetrahedra, mut passed, mut volume) = (Vec::new(), Vec::new(), 0.0);
        for (triangle, part) in self.tetrahedra(cell, centroid).filter(|&(_, part)| part > 0.0) {
            volume += part;
            tetrahedra.push(triangle);
            passed.push(volume);
        }
        let mut samples = vec![centroid];
        if tetrahedra.is_empty() {
            return samples;
        }
        let [fewest, most] = COUNT;
        let relative = if median_volume > 0.0 { volume / median_volume } else { 1.0 };
        let count = (fewest + fewest * relative).clamp(fewest, most).floor();
        // Every cell has its own sequence, whatever was drawn for others.
        let mut random = Random::new(seed ^ (u64::from(cell) + 1).wrapping_mul(0xD1B5_4A32_D192_ED03));
        for index in 0..count as u32 {
            // One sample in each of `count` equal parts of the volume: as uniform, and more even.
            let target = volume * (f64::from(index) + random.unit()) / count;
            let chosen = passed.partition_point(|&upto| upto < target).min(tetrahedra.len() - 1);
            let [s, t, u] = in_tetrahedron(&mut random);
            let [a, b, c] = tetrahedra[chosen].map(|p| p - centroid);
            samples.push(centroid + (a * s + b * t + c * u) * (1.0 - SHRINK));
        }
        samples
    }
}

/// Three barycentric coordinates, uniformly distributed in a tetrahedron (the fourth is what they lack to 1): the gaps
/// between three sorted numbers.
fn in_tetrahedron(random: &mut Random) -> [f64; 3] {
    let mut cuts = [random.unit(), random.unit(), random.unit()];
    cuts.sort_unstable_by(f64::total_cmp);
    [cuts[0], cuts[1] - cuts[0], cuts[2] - cuts[1]]
}
