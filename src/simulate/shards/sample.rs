//! One scan as numbers.

use std::sync::Arc;

use nalgebra::Point3;

use super::super::model::Model;
use super::super::options::{ScanOptions, Setup};
use super::super::random::{Random, hash};
use super::super::real::{RealSite, Seen};
use super::super::scan::scan;
use super::answers::{Answers, Exact};
use super::float16::bits;
use super::queries::{self, CellQuery};
use super::{Interface, Sizes};
use crate::reconstruct::occupancy::inputs::Inputs;
use crate::reconstruct::occupancy::{HeightField, Occupancy};
use crate::reconstruct::{Parameters, Partitioned};
use crate::site::Site;

/// The number of real scans among the set-ups: after those of the virtual scanner.
pub(super) const REAL: u8 = Setup::ALL.len() as u8;

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
    pub known: Vec<u8>,
    pub distance: Vec<f32>,
    pub cell_inside: Vec<f32>,
    pub cell_known: Vec<f32>,
    pub cell_volume: Vec<f32>,
    pub cell_vote: Vec<f32>,
    pub scale: f32,
    pub exact: u8,
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

/// What is scanned: a model by a virtual scanner, or a building whose scan is thinned.
#[derive(Debug, Clone, Copy)]
pub(super) enum Subject<'a> {
    Model(&'a Model),
    Real(&'a RealSite),
}

impl Subject<'_> {
    /// The tile that it is of.
    pub fn tile(&self) -> &Arc<str> {
        match self {
            Self::Model(model) => &model.tile,
            Self::Real(real) => &real.tile,
        }
    }

    fn id(&self) -> &str {
        match self {
            Self::Model(model) => &model.id,
            Self::Real(real) => &real.site.id,
        }
    }
}

/// How a scan was made, as numbers.
struct Conditions {
    setup: u8,
    noise: f64,
    density: f64,
}

impl Recipe<'_> {
    /// Scans a subject for the `variant`-th time and asks all questions.
    ///
    /// # Errors
    /// Why nothing can be asked about the scan.
    pub fn sample(&self, subject: Subject<'_>, variant: usize) -> Result<Sample, String> {
        let id = format!("{}#{variant}", subject.id());
        let seed = hash(self.seed, &format!("{}/{id}", subject.tile()));
        let mut random = Random::new(seed);
        match subject {
            Subject::Model(model) => {
                let placed = if self.augment { model.augmented(&mut random) } else { model.placed() };
                let truth = Exact::new(&placed.mesh).ok_or("the model has no surface")?;
                let scan = scan(&placed, self.options, 0.0, random.bits()).ok_or("the model has no surface")?;
                let setup = Setup::ALL.iter().position(|s| *s == scan.setup).unwrap_or(0) as u8;
                let made = Conditions { setup, noise: scan.noise, density: scan.density };
                self.asked(&scan.site(&id), &truth, &made, random)
            }
            Subject::Real(real) => {
                let turned = if self.augment { real.turned(&mut random) } else { real.clone() };
                let truth = Seen::new(&turned).ok_or("the building has no points")?;
                let site = turned.copy(&id, self.options, &mut random);
                let area = turned.site.footprint.as_ref().map_or(1.0, geo::Area::unsigned_area).max(1.0);
                // Nobody knows how much noise a real scan has.
                let noise = f64::NAN;
                let made = Conditions { setup: REAL, noise, density: site.points.len() as f64 / area };
                self.asked(&site, &truth, &made, random)
            }
        }
    }

    /// All questions about a scan.
    fn asked(&self, site: &Site, truth: &dyn Answers, made: &Conditions, mut random: Random) -> Result<Sample, String> {
        let building =
            Partitioned::new(site, self.parameters).map_err(|failure| format!("no partition: {:?}", failure.reason))?;
        let inputs = Inputs::new(&building);

        let scale = inputs.scale();
        let cells = queries::cells(&building, truth, &self.sizes, &mut random);
        if cells.is_empty() {
            return Err("no cell of the partition lies in the footprint and was scanned".to_owned());
        }
        let mut places = truth.near(self.sizes.near, scale, &mut random);
        places.extend(queries::uniform(truth, self.sizes.uniform, scale, &mut random));
        places.extend(cells.iter().flat_map(|cell| &cell.samples));
        let vote = HeightField.occupancy(&building).map_err(|error| error.to_string())?;
        let of_cell = |values: &[f64], cell: &CellQuery| values.get(cell.cell as usize).map_or(0.0, |v| *v as f32);
        let halves = |values: Vec<f32>| values.into_iter().map(bits).collect::<Vec<u16>>();
        let answers: Vec<Option<bool>> = places.iter().map(|p| truth.inside(p)).collect();

        let Asked { place, patch, radius } = self.ask(&inputs, &places);
        Ok(Sample {
            raster: if self.sizes.grid == 0 { Vec::new() } else { halves(inputs.raster(self.sizes.grid)) },
            subsample: halves(inputs.subsample(self.sizes.subsample)),
            place,
            patch: halves(patch),
            radius,
            inside: answers.iter().map(|answer| u8::from(*answer == Some(true))).collect(),
            known: answers.iter().map(|answer| u8::from(answer.is_some())).collect(),
            distance: places.iter().map(|p| truth.distance(p) as f32).collect(),
            cell_inside: cells.iter().map(|cell| cell.inside as f32).collect(),
            cell_known: cells.iter().map(|cell| cell.known as f32).collect(),
            cell_volume: cells.iter().map(|cell| of_cell(&building.volumes, cell)).collect(),
            cell_vote: cells.iter().map(|cell| of_cell(&vote, cell)).collect(),
            scale: scale as f32,
            exact: u8::from(truth.is_exact()),
            setup: made.setup,
            noise: made.noise as f32,
            density: made.density as f32,
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
