//! What was found wrong, with the face that it was found on.

use serde::Serialize;

use super::feature::{Face, Feature};
use crate::audit::{self, Finding};
use crate::source::cityjson::CityObject;

/// A fault as the page shows it.
#[derive(Debug, Serialize)]
pub(super) struct Fault {
    code: u16,
    name: &'static str,
    /// What is wrong, for a person.
    info: String,
    /// Where it is in the file.
    place: String,
    /// Whether labels or attributes are wrong and the geometry is not.
    about_labels: bool,
    /// The object it is on: an index into the group of the feature.
    #[serde(skip_serializing_if = "Option::is_none")]
    object: Option<usize>,
    /// The face it is on, counted from the first of the feature.
    #[serde(skip_serializing_if = "Option::is_none")]
    face: Option<usize>,
}

impl Fault {
    /// The faults of a feature: those of its geometry, then those of its labels and attributes.
    pub fn of(found: &audit::Feature, group: &[&CityObject], feature: &Feature) -> Vec<Self> {
        let errors = found.errors.iter().map(|finding| (finding, false));
        let labels = found.semantic_errors.iter().map(|finding| (finding, true));
        errors
            .chain(labels)
            .map(|(finding, about_labels)| {
                let object = group.iter().position(|object| is_on(&finding.id, &object.id));
                let named = |face: &Face| object == Some(face.object) && names(&finding.id, face);
                let face = feature.faces.iter().position(named);
                Self { about_labels, object, face, ..Self::of_file(finding) }
            })
            .collect()
    }

    /// A fault of a file as a whole.
    pub fn of_file(finding: &Finding) -> Self {
        Self {
            code: finding.code,
            name: finding.description,
            info: finding.info.clone(),
            place: finding.id.clone(),
            about_labels: false,
            object: None,
            face: None,
        }
    }
}

/// What follows the id of the object in a place, when that is the object.
fn rest<'a>(place: &'a str, object: &str) -> Option<&'a str> {
    place.strip_prefix("coid=")?.strip_prefix(object)
}

/// Whether a place is on this object.
fn is_on(place: &str, object: &str) -> bool {
    rest(place, object).is_some_and(|rest| rest.is_empty() || rest.starts_with('|'))
}

/// Whether a place, which is on the object of the face, ends with this face.
fn names(place: &str, face: &Face) -> bool {
    let at = face.place;
    let solid = at.solid.map_or_else(String::new, |solid| format!("|solid={solid}"));
    place.ends_with(&format!("|geom={}{solid}|shell={}|face={}", at.geometry, at.shell, at.face))
}
