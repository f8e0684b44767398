//! What makes a run the same run: then, and only then, what another has left may be taken over.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;

use rayon::ThreadPool;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::buildings::Task;
use crate::error::{InputError, Result};
use crate::site::Site;

/// All that a building depends on: the program, the parameters, and what is known of every building before the method
/// sees it. That is held against the points and footprints themselves, not against the names and dates of files.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Identity {
    /// Version of gable.
    gable: String,
    /// Parameters of the method.
    parameters: Value,
    /// Hash of the tasks.
    inputs: u64,
}

impl Identity {
    /// The identity of a run with these parameters over inputs of this hash; see [`hash_of`].
    pub(super) fn new(parameters: Value, inputs: u64) -> Self {
        Self { gable: env!("CARGO_PKG_VERSION").to_owned(), parameters, inputs }
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
        } else if self.inputs != other.inputs {
            (
                "buildings made from other tiles, footprints or classes of points".to_owned(),
                "those of this run".to_owned(),
            )
        } else {
            return Ok(());
        };
        let fault = InputError::new(folder, found, expected).at("what an earlier run has left");
        Err(fault
            .remedy("Resume with the same inputs and options, or give --overwrite without --resume to start anew")
            .into())
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

/// The hash of all that is known of the buildings, computed on the threads of `pool`.
pub(super) fn hash_of(tasks: &[Task], pool: &ThreadPool) -> u64 {
    let hashes: Vec<u64> = pool.install(|| tasks.par_iter().map(hash_of_task).collect());
    let mut hasher = DefaultHasher::new();
    hashes.hash(&mut hasher);
    hasher.finish()
}

fn hash_of_task(task: &Task) -> u64 {
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
