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

    /// The answers at some places of a building, local metres, and the radius in metres of the patch at each.
    ///
    /// # Errors
    /// Fails when the network does.
    pub fn query(&self, inputs: &Inputs, places: &[Point3<f64>]) -> Result<Vec<(Answer, f64)>, NetworkError> {
        let interface = self.network.interface();
        let shared = match interface {
            Interface::Field { grid, .. } => self.network.encode(&inputs.raster(grid))?,
            Interface::Points2Surf { subsample, .. } => inputs.subsample(subsample),
        };
        let mut answers = Vec::with_capacity(places.len());
        let mut queries = Queries::default();
        let mut radii = Vec::with_capacity(BATCH);
        for batch in places.chunks(BATCH) {
            queries.clear();
            radii.clear();
            for place in batch {
                radii.push(queries.push(&interface, inputs, &shared, place));
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
        let mut places = Vec::new();
        let mut ends = Vec::new();
        let seed = building.seed();
        let median = building.complex.median_volume();
        for cell in building.free() {
            match self.rule {
                CellRule::Mean => places.extend(building.complex.samples(cell, median, seed)),
                CellRule::Paper => places.push(building.complex.cell_centroid(cell)),
            }
            ends.push((cell, places.len()));
        }
        let answers = self.query(&inputs, &places)?;
        let mut occupancy = vec![0.0; building.complex.cells.len()];
        let mut start = 0;
        for (cell, end) in ends {
            let answers = &answers[start..end];
            start = end;
            occupancy[cell as usize] = match self.rule {
                CellRule::Mean => {
                    answers.iter().map(|(answer, _)| sigmoid(answer.inside.into())).sum::<f64>() / answers.len() as f64
                }
                CellRule::Paper => answers.first().map_or(0.5, |(answer, radius)| {
                    let distance = f64::from(answer.distance) * radius / inputs.scale();
                    let volume = building.volumes[cell as usize] / inputs.scale().powi(3);
                    sigmoid(distance.copysign(answer.inside.into()) * volume * 1e6)
                }),
            };
        }
        Ok(occupancy)
    }

    fn probability(&self, building: &Partitioned, places: &[Point3<f64>]) -> Result<Vec<f64>, OccupancyError> {
        let answers = self.query(&Inputs::new(building), places)?;
        Ok(answers.iter().map(|(answer, _)| sigmoid(answer.inside.into())).collect())
    }
}

fn sigmoid(logit: f64) -> f64 {
    1.0 / (1.0 + (-logit).exp())
}
