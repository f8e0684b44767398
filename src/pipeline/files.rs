//! The files that a reader is to read: what a pattern or a folder stands for.

use std::path::PathBuf;

use super::catalogue;
use super::options::Place;
use super::stage::{Role, StageKind};
use crate::error::{Error, Result};

/// What a COPC is read by alone, and in a folder of tiles.
const COPC: (&str, &str) = ("readers.copc", "readers.las");

/// The files that a pattern matches, sorted.
pub(super) fn matches(pattern: &str, place: &Place) -> Result<Vec<PathBuf>> {
    let paths = glob::glob(pattern).map_err(|e| {
        place.fault(format!("the pattern `{pattern}`: {}", e.msg), "a glob pattern such as tiles/*.laz")
    })?;
    let mut files = Vec::new();
    for path in paths {
        let path = path.map_err(|e| Error::io(e.path().to_path_buf(), "read", e.into()))?;
        if path.is_file() {
            files.push(path);
        }
    }
    if files.is_empty() {
        let found = format!("the pattern `{pattern}`, which matches no file");
        return Err(place.fault(found, "a pattern that matches a file").into());
    }
    files.sort();
    Ok(files)
}

/// The files directly in a folder that a reader would be chosen for by their names, sorted.
pub(super) fn in_folder(folder: &str, kind: &StageKind, place: &Place) -> Result<Vec<PathBuf>> {
    let is_ours = |path: &PathBuf| {
        let name = path.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
        let found = catalogue::infer(&name, Role::Reader, place).map(|found| found.name);
        // A COPC is a LAZ as well.
        path.is_file() && found.is_ok_and(|found| found == kind.name || (found, kind.name) == COPC)
    };
    let entries = std::fs::read_dir(folder).map_err(|e| Error::io(folder, "read", e))?;
    let paths = entries.map(|entry| entry.map(|entry| entry.path())).collect::<std::io::Result<Vec<PathBuf>>>();
    let mut files: Vec<PathBuf> =
        paths.map_err(|e| Error::io(folder, "read", e))?.into_iter().filter(is_ours).collect();
    if files.is_empty() {
        let found = format!("the folder `{folder}`, in which no file is one for `{}`", kind.name);
        return Err(place.fault(found, "a folder with files directly in it, or a pattern").into());
    }
    files.sort();
    Ok(files)
}
