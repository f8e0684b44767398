//! Files that appear under their names only when they are whole.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use tempfile::NamedTempFile;

use crate::error::{Error, InputError, Result};

/// A file being written: a hidden temporary beside its target, removed on drop, renamed by [`Self::commit`]. One of that
/// name is replaced, as in PDAL.
pub(super) struct NewFile {
    temporary: NamedTempFile,
    path: PathBuf,
    target: PathBuf,
    fault: Fault,
}

/// What went wrong first.
type Fault = Arc<Mutex<Option<io::Error>>>;

impl NewFile {
    /// Makes a temporary file for `path`, and the folder that it goes to.
    ///
    /// # Errors
    /// A folder of that name, or the system refuses.
    pub fn create(path: &Path) -> Result<(Self, Sturdy)> {
        // A link stays a link: what it points to is replaced.
        let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        if target.is_dir() {
            return Err(InputError::new(path, "a folder", "the name of a file").into());
        }
        let folder = target.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."));
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "create", e))?;
        let mut builder = tempfile::Builder::new();
        builder.prefix(".gable-").suffix(".part");
        #[cfg(unix)]
        {
            // Temporary files are private by default; a result is as readable as any other file of the user.
            use std::os::unix::fs::PermissionsExt;
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let temporary = builder.tempfile_in(folder).map_err(|e| Error::io(path, "create", e))?;
        let file = temporary.reopen().map_err(|e| Error::io(path, "create", e))?;
        let fault = Fault::default();
        let sturdy = Sturdy { file: BufWriter::with_capacity(1 << 18, file), fault: Arc::clone(&fault) };
        Ok((Self { temporary, path: path.to_path_buf(), target, fault }, sturdy))
    }

    /// What went wrong until now.
    ///
    /// # Errors
    /// The first fault of the system.
    pub fn check(&self) -> Result<()> {
        match self.fault.lock().unwrap_or_else(PoisonError::into_inner).take() {
            Some(fault) => Err(Error::io(&self.path, "write", fault)),
            None => Ok(()),
        }
    }

    /// Gives the file its name, after everything was written to `sturdy` and that was flushed.
    ///
    /// # Errors
    /// The system refuses, or has refused before.
    pub fn commit(self) -> Result<PathBuf> {
        self.check()?;
        let Self { temporary, path, target, .. } = self;
        temporary.as_file().sync_all().map_err(|e| Error::io(&path, "write", e))?;
        temporary.persist(&target).map_err(|e| Error::io(&path, "rename the finished file to", e.error))?;
        Ok(path)
    }
}

/// Writes to a file and never fails: after the first fault, which is kept for [`NewFile::check`], it takes bytes and drops
/// them. The writer of the `las` crate panics when it is dropped and cannot write.
pub(super) struct Sturdy {
    file: BufWriter<File>,
    fault: Fault,
}

impl Sturdy {
    fn is_broken(&self) -> bool {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    fn keep<T>(&self, outcome: io::Result<T>, otherwise: T) -> T {
        outcome.unwrap_or_else(|fault| {
            self.fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(fault);
            otherwise
        })
    }
}

impl Write for Sturdy {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.is_broken() {
            return Ok(bytes.len());
        }
        let outcome = self.file.write_all(bytes).map(|()| bytes.len());
        Ok(self.keep(outcome, bytes.len()))
    }

    fn flush(&mut self) -> io::Result<()> {
        if !self.is_broken() {
            let outcome = self.file.flush();
            self.keep(outcome, ());
        }
        Ok(())
    }
}

impl Seek for Sturdy {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        if self.is_broken() {
            return Ok(0);
        }
        let outcome = self.file.seek(to);
        Ok(self.keep(outcome, 0))
    }
}

impl Drop for Sturdy {
    /// What a buffer still holds must not be lost without a word.
    fn drop(&mut self) {
        let _ = self.flush();
    }
}
