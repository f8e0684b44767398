//! What the page is given: a head in JSON and columns of numbers, packed as those of [`view`](crate::view).

use serde::Serialize;

use super::Step;
use super::cells::Cells;
use super::drawn::Drawn;
use super::figures::{Figure, Parameter, figures, parameters};
use super::polygons::{Faces, PLANES, SURFACES};
use crate::building::Building;
use crate::error::Result;
use crate::network::FieldOptions;
use crate::reconstruct::Steps;
use crate::run::Chosen;
use crate::view::cloud::Cloud;
use crate::view::packed::{STEPS_PER_METRE, packed};

/// What the page is told in JSON.
#[derive(Debug, Serialize)]
struct Head {
    id: String,
    gable: &'static str,
    crs: String,
    origin: [f64; 3],
    metres_per_unit: [f64; 3],
    steps_per_metre: f64,
    /// The highest level of detail that was reached, or nothing.
    lod: &'static str,
    /// Why LoD 2.2 of the whole building was not reached.
    failure: Option<String>,
    notes: Vec<String>,
    steps: Vec<StepHead>,
    plane_kinds: [&'static str; PLANES.len()],
    surfaces: [&'static str; SURFACES.len()],
    columns: Vec<(&'static str, usize)>,
}

/// A step.
#[derive(Debug, Serialize)]
struct StepHead {
    key: Step,
    is_reached: bool,
    figures: Vec<Figure>,
    parameters: Vec<Parameter>,
}

/// The contents of a page while they are gathered.
#[derive(Debug)]
pub(super) struct Payload {
    head: Head,
    drawn: Drawn,
}

impl Payload {
    /// All that is told in words and figures.
    pub fn new(chosen: &Chosen, building: &Building, steps: &Steps, field: &FieldOptions) -> Self {
        let frame = chosen.site.frame;
        let step = |key: Step| StepHead {
            key,
            is_reached: key.is_reached(steps),
            figures: figures(key, steps, building, field),
            parameters: parameters(key, &steps.parameters, &chosen.segmentation, field),
        };
        let notes = chosen.notes.iter().chain(&building.notes).cloned().collect();
        let head = Head {
            id: building.id.clone(),
            gable: env!("CARGO_PKG_VERSION"),
            crs: chosen.crs.to_string(),
            origin: frame.origin,
            metres_per_unit: frame.metres_per_unit,
            steps_per_metre: STEPS_PER_METRE,
            lod: building.outcome.lod().unwrap_or_default(),
            failure: building.outcome.reason().map(|(_, detail)| detail.to_owned()),
            notes,
            steps: Step::ALL.map(step).into(),
            plane_kinds: PLANES,
            surfaces: SURFACES,
            columns: Vec::new(),
        };
        Self { head, drawn: Drawn::default() }
    }

    /// All that is drawn.
    pub fn draw(&mut self, steps: &Steps, building: &Building, cloud: &Cloud) {
        self.drawn.add_cloud(cloud);
        self.drawn.add_points(steps, building);
        self.drawn.add_planes(steps);
        self.drawn.cells = Cells::of(steps);
        self.drawn.faces = Faces::of(steps.surface.iter().flat_map(|surface| &surface.solids));
    }

    /// All of it as text.
    ///
    /// # Errors
    /// Never in practice: memory takes every byte.
    pub fn pack(mut self) -> Result<String> {
        self.head.columns = self.drawn.in_order().map(|(name, column)| (name, column.len())).collect();
        packed(&self.head, self.drawn.in_order().map(|(_, column)| column))
    }
}
