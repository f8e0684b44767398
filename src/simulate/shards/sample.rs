//! One scan as numbers.

use nalgebra::Point3;

use super::super::model::Model;
use super::super::options::{ScanOptions, Setup};
use super::super::random::{Random, hash};
use super::super::scan::scan;
use super::super::truth::Truth;
use super::float16::bits;
use super::queries::{self, CellQuery};
use super::{Interface, Sizes};
use crate::reconstruct::occupancy::inputs::Inputs;
use crate::reconstruct::occupancy::{HeightField, Occupancy};
use crate::reconstruct::{Parameters, Partitioned};

/// What a network is asked and told about one scan, and the truth. The shapes are those of the README of `training/`, without
/// their first number.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Sample {
    pub raster: Vec<u16>,
    pub subsample: Vec<u16>,
    pub place: Vec<f32>,
    pub patch: Vec<u16>,
    pub radius: Vec<f32>,
    pub inside: Vec<u8>,
    pub distance: Vec<f32>,
    pub cell_inside: Vec<f32>,
    pub cell_volume: Vec<f32>,
    pub cell_vote: Vec<f32>,
    pub scale: f32,
    pub setup: u8,
    pub noise: f32,
    pub density: f32,
}

/// What all scans of a data set have in common.
pub(super) struct Recipe<'a> {
    pub interface: Interface,
    pub sizes: Sizes,
    pub options: &'a ScanOptions,
    pub parameters: &'a Parameters,
    pub augment: bool,
    pub seed: u64,
}

impl Recipe<'_> {
    /// Scans a model for the `variant`-th time and asks all questions.
    ///
    /// # Errors
    /// Why nothing can be asked about the scan.
    pub fn sample(&self, model: &Model, variant: usize) -> Result<Sample, String> {
        let id = format!("{}#{variant}", model.id);
        let seed = hash(self.seed, &format!("{}/{id}", model.tile));
        let mut random = Random::new(seed);
        let placed = if self.augment { model.augmented(&mut random) } else { model.placed() };
        let truth = Truth::new(&placed.mesh).ok_or("the model has no surface")?;
        let scan = scan(&placed, self.options, 0.0, random.bits()).ok_or("the model has no surface")?;
        let site = scan.site(&id);
        let building = Partitioned::new(&site, self.parameters)
            .map_err(|failure| format!("no partition: {:?}", failure.reason))?;
        let inputs = Inputs::new(&building);

        let scale = inputs.scale();
        let cells = queries::cells(&building, &truth, &self.sizes, &mut random);
        if cells.is_empty() {
            return Err("no cell of the partition lies in the footprint".to_owned());
        }
        let mut places = queries::near(&placed.mesh, self.sizes.near, scale, &mut random);
        places.extend(queries::uniform(&truth, self.sizes.uniform, scale, &mut random));
        places.extend(cells.iter().flat_map(|cell| &cell.samples));
        let vote = HeightField.occupancy(&building).map_err(|error| error.to_string())?;
        let of_cell = |values: &[f64], cell: &CellQuery| values.get(cell.cell as usize).map_or(0.0, |v| *v as f32);
        let halves = |values: Vec<f32>| values.into_iter().map(bits).collect::<Vec<u16>>();

        let Asked { place, patch, radius } = self.ask(&inputs, &places);
        Ok(Sample {
            raster: if self.sizes.grid == 0 { Vec::new() } else { halves(inputs.raster(self.sizes.grid)) },
            subsample: halves(inputs.subsample(self.sizes.subsample)),
            place,
            patch: halves(patch),
            radius,
            inside: places.iter().map(|p| u8::from(truth.is_inside(p))).collect(),
            distance: places.iter().map(|p| truth.distance(p) as f32).collect(),
            cell_inside: cells.iter().map(|cell| cell.inside as f32).collect(),
            cell_volume: cells.iter().map(|cell| of_cell(&building.volumes, cell)).collect(),
            cell_vote: cells.iter().map(|cell| of_cell(&vote, cell)).collect(),
            scale: scale as f32,
            setup: Setup::ALL.iter().position(|s| *s == scan.setup).unwrap_or(0) as u8,
            noise: scan.noise as f32,
            density: scan.density as f32,
        })
    }

    /// The inputs of a network at these places.
    fn ask(&self, inputs: &Inputs, places: &[Point3<f64>]) -> Asked {
        let mut asked = Asked::default();
        for p in places {
            let radius = match self.interface {
                Interface::Field => {
                    let radius = inputs.patch(p, self.sizes.neighbours, &mut asked.patch);
                    inputs.place(p, radius, &mut asked.place);
                    radius
                }
                Interface::Points2surf => {
                    asked.place.extend(inputs.to_field(p).iter().map(|v| *v as f32));
                    inputs.bare_patch(p, self.sizes.neighbours, &mut asked.patch)
                }
            };
            asked.radius.push(radius as f32);
        }
        asked
    }
}

/// The inputs of a network at some places.
#[derive(Default)]
struct Asked {
    place: Vec<f32>,
    patch: Vec<f32>,
    radius: Vec<f32>,
}
