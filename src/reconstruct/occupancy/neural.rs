//! The neural implicit field (paper, section 3.3).

use std::sync::Arc;

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::inputs::{Inputs, lookup};
use super::network::{Answer, Interface, Network, NetworkError, Queries};
use super::{Occupancy, OccupancyError};
use crate::reconstruct::Partitioned;

/// Queries are made and answered so many at a time, which bounds the memory of a building.
const BATCH: usize = 1024;

/// So many samples of a cell are asked first …
const SCOUTS: usize = 4;
/// … and where their mean probability is this near to 0 or 1, the others are not asked.
const DECIDED: f64 = 0.03;

/// How the answers at the samples of a cell become its occupancy.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum CellRule {
    /// The mean probability of samples in the whole cell.
    #[default]
    Mean,
    /// The paper's: sigmoid of signed distance at the centroid times volume, both in the field frame, times 10⁶; for
    /// comparison.
    Paper,
}

/// What all places of a building share: its code, or for Points2Surf its sub-sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Encoded(Vec<f32>);

/// A network as an occupancy.
#[derive(Debug, Clone)]
pub struct Neural {
    network: Arc<dyn Network>,
    rule: CellRule,
}

impl Neural {
    /// The field that a network knows; `rule` makes occupancies of its answers.
    pub fn new(network: Arc<dyn Network>, rule: CellRule) -> Self {
        Self { network, rule }
    }

    /// What all places of a building share, once per building.
    ///
    /// # Errors
    /// Fails when the network does.
    pub fn encode(&self, inputs: &Inputs) -> Result<Encoded, NetworkError> {
        Ok(Encoded(match self.network.interface() {
            Interface::Field { grid, .. } => self.network.encode(&inputs.raster(grid))?,
            Interface::Points2Surf { subsample, .. } => inputs.subsample(subsample),
        }))
    }

    /// The answers at some places of a building, local metres, and the radius in metres of the patch at each.
    ///
    /// # Errors
    /// Fails when the network does.
    pub fn query(
        &self,
        inputs: &Inputs,
        encoded: &Encoded,
        places: &[Point3<f64>],
    ) -> Result<Vec<(Answer, f64)>, NetworkError> {
        let interface = self.network.interface();
        let mut answers = Vec::with_capacity(places.len());
        let mut queries = Queries::default();
        let mut radii = Vec::with_capacity(BATCH);
        for batch in places.chunks(BATCH) {
            queries.clear();
            radii.clear();
            for place in batch {
                radii.push(queries.push(&interface, inputs, &encoded.0, place));
            }
            answers.extend(self.network.decode(&queries)?.into_iter().zip(radii.iter().copied()));
        }
        if answers.len() == places.len() {
            Ok(answers)
        } else {
            Err(NetworkError(format!("{} answers to {} queries", answers.len(), places.len())))
        }
    }
}

impl Queries {
    fn clear(&mut self) {
        self.count = 0;
        for values in [&mut self.code, &mut self.place, &mut self.patch, &mut self.subsample] {
            values.clear();
        }
    }

    /// Adds a place and returns the radius of its patch.
    fn push(&mut self, interface: &Interface, inputs: &Inputs, shared: &[f32], place: &Point3<f64>) -> f64 {
        self.count += 1;
        let field = inputs.to_field(place);
        match *interface {
            Interface::Field { grid, code, neighbours } => {
                lookup(shared, code, grid, field.x, field.y, &mut self.code);
                let radius = inputs.patch(place, neighbours, &mut self.patch);
                inputs.place(place, radius, &mut self.place);
                radius
            }
            Interface::Points2Surf { neighbours, .. } => {
                let centre = field.map(|value| value as f32);
                self.subsample.extend(shared.chunks_exact(3).flat_map(|p| [0, 1, 2].map(|i| p[i] - centre[i])));
                inputs.bare_patch(place, neighbours, &mut self.patch)
            }
        }
    }
}

impl Occupancy for Neural {
    fn occupancy(&self, building: &Partitioned) -> Result<Vec<f64>, OccupancyError> {
        let inputs = Inputs::new(building);
        let cells: Vec<u32> = building.free().collect();
        let found = match self.rule {
            CellRule::Mean => self.mean_probabilities(&inputs, building, &cells)?,
            CellRule::Paper => self.signed_distances_by_volume(&inputs, building, &cells)?,
        };
        let mut occupancy = vec![0.0; building.complex.cells.len()];
        for (cell, value) in cells.into_iter().zip(found) {
            occupancy[cell as usize] = value;
        }
        Ok(occupancy)
    }

