//! Files that are read several times: without a name, at once, or from standard input, which comes only once.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

/// Names that mean standard input.
const STANDARD_INPUT: [&str; 4] = ["-", "/dev/stdin", "/dev/fd/0", "/proc/self/fd/0"];

/// Whether a path means standard input.
pub(crate) fn is_standard_input(path: &Path) -> bool {
    STANDARD_INPUT.iter().any(|name| path == Path::new(name))
}

/// Reads a file from its beginning with a position of its own, whatever others read at the same time.
#[derive(Debug)]
pub(crate) struct Reread {
    file: Arc<File>,
    at: u64,
}

impl Reread {
    /// A reader at the beginning.
    pub fn new(file: Arc<File>) -> Self {
        Self { file, at: 0 }
    }

    /// Standard input from its beginning: what came is kept in a temporary file without a name as long as the process
    /// lives, because whoever reads models reads them more than once.
    ///
    /// # Errors
    /// It cannot be read, or the temporary file not be written.
    pub fn standard_input() -> io::Result<Self> {
        static KEPT: Mutex<Option<Arc<File>>> = Mutex::new(None);
        let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(file) = &*kept {
            return Ok(Self::new(file.clone()));
        }
        let mut file = tempfile::tempfile()?;
        io::copy(&mut io::stdin().lock(), &mut file)?;
        Ok(Self::new(kept.insert(Arc::new(file)).clone()))
    }
}

impl Read for Reread {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        #[cfg(unix)]
        let read = std::os::unix::fs::FileExt::read_at(&*self.file, buffer, self.at)?;
        #[cfg(windows)]
        let read = std::os::windows::fs::FileExt::seek_read(&*self.file, buffer, self.at)?;
        self.at += read as u64;
        Ok(read)
    }
}

impl Seek for Reread {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let (base, offset) = match to {
            SeekFrom::Start(at) => (at, 0),
            SeekFrom::Current(offset) => (self.at, offset),
            SeekFrom::End(offset) => (self.file.metadata()?.len(), offset),
        };
        self.at = base.checked_add_signed(offset).ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.at)
    }
}
