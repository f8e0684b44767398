//! One building, one field: reconstructed as ever, with an eye on what the field says on the way.

use std::sync::{Mutex, PoisonError};

use nalgebra::Point3;
use serde::Serialize;

use super::cells::CellFindings;
use super::subject::Subject;
use crate::building::{Building, Outcome, Reason};
use crate::evaluate::{Shape, overlap, surface_distance};
use crate::reconstruct::occupancy::{Occupancy, OccupancyError};
use crate::reconstruct::{Parameters, Partitioned, label, reconstruct};

/// Sample points per surface for the distances between surfaces.
const SAMPLES: usize = 5_000;
/// Vertical rays for the overlap of volumes.
const RAYS: usize = 10_000;

/// What a field came to on one building.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Findings {
    /// The building.
    pub id: String,
    /// On the cells; `None` when there were none, for want of planes.
    pub cells: Option<CellFindings>,
    /// Share of the places near the surface whose side is right.
    pub near: Option<f64>,
    /// Share of the places in the building's box whose side is right.
    pub uniform: Option<f64>,
    /// On the LoD 2.2 model; `None` when there is none.
    pub surface: Option<SurfaceFindings>,
    /// Why there is none.
    pub failure: Option<Reason>,
    /// Why the vote decided in place of the field.
    pub fallback: Option<String>,
}

/// How a LoD 2.2 model compares with the truth. R is the largest side of the true building's box.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SurfaceFindings {
    /// Volume of the intersection over that of the union.
    pub volume_iou: Option<f64>,
    /// Hausdorff distance over R.
    pub hausdorff: Option<f64>,
    /// Symmetric mean Hausdorff distance over R.
    pub symmetric_mean: Option<f64>,
    /// Root mean square of the height over the true roof, metres.
    pub roof_rmse: Option<f64>,
    /// Faces of all its solids.
    pub faces: usize,
}

/// Reconstructs a building with a field, and measures both.
pub fn observe(subject: &Subject, field: &dyn Occupancy, parameters: &Parameters) -> Findings {
    let watched = Watched { field, subject, parameters, seen: Mutex::new(None) };
    let building = reconstruct(&subject.site, parameters, &watched);
    watched.ask_if_not_seen();
    let seen = watched.seen.into_inner().unwrap_or_else(PoisonError::into_inner).unwrap_or_default();
    let surface = match building.outcome {
        Outcome::Lod22 => surface(&building, subject),
        _ => None,
    };
    Findings {
        id: building.id,
        cells: seen.cells,
        near: seen.near,
        uniform: seen.uniform,
        surface,
        failure: building.outcome.reason().map(|(reason, _)| reason),
        fallback: building.measures.field_fallback,
    }
}

fn surface(building: &Building, subject: &Subject) -> Option<SurfaceFindings> {
    let shape = Shape::of_building(building)?;
    let distance = surface_distance(&shape, &subject.shape, SAMPLES, super::hash(0, &building.id));
    let overlap = overlap(&shape, &subject.shape, RAYS);
    Some(SurfaceFindings {
        volume_iou: overlap.map(|o| o.volume_iou),
        hausdorff: distance.map(|d| d.relative_hausdorff),
        symmetric_mean: distance.map(|d| d.relative_symmetric_mean),
        roof_rmse: overlap.and_then(|o| Some(o.roofs?.rmse)),
        faces: shape.faces.len(),
    })
}

/// A field that is watched while it is asked for the first time, which is with the finest tolerances.
#[derive(Debug)]
struct Watched<'a> {
    field: &'a dyn Occupancy,
    subject: &'a Subject,
    parameters: &'a Parameters,
    seen: Mutex<Option<Seen>>,
}

impl Watched<'_> {
    /// Asks the field about a building that was made without it.
    fn ask_if_not_seen(&self) {
        let seen = || self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        if seen().is_none()
            && let Ok(building) = Partitioned::new(&self.subject.site, self.parameters)
        {
            // What fails has nothing to show.
            let _ = self.occupancy(&building);
        }
    }
}

/// What was seen of a field.
#[derive(Debug, Default)]
struct Seen {
    cells: Option<CellFindings>,
    near: Option<f64>,
    uniform: Option<f64>,
}

impl Seen {
    fn new(watched: &Watched, building: &Partitioned, occupancy: &[f64]) -> Result<Self, OccupancyError> {
        let Watched { field, subject, parameters, .. } = watched;
        let fractions = subject.fractions(building);
        let labels = label(building, occupancy, field.is_height_field(), parameters);
        let [near, uniform] = [&subject.near, &subject.uniform];
        Ok(Self {
            cells: Some(CellFindings::new(building, occupancy, &labels, &fractions)),
            near: near.accuracy(&field.probability(building, &near.places)?),
            uniform: uniform.accuracy(&field.probability(building, &uniform.places)?),
        })
    }
}

impl Occupancy for Watched<'_> {
    fn occupancy(&self, building: &Partitioned) -> Result<Vec<f64>, OccupancyError> {
        let occupancy = self.field.occupancy(building)?;
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        if seen.is_none() {
            *seen = Some(Seen::new(self, building, &occupancy)?);
        }
        Ok(occupancy)
    }

    fn probability(&self, building: &Partitioned, places: &[Point3<f64>]) -> Result<Vec<f64>, OccupancyError> {
        self.field.probability(building, places)
    }

    fn is_height_field(&self) -> bool {
        self.field.is_height_field()
    }
}
