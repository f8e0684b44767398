//! Opening what a user names: a file, an object in object storage or on the web, or standard input. A pipe or a device must
//! not hang the program or fill its memory.

use super::objects::{self, Object, ObjectReader};
use super::reread::{Reread, is_standard_input};
use crate::error::{Error, InputError, Result};
use std::fs::{File, FileType, Metadata};
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// A file or an object that can be opened again and again; of an object always the same version.
#[derive(Debug, Clone)]
pub(crate) enum Place {
    /// A file.
    File(PathBuf),
    /// An object.
    Object(Arc<Object>),
}

impl Place {
    /// The file or object at `path`, and its size in bytes; `expected` is for the message.
    ///
    /// # Errors
    /// It is not there, or is a folder, a pipe or a device.
    pub fn of(path: &Path, expected: &str) -> Result<(Self, u64)> {
        if objects::is_object(path) {
            let object = Object::open(path)?;
            let size = object.size();
            return Ok((Self::Object(object), size));
        }
        let meta = described(path)?;
        if !meta.is_file() {
            return Err(InputError::new(path, kind(meta.file_type()), expected).into());
        }
        Ok((Self::File(path.to_path_buf()), meta.len()))
    }

    /// Opens it at its beginning.
    ///
    /// # Errors
    /// The system refuses.
    pub fn open(&self) -> Result<Input> {
        match self {
            Self::File(path) => File::open(path).map(Input::File).map_err(|e| Error::io(path, "open", e)),
            Self::Object(object) => Ok(Input::Object(ObjectReader::new(object.clone()))),
        }
    }

    /// Whether to read a little of it costs more than a moment.
    pub fn is_remote(&self) -> bool {
        matches!(self, Self::Object(_))
    }

    /// What ended all reading of an object, although requests were tried again. Readers that take what cannot be read for damage
    /// of the file, and go on with the rest, ask for it in the end.
    ///
    /// # Errors
    /// That.
    pub fn verdict(&self) -> Result<()> {
        match self {
            Self::File(_) => Ok(()),
            Self::Object(object) => Ok(object.verdict()?),
        }
    }
}

/// What is read back and forth.
#[derive(Debug)]
pub(crate) enum Input {
    /// A file.
    File(File),
    /// An object.
    Object(ObjectReader),
}

impl Input {
    /// Says which bytes will be read next, so that those of an object come in few requests, and no others.
    pub fn expect(&mut self, ranges: impl Iterator<Item = Range<u64>>) {
        if let Self::Object(reader) = self {
            reader.expect(ranges.collect());
        }
    }
}

impl Read for Input {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::File(file) => file.read(buffer),
            Self::Object(reader) => reader.read(buffer),
        }
    }
}

impl Seek for Input {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        match self {
            Self::File(file) => file.seek(to),
            Self::Object(reader) => reader.seek(to),
        }
    }
}

/// Opens a file or an object that is read back and forth, and gives its size in bytes; `expected` is for the message.
///
/// # Errors
/// As [`Place::of`].
pub(crate) fn regular(path: &Path, expected: &str) -> Result<(Input, u64)> {
    let (place, size) = Place::of(path, expected)?;
    Ok((place.open()?, size))
}

/// The bytes of a file or an object that is read as a whole; `expected` is for the message.
///
/// # Errors
/// As [`regular`], and it cannot be read.
pub(crate) fn whole(path: &Path, expected: &str) -> Result<Vec<u8>> {
    let (mut input, size) = regular(path, expected)?;
    input.expect(std::iter::once(0..size));
    let mut bytes = Vec::new();
    input.read_to_end(&mut bytes).map_err(|e| Error::io(path, "read", e))?;
    Ok(bytes)
}

/// Opens a file or an object that is read once from its beginning to its end, which may be a pipe, or standard input (`-`), which
/// may be opened again.
///
/// # Errors
/// It cannot be opened, or is a folder or a device, which may have no end.
pub(crate) fn stream(path: &Path, expected: &str) -> Result<Box<dyn Read + Send>> {
    if is_standard_input(path) {
        let input = Reread::standard_input().map_err(|e| Error::io("standard input", "read", e))?;
        return Ok(Box::new(input));
    }
    if objects::is_object(path) {
        let (mut input, size) = regular(path, expected)?;
        input.expect(std::iter::once(0..size));
        return Ok(Box::new(input));
    }
    let meta = described(path)?;
    if !meta.is_file() && !is_pipe(meta.file_type()) {
        return Err(InputError::new(path, kind(meta.file_type()), expected).into());
    }
    let file = File::open(path).map_err(|e| Error::io(path, "open", e))?;
    Ok(Box::new(file))
}

/// Refuses a pipe where a model is read more than once.
///
/// # Errors
/// It is one, and not standard input.
pub(crate) fn refuse_pipe(path: &Path) -> Result<()> {
    if is_standard_input(path) || !std::fs::metadata(path).is_ok_and(|meta| is_pipe(meta.file_type())) {
        return Ok(());
    }
    let fault = InputError::new(path, "a pipe, which can be read once", "a file, or standard input");
    Err(fault.remedy(format!("Give it as standard input: - < {}", path.display())).into())
}

fn described(path: &Path) -> Result<Metadata> {
    std::fs::metadata(path).map_err(|e| Error::io(path, "open", e))
}

fn kind(of: FileType) -> &'static str {
    match of {
        of if of.is_dir() => "a folder, not a file",
        of if is_pipe(of) => "a pipe, not a file",
        _ => "a device, not a file",
    }
}

fn is_pipe(of: FileType) -> bool {
    #[cfg(unix)]
    return std::os::unix::fs::FileTypeExt::is_fifo(&of) || std::os::unix::fs::FileTypeExt::is_socket(&of);
    #[cfg(not(unix))]
    return !of.is_file() && !of.is_dir();
}
