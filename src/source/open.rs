//! Opening what a user names: a pipe or a device must not hang the program or fill its memory.

use super::reread::{Reread, is_standard_input};
use crate::error::{Error, InputError, Result};
use std::fs::{File, FileType, Metadata};
use std::io::Read;
use std::path::Path;

/// Opens a file that is read back and forth, and gives its size in bytes; `expected` is for the message.
///
/// # Errors
/// It cannot be opened, or is a folder, a pipe or a device.
pub(crate) fn regular(path: &Path, expected: &str) -> Result<(File, u64)> {
    let meta = described(path)?;
    if !meta.is_file() {
        return Err(InputError::new(path, kind(meta.file_type()), expected).into());
    }
    File::open(path).map(|file| (file, meta.len())).map_err(|e| Error::io(path, "open", e))
}

/// The bytes of a file that is read as a whole; `expected` is for the message.
///
/// # Errors
/// As [`regular`], and it cannot be read.
pub(crate) fn whole(path: &Path, expected: &str) -> Result<Vec<u8>> {
    let (mut file, _) = regular(path, expected)?;
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).map_err(|e| Error::io(path, "read", e))?;
    Ok(bytes)
}

/// Opens a file that is read once from its beginning to its end, which may be a pipe, or standard input (`-`), which may
/// be opened again.
///
/// # Errors
/// It cannot be opened, or is a folder or a device, which may have no end.
pub(crate) fn stream(path: &Path, expected: &str) -> Result<Box<dyn Read + Send>> {
    if is_standard_input(path) {
        let input = Reread::standard_input().map_err(|e| Error::io("standard input", "read", e))?;
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
