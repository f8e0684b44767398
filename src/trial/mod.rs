//! Trials of fields: what each is worth, on virtual scans of buildings that are known exactly.
//!
//! ```text
//! truths (models, generator) ─► column: scan ─► subject ─► per field: watched reconstruct ─► Findings ─► Figures
//! ```
//!
//! A [`Column`] is a condition under which all truths are scanned, once for all fields: each field meets the same points,
//! and by that the same cells. A [`Contender`] is a field with a name; the oracle is one that knows the truth and shows
//! what the cells and the cut cost alone. A [`HeldOutTrial`] does the same on real scans, without a truth. Everything follows from one seed, whatever the number of threads.

mod calibration;
mod cells;
mod column;
mod figures;
mod fraction;
mod held_out;
mod oracle;
mod subject;
#[cfg(test)]
mod tests;
mod truths;
mod watched;

use std::sync::Arc;
use std::time::Instant;

use rayon::prelude::*;
use serde::Serialize;

pub use calibration::Calibration;
pub use cells::CellFindings;
pub use column::Column;
pub use figures::Figures;
pub use fraction::inside_fraction;
pub use held_out::{
    Confident, FEWEST_POINTS, HeldOutField, HeldOutFigures, HeldOutFindings, HeldOutTrial, Holding, Split,
};
pub use oracle::Oracle;
pub use subject::{Places, Subject};
pub use truths::{choose, overhanging};
pub use watched::{Findings, SurfaceFindings, observe};

use crate::geometry::hash;
use crate::reconstruct::Parameters;
use crate::reconstruct::occupancy::Occupancy;
use crate::simulate::{Model, scan};

/// A field on trial.
#[derive(Debug, Clone)]
pub struct Contender {
    /// Its name in tables and reports.
    pub name: String,
    /// The field; `None` for the [`Oracle`], which is another for every building.
    pub field: Option<Arc<dyn Occupancy>>,
}

/// What is tried.
#[derive(Debug, Clone)]
pub struct Trial {
    /// The fields.
    pub contenders: Vec<Contender>,
    /// The conditions.
    pub columns: Vec<Column>,
    /// The buildings for all columns but those [with overhangs](Column::needs_overhangs).
    pub models: Vec<Model>,
    /// The buildings for those.
    pub overhanging: Vec<Model>,
    /// Parameters of the reconstruction.
    pub parameters: Parameters,
    /// The seed of scans and places.
    pub seed: u64,
}

/// How far a trial is.
#[derive(Debug, Clone, Copy)]
pub enum Step<'a> {
    /// A column begins, with so many buildings.
    Started {
        /// The column.
        column: Column,
        /// Its buildings.
        buildings: usize,
    },
    /// A building of the column is done by all fields.
    Building,
    /// A column is done.
    Finished {
        /// The column.
        column: Column,
        /// Seconds of all threads together that went into scans.
        scans: f64,
        /// Seconds of all threads together that each field took, measuring included, in the order of the contenders.
        fields: &'a [f64],
    },
}

/// What a column found.
#[derive(Debug, Clone, Serialize)]
pub struct ColumnFindings {
    /// The condition.
    pub column: Column,
    /// How the scans were made.
    pub scan: crate::simulate::ScanOptions,
    /// Buildings that were scanned and seen.
    pub seen: usize,
    /// Buildings of which the scanner saw nothing; they count nowhere else.
    pub unseen: Vec<String>,
    /// What each field came to, in the order of the contenders.
    pub fields: Vec<FieldFindings>,
}

/// What a field came to in a column.
#[derive(Debug, Clone, Serialize)]
pub struct FieldFindings {
    /// The field.
    pub field: String,
    /// Over all buildings.
    pub figures: Figures,
    /// Building by building.
    pub buildings: Vec<Findings>,
}

/// The findings about one building by every field, and the seconds that the scan and each field took.
struct Tried {
    id: String,
    findings: Option<Vec<Findings>>,
    scan: f64,
    fields: Vec<f64>,
}

impl Trial {
    /// Tries all fields under all conditions, on the rayon pool that it is called in.
    pub fn run(&self, observer: &(dyn Fn(Step<'_>) + Sync)) -> Vec<ColumnFindings> {
        self.columns.iter().map(|&column| self.column(column, observer)).collect()
    }

    fn column(&self, column: Column, observer: &(dyn Fn(Step<'_>) + Sync)) -> ColumnFindings {
        let models = if column.needs_overhangs() { &self.overhanging } else { &self.models };
        observer(Step::Started { column, buildings: models.len() });
        let tried: Vec<Tried> = models
            .par_iter()
            .map(|model| {
                let tried = self.building(model, column);
                observer(Step::Building);
                tried
            })
            .collect();
        let sum = |of: &dyn Fn(&Tried) -> f64| tried.iter().map(of).sum::<f64>();
        let seconds: Vec<f64> =
            (0..self.contenders.len()).map(|i| sum(&|t| t.fields.get(i).copied().unwrap_or(0.0))).collect();
        observer(Step::Finished { column, scans: sum(&|t| t.scan), fields: &seconds });
        let unseen = tried.iter().filter(|t| t.findings.is_none()).map(|t| t.id.clone()).collect();
        let seen: Vec<Vec<Findings>> = tried.into_iter().filter_map(|t| t.findings).collect();
        let fields = self.contenders.iter().enumerate().map(|(i, contender)| {
            let buildings: Vec<Findings> = seen.iter().filter_map(|findings| findings.get(i).cloned()).collect();
            FieldFindings { field: contender.name.clone(), figures: Figures::of(&buildings), buildings }
        });
        ColumnFindings { column, scan: column.options(), seen: seen.len(), unseen, fields: fields.collect() }
    }

    fn building(&self, model: &Model, column: Column) -> Tried {
        let started = Instant::now();
        let placed = model.placed();
        let seed = hash(self.seed, &format!("{}/{}", model.id, column.name()));
        let scan = scan(&placed, &column.options(), 0.0, seed).filter(|scan| !scan.points.is_empty());
        let subject = scan.and_then(|scan| Subject::new(scan.site(&model.id), placed.mesh, seed));
        let scan = started.elapsed().as_secs_f64();
        let Some(subject) = subject else {
            return Tried { id: model.id.clone(), findings: None, scan, fields: Vec::new() };
        };
        let (findings, fields) = self
            .contenders
            .iter()
            .map(|contender| {
                let started = Instant::now();
                let found = match &contender.field {
                    Some(field) => observe(&subject, &**field, &self.parameters),
                    None => observe(&subject, &Oracle::new(&subject), &self.parameters),
                };
                (found, started.elapsed().as_secs_f64())
            })
            .unzip();
        Tried { id: model.id.clone(), findings: Some(findings), scan, fields }
    }
}
