//! What stands for objects where the feature `remote` is not built in: all are refused.

use std::convert::Infallible;
use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use crate::error::{InputError, Result};

/// An object, of which there is none.
#[derive(Debug)]
pub(crate) struct Object(Infallible);

/// A reader of one.
#[derive(Debug)]
pub(crate) struct ObjectReader(Arc<Object>);

fn refused(path: &Path) -> InputError {
    let found = "an address in object storage or on the web";
    InputError::new(super::label(path), found, "a file: this gable was built without the feature `remote`")
        .remedy("Fetch the file, or build with the feature `remote`")
}

impl Object {
    /// Refuses.
    pub fn open(path: &Path) -> Result<Arc<Self>> {
        Err(refused(path).into())
    }

    /// Its size.
    pub fn size(&self) -> u64 {
        match self.0 {}
    }

    /// What ended all reading of it.
    pub fn verdict(&self) -> Result<(), InputError> {
        match self.0 {}
    }
}

impl ObjectReader {
    /// A reader at the beginning.
    pub fn new(object: Arc<Object>) -> Self {
        Self(object)
    }

    /// Says which ranges will be read next.
    pub fn expect(&mut self, _: Vec<Range<u64>>) {
        match self.0.0 {}
    }
}

impl Read for ObjectReader {
    fn read(&mut self, _: &mut [u8]) -> io::Result<usize> {
        match self.0.0 {}
    }
}

impl Seek for ObjectReader {
    fn seek(&mut self, _: SeekFrom) -> io::Result<u64> {
        match self.0.0 {}
    }
}

/// Refuses.
pub(crate) fn list(folder: &Path, _: bool) -> Result<Vec<PathBuf>> {
    Err(refused(folder).into())
}

/// Refuses.
pub(crate) fn exists(path: &Path) -> Result<bool> {
    Err(refused(path).into())
}

/// Refuses.
pub(crate) fn put(_: &Path, to: &Path) -> Result<()> {
    Err(refused(to).into())
}

/// Refuses.
pub(crate) fn put_folder(_: &Path, to: &Path, _: &str) -> Result<()> {
    Err(refused(to).into())
}
