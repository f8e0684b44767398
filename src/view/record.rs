//! The report of the run that made a model: what of it the page shows.

use std::collections::HashMap;
use std::path::Path;

use serde_json::{Map, Value};

use crate::error::{InputError, Result};
use crate::source::open;

/// Members of the report about the run as a whole.
const RUN: [&str; 12] = [
    "gable",
    "command",
    "started",
    "interrupted",
    "field",
    "counts",
    "quality",
    "wall_seconds",
    "cpu_seconds",
    "threads",
    "peak_memory_bytes",
    "warnings",
];

/// Members of the report of a building that its attributes do not tell.
const BUILDING: [&str; 6] = ["cells", "solids_lod12", "solids_lod22", "setbacks", "wall_ms", "cpu_ms"];

/// What a report says.
#[derive(Debug)]
pub(super) struct Record {
    /// Of the run as a whole.
    pub run: Map<String, Value>,
    /// Of each building, by its id.
    pub buildings: HashMap<String, Value>,
}

/// Reads `OUT.report.json`.
///
/// # Errors
/// The file cannot be read, or is no report of gable's.
pub(super) fn read(path: &Path) -> Result<Record> {
    let bytes = open::whole(path, "the report of a run")?;
    let refusal = |found: String| {
        let expected = "the report of a run, as `gable reconstruct` writes it beside the model";
        InputError::new(path, found, expected).remedy("Give OUT.report.json, or leave --report out")
    };
    let report: Value = serde_json::from_slice(&bytes).map_err(|e| refusal(e.to_string()))?;
    let (Some(_), Some(buildings)) = (report.get("gable"), report.get("buildings").and_then(Value::as_array)) else {
        return Err(refusal("no \"gable\" and no list of \"buildings\"".to_owned()).into());
    };
    let pick = |from: &Value, names: &[&str]| -> Map<String, Value> {
        names.iter().filter_map(|name| Some(((*name).to_owned(), from.get(name)?.clone()))).collect()
    };
    let mut run = pick(&report, &RUN);
    let tiles = report.pointer("/inputs/tiles").and_then(Value::as_array).into_iter().flatten();
    let problems = tiles.filter_map(|tile| tile.get("problems")?.as_array()).flatten().cloned();
    run.insert("tile_problems".to_owned(), problems.collect());
    let of_building = |building: &Value| {
        let id = building.get("id")?.as_str()?.to_owned();
        Some((id, Value::Object(pick(building, &BUILDING))))
    };
    Ok(Record { run, buildings: buildings.iter().filter_map(of_building).collect() })
}
