//! From arguments to tiles.

use super::cloud;
use crate::error::{Error, InputError, Result};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

const WANTED: &str = "LAS, LAZ, COPC, PLY or text files, folders or glob patterns";

/// The tiles that `args` name: files, folders (the tiles directly in them) and glob patterns.
///
/// Sorted and without duplicates, both by canonical path, so that neither the order of the arguments nor a tile that is
/// named twice matters. A file named outright is taken whatever its extension; in folders and patterns only `.las`, `.laz`
/// (so `.copc.laz` too), `.ply`, `.xyz` and `.pts`, in upper or lower case, count as tiles, and in patterns that end with
/// another extension of text, such as `.txt`, that one.
///
/// # Errors
/// An argument that does not exist, a pattern that is malformed or matches no tile, a folder without tiles, no argument
/// at all, or a folder that cannot be read.
pub fn expand(args: &[String]) -> Result<Vec<PathBuf>> {
    if args.is_empty() {
        return Err(InputError::new("tiles", "no argument", WANTED).into());
    }
    let mut found = BTreeMap::new();
    for arg in args {
        let path = Path::new(arg);
        let tiles = if path.is_dir() {
            let tiles = tiles_in(path)?;
            if tiles.is_empty() {
                return Err(InputError::new(path, "a folder without .las, .laz, .ply, .xyz or .pts files", WANTED)
                    .remedy("Folders are not searched recursively: use a pattern such as 'folder/**/*.laz'")
                    .into());
            }
            tiles
        } else if path.exists() {
            vec![path.to_path_buf()]
        } else if arg.contains(['*', '?', '[']) {
            matches(arg)?
        } else {
            return Err(InputError::new(path, "no such file or folder", WANTED).into());
        };
        for tile in tiles {
            let canonical = fs::canonicalize(&tile).map_err(|e| Error::io(&tile, "open", e))?;
            found.entry(canonical).or_insert(tile);
        }
    }
    Ok(found.into_values().collect())
}

fn matches(pattern: &str) -> Result<Vec<PathBuf>> {
    let malformed = |e: glob::PatternError| {
        InputError::new(pattern, "a malformed pattern", "a glob pattern")
            .at(format!("character {}", e.pos))
            .remedy(e.msg)
    };
    let mut paths = Vec::new();
    if Path::new(pattern).components().any(|part| part.as_os_str() == "**") {
        let whole = glob::Pattern::new(pattern).map_err(malformed)?;
        walk(&before_the_first_wildcard(pattern), &whole, &mut paths)?;
    } else {
        for path in glob::glob(pattern).map_err(malformed)? {
            paths.push(path.map_err(|e| Error::io(e.path().to_path_buf(), "read", e.into()))?);
        }
    }
    let mut tiles = Vec::new();
    for path in paths {
        if path.is_dir() {
            tiles.extend(tiles_in(&path)?);
        } else if is_tile(&path) || is_meant(&path, pattern) {
            tiles.push(path);
        }
    }
    if tiles.is_empty() {
        let found = "a pattern that matches no .las, .laz, .ply, .xyz or .pts file";
        return Err(InputError::new(pattern, found, WANTED).into());
    }
    Ok(tiles)
}

/// The folder that all paths of a pattern are in.
fn before_the_first_wildcard(pattern: &str) -> PathBuf {
    let is_plain = |part: &Component<'_>| !part.as_os_str().to_string_lossy().contains(['*', '?', '[']);
    Path::new(pattern).components().take_while(is_plain).collect()
}

/// The paths below `folder` that match. As in shells, `**` does not go into links to folders: they may lead back.
fn walk(folder: &Path, pattern: &glob::Pattern, found: &mut Vec<PathBuf>) -> Result<()> {
    const OPTIONS: glob::MatchOptions = glob::MatchOptions {
        case_sensitive: true,
        require_literal_separator: true,
        require_literal_leading_dot: false,
    };
    let named = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    for entry in fs::read_dir(named).map_err(|e| Error::io(named, "read", e))? {
        let entry = entry.map_err(|e| Error::io(named, "read", e))?;
        let path = folder.join(entry.file_name());
        if pattern.matches_path_with(&path, OPTIONS) {
            found.push(path.clone());
        }
        if entry.file_type().map_err(|e| Error::io(&path, "read", e))?.is_dir() {
            walk(&path, pattern, found)?;
        }
    }
    Ok(())
}

fn tiles_in(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut tiles = Vec::new();
    for entry in fs::read_dir(folder).map_err(|e| Error::io(folder, "read", e))? {
        let path = entry.map_err(|e| Error::io(folder, "read", e))?.path();
        if is_tile(&path) && path.is_file() {
            tiles.push(path);
        }
    }
    Ok(tiles)
}

fn is_tile(path: &Path) -> bool {
    let plain = cloud::TEXT[..cloud::PLAIN].iter();
    ["las", "laz", "ply"].iter().chain(plain).any(|known| has_extension(path, known))
}

/// Whether a file of text is one because the pattern says its extension.
fn is_meant(path: &Path, pattern: &str) -> bool {
    cloud::TEXT.iter().any(|known| has_extension(path, known) && has_extension(Path::new(pattern), known))
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case(extension))
}
