//! Validates city model files, from anyone: CityJSON 1.0 to 2.0 and CityJSONSeq.
//!
//! A file is read feature by feature and checked on the integers that stand in it, by the levels of
//! [`validate`](crate::validate): surfaces as faces, composite surfaces also as connected, solids with their voids,
//! composite solids, and the parts of a building together. A file of real coordinates (CityJSON 1.0 may have them) is checked
//! on the coarsest decimal grid that holds them, at most six decimals of its unit. As in val3dity, vertices nearer than the
//! snap tolerance are one, the first of them; the level above is checked where the one below is sound.
//!
//! An intersection (306) is one of the faces as they stand in the file, however small: no tolerance is known to the programs
//! that will read it. On a grid of 1 mm the rounding of two narrow faces beside each other can make one (once in the 4 400
//! solids of five 3DBAG tiles, whose maker had checked them before they were rounded).
//!
//! The schema of the version that the file states is checked as well, and told apart from the geometry.
//!
//! What labels and attributes say of the geometry is checked too and kept apart, because val3dity would not call it invalid. Only
//! a terrain (`TINRelief`) that looks down is called invalid here and not there: like a solid that is inside out (405).

mod attributes;
mod feature;
mod grid;
mod hints;
mod report;
mod schema;
mod templates;
#[cfg(test)]
mod tests;
mod warnings;

use std::path::Path;

use rayon::prelude::*;

use crate::error::{Error, InputError, Result};
use crate::sink::prefix_in;
use crate::source::cityjson::{self, CityModel};
use crate::source::crs::Crs;
use crate::validate::Tolerances;
use grid::Grid;
pub use report::{Feature, Finding, Overview, Parameters, Report};
use schema::Schema;
use templates::Templates;

/// How a file is checked.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Tolerances of rings, polygons and vertices.
    pub tolerances: Tolerances,
    /// How far solids and building parts may overlap, metres.
    pub overlap: f64,
    /// Of each geometry only the faults of the lowest level (rings, polygons, shells, …) that has any, as val3dity does.
    pub first_level: bool,
    /// Whether the file is checked by the official schema of its version.
    pub schema: bool,
}

impl Default for Options {
    /// The default tolerances; an overlap of 1 mm, that of the snap tolerance, is no overlap.
    fn default() -> Self {
        let tolerances = Tolerances::default();
        Self { tolerances, overlap: tolerances.snap, first_level: false, schema: true }
    }
}

/// How many features of a sequence are held at a time.
const BATCH: usize = 512;

/// Checks a file. After every batch `progress` is told the number of features so far and the number of bytes that were read
/// since it was last told.
///
/// # Errors
/// The file cannot be read or is no CityJSON, or its CRS is geographic: distances in degrees mean nothing. A feature of a
/// sequence that cannot be read is a finding on the file (901), and the others are checked.
pub fn audit(path: &Path, options: &Options, progress: &mut dyn FnMut(usize, u64)) -> Result<Report> {
    let mut pieces = if options.schema { cityjson::features_with_text(path) } else { cityjson::features(path) }?;
    let mut schema = options.schema.then(|| Schema::of(path));
    if let Some(schema) = &mut schema {
        schema.root(&pieces.take_text());
    }
    let crs = pieces.head().crs_code().and_then(|code| Crs::parse(&code).ok());
    if let Some(crs) = crs.as_ref().filter(|crs| crs.is_geographic) {
        return Err(InputError::new(path, format!("the geographic CRS {}", crs.name), "coordinates in metres or feet")
            .at("metadata.referenceSystem")
            .remedy("Reproject the model before it is validated")
            .into());
    }
    let metres_per_unit = crs.as_ref().map_or([1.0; 3], |crs| crs.metres_per_unit);
    let version = pieces.head().version.clone();
    let mut report = Report::open(path, options);
    report.input_file_type = format!("CityJSON {version}");
    report.crs = crs.map(|crs| crs.to_string());
    if pieces.head().transform.is_none() && !version.starts_with("1.0") {
        let message = format!(
            "the file has no \"transform\", which CityJSON {version} requires; its numbers were taken as they are"
        );
        report.dataset_errors.push(Finding::new(901, "", message));
    }
    let head = pieces.head().clone();
    let templates = Templates::of(&head, metres_per_unit);
    let mut told = 0;
    loop {
        let mut batch = Vec::new();
        for _ in 0..BATCH {
            let Some(piece) = pieces.next() else { break };
            if let Some(schema) = &mut schema {
                schema.feature(&pieces.take_text());
            }
            match piece {
                Ok(model) => batch.push(model),
                Err(Error::Input(fault)) => report.dataset_errors.push(Finding::new(901, "", fault.to_string())),
                Err(other) => return Err(other),
            }
        }
        let read = pieces.bytes_read();
        if read == told && batch.is_empty() {
            break;
        }
        let grids: Vec<Grid> = batch.iter().map(|model| Grid::of(model, metres_per_unit)).collect();
        report.grid_step = report.grid_step.or_else(|| grids.first().map(|grid| grid.step));
        report.features.extend(check(&batch, &grids, &templates, options, prefix_in(&head)));
        progress(report.features.len(), read - told);
        told = read;
    }
    if let Some(schema) = schema {
        let found = schema.close();
        report.schema_errors = found.faults;
        report.schema_warnings = found.warnings;
        report.notes = found.notes;
    }
    Ok(report.close())
}

/// The report on a file that [`audit`] refuses: invalid, with the reason as its fault (901).
pub fn refusal(path: &Path, options: &Options, reason: &Error) -> Report {
    let mut report = Report::open(path, options);
    report.dataset_errors.push(Finding::new(901, "", reason.to_string()));
    report.close()
}

/// The features of some models, in their order.
fn check(models: &[CityModel], grids: &[Grid], templates: &Templates, options: &Options, prefix: &str) -> Vec<Feature> {
    let groups: Vec<_> = models
        .iter()
        .zip(grids)
        .flat_map(|(model, grid)| model.groups().into_iter().map(move |group| (model, grid, group)))
        .map(|(model, grid, group)| {
            (model, grid, group.into_iter().filter_map(|i| model.objects.get(i)).collect::<Vec<_>>())
        })
        .collect();
    groups
        .into_par_iter()
        .map(|(model, grid, group)| feature::check(model, grid, templates, &group, options, prefix))
        .collect()
}
