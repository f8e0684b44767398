//! A file, or an object, that appears under its name only when it is whole.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;

use crate::error::{Error, InputError, Result};
use crate::source::objects;

/// A file being written: a hidden temporary beside the target, removed on drop, renamed by [`Output::commit`]; or an object,
/// whose temporary file is uploaded then.
pub(super) struct Output {
    file: BufWriter<NamedTempFile>,
    path: PathBuf,
    target: PathBuf,
    scratch: PathBuf,
    overwrite: bool,
}

impl Output {
    /// Opens a temporary file for `path` in the folder `scratch`; without one beside `path`. Both must be on one file
    /// system for the rename. What becomes an object is in the folder for temporary files where there is no `scratch`.
    pub(super) fn create(path: &Path, overwrite: bool, scratch: Option<&Path>) -> Result<Self> {
        if objects::is_object(path) {
            return Self::create_object(path, overwrite, scratch);
        }
        // A link stays a link: what it points to is replaced.
        let target = std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
        if target.is_dir() {
            return Err(InputError::new(path, "a folder", "a file name")
                .remedy("Give the name of a file inside that folder.")
                .into());
        }
        if !overwrite && target.exists() {
            return Err(exists(path).into());
        }
        let scratch = scratch.unwrap_or_else(|| folder(&target)).to_path_buf();
        let file = temporary(0o666).tempfile_in(&scratch).map_err(|e| Error::io(path, "create", e))?;
        let file = BufWriter::with_capacity(1 << 18, file);
        Ok(Self { file, path: path.to_path_buf(), target, scratch, overwrite })
    }

    fn create_object(path: &Path, overwrite: bool, scratch: Option<&Path>) -> Result<Self> {
        refuse_web(path)?;
        if !overwrite && objects::exists(path)? {
            return Err(exists(path).into());
        }
        let scratch = scratch.map_or_else(std::env::temp_dir, Path::to_path_buf);
        let file = temporary(0o600).tempfile_in(&scratch).map_err(|e| Error::io(path, "create a local file for", e))?;
        let file = BufWriter::with_capacity(1 << 18, file);
        Ok(Self { file, path: path.to_path_buf(), target: path.to_path_buf(), scratch, overwrite })
    }

    /// A nameless temporary file, for what must be written later.
    pub(super) fn spill(&self) -> Result<BufWriter<File>> {
        let file = tempfile::tempfile_in(&self.scratch).map_err(|e| self.fault("create a spill file for", e))?;
        Ok(BufWriter::with_capacity(1 << 18, file))
    }

    /// Appends bytes.
    pub(super) fn write(&mut self, bytes: &[u8]) -> Result<()> {
        self.file.write_all(bytes).map_err(|e| self.fault("write", e))
    }

    /// Appends what was spilled.
    pub(super) fn append(&mut self, spill: BufWriter<File>) -> Result<()> {
        let copy = || -> io::Result<()> {
            let mut spilled = spill.into_inner().map_err(io::IntoInnerError::into_error)?;
            spilled.seek(SeekFrom::Start(0))?;
            io::copy(&mut spilled, &mut self.file).map(drop)
        };
        copy().map_err(|e| self.fault("write", e))
    }

    /// Writes over the first bytes, makes all of it durable, and gives the file its name; returns its size.
    pub(super) fn commit(self, head: &[u8]) -> Result<u64> {
        let Self { file, path, target, overwrite, .. } = self;
        let close = || -> io::Result<(NamedTempFile, u64)> {
            let mut file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
            file.seek(SeekFrom::Start(0))?;
            file.write_all(head)?;
            file.as_file().sync_all()?;
            let bytes = file.as_file().metadata()?.len();
            Ok((file, bytes))
        };
        let (file, bytes) = close().map_err(|e| Error::io(&path, "write", e))?;
        if objects::is_object(&target) {
            if !overwrite && objects::exists(&target)? {
                return Err(exists(&path).into());
            }
            objects::put(file.path(), &target)?;
            return Ok(bytes);
        }
        let renamed = if overwrite { file.persist(&target) } else { file.persist_noclobber(&target) };
        match renamed {
            Ok(_) => {}
            Err(fault) if fault.error.kind() == io::ErrorKind::AlreadyExists => return Err(exists(&path).into()),
            // Someone has removed the folder. The file is still open, and the work of hours need not be lost.
            Err(fault) if fault.error.kind() == io::ErrorKind::NotFound => {
                restore(fault.file, &target).map_err(|e| Error::io(&path, "write", e))?;
            }
            Err(fault) => return Err(Error::io(&path, "rename the finished file to", fault.error)),
        }
        // The name is durable once its folder is. Not every file system can sync a folder, and the data are safe.
        #[cfg(unix)]
        let _ = File::open(folder(&target)).and_then(|folder| folder.sync_all());
        Ok(bytes)
    }

