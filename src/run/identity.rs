//! What makes a run the same run: then, and only then, what another has left may be taken over.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::buildings::Task;
use crate::error::{InputError, Result};
use crate::site::Site;

/// All that the buildings of a run depend on but what is known of each before the method sees it: the program and the
/// parameters. The rest is told by the [hash](hash_of) of each, which is one of points and footprints themselves, not of the names and dates
/// of files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Identity {
    /// Version of gable.
    gable: String,
    /// Parameters of the method.
    parameters: Value,
}

impl Identity {
    /// The identity of a run with these parameters.
    pub(super) fn new(parameters: Value) -> Self {
        Self { gable: env!("CARGO_PKG_VERSION").to_owned(), parameters }
    }

    /// Whether what a run of identity `other` left in `folder` may be taken over.
    ///
    /// # Errors
    /// What differs.
    pub(super) fn check(&self, other: &Self, folder: &Path) -> Result<()> {
        let (found, expected) = if self.gable != other.gable {
            (format!("buildings made by gable {}", other.gable), format!("gable {}", self.gable))
        } else if self.parameters != other.parameters {
            let (mut found, mut expected) = (Vec::new(), Vec::new());
            differences("", &other.parameters, &self.parameters, &mut found, &mut expected);
            (format!("buildings made with {}", found.join(", ")), expected.join(", "))
        } else {
            return Ok(());
        };
        let fault = InputError::new(folder, found, expected).at("what an earlier run has left");
        Err(fault.remedy("Resume with the same options, or give --overwrite without --resume to start anew").into())
    }
}

/// Lists the members that differ, each with its value, on both sides.
fn differences(name: &str, left: &Value, right: &Value, lefts: &mut Vec<String>, rights: &mut Vec<String>) {
    if left == right {
        return;
    }
    if let (Value::Object(a), Value::Object(b)) = (left, right) {
        let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
        for key in keys {
            let member = |map: &serde_json::Map<String, Value>| map.get(key).cloned().unwrap_or_default();
            differences(key, &member(a), &member(b), lefts, rights);
        }
    } else {
        lefts.push(format!("{name} {left}"));
        rights.push(format!("{name} {right}"));
    }
}

/// The hash of all that is known of a building before it is made.
pub(super) fn hash_of(task: &Task) -> u64 {
    let mut hasher = DefaultHasher::new();
    match task {
        Task::Reconstruct { site, notes } => {
            notes.hash(&mut hasher);
            hash_site(site, &mut hasher);
        }
        Task::Keep(building) => {
            building.id.hash(&mut hasher);
            Value::Object(building.attributes.clone()).to_string().hash(&mut hasher);
        }
    }
    hasher.finish()
}

fn hash_site(site: &Site, hasher: &mut DefaultHasher) {
    let Site {
        id,
        frame,
        footprint,
        points,
        ground_points,
        ground,
        ground_line,
        coverage,
        covered,
        eaves,
        attributes,
        record,
        edits,
    } = site;
    let (roofprint, under_eaves) = eaves.as_ref().map(|eaves| (&eaves.outline, &eaves.points)).unzip();
    let mut number = |value: f64| hasher.write_u64(value.to_bits());
    frame.origin.into_iter().chain(frame.metres_per_unit).for_each(&mut number);
    [ground.height, ground.spread, coverage.share].into_iter().for_each(&mut number);
    for points in [points, ground_points, ground_line].into_iter().chain(under_eaves) {
        // The length keeps a point of the ground from being taken for one more of the building.
        number(points.len() as f64);
        points.iter().flat_map(|point| point.iter().copied()).for_each(&mut number);
    }
    for polygon in [footprint.as_ref(), covered.as_ref(), roofprint].into_iter().flatten().flatten() {
        for ring in std::iter::once(polygon.exterior()).chain(polygon.interiors()) {
            // The length keeps a hole from being taken for more of the exterior.
            number(ring.0.len() as f64);
            ring.coords().flat_map(|c| [c.x, c.y]).for_each(&mut number);
        }
    }
    id.hash(hasher);
    std::mem::discriminant(&ground.source).hash(hasher);
    Value::Object(attributes.clone()).to_string().hash(hasher);
    serde_json::to_string(record).unwrap_or_default().hash(hasher);
    serde_json::to_string(edits).unwrap_or_default().hash(hasher);
}
