//! A report of more buildings than are to be held: they wait on disk until what stands before them is known.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Seek, SeekFrom, Write};
use std::path::Path;

use super::{BuildingReport, Report};
use crate::error::{Error, Result};
use crate::sink::temporary;

/// Where the buildings stand in a report without any: its last member.
const NONE: &str = "\"buildings\": []\n}";
/// The blanks before a building.
const INDENT: &str = "    ";

/// Buildings of a report, in their order.
#[derive(Debug)]
pub struct Spool {
    file: BufWriter<File>,
    is_empty: bool,
}

impl Spool {
    /// None yet; they wait in a nameless file in `folder`.
    ///
    /// # Errors
    /// The system refuses to make it.
    pub fn create(folder: &Path) -> Result<Self> {
        let file = tempfile::tempfile_in(folder).map_err(|e| Error::io(folder, "create a spill file in", e))?;
        Ok(Self { file: BufWriter::new(file), is_empty: true })
    }

    /// Takes one more.
    ///
    /// # Errors
    /// The system refuses to write.
    pub fn add(&mut self, building: &BuildingReport) -> Result<()> {
        let mut put = || -> io::Result<()> {
            let text = serde_json::to_string_pretty(building)?;
            self.file.write_all(if self.is_empty { b"[\n" } else { b",\n" })?;
            for (number, line) in text.lines().enumerate() {
                self.file.write_all(if number > 0 { b"\n" } else { b"" })?;
                self.file.write_all(INDENT.as_bytes())?;
                self.file.write_all(line.as_bytes())?;
            }
            self.is_empty = false;
            Ok(())
        };
        put().map_err(|e| Error::io("the report", "write", e))
    }

    /// Writes `report`, which has no buildings of its own, with these in it: as [`Report::write`] would if it held them.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write(self, report: &Report, path: &Path) -> Result<()> {
        let fault = |e: io::Error| Error::io(path, "write", e);
        let text = serde_json::to_string_pretty(report).map_err(|e| fault(e.into()))?;
        let head = text.strip_suffix(NONE).filter(|_| !self.is_empty);
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."));
        let mut file = temporary(0o666).tempfile_in(folder).map_err(fault)?;
        let put = |out: &mut File| -> io::Result<()> {
            let mut out = BufWriter::new(out);
            match head {
                None => out.write_all(text.as_bytes())?,
                Some(head) => {
                    let mut spooled = self.file.into_inner().map_err(io::IntoInnerError::into_error)?;
                    spooled.seek(SeekFrom::Start(0))?;
                    out.write_all(head.as_bytes())?;
                    out.write_all(b"\"buildings\": ")?;
                    io::copy(&mut BufReader::new(spooled), &mut out)?;
                    out.write_all(b"\n  ]\n}")?;
                }
            }
            out.write_all(b"\n")?;
            out.flush()
        };
        put(file.as_file_mut()).and_then(|()| file.as_file().sync_all()).map_err(fault)?;
        file.persist(path).map(drop).map_err(|e| Error::io(path, "rename the finished file to", e.error))
    }
}
