//! From arguments to files and objects.

use super::objects;
use crate::error::{Error, InputError, Result};
use std::collections::BTreeMap;
use std::fs;
use std::path::{Component, Path, PathBuf};

/// How patterns match: only `**` goes beyond a separator.
const OPTIONS: glob::MatchOptions =
    glob::MatchOptions { case_sensitive: true, require_literal_separator: true, require_literal_leading_dot: false };

/// What kind of file arguments name.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Kind {
    /// What one argument is, such as `tiles`.
    pub name: &'static str,
    /// What is expected.
    pub wanted: &'static str,
    /// The extensions that count in folders and patterns, in upper or lower case.
    pub extensions: &'static [&'static str],
    /// Those that count where a pattern ends with them.
    pub meant: &'static [&'static str],
}

/// The files of a kind that `args` name: files, folders (the files directly in them) and glob patterns; and objects, those
/// directly below an address that ends with a separator, and patterns of such.
///
/// Sorted and without duplicates, both by canonical path, so that neither the order of the arguments nor a file that is
/// named twice matters. A file named outright is taken whatever its extension, and an object too, which may not be there:
/// whoever opens it says so.
///
/// # Errors
/// An argument that does not exist, a pattern that is malformed or matches no file, a folder without files, no argument
/// at all, or a folder that cannot be read.
pub(crate) fn expand(args: &[String], kind: &Kind) -> Result<Vec<PathBuf>> {
    let wanted = kind.wanted;
    if args.is_empty() {
        return Err(InputError::new(kind.name, "no argument", wanted).into());
    }
    let mut found = BTreeMap::new();
    for arg in args {
        let path = Path::new(arg);
        if objects::is_object(path) {
            found.extend(kind.objects(arg)?.into_iter().map(|object| (object.clone(), object)));
            continue;
        }
        let files = if path.is_dir() {
            let files = kind.files_in(path)?;
            if files.is_empty() {
                let example = kind.extensions.last().copied().unwrap_or_default();
                return Err(InputError::new(path, format!("a folder without {} files", kind.listed()), wanted)
                    .remedy(format!(
                        "Folders are not searched recursively: use a pattern such as 'folder/**/*.{example}'"
                    ))
                    .into());
            }
            files
        } else if path.exists() {
            vec![path.to_path_buf()]
        } else if arg.contains(['*', '?', '[']) {
            kind.matches(arg)?
        } else {
            return Err(InputError::new(path, "no such file or folder", wanted).into());
        };
        for file in files {
            let canonical = fs::canonicalize(&file).map_err(|e| Error::io(&file, "open", e))?;
            found.entry(canonical).or_insert(file);
        }
    }
    Ok(found.into_values().collect())
}

impl Kind {
    /// The objects that an address names.
    fn objects(&self, address: &str) -> Result<Vec<PathBuf>> {
        let path = objects::label(Path::new(address));
        let address = path.to_string_lossy();
        // In the address of a web server a question mark begins a query, which is no part of it any more.
        let first = address.find(['*', '?', '[']);
        let (folder, pattern) = match first {
            None if !address.ends_with('/') => return Ok(vec![path]),
            None => (address.as_ref(), None),
            Some(first) => (&address[..=address[..first].rfind('/').unwrap_or(first)], Some(address.as_ref())),
        };
        let whole =
            pattern.map(|pattern| glob::Pattern::new(pattern).map_err(|e| malformed(pattern, &e))).transpose()?;
        let is_deep = pattern.is_some_and(|pattern| pattern[folder.len()..].contains('/'));
        let matches = |object: &PathBuf| {
            let named = whole.as_ref().is_none_or(|whole| whole.matches_path_with(object, OPTIONS));
            named && (self.is_one(object) || pattern.is_some_and(|pattern| self.is_meant(object, pattern)))
        };
        let found: Vec<PathBuf> = objects::list(Path::new(folder), is_deep)?.into_iter().filter(matches).collect();
        if found.is_empty() {
            let what = if pattern.is_some() { "a pattern that matches no" } else { "a name below which there is no" };
            return Err(InputError::new(&path, format!("{what} {} object", self.listed()), self.wanted).into());
        }
        Ok(found)
    }

    fn matches(&self, pattern: &str) -> Result<Vec<PathBuf>> {
        let mut paths = Vec::new();
        if Path::new(pattern).components().any(|part| part.as_os_str() == "**") {
            let whole = glob::Pattern::new(pattern).map_err(|e| malformed(pattern, &e))?;
            walk(&before_the_first_wildcard(pattern), &whole, &mut paths)?;
        } else {
            for path in glob::glob(pattern).map_err(|e| malformed(pattern, &e))? {
                paths.push(path.map_err(|e| Error::io(e.path().to_path_buf(), "read", e.into()))?);
            }
        }
        let mut files = Vec::new();
        for path in paths {
            if path.is_dir() {
                files.extend(self.files_in(&path)?);
            } else if self.is_one(&path) || self.is_meant(&path, pattern) {
                files.push(path);
            }
        }
        if files.is_empty() {
            let found = format!("a pattern that matches no {} file", self.listed());
            return Err(InputError::new(pattern, found, self.wanted).into());
        }
        Ok(files)
    }

    fn files_in(&self, folder: &Path) -> Result<Vec<PathBuf>> {
        let mut files = Vec::new();
        for entry in fs::read_dir(folder).map_err(|e| Error::io(folder, "read", e))? {
            let path = entry.map_err(|e| Error::io(folder, "read", e))?.path();
            if self.is_one(&path) && path.is_file() {
                files.push(path);
            }
        }
        Ok(files)
    }

    /// Whether a file in a folder is of this kind.
    fn is_one(&self, path: &Path) -> bool {
        self.extensions.iter().any(|known| has_extension(path, known))
    }

    /// Whether a file is one because the pattern says its extension.
    fn is_meant(&self, path: &Path, pattern: &str) -> bool {
        self.meant.iter().any(|known| has_extension(path, known) && has_extension(Path::new(pattern), known))
    }

    /// The extensions that count, such as `.las, .laz or .ply`.
    fn listed(&self) -> String {
        let dotted: Vec<String> = self.extensions.iter().map(|extension| format!(".{extension}")).collect();
        match dotted.split_last() {
            Some((last, [])) => last.clone(),
            Some((last, before)) => format!("{} or {last}", before.join(", ")),
            None => String::new(),
        }
    }
}

fn malformed(pattern: &str, error: &glob::PatternError) -> InputError {
    InputError::new(pattern, "a malformed pattern", "a glob pattern")
        .at(format!("character {}", error.pos))
        .remedy(error.msg)
}

/// The folder that all paths of a pattern are in.
fn before_the_first_wildcard(pattern: &str) -> PathBuf {
    let is_plain = |part: &Component<'_>| !part.as_os_str().to_string_lossy().contains(['*', '?', '[']);
    Path::new(pattern).components().take_while(is_plain).collect()
}

/// The paths below `folder` that match. As in shells, `**` does not go into links to folders: they may lead back.
fn walk(folder: &Path, pattern: &glob::Pattern, found: &mut Vec<PathBuf>) -> Result<()> {
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

/// Whether the name of a file ends with an extension, which may have a dot in it, and is more than that.
fn has_extension(path: &Path, extension: &str) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    name.strip_suffix(extension).is_some_and(|stem| stem.len() > 1 && stem.ends_with('.'))
}