    fn probability(&self, building: &Partitioned, places: &[Point3<f64>]) -> Result<Vec<f64>, OccupancyError> {
        let inputs = Inputs::new(building);
        let answers = self.query(&inputs, &self.encode(&inputs)?, places)?;
        Ok(answers.iter().map(|(answer, _)| sigmoid(answer.inside.into())).collect())
    }
}

impl Neural {
    /// The mean probability of the samples of each cell. A few are asked first; where these agree the rest is spared.
    fn mean_probabilities(
        &self,
        inputs: &Inputs,
        building: &Partitioned,
        cells: &[u32],
    ) -> Result<Vec<f64>, NetworkError> {
        let encoded = self.encode(inputs)?;
        let median = building.complex.median_volume();
        let samples = |cell: u32| building.complex.samples(cell, median, building.seed());
        let ask = |who: &[usize], scouts: bool| -> Result<Vec<(usize, f64)>, NetworkError> {
            let (mut places, mut of) = (Vec::new(), Vec::new());
            for &slot in who {
                let all = samples(cells[slot]);
                let count = all.len();
                for (_, place) in all.into_iter().enumerate().filter(|(i, _)| is_scout(*i, count) == scouts) {
                    places.push(place);
                    of.push(slot);
                }
            }
            let answers = self.query(inputs, &encoded, &places)?;
            Ok(of.into_iter().zip(answers.iter().map(|(answer, _)| sigmoid(answer.inside.into()))).collect())
        };
        let mut sums = vec![(0.0, 0.0); cells.len()];
        let add = |sums: &mut [(f64, f64)], answers: Vec<(usize, f64)>| {
            for (slot, probability) in answers {
                sums[slot].0 += probability;
                sums[slot].1 += 1.0;
            }
        };
        let everyone: Vec<usize> = (0..cells.len()).collect();
        add(&mut sums, ask(&everyone, true)?);
        let mean = |(sum, count): (f64, f64)| if count > 0.0 { sum / count } else { 0.5 };
        let is_undecided = |slot: &usize| (DECIDED..=1.0 - DECIDED).contains(&mean(sums[*slot]));
        let undecided: Vec<usize> = everyone.into_iter().filter(is_undecided).collect();
        add(&mut sums, ask(&undecided, false)?);
        Ok(sums.into_iter().map(mean).collect())
    }

    /// The paper's occupancy: sigmoid of the signed distance at the centroid times volume.
    fn signed_distances_by_volume(
        &self,
        inputs: &Inputs,
        building: &Partitioned,
        cells: &[u32],
    ) -> Result<Vec<f64>, NetworkError> {
        let encoded = self.encode(inputs)?;
        let centroids: Vec<Point3<f64>> = cells.iter().map(|&cell| building.complex.cell_centroid(cell)).collect();
        let answers = self.query(inputs, &encoded, &centroids)?;
        let occupancy = |(&cell, (answer, radius)): (&u32, (Answer, f64))| {
            let distance = f64::from(answer.distance) * radius / inputs.scale();
            let volume = building.volumes[cell as usize] / inputs.scale().powi(3);
            sigmoid(distance.copysign(answer.inside.into()) * volume * 1e6)
        };
        Ok(cells.iter().zip(answers).map(occupancy).collect())
    }
}

/// Whether the sample `index` of the `count` of a cell is asked first: its centroid, and every few of the others, which
/// come in the order of the parts of the cell.
fn is_scout(index: usize, count: usize) -> bool {
    let step = (count.saturating_sub(1) / (SCOUTS - 1)).max(1);
    index.checked_sub(1).is_none_or(|other| other % step == step / 2 && other / step < SCOUTS - 1)
}

fn sigmoid(logit: f64) -> f64 {
    1.0 / (1.0 + (-logit).exp())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scouts_are_few_and_spread_over_the_cell() {
        for count in 1..=33 {
            let scouts: Vec<usize> = (0..count).filter(|&i| is_scout(i, count)).collect();
            assert_eq!(scouts.len(), count.min(SCOUTS), "{count}: {scouts:?}");
            assert_eq!(scouts[0], 0);
        }
        assert_eq!((0..17).filter(|&i| is_scout(i, 17)).collect::<Vec<_>>(), [0, 3, 8, 13]);
    }
}
