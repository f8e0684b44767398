//! What a person has decided about the buildings of a job.

use std::collections::BTreeMap;
use std::path::Path;

use super::job::Job;
use super::journal::Journal;
use crate::edits::{Edits, State, some};
use crate::error::{InputError, Result};
use crate::report::BuildingReport;
use crate::site::Site;
use crate::source::crs::Crs;
use crate::source::edits;

/// What a CRS is called in a file of edits: by its code, if it has one.
pub fn name(crs: &Crs) -> String {
    crs.code.as_ref().map_or_else(|| crs.name.clone(), ToString::to_string)
}

/// The edits of a job whose model is in `crs`; none where it names no file.
///
/// # Errors
/// As [`edits::read`], or the coordinates are in another CRS.
pub(super) fn read(job: &Job, crs: &Crs) -> Result<Edits> {
    job.edits.as_deref().map_or_else(|| Ok(Edits::default()), |path| of_file(path, crs))
}

/// The edits in a file, of a model in `crs`.
///
/// # Errors
/// As [`edits::read`], or the coordinates are in another CRS.
pub fn of_file(path: &Path, crs: &Crs) -> Result<Edits> {
    let edits = edits::read(path)?;
    let own = name(crs);
    match &edits.crs {
        Some(name) if *name != own => {
            let fault =
                InputError::new(path, format!("edits in the CRS {name:?}"), format!("{own:?}, that of the model"));
            Err(fault.remedy("Make the model in the CRS that it was edited in: --crs gives the tiles another").into())
        }
        _ => Ok(edits),
    }
}

/// Gives a building its edits, if they are accepted.
pub(super) fn give(edits: &Edits, site: &mut Site) {
    if let Some(edited) = edits.buildings.get(&site.id).filter(|edited| edited.state == State::Accepted) {
        site.edits.clone_from(&edited.edits);
    }
}

/// Says which edits the buildings of these ids do not get.
pub(super) fn tell<'a>(edits: &Edits, ids: impl Iterator<Item = &'a str>, journal: &Journal<'_>) {
    if edits.buildings.is_empty() {
        return;
    }
    let mut left: BTreeMap<&str, _> = edits
        .buildings
        .iter()
        .filter(|(_, edited)| !edited.edits.is_empty())
        .map(|(id, edited)| (id.as_str(), edited))
        .collect();
    let mut waiting = Vec::new();
    for id in ids {
        waiting.extend(left.remove(id).filter(|edited| edited.state != State::Accepted).map(|_| id.to_owned()));
    }
    if !waiting.is_empty() {
        journal.warn(&format!(
            "the edits of {} building(s) are not accepted and were left out: {}",
            waiting.len(),
            some(&waiting)
        ));
    }
    let unknown: Vec<String> = left.into_keys().map(str::to_owned).collect();
    if !unknown.is_empty() {
        journal.warn(&format!(
            "there are edits of {} building(s) that this run does not make: {}",
            unknown.len(),
            some(&unknown)
        ));
    }
}

/// Says which buildings do not follow all of their edits.
pub(super) fn warn_of_refusals(buildings: &[BuildingReport], journal: &Journal<'_>) {
    for building in buildings {
        for note in building.edits.iter().flat_map(crate::building::EditTally::notes) {
            journal.warn(&format!("{}: {note}", building.id));
        }
    }
}
