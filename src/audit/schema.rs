//! The official schema of the version that a file states.
//!
//! The schemas are those in the `cjval` crate, by the makers of CityJSON, and so are the checks beyond them: parents that
//! know their children, arrays of semantics as long as the boundaries, extensions. Features of a
//! sequence are checked many at a time as one object without vertices, because compiling the schema takes longer than
//! checking a building by it; that their vertices are there is known from reading them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use cjval::CJValidator;
use serde_json::{Map, Value, json};

use super::hints;
use super::report::Finding;
use super::warnings::Warnings;
use crate::guard::guarded;
use crate::source::open;

/// Objects that are checked at a time.
const BATCH: usize = 2_000;
/// So many faults are shown; a wrong name in every building is no news after some.
const SHOWN: usize = 100;
/// Characters of a fault that are shown from its beginning and its end: in between stands the whole of what is refused.
const SHOWN_OF_FAULT: [usize; 2] = [80, 160];
/// What the schema says of an object for which it has several alternatives.
const NO_ALTERNATIVE: &str = " is not valid under any of the given schemas";
/// What cjval finds that counts, in its words; the rest is checked elsewhere, or no fault.
const COUNTED: [&str; 5] = ["json_syntax", "schema", "extensions", "parents_children_consistency", "semantics_arrays"];
/// The members of a head that features rely on.
const OF_HEAD: [&str; 5] = ["type", "version", "transform", "metadata", "extensions"];

/// Checks a file piece by piece.
pub(super) struct Schema {
    /// The file, beside which the schemas of its extensions are looked for.
    path: PathBuf,
    /// What the features of a sequence rely on; empty before the first piece.
    head: Map<String, Value>,
    /// The schemas of extensions that are at hand.
    extensions: Vec<String>,
    /// Whether the schema of an extension that the file declares is not.
    lacks_extension: bool,
    pending: Map<String, Value>,
    warnings: Warnings,
    is_sequence: bool,
    faults: Vec<Finding>,
    /// How many more there are than are shown.
    hidden: usize,
    notes: Vec<String>,
}

/// What was found.
#[derive(Debug, Default)]
pub(super) struct Found {
    /// Where the file is not as the schema wants it.
    pub faults: Vec<Finding>,
    /// What it allows and its makers warn of, one sentence each.
    pub warnings: Vec<String>,
    /// What could not be checked, one sentence each.
    pub notes: Vec<String>,
}

impl Schema {
    /// Nothing has been checked yet.
    pub fn of(path: &Path) -> Self {
        Self {
            path: path.to_path_buf(),
            head: Map::new(),
            extensions: Vec::new(),
            lacks_extension: false,
            pending: Map::new(),
            warnings: Warnings::default(),
            is_sequence: false,
            faults: Vec::new(),
            hidden: 0,
            notes: Vec::new(),
        }
    }

    /// Checks the first piece: a whole CityJSON, or the head of a sequence.
    pub fn root(&mut self, text: &[u8]) {
        // What is no JSON has been told by who reads it.
        let Ok(Value::Object(root)) = serde_json::from_slice(text) else { return };
        self.head = OF_HEAD.iter().filter_map(|name| Some(((*name).to_owned(), root.get(*name)?.clone()))).collect();
        self.find_extensions();
        self.warnings.root(&root);
        let objects = root.get("CityObjects").and_then(Value::as_object);
        self.check(&String::from_utf8_lossy(text), objects.unwrap_or(&Map::new()));
    }

    /// Takes a feature of a sequence.
    pub fn feature(&mut self, text: &[u8]) {
        let Ok(Value::Object(mut feature)) = serde_json::from_slice(text) else { return };
        self.is_sequence = true;
        self.warnings.vertices(&feature);
        let objects = feature.remove("CityObjects");
        let Some(Value::Object(objects)) = objects else { return };
        match feature.get("id") {
            Some(Value::String(id)) if objects.contains_key(id) => {}
            Some(Value::String(id)) => self.add("", &format!("the feature {id:?} has no CityObject of its id")),
            _ => {
                let first = objects.keys().next().cloned().unwrap_or_default();
                self.add(&first, "\"id\" is a required property of a CityJSONFeature");
            }
        }
        if objects.keys().any(|id| self.pending.contains_key(id)) {
            self.flush();
        }
        self.pending.extend(objects);
        if self.pending.len() >= BATCH {
            self.flush();
        }
    }