    /// Where the file is as long as it has no name.
    pub(super) fn temporary(&self) -> &Path {
        self.file.get_ref().path()
    }

    /// The path that the file will have, as it was given.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// A fault of the system while doing `action`.
    pub(super) fn fault(&self, action: &'static str, source: io::Error) -> Error {
        Error::io(&self.path, action, source)
    }
}

/// Writes a finished file whose name is gone to `target`, whose folder is made anew.
fn restore(mut file: NamedTempFile, target: &Path) -> io::Result<()> {
    std::fs::create_dir_all(folder(target))?;
    let mut copy = temporary(0o666).tempfile_in(folder(target))?;
    file.seek(SeekFrom::Start(0))?;
    io::copy(file.as_file_mut(), copy.as_file_mut())?;
    copy.as_file().sync_all()?;
    copy.persist_noclobber(target)?;
    Ok(())
}

/// Writes a whole file at once: it appears under its name when it is complete, in the place of one that is there.
///
/// # Errors
/// A folder stands in its place, or the system refuses.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<()> {
    let mut output = Output::create(path, true, None)?;
    output.write(bytes)?;
    output.commit(&[]).map(drop)
}

/// Copies a file in the same way.
///
/// # Errors
/// As [`write_whole`], or the file cannot be read.
pub fn copy_whole(from: &Path, to: &Path) -> Result<()> {
    let mut source = File::open(from).map_err(|e| Error::io(from, "open", e))?;
    let mut output = Output::create(to, true, None)?;
    io::copy(&mut source, &mut output.file).map_err(|e| output.fault("write", e))?;
    output.commit(&[]).map(drop)
}

/// Writes a value as indented JSON in the same way, without ever holding the text in memory.
///
/// # Errors
/// As [`write_whole`].
pub fn write_json(path: &Path, value: &impl serde::Serialize) -> Result<()> {
    let mut output = Output::create(path, true, None)?;
    serde_json::to_writer_pretty(&mut output.file, value).map_err(|e| output.fault("write", e.into()))?;
    output.write(b"\n")?;
    output.commit(&[]).map(drop)
}

/// What is written before it has its name.
pub(crate) fn temporary<'a>(mode: u32) -> tempfile::Builder<'a, 'a> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".gable-").suffix(".part");
    #[cfg(unix)]
    {
        // Temporary files are private by default; a result is as readable as any other file of the user.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(mode));
    }
    #[cfg(not(unix))]
    let _ = mode;
    builder
}

/// The folder of a file.
pub(super) fn folder(path: &Path) -> &Path {
    path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."))
}

/// Refuses to write to a web server.
pub(crate) fn refuse_web(path: &Path) -> Result<(), InputError> {
    if !objects::is_web(path) {
        return Ok(());
    }
    let fault =
        InputError::new(objects::label(path), "a web server as output", "a file, or an object (s3://, az://, gs://)");
    Err(fault.remedy("Web servers take no files: write it where the server has it from"))
}

/// The refusal to replace a file.
pub(super) fn exists(path: &Path) -> InputError {
    InputError::new(path, "an existing file", "a new file name").remedy("Give --overwrite to replace it.")
}

#[cfg(test)]
mod tests {
    use super::Output;

    #[cfg(unix)]
    #[test]
    fn a_folder_that_is_removed_while_a_file_is_written_costs_nothing() {
        let outside = tempfile::tempdir().unwrap();
        let folder = outside.path().join("out");
        std::fs::create_dir_all(folder.join("scratch")).unwrap();
        let target = folder.join("city.json");
        let mut output = Output::create(&target, false, Some(&folder.join("scratch"))).unwrap();
        output.write(b"before ").unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        output.write(b"and after").unwrap();
        assert_eq!(output.commit(b"BEFORE").unwrap(), 16);
        assert_eq!(std::fs::read(&target).unwrap(), b"BEFORE and after");
        assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1, "nothing else is left");
    }
}
