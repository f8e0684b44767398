//! What the makers of CityJSON warn of beside its schema: a file that has it is valid, but larger than it need be, or some
//! programs will not understand all of it.
//!
//! The three warnings are those of `cjval` 0.10. They are counted here because it tells none where it has found an error of any
//! kind, compiles the schema for every feature of a sequence, and takes (1, 23, 4) and (12, 3, 4) for one vertex.

use std::collections::{BTreeSet, HashSet};

use serde_json::{Map, Value};

/// The members that the schema knows of a CityJSON object.
const ROOT: [&str; 9] = [
    "type",
    "version",
    "extensions",
    "transform",
    "metadata",
    "CityObjects",
    "vertices",
    "appearance",
    "geometry-templates",
];

/// Counts what is warned of.
#[derive(Debug, Default)]
pub(super) struct Warnings {
    unknown: BTreeSet<String>,
    duplicates: Count,
    unused: Count,
}

/// How many vertices, in how many features or files.
#[derive(Debug, Default)]
struct Count {
    vertices: usize,
    pieces: usize,
}

impl Count {
    fn add(&mut self, vertices: usize) {
        self.vertices += vertices;
        self.pieces += usize::from(vertices > 0);
    }

    /// `3 vertices (in 2 features)`.
    fn told(&self, is_sequence: bool) -> String {
        let of = if is_sequence { format!(" (in {} features)", self.pieces) } else { String::new() };
        format!("{} {}{of}", self.vertices, if self.vertices == 1 { "vertex" } else { "vertices" })
    }
}

impl Warnings {
    /// Takes the members of the root of a file.
    pub fn root(&mut self, root: &Map<String, Value>) {
        let unknown = root.keys().filter(|name| !name.starts_with('+') && !ROOT.contains(&name.as_str()));
        self.unknown.extend(unknown.cloned());
        self.vertices(root);
    }

    /// Takes the vertices and objects of a file or a feature.
    pub fn vertices(&mut self, piece: &Map<String, Value>) {
        let Some(vertices) = piece.get("vertices").and_then(Value::as_array) else { return };
        let mut seen = HashSet::with_capacity(vertices.len());
        self.duplicates.add(vertices.iter().filter(|vertex| !seen.insert(*vertex)).count());
        let mut used = vec![false; vertices.len()];
        for object in piece.get("CityObjects").and_then(Value::as_object).into_iter().flat_map(Map::values) {
            let list = |name: &str| object.get(name).and_then(Value::as_array).into_iter().flatten();
            let addresses = list("address").filter_map(|address| address.pointer("/location/boundaries"));
            let geometries = list("geometry").filter_map(|geometry| geometry.get("boundaries"));
            geometries.chain(addresses).for_each(|boundaries| mark(boundaries, &mut used));
        }
        self.unused.add(used.iter().filter(|used| !**used).count());
    }

    /// What is warned of, one sentence each.
    pub fn told(&self, is_sequence: bool) -> Vec<String> {
        let mut told = Vec::new();
        if !self.unknown.is_empty() {
            let names: Vec<String> = self.unknown.iter().map(|name| format!("{name:?}")).collect();
            told.push(format!(
                "the schema does not know the members {} of the root: programs may pass over them",
                names.join(", ")
            ));
        }
        if self.duplicates.vertices > 0 {
            told.push(format!("{} at the place of another", self.duplicates.told(is_sequence)));
        }
        if self.unused.vertices > 0 {
            told.push(format!("{} in no geometry", self.unused.told(is_sequence)));
        }
        told
    }
}

/// Marks the vertices that boundaries name, however deep they are nested.
fn mark(boundaries: &Value, used: &mut [bool]) {
    match boundaries {
        Value::Array(parts) => parts.iter().for_each(|part| mark(part, used)),
        Value::Number(number) => {
            let place = number.as_u64().and_then(|index| usize::try_from(index).ok());
            if let Some(used) = place.and_then(|index| used.get_mut(index)) {
                *used = true;
            }
        }
        _ => {}
    }
}
