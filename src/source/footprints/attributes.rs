//! The attributes of features by their names.

use std::collections::HashSet;

use serde_json::{Map, Value};

/// The names of attributes in the order in which they first occur.
#[derive(Default)]
pub(super) struct Columns {
    pub names: Vec<String>,
    seen: HashSet<String>,
}

impl Columns {
    pub fn extend<'a>(&mut self, names: impl IntoIterator<Item = &'a String>) {
        for name in names {
            if !self.seen.contains(name) {
                self.seen.insert(name.clone());
                self.names.push(name.clone());
            }
        }
    }
}

/// The value of an attribute by its name; by its name without regard to case where there is no such.
pub(super) fn attribute<'a>(attributes: &'a Map<String, Value>, name: &str) -> Option<&'a Value> {
    attributes
        .get(name)
        .or_else(|| attributes.iter().find(|(key, _)| key.eq_ignore_ascii_case(name)).map(|(_, value)| value))
}
