//! The truth as a city model.

use std::path::Path;

use serde_json::json;

use super::super::model::Model;
use super::{Job, Scanned, layout};
use crate::building::{Building, Measures, Outcome};
use crate::error::Result;
use crate::record::Record;
use crate::sink::{self, Metadata, Sink};
use crate::site::QUANTUM;
use crate::solid::{self, Part};
use crate::source::cityjson::Transform;

/// Opens the file.
pub(super) fn create(path: &Path, job: &Job, models: &[Model]) -> Result<Box<dyn Sink>> {
    let metadata = Metadata {
        title: "what was scanned".to_owned(),
        reference_system: job.crs.reference_system(),
        crs: Some(job.crs.clone()),
        transform: Transform { scale: [QUANTUM; 3], translate: layout::corner(models).map(f64::trunc) },
        others: Metadata::making(json!({"scan": job.options, "seed": job.seed})),
        ..Metadata::default()
    };
    sink::create(path, metadata, job.overwrite)
}

/// A model as a building with its true footprint.
pub(super) fn building(scanned: &Scanned) -> Building {
    let model = scanned.model;
    let step = model.frame.step();
    Building {
        id: scanned.id.clone(),
        frame: model.frame,
        attributes: scanned.attributes.clone(),
        model: solid::Model {
            footprint: solid::quantise_footprint(&model.footprint, step),
            ground: (model.ground / step[2]).round() as i64,
            parts: vec![Part { lod22: Some(model.solid.as_ref().clone()), ..Part::default() }],
            ..solid::Model::default()
        },
        outcome: Outcome::Lod22,
        measures: Measures::default(),
        record: Record::default(),
        notes: Vec::new(),
    }
}
