//! The part of a job: its buildings as the method returned them, in the order of their places in the model.
//!
//! A head, a line for each building as in a [checkpoint](crate::run::checkpoint), and an end, each with its checksum: a part
//! that is cut off is no part.

use std::fs::File;
use std::io::{self, BufRead, BufReader, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use tempfile::NamedTempFile;

use crate::building::Building;
use crate::error::{Error, Result};
use crate::run::records::{Record, content, line};
use crate::sink::temporary;

/// The extension of a part.
const EXTENSION: &str = "part.jsonl";

/// What a part is of.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(super) struct Head {
    /// Identity of the plan.
    pub(super) plan: String,
    pub(super) job: usize,
    /// Number of buildings.
    pub(super) buildings: usize,
}

/// The last line.
#[derive(Debug, PartialEq, Eq, Serialize, Deserialize)]
struct End {
    end: usize,
}

/// What is looked at of every building before any is read whole.
#[derive(Debug, Deserialize)]
pub(super) struct Glance {
    pub(super) index: usize,
    pub(super) building: GlanceAtBuilding,
}

#[derive(Debug, Deserialize)]
pub(super) struct GlanceAtBuilding {
    pub(super) id: String,
    pub(super) frame: crate::site::Frame,
}

/// The file of the part of a job in a folder of parts.
pub(super) fn path_of(folder: &Path, job: usize) -> PathBuf {
    folder.join(format!("{job}.{EXTENSION}"))
}

/// The report of a job beside its part.
pub(super) fn report_of(folder: &Path, job: usize) -> PathBuf {
    folder.join(format!("{job}.report.json"))
}

/// Whether a name is that of a part; of which job.
pub(super) fn job_of(name: &str) -> Option<usize> {
    let job = name.strip_suffix(EXTENSION)?.strip_suffix('.')?;
    job.parse().ok().filter(|number: &usize| number.to_string() == job)
}

/// A part that is being written.
pub(super) struct PartWriter {
    file: BufWriter<NamedTempFile>,
    path: PathBuf,
    written: usize,
}

impl PartWriter {
    /// Begins the part at `path`, in the folder `scratch` until it is whole.
    ///
    /// # Errors
    /// The system refuses.
    pub(super) fn create(path: PathBuf, head: &Head, scratch: &Path) -> Result<Self> {
        let file = temporary(0o666).tempfile_in(scratch).map_err(|e| Error::io(&path, "create", e))?;
        let mut part = Self { file: BufWriter::with_capacity(1 << 18, file), path, written: 0 };
        part.put(head)?;
        Ok(part)
    }

    /// Writes one more building.
    ///
    /// # Errors
    /// The system refuses.
    pub(super) fn write(&mut self, record: &Record<&Building>) -> Result<()> {
        self.written += 1;
        self.put(record)
    }

    /// Ends the part, makes it durable and gives it its name, in the place of one that is there.
    ///
    /// # Errors
    /// The system refuses.
    pub(super) fn commit(mut self) -> Result<()> {
        self.put(&End { end: self.written })?;
        let Self { file, path, .. } = self;
        let file = file.into_inner().map_err(|e| Error::io(&path, "write", e.into_error()))?;
        file.as_file().sync_all().map_err(|e| Error::io(&path, "write", e))?;
        file.persist(&path).map(drop).map_err(|e| Error::io(&path, "rename the finished file to", e.error))
    }

    fn put(&mut self, value: &impl Serialize) -> Result<()> {
        let written = line(value).map_err(io::Error::from).and_then(|line| self.file.write_all(&line));
        written.map_err(|e| Error::io(&self.path, "write", e))
    }
}

/// What a part is of, if the file is one that is whole as far as its ends tell.
///
/// # Errors
/// The file cannot be read.
pub(super) fn head(path: &Path) -> io::Result<Option<Head>> {
    const LONGEST_END: u64 = 128;
    let mut file = BufReader::new(File::open(path)?);
    let mut bytes = Vec::new();
    file.read_until(b'\n', &mut bytes)?;
    let head: Option<Head> = content(&bytes).and_then(|json| serde_json::from_slice(json).ok());
    let Some(head) = head else { return Ok(None) };
    let length = file.seek(SeekFrom::End(0))?;
    file.seek(SeekFrom::Start(length.saturating_sub(LONGEST_END)))?;
    let mut tail = Vec::new();
    io::Read::read_to_end(&mut file, &mut tail)?;
    let lines = tail.strip_suffix(b"\n").unwrap_or(&tail);
    let start = lines.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
    let end: Option<End> = content(&tail[start..]).and_then(|json| serde_json::from_slice(json).ok());
    Ok((end == Some(End { end: head.buildings })).then_some(head))
}

/// Looks at all buildings of a part: `each` is told where each stands. What is wrong with the part, if anything is.
///
/// # Errors
/// The file cannot be read.
pub(super) fn look_through(path: &Path, mut each: impl FnMut(Glance, u64, usize)) -> io::Result<Option<String>> {
    let mut reader = BufReader::with_capacity(1 << 18, File::open(path)?);
    let mut bytes = Vec::new();
    let (mut at, mut number, mut head) = (0, 0, None::<Head>);
    loop {
        bytes.clear();
        let length = reader.read_until(b'\n', &mut bytes)?;
        number += 1;
        let damaged = || Ok(Some(format!("line {number} is damaged or cut off")));
        let Some(json) = content(&bytes) else { return damaged() };
        match &head {
            None => match serde_json::from_slice(json) {
                Ok(found) => head = Some(found),
                Err(_) => return damaged(),
            },
            Some(head) => {
                if let Ok(end) = serde_json::from_slice::<End>(json) {
                    let seen = number - 2;
                    let is_whole = end.end == seen && head.buildings == seen;
                    return Ok((!is_whole).then(|| format!("it holds {seen} of {} buildings", head.buildings)));
                }
                match serde_json::from_slice::<Glance>(json) {
                    Ok(glance) => each(glance, at, length),
                    Err(_) => return damaged(),
                }
            }
        }
        at += length as u64;
    }
}
