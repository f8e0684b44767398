//! Ids: which attribute they come from, and how they become unique.

use std::collections::HashSet;
use std::path::Path;

use serde_json::Value;

use super::attributes::meant;
use super::{Attributes, FootprintOptions, names};
use crate::error::{InputError, Result};

/// Attributes that hold ids in the data of mapping agencies and in common exports, best first.
const KNOWN: [&str; 27] = [
    "identificatie",
    "gml_id",
    "building_id",
    "id",
    "uuid",
    "guid",
    "globalid",
    "cleabs",
    "toid",
    "egid",
    "lokaalid",
    "localid",
    "bag_id",
    "pand_id",
    "osm_id",
    "full_id",
    "osm_way_id",
    "gmlid",
    "oid",
    "ident",
    "kennung",
    "gid",
    "fid",
    "ogc_fid",
    "objectid",
    "id_0",
    "nr",
];
/// What made-up ids begin with.
const MADE_UP: &str = "footprint";

/// The id of one feature.
#[derive(Debug, PartialEq)]
pub(super) struct Assigned {
    pub id: String,
    /// What was made up, if anything.
    pub note: Option<String>,
}

/// The ids of a layer, feature by feature.
#[derive(Debug)]
pub(super) struct Ids {
    pub attribute: Option<String>,
    pub assigned: Vec<Assigned>,
    pub warnings: Vec<String>,
}

/// Gives every feature an id that is unique among `features`; `columns` are all attributes that occur.
pub(super) fn assign<'a>(
    features: impl Iterator<Item = &'a Attributes> + Clone,
    columns: &[String],
    options: &FootprintOptions,
    path: &Path,
) -> Result<Ids> {
    let attribute = match &options.id_attribute {
        Some(wanted) => Some(named(wanted, columns, path)?),
        None => guess(&features, columns),
    };
    let real: Vec<Option<String>> =
        features.map(|feature| attribute.as_deref().and_then(|name| text_of(&feature.meant(name)?))).collect();
    let taken: HashSet<&str> = real.iter().flatten().map(String::as_str).collect();
    let mut used: HashSet<String> = HashSet::new();
    let (mut missing, mut repeated) = (0, 0);
    let ids = (1..)
        .zip(&real)
        .map(|(number, real)| {
            let free = |id: &String| !taken.contains(id.as_str()) && !used.contains(id);
            let (id, note) = match real {
                Some(id) if !used.contains(id) => (id.clone(), None),
                Some(id) => {
                    repeated += 1;
                    let new = unique(id, 2, free);
                    let note = format!("its id `{id}` is that of an earlier feature; it became `{new}`");
                    (new, Some(note))
                }
                None => {
                    missing += 1;
                    let first = format!("{MADE_UP}-{number}");
                    let new = if free(&first) { first } else { unique(&first, 2, free) };
                    let note = attribute.as_ref().map(|name| format!("it has no `{name}`; it became `{new}`"));
                    (new, note)
                }
            };
            used.insert(id.clone());
            Assigned { id, note }
        })
        .collect::<Vec<_>>();
    let warnings = match &attribute {
        None if !ids.is_empty() => vec![format!("no attribute holds an id; features are numbered {MADE_UP}-1, …")],
        None => Vec::new(),
        Some(name) => [
            (missing, format!("of {} features have no `{name}`; they are numbered", ids.len())),
            (repeated, format!("of {} features repeat the `{name}` of another; a number was added", ids.len())),
        ]
        .into_iter()
        .filter(|(count, _)| *count > 0)
        .map(|(count, what)| format!("{count} {what}"))
        .collect(),
    };
    Ok(Ids { attribute, assigned: ids, warnings })
}

fn unique(base: &str, from: usize, free: impl Fn(&String) -> bool) -> String {
    let mut number = from;
    loop {
        let candidate = format!("{base}-{number}");
        if free(&candidate) {
            return candidate;
        }
        number += 1;
    }
}

fn named(wanted: &str, columns: &[String], path: &Path) -> Result<String> {
    let fault = |found: String| InputError::new(path, found, "an attribute that holds the id").at("its attributes");
    match meant(wanted, columns) {
        Ok(Some(column)) => Ok(column.clone()),
        Err(alike) => Err(fault(format!("no attribute `{wanted}`, but several that differ from it in case"))
            .remedy(format!("Name one of {}", alike.join(", ")))
            .into()),
        Ok(None) => Err(fault(format!("no attribute `{wanted}`"))
            .remedy(names::remedy(wanted, columns.iter().map(String::as_str)))
            .into()),
    }
}

/// The best known attribute that has a different value in every feature; else any such whose name ends in `id`; else
/// the best known one that has a value at all.
fn guess<'a>(features: &(impl Iterator<Item = &'a Attributes> + Clone), columns: &[String]) -> Option<String> {
    let present: Vec<&String> =
        KNOWN.iter().filter_map(|known| columns.iter().find(|c| c.eq_ignore_ascii_case(known))).collect();
    let id_of = |feature: &Attributes, name: &str| feature.meant(name).as_ref().and_then(text_of);
    let is_unique = |name: &&&String| {
        let mut seen = HashSet::new();
        features.clone().all(|f| id_of(f, name).is_some_and(|id| seen.insert(id)))
    };
    let has_any = |name: &&&String| features.clone().any(|f| id_of(f, name).is_some());
    let ends_in_id: Vec<&String> = columns.iter().filter(|c| c.to_ascii_lowercase().ends_with("id")).collect();
    let best = present.iter().find(is_unique).or_else(|| ends_in_id.iter().find(is_unique));
    best.or_else(|| present.iter().find(has_any)).map(|name| (*name).clone())
}

/// An id as text, exactly as it stands; `None` for what is none.
fn text_of(value: &Value) -> Option<String> {
    match value {
        Value::String(text) if !text.trim().is_empty() => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        Value::Bool(value) => Some(value.to_string()),
        _ => None,
    }
}