    /// What was found.
    pub fn close(mut self) -> Found {
        self.flush();
        if self.hidden > 0 {
            let more = format!("and {} more of this kind", self.hidden);
            self.faults.push(Finding::new(901, "", more));
        }
        Found { faults: self.faults, warnings: self.warnings.told(self.is_sequence), notes: self.notes }
    }

    fn flush(&mut self) {
        if self.pending.is_empty() {
            return;
        }
        let mut object = self.head.clone();
        object.insert("CityObjects".to_owned(), Value::Object(std::mem::take(&mut self.pending)));
        object.insert("vertices".to_owned(), json!([]));
        let object = Value::Object(object);
        if let Some(objects) = object["CityObjects"].as_object() {
            self.check(&object.to_string(), objects);
        }
    }

    /// Checks a CityJSON whose objects are these.
    fn check(&mut self, text: &str, objects: &Map<String, Value>) {
        let extensions = std::mem::take(&mut self.extensions);
        // It takes for granted what the schema lets pass, and some of it need not be.
        let found = guarded(|| {
            let mut validator = CJValidator::from_str(text);
            for extension in &extensions {
                // What is no JSON has been left out.
                let _ = validator.add_one_extension_from_str(extension);
            }
            validator.validate()
        });
        self.extensions = extensions;
        match found {
            Ok(found) => {
                for (_, summary) in found.iter().filter(|(name, _)| COUNTED.contains(&name.as_str())) {
                    summary.get_errors().iter().for_each(|error| self.said(error, objects));
                }
            }
            Err(place) => self.notes.push(format!("the schema was not checked to the end: cjval failed at {place}")),
        }
    }

    /// A fault in the words of cjval: `what [path:/CityObjects/id/…]`, or with the path in front. What it says begins with
    /// the whole of what it refuses.
    fn said(&mut self, error: &str, objects: &Map<String, Value>) {
        // Nothing can be said of what only the schema of an extension knows.
        if self.lacks_extension && error.contains("have a schema") {
            return;
        }
        let (what, path) = match error.rsplit_once(" [path:") {
            Some((what, path)) => (what, path.trim_end_matches(']')),
            None => (error, ""),
        };
        let id =
            path.strip_prefix("/CityObjects/").map(|rest| rest.split('/').next().unwrap_or(rest)).unwrap_or_default();
        let hints = objects.get(id).and_then(Value::as_object).map(hints::of).unwrap_or_default();
        let mut info = match what.find(NO_ALTERNATIVE) {
            Some(_) => format!("it{NO_ALTERNATIVE}"),
            None => shortened(what),
        };
        if !hints.is_empty() {
            info = format!("{info}: {}", hints.join(", "));
        }
        if !path.is_empty() {
            info = format!("{path}: {info}");
        }
        self.add(id, &info);
    }

    fn add(&mut self, id: &str, info: &str) {
        if self.faults.len() >= SHOWN {
            self.hidden += 1;
            return;
        }
        let place = if id.is_empty() { String::new() } else { format!("coid={id}") };
        self.faults.push(Finding::new(901, place, info));
    }

    /// Looks for the schemas of the extensions that the file names: beside it, by the last part of their addresses.
    fn find_extensions(&mut self) {
        let declared: BTreeMap<String, String> = self
            .head
            .get("extensions")
            .and_then(Value::as_object)
            .into_iter()
            .flatten()
            .map(|(name, extension)| {
                let url = extension.get("url").and_then(Value::as_str).unwrap_or_default();
                (name.clone(), url.to_owned())
            })
            .collect();
        for (name, url) in declared {
            let file = url.rsplit('/').next().unwrap_or(&url);
            let beside = self.path.with_file_name(file);
            let bytes = open::whole(&beside, "the schema of an extension").ok().filter(|_| !file.is_empty());
            let text = bytes.and_then(|bytes| String::from_utf8(bytes).ok());
            if let Some(text) =
                text.filter(|text| serde_json::from_str::<Value>(text).is_ok_and(|json| json.is_object()))
            {
                self.extensions.push(text);
            } else {
                self.lacks_extension = true;
                self.notes.push(format!(
                    "the extension {name:?} was not checked: its schema is not at hand (put {file:?} beside the file; it \
                     is at {url:?})"
                ));
            }
        }
    }
}

/// A text without its middle, if it is long.
fn shortened(text: &str) -> String {
    let [first, last] = SHOWN_OF_FAULT;
    let count = text.chars().count();
    if count <= first + last {
        return text.to_owned();
    }
    let start: String = text.chars().take(first).collect();
    let end: String = text.chars().skip(count - last).collect();
    format!("{start} … {end}")
}
