//! What a conversion leaves out, so that nothing is lost silently.

use std::collections::BTreeMap;

use serde_json::Value;

use crate::source::cityjson::{CityModel, GeometryKind};

/// What was left out, and how often.
#[derive(Debug, Default)]
pub(super) struct Losses {
    /// Members of the file or its features.
    members: BTreeMap<String, usize>,
    /// Geometries, by their type.
    geometries: BTreeMap<String, usize>,
    /// Places of addresses.
    places: usize,
}

impl Losses {
    /// Takes out of a model what cannot be carried over, and what CityJSON 2.0 writes otherwise than 1.0.
    pub(super) fn take(&mut self, model: &mut CityModel) {
        for name in std::mem::take(&mut model.others) {
            *self.members.entry(name).or_default() += 1;
        }
        for object in &mut model.objects {
            object.geometries.retain(|geometry| match &geometry.kind {
                GeometryKind::Other(kind) => {
                    *self.geometries.entry(kind.clone()).or_default() += 1;
                    false
                }
                _ => true,
            });
            let Some(address) = object.members.get_mut("address") else { continue };
            if address.is_object() {
                *address = Value::Array(vec![address.take()]);
            }
            for address in address.as_array_mut().into_iter().flatten().filter_map(Value::as_object_mut) {
                // It would refer to vertices by number.
                self.places += usize::from(address.shift_remove("location").is_some());
            }
        }
    }

    /// What to tell the user.
    pub(super) fn messages(self) -> Vec<String> {
        let mut messages = Vec::new();
        for (name, count) in self.members {
            let what = match name.as_str() {
                "appearance" => "materials and textures (appearance)".to_owned(),
                "geometry-templates" => "geometry templates".to_owned(),
                other => format!("the member {other:?}"),
            };
            let of = if count > 1 { format!(" of {count} features") } else { String::new() };
            messages.push(format!("{what}{of} left out: gable does not carry them over"));
        }
        for (kind, count) in self.geometries {
            let what = match kind.as_str() {
                "GeometryInstance" => "instances of geometry templates".to_owned(),
                other => format!("geometries of type {other}, which have no faces,"),
            };
            messages.push(format!("{count} {what} left out"));
        }
        if self.places > 0 {
            messages.push(format!("the locations of {} addresses left out; the addresses stay", self.places));
        }
        messages
    }
}
