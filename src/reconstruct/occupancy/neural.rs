//! The neural implicit field (paper, section 3.3).

use std::sync::Arc;

use nalgebra::Point3;
use serde::{Deserialize, Serialize};

use super::inputs::{Inputs, Windows, lookup};
use super::network::{Answer, Interface, Network, NetworkError, Queries};
use super::sparing::Spared;
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

/// What all places of a building share, window by window: its code, or for Points2Surf its sub-sample.
#[derive(Debug, Clone)]
pub struct Encoded<'a> {
    windows: Windows<'a>,
    shared: Vec<Vec<f32>>,
}

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
    pub fn encode<'a>(&self, inputs: &Inputs<'a>) -> Result<Encoded<'a>, NetworkError> {
        Ok(match self.network.interface() {
            Interface::Field { grid, .. } => {
                let windows = Windows::new(inputs);
                let codes = windows.inputs().iter().map(|window| self.network.encode(&window.raster(grid)));
                Encoded { shared: codes.collect::<Result<_, _>>()?, windows }
            }
            Interface::Points2Surf { subsample, .. } => {
                Encoded { windows: Windows::whole(inputs), shared: vec![inputs.subsample(subsample)] }
            }
        })
    }

    /// The answers at some places of a building, local metres, and the radius in metres of the patch at each.
    ///
    /// # Errors
    /// Fails when the network does.
    pub fn query(&self, encoded: &Encoded, places: &[Point3<f64>]) -> Result<Vec<(Answer, f64)>, NetworkError> {
        let interface = self.network.interface();
        let mut answers = Vec::with_capacity(places.len());
        let mut queries = Queries::default();
        let mut radii = Vec::with_capacity(BATCH);
        for batch in places.chunks(BATCH) {
            queries.clear();
            radii.clear();
            for place in batch {
                let window = encoded.windows.at(place);
                let (inputs, shared) = (&encoded.windows.inputs()[window], &encoded.shared[window]);
                radii.push(queries.push(&interface, inputs, shared, place));
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
    /// By [`CellRule::Mean`] only those cells are asked about whose label the network could change, and the vote stands
    /// for the others.
    fn occupancy(&self, building: &Partitioned) -> Result<Vec<f64>, OccupancyError> {
        let (mut occupancy, cells) = match self.rule {
            CellRule::Mean => {
                let Spared { vote, asked } = Spared::of(building);
                (vote, asked)
            }
            CellRule::Paper => (vec![0.0; building.complex.cells.len()], building.free().collect()),
        };
        if cells.is_empty() {
            return Ok(occupancy);
        }
        let inputs = Inputs::new(building);
        let found = match self.rule {
            CellRule::Mean => self.mean_probabilities(&inputs, building, &cells)?,
            CellRule::Paper => self.signed_distances_by_volume(&inputs, building, &cells)?,
        };
        for (cell, value) in cells.into_iter().zip(found) {
            occupancy[cell as usize] = value;
        }
        Ok(occupancy)
    }

    fn probability(&self, building: &Partitioned, places: &[Point3<f64>]) -> Result<Vec<f64>, OccupancyError> {
        let inputs = Inputs::new(building);
        let answers = self.query(&self.encode(&inputs)?, places)?;
        Ok(answers.iter().map(|(answer, _)| sigmoid(answer.inside.into())).collect())
    }
}

impl Neural {
    /// The mean probability of the samples of each cell. The centroid is asked first: where the surface is farther from
    /// it than the cell reaches, it speaks for all. Of the other cells a few samples are asked, and where these agree the
    /// rest is spared.
    fn mean_probabilities(
        &self,
        inputs: &Inputs,
        building: &Partitioned,
        cells: &[u32],
    ) -> Result<Vec<f64>, NetworkError> {
        let complex = &building.complex;
        let encoded = self.encode(inputs)?;
        let centroids: Vec<Point3<f64>> = cells.iter().map(|&cell| complex.cell_centroid(cell)).collect();
        let answers = self.query(&encoded, &centroids)?;
        let mut means: Vec<Mean> = answers.iter().map(|(answer, _)| Mean::default().and(*answer)).collect();

        let median = complex.median_volume();
        let mut open = Vec::new();
        for (slot, ((answer, radius), centroid)) in answers.iter().zip(&centroids).enumerate() {
            let distance = f64::from(answer.distance) * radius;
            let speaks_for_all = || {
                let corners = complex.cell_vertices(cells[slot]);
                let corners = corners.iter().map(|&corner| complex.vertices[corner as usize].position);
                corners.map(|corner| (corner - centroid).norm()).all(|reach| reach < distance)
            };
            if !(means[slot].is_decided() && speaks_for_all()) {
                open.push((slot, complex.samples(cells[slot], median, building.seed())));
            }
        }
        for scouts in [true, false] {
            let (mut places, mut of) = (Vec::new(), Vec::new());
            for (slot, samples) in &open {
                let chosen = samples.iter().enumerate().skip(1).filter(|(i, _)| is_scout(*i, samples.len()) == scouts);
                places.extend(chosen.map(|(_, place)| *place));
                of.resize(places.len(), *slot);
            }
            for (slot, (answer, _)) in of.into_iter().zip(self.query(&encoded, &places)?) {
                means[slot] = means[slot].and(answer);
            }
            open.retain(|(slot, _)| !means[*slot].is_decided());
        }
        Ok(means.into_iter().map(Mean::value).collect())
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
        let answers = self.query(&encoded, &centroids)?;
        let occupancy = |(&cell, (answer, radius)): (&u32, (Answer, f64))| {
            let distance = f64::from(answer.distance) * radius / inputs.scale();
            let volume = building.volumes[cell as usize] / inputs.scale().powi(3);
            sigmoid(distance.copysign(answer.inside.into()) * volume * 1e6)
        };
        Ok(cells.iter().zip(answers).map(occupancy).collect())
    }
}

/// The mean probability of some samples.
#[derive(Debug, Clone, Copy, Default)]
struct Mean {
    sum: f64,
    count: f64,
}

impl Mean {
    fn and(self, answer: Answer) -> Self {
        Self { sum: self.sum + sigmoid(answer.inside.into()), count: self.count + 1.0 }
    }

    fn value(self) -> f64 {
        self.sum / f64::max(self.count, 1.0)
    }

    /// Whether other samples would hardly change it.
    fn is_decided(self) -> bool {
        !(DECIDED..=1.0 - DECIDED).contains(&self.value())
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
