//! What stops a whole run, or a whole input file.
//!
//! A building that cannot be done is never an error: it becomes a [`crate::report::BuildingReport`] with a reason.

use std::fmt;
use std::path::{Path, PathBuf};

/// The result of everything that can stop a run.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// What stops a run.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// An input file or option is not what it should be.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The operating system refused to read or write.
    #[error("{}: cannot {action}: {source}{}", path.display(), advice(source))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What was tried, as a verb: `open`, `read`, `write`, `rename`.
        action: &'static str,
        /// What the system answered.
        source: std::io::Error,
    },
    /// The run was interrupted before anything was written.
    #[error("interrupted before anything was written")]
    Interrupted,
}

impl Error {
    /// An [`Error::Io`] for `path` while doing `action`; where `source` is an error of this crate, which says more, that.
    pub fn io(path: impl Into<PathBuf>, action: &'static str, source: std::io::Error) -> Self {
        source.downcast().unwrap_or_else(|source| Self::Io { path: path.into(), action, source })
    }
}

/// What the user can do when the system refuses.
fn advice(source: &std::io::Error) -> &'static str {
    use std::io::ErrorKind;
    match source.kind() {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => ". Make room there, or write to another place",
        ErrorKind::FileTooLarge => ". Raise the limit on the size of files, or write to another place",
        ErrorKind::PermissionDenied => ". See whether you may read or write there",
        ErrorKind::ReadOnlyFilesystem => ". Write to another place",
        _ => "",
    }
}

/// A fault of an input: which file, where in it, what was found, what was expected, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InputError {
    /// The file or option at fault.
    pub file: PathBuf,
    /// Where in the file: a feature, a byte, a header field. Empty when it is the file as a whole.
    pub place: String,
    /// What was found there.
    pub found: String,
    /// What was expected.
    pub expected: String,
    /// What the user can do about it.
    pub remedy: String,
}

impl InputError {
    /// A fault of `file` as a whole; see [`Self::at`] for the place and [`Self::remedy`] for what to do.
    pub fn new(file: impl AsRef<Path>, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self {
            file: file.as_ref().to_path_buf(),
            place: String::new(),
            found: found.into(),
            expected: expected.into(),
            remedy: String::new(),
        }
    }

    /// The same fault with the place in the file.
    #[must_use]
    pub fn at(mut self, place: impl Into<String>) -> Self {
        self.place = place.into();
        self
    }

    /// The same fault with what the user can do.
    #[must_use]
    pub fn remedy(mut self, remedy: impl Into<String>) -> Self {
        self.remedy = remedy.into();
        self
    }
}

impl fmt::Display for InputError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if !self.place.is_empty() {
            write!(f, ", {}", self.place)?;
        }
        write!(f, ": found {}, expected {}", self.found, self.expected)?;
        if !self.remedy.is_empty() {
            write!(f, ". {}", self.remedy)?;
        }
        Ok(())
    }
}

impl std::error::Error for InputError {}
