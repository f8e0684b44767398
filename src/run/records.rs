//! Buildings that are done, as lines of a file: each with a checksum, so that one that was cut off is known.

use std::collections::BTreeMap;
use std::fs::File;
use std::hash::{DefaultHasher, Hasher};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use super::identity::Identity;
use crate::building::Building;
use crate::error::{Error, Result};
use crate::guard::lock;

/// Characters of a checksum and the blank behind it.
const CHECKSUM: usize = 17;

/// A building and what it cost, as a line.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Record<B> {
    /// Its place in the order of the model.
    pub(super) index: usize,
    /// The hash of all that was known of it before it was made.
    pub(super) inputs: u64,
    pub(super) wall: Duration,
    pub(super) cpu: Option<Duration>,
    pub(super) building: B,
}

/// The part of a [`Record`] that is wanted of all lines.
#[derive(Deserialize)]
struct Index {
    index: usize,
}

/// Buildings in a file, by their places.
#[derive(Debug)]
pub(super) struct Records {
    file: Mutex<File>,
    path: PathBuf,
    /// First byte and length of the line of each.
    found: Mutex<BTreeMap<usize, (u64, usize)>>,
}

impl Records {
    /// Those of an open file, in which these lines were found.
    pub(super) fn new(file: File, path: PathBuf, found: BTreeMap<usize, (u64, usize)>) -> Self {
        Self { file: Mutex::new(file), path, found: Mutex::new(found) }
    }

    /// None yet, in a file without a name that goes with this process.
    ///
    /// # Errors
    /// The system's temporary folder cannot be written to.
    pub(super) fn nameless() -> Result<Self> {
        let folder = std::env::temp_dir();
        let file = tempfile::tempfile_in(&folder).map_err(|e| Error::io(&folder, "create a temporary file in", e))?;
        Ok(Self::new(file, folder, BTreeMap::new()))
    }

    /// The file, or the folder that it stands in without a name.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        lock(&self.found).len()
    }

    /// Whether the building of this place is there.
    pub(super) fn has(&self, index: usize) -> bool {
        lock(&self.found).contains_key(&index)
    }

    /// A building that is there; `None` when there is none, or when it can no longer be read: then it is made anew.
    pub(super) fn recall(&self, index: usize) -> Option<Record<Building>> {
        let (start, length) = *lock(&self.found).get(&index)?;
        let mut bytes = vec![0; length];
        let mut file = lock(&self.file);
        file.seek(SeekFrom::Start(start)).and_then(|_| file.read_exact(&mut bytes)).ok()?;
        drop(file);
        let record: Record<Building> = serde_json::from_slice(content(&bytes)?).ok()?;
        (record.index == index).then_some(record)
    }

    /// Keeps a building that was made, instead of another of its place. In a file that has a name it is safe from the end of this process as soon as this
    /// returns.
    ///
    /// # Errors
    /// The system refuses to write.
    pub(super) fn keep(&self, record: &Record<&Building>) -> Result<()> {
        let fault = |e: io::Error| Error::io(&self.path, "write", e);
        let bytes = line(record).map_err(|e| fault(e.into()))?;
        let mut file = lock(&self.file);
        let start = file.seek(SeekFrom::End(0)).and_then(|end| file.write_all(&bytes).map(|()| end)).map_err(fault)?;
        drop(file);
        lock(&self.found).insert(record.index, (start, bytes.len()));
        Ok(())
    }
}

/// The lines of a checkpoint that are whole.
#[derive(Debug, Default)]
pub(super) struct Lines {
    pub(super) head: Option<Identity>,
    pub(super) found: BTreeMap<usize, (u64, usize)>,
    /// The end of the last of them.
    pub(super) end: u64,
}

/// Reads up to the first line that is not whole.
pub(super) fn scan(file: &File) -> io::Result<Lines> {
    let mut reader = BufReader::with_capacity(1 << 18, file);
    reader.seek(SeekFrom::Start(0))?;
    let mut lines = Lines::default();
    let mut bytes = Vec::new();
    loop {
        bytes.clear();
        let length = reader.read_until(b'\n', &mut bytes)?;
        let Some(content) = content(&bytes) else { return Ok(lines) };
        if lines.head.is_none() {
            let Ok(head) = serde_json::from_slice(content) else { return Ok(lines) };
            lines.head = Some(head);
        } else {
            let Ok(Index { index }) = serde_json::from_slice(content) else { return Ok(lines) };
            lines.found.insert(index, (lines.end, length));
        }
        lines.end += length as u64;
    }
}

/// A value as a line: checksum, blank, JSON, line end.
pub(super) fn line(value: &impl Serialize) -> serde_json::Result<Vec<u8>> {
    let json = serde_json::to_vec(value)?;
    let mut line = format!("{:016x} ", checksum(&json)).into_bytes();
    line.extend_from_slice(&json);
    line.push(b'\n');
    Ok(line)
}

/// The JSON of a line that is whole.
pub(super) fn content(line: &[u8]) -> Option<&[u8]> {
    let (head, json) = line.strip_suffix(b"\n")?.split_at_checked(CHECKSUM)?;
    (head == format!("{:016x} ", checksum(json)).as_bytes()).then_some(json)
}

pub(super) fn checksum(bytes: &[u8]) -> u64 {
    let mut hasher = DefaultHasher::new();
    hasher.write(bytes);
    hasher.finish()
}
