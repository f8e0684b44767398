//! Copies of objects for the readers of formats that read a file from its beginning to its end, or want one by its name.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

use crate::error::{Error, InputError, Result};
use crate::source::open::Place;

/// The parts of a shapefile that may stand beside it.
const PARTS: [&str; 4] = ["dbf", "shx", "prj", "cpg"];

/// A copy of an object in a temporary folder, which goes when this does.
pub(super) struct Fetched {
    _folder: TempDir,
    file: PathBuf,
    of: PathBuf,
}

impl Fetched {
    /// Fetches the object at `path`; of a shapefile also what stands beside it.
    ///
    /// # Errors
    /// It cannot be read, or no copy be written.
    pub fn of(path: &Path) -> Result<Self> {
        let folder = tempfile::tempdir().map_err(|e| Error::io(path, "make a temporary copy of", e))?;
        let name = path.file_name().unwrap_or_else(|| "footprints".as_ref());
        let file = folder.path().join(name);
        fetch(path, &file)?;
        if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("shp")) {
            for part in PARTS {
                match fetch(&path.with_extension(part), &file.with_extension(part)) {
                    // Who may not list a bucket is not told what there is not, but refused.
                    Err(Error::Input(InputError { found, .. })) if found.starts_with("no ") => {}
                    other => other?,
                }
            }
        }
        Ok(Self { _folder: folder, file, of: path.to_path_buf() })
    }

    /// The copy.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// An error that names the object where it named the copy.
    pub fn renamed(&self, error: Error) -> Error {
        match error {
            Error::Input(mut fault) => {
                if fault.file == self.file {
                    fault.file.clone_from(&self.of);
                }
                Error::Input(fault)
            }
            Error::Io { path, action, source } if path == self.file => Error::io(&self.of, action, source),
            other => other,
        }
    }
}

fn fetch(path: &Path, to: &Path) -> Result<()> {
    let (place, size) = Place::of(path, "a footprint file")?;
    let mut input = place.open()?;
    input.expect(std::iter::once(0..size));
    let mut file = File::create(to).map_err(|e| Error::io(path, "make a temporary copy of", e))?;
    let copied = io::copy(&mut input, &mut file);
    copied.map(drop).map_err(|e| Error::io(path, "make a temporary copy of", e))
}
