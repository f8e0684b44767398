//! A folder that appears under its name only when it is whole; as objects, one whose main file does.

use std::path::{Path, PathBuf};

use tempfile::TempDir;

use super::output::{exists, folder, refuse_web, temporary};
use crate::error::{Error, InputError, Result};
use crate::source::objects;

/// A folder being filled: a hidden temporary beside the target, removed on drop, renamed by [`OutputFolder::commit`].
pub(super) struct OutputFolder {
    folder: TempDir,
    path: PathBuf,
    target: PathBuf,
    overwrite: bool,
    /// The file that a folder of this format has: one without it is not replaced.
    mark: &'static str,
    bytes: u64,
}

impl OutputFolder {
    /// Makes a temporary folder for `path` in the folder `scratch`; without one beside `path`. Both must be on one file
    /// system for the rename. A folder that is there is replaced only if it is empty or has the file `mark`.
    pub(super) fn create(path: &Path, overwrite: bool, scratch: Option<&Path>, mark: &'static str) -> Result<Self> {
        if objects::is_object(path) {
            return Self::create_objects(path, overwrite, scratch, mark);
        }
        let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        if target.exists() {
            if !overwrite {
                return Err(exists(path).into());
            }
            let is_empty = || std::fs::read_dir(&target).is_ok_and(|mut entries| entries.next().is_none());
            if !target.join(mark).is_file() && !is_empty() {
                return Err(InputError::new(
                    path,
                    format!("something without a {mark}"),
                    format!("a folder with a {mark}"),
                )
                .remedy("Nothing else is replaced. Give another name.")
                .into());
            }
        }
        let scratch = scratch.unwrap_or_else(|| folder(&target));
        let folder = temporary(0o777).tempdir_in(scratch).map_err(|e| Error::io(path, "create", e))?;
        Ok(Self { folder, path: path.to_path_buf(), target, overwrite, mark, bytes: 0 })
    }

    fn create_objects(path: &Path, overwrite: bool, scratch: Option<&Path>, mark: &'static str) -> Result<Self> {
        refuse_web(path)?;
        if objects::exists(path)? {
            if !overwrite {
                return Err(exists(path).into());
            }
            if !objects::exists(&path.join(mark))? {
                let found = format!("objects without a {mark}");
                let fault = InputError::new(path, found, format!("nothing, or a {mark} and what belongs to it"));
                return Err(fault.remedy("Nothing else is replaced. Give another name.").into());
            }
        }
        let scratch = scratch.map_or_else(std::env::temp_dir, Path::to_path_buf);
        let folder =
            temporary(0o700).tempdir_in(scratch).map_err(|e| Error::io(path, "create a local folder for", e))?;
        Ok(Self { folder, path: path.to_path_buf(), target: path.to_path_buf(), overwrite, mark, bytes: 0 })
    }

    /// Where spill files may stand: beside the result.
    pub(super) fn scratch(&self) -> &Path {
        self.folder.path().parent().unwrap_or_else(|| self.folder.path())
    }

    /// Writes a file in the folder; folders on its way are made.
    pub(super) fn write(&mut self, name: &str, bytes: &[u8]) -> Result<()> {
        let file = self.folder.path().join(name);
        let fault = |e| Error::io(self.path.join(name), "write", e);
        if let Some(parent) = file.parent() {
            std::fs::create_dir_all(parent).map_err(fault)?;
        }
        std::fs::write(&file, bytes).map_err(fault)?;
        self.bytes += bytes.len() as u64;
        Ok(())
    }

    /// Gives the folder its name; returns the size of its files.
    pub(super) fn commit(self) -> Result<u64> {
        let Self { folder, path, target, overwrite, mark, bytes } = self;
        if objects::is_object(&target) {
            objects::put_folder(folder.path(), &target, mark)?;
            return Ok(bytes);
        }
        let fault = |e| Error::io(&path, "rename the finished folder to", e);
        if target.exists() {
            if !overwrite {
                return Err(exists(&path).into());
            }
            // The old one steps aside first: a folder cannot be renamed over another.
            let beside = folder.path().parent().unwrap_or_else(|| folder.path());
            let aside = temporary(0o777).tempdir_in(beside).map_err(fault)?;
            std::fs::rename(&target, aside.path().join(mark)).map_err(fault)?;
            std::fs::rename(folder.path(), &target).map_err(fault)?;
        } else {
            std::fs::rename(folder.path(), &target).map_err(fault)?;
        }
        // It is no longer temporary.
        let _ = folder.keep();
        Ok(bytes)
    }

    /// The path that the folder will have, as it was given.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }
}
