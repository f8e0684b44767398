//! The uniform sub-sample of a building: the global branch of Points2Surf (paper, section 3.3).

use super::Inputs;
use crate::geometry::Random;

impl Inputs<'_> {
    /// `count` points [count, 3] in the field frame, drawn without replacement in random order, and repeated where there
    /// are fewer: padding with zeros, as the reference code does, would put points into the middle of the building.
    pub fn subsample(&self, count: usize) -> Vec<f32> {
        let points = &self.building.site.points;
        let mut order: Vec<usize> = (0..points.len()).collect();
        let mut random = Random::new(self.building.seed());
        let drawn = count.min(order.len());
        for i in 0..drawn {
            let j = i + random.below(order.len() - i);
            order.swap(i, j);
        }
        order.truncate(drawn);
        let chosen = order.iter().cycle().take(if order.is_empty() { 0 } else { count });
        let mut subsample: Vec<f32> =
            chosen.flat_map(|&i| self.to_field(&points[i]).data.0[0]).map(|value| value as f32).collect();
        subsample.resize(3 * count, 0.0);
        subsample
    }
}
