//! Which format a file has, by its first bytes; its name only says which of several files is meant.

use std::io::Read;
use std::path::{Path, PathBuf};

use super::{Reader, flatgeobuf, geojson, geoparquet, shapefile, sqlite};
use crate::error::{Error, InputError, Result};
use crate::source::open;

/// What is accepted, for messages.
pub(super) const ACCEPTED: &str =
    "GeoJSON, GeoPackage, SpatiaLite, Shapefile (the .shp with its .dbf and .prj), FlatGeobuf or GeoParquet";

/// A format.
pub(super) struct Format {
    /// What reads its files.
    pub reader: Reader,
    /// Whether it reads of an object only what it needs, instead of a copy.
    pub is_read_by_ranges: bool,
}

/// The file to read (the `.shp` when another part of a shapefile is given) and its format.
pub(super) fn of(path: &Path) -> Result<(PathBuf, Format)> {
    let is_part = path
        .extension()
        .and_then(|e| e.to_str())
        .is_some_and(|e| ["dbf", "shx", "prj", "cpg"].iter().any(|part| e.eq_ignore_ascii_case(part)));
    let main = if is_part { with_extension(path, "shp") } else { None };
    let path = main.unwrap_or_else(|| path.to_path_buf());
    let mut start = Vec::new();
    open::regular(&path, &format!("a footprint file: {ACCEPTED}"))?
        .0
        .take(4096)
        .read_to_end(&mut start)
        .map_err(|e| Error::io(&path, "read", e))?;
    let text = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(&start);
    // A sequence (RFC 8142) begins with a separator.
    let text = text.strip_prefix(&[geojson::RECORD_SEPARATOR]).unwrap_or(text).trim_ascii_start();
    let reader: Reader = match start.as_slice() {
        [] => return Err(refused(&path, "an empty file").into()),
        [b'S', b'Q', b'L', b'i', b't', b'e', b' ', ..] => sqlite::read,
        [0x00, 0x00, 0x27, 0x0A, ..] => shapefile::read,
        [b'f', b'g', b'b', ..] => flatgeobuf::read,
        _ if start.starts_with(geoparquet::MAGIC) => geoparquet::read,
        [b'P', b'K', 0x03, 0x04, ..] => return Err(refused(&path, "a ZIP archive").remedy("Unpack it first").into()),
        [b'L', b'A', b'S', b'F', ..] => return Err(refused(&path, "a LAS point cloud").into()),
        _ if text.first() == Some(&b'{') => geojson::read,
        _ if text.first() == Some(&b'<') => return Err(refused(&path, "XML").into()),
        _ => return Err(refused(&path, "an unknown format").into()),
    };
    let is_read_by_ranges = start.starts_with(geoparquet::MAGIC);
    Ok((path, Format { reader, is_read_by_ranges }))
}

fn refused(path: &Path, found: &str) -> InputError {
    InputError::new(path, found, format!("a footprint file: {ACCEPTED}"))
}

/// The file beside `path` with another extension, in lower or upper case, when it is there.
pub(super) fn with_extension(path: &Path, extension: &str) -> Option<PathBuf> {
    [extension.to_string(), extension.to_uppercase()]
        .iter()
        .map(|extension| path.with_extension(extension))
        .find(|candidate| candidate.is_file())
}

/// The name of a file without folder and extension, for formats without layers.
pub(super) fn stem(path: &Path) -> String {
    path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}
