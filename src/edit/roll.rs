//! The list of buildings: what is known of each, and the most urgent first.

use std::collections::HashMap;
use std::path::Path;

use serde::Serialize;

use super::drawn::extent;
use super::need::{Condition, Need};
use crate::edits::State;
use crate::error::{Error, InputError, Result};
use crate::sink::prefix_in;
use crate::site::Site;
use crate::source::cityjson::{self, CityObject};
use crate::source::open::refuse_pipe;

/// How urgent a building is that the model lacks.
const ABSENT: f64 = 10.0;

/// The list of buildings, as the page is given it.
#[derive(Debug, Serialize)]
pub(super) struct Roll<'a> {
    /// The file of the model.
    pub name: &'a str,
    pub gable: &'static str,
    pub crs: &'a str,
    pub units: Units,
    /// Who edits.
    pub author: Option<&'a str>,
    pub edits_file: String,
    pub export_file: String,
    pub notes: &'a [String],
    #[serde(flatten)]
    pub buildings: Buildings,
}

/// Metres per unit of the CRS, in the plan and upwards.
#[derive(Debug, Serialize)]
pub(super) struct Units {
    plan: f64,
    height: f64,
}

impl From<[f64; 3]> for Units {
    fn from([plan, _, height]: [f64; 3]) -> Self {
        Self { plan, height }
    }
}

/// All rows, the most urgent first.
#[derive(Debug, Serialize)]
pub(super) struct Buildings {
    counts: Counts,
    buildings: Vec<Row>,
}

/// How many buildings are in each state.
#[derive(Debug, Default, Serialize)]
struct Counts {
    open: usize,
    accepted: usize,
    edited: usize,
    rejected: usize,
}

impl From<Vec<Row>> for Buildings {
    fn from(mut rows: Vec<Row>) -> Self {
        rows.sort_by(|a, b| b.urgency.total_cmp(&a.urgency).then_with(|| a.id.cmp(&b.id)));
        let mut counts = Counts::default();
        for row in &rows {
            *match row.state {
                State::Open => &mut counts.open,
                State::Accepted => &mut counts.accepted,
                State::Edited => &mut counts.edited,
                State::Rejected => &mut counts.rejected,
            } += 1;
        }
        Self { counts, buildings: rows }
    }
}

/// A building in the list.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Row {
    pub id: String,
    pub state: State,
    /// How many edits it has.
    pub edits: usize,
    /// How much it needs a person; 0 where it needs none, or a person has decided.
    pub urgency: f64,
    /// Why, the most urgent first.
    pub why: Vec<String>,
    lod: Option<String>,
    rmse: Option<f64>,
    missing: Option<f64>,
    excess: Option<f64>,
    confidence: Option<f64>,
    faces: Option<usize>,
    failure: Option<String>,
    /// The middle of its box, in the CRS.
    centre: Option<[f64; 2]>,
}

impl Row {
    /// A building in a condition, if the model has it.
    pub fn new(site: &Site, (state, edits): (State, usize), condition: Option<&Condition>) -> Self {
        let absent = || Need { urgency: ABSENT, why: vec!["not in the model".to_owned()] };
        let Need { urgency, why } = condition.map_or_else(absent, Condition::need);
        let is_decided = matches!(state, State::Accepted | State::Rejected);
        let condition = condition.cloned().unwrap_or_default();
        let middle = |[low, high]: [[f64; 2]; 2]| [0, 1].map(|axis| f64::midpoint(low[axis], high[axis]));
        Self {
            id: site.id.clone(),
            state,
            edits,
            urgency: if is_decided { 0.0 } else { urgency },
            why,
            lod: Some(condition.lod).filter(|lod| !lod.is_empty()),
            rmse: condition.rmse,
            missing: condition.missing,
            excess: condition.excess,
            confidence: condition.confidence,
            faces: condition.faces,
            failure: condition.failure.map(|(_, detail)| detail),
            centre: extent(site).map(middle),
        }
    }
}

/// The conditions of the buildings of a model, by their ids.
///
/// # Errors
/// The model cannot be read, is no CityJSON, or has no building.
pub(super) fn conditions(model: &Path) -> Result<HashMap<String, Condition>> {
    refuse_pipe(model)?;
    let pieces = cityjson::features(model)?;
    let prefix = prefix_in(pieces.head()).to_owned();
    let mut conditions = HashMap::new();
    for piece in pieces {
        let piece = match piece {
            Ok(piece) => piece,
            // A feature that cannot be read is a building that the model lacks.
            Err(Error::Input(_)) => continue,
            Err(other) => return Err(other),
        };
        for group in piece.groups() {
            let group: Vec<&CityObject> = group.into_iter().filter_map(|i| piece.objects.get(i)).collect();
            let Some(top) = group.first().filter(|top| top.kind == "Building") else { continue };
            conditions.insert(top.id.clone(), Condition::of_attributes(&top.attributes, &prefix, faces(&group)));
        }
    }
    if conditions.is_empty() {
        let fault = InputError::new(model, "no building that can be read", "the model that is to be mended");
        return Err(fault.remedy("`gable validate` tells what is wrong with the file").into());
    }
    Ok(conditions)
}

/// Number of faces at LoD 2.2.
fn faces(group: &[&CityObject]) -> usize {
    let geometries = group.iter().flat_map(|object| &object.geometries).filter(|geometry| geometry.lod == "2.2");
    geometries.flat_map(|geometry| &geometry.shells).map(|shell| shell.faces.len()).sum()
}
