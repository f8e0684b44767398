//! CityJSONSeq to a stream: standard output, a pipe or a device.
//!
//! Nobody can go back in a stream, so the head does not tell the extent, and there is no name that could appear late: what
//! reads it sees each building as soon as it is done.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::header::Metadata;
use super::sequence::Sequence;
use super::{Feature, Format, Sink, Written};
use crate::error::{Error, InputError, Result};

/// Names that mean standard output.
const STANDARD_OUTPUT: [&str; 4] = ["-", "/dev/stdout", "/dev/fd/1", "/proc/self/fd/1"];

/// Whether an output is standard output.
pub fn is_standard_output(path: &Path) -> bool {
    STANDARD_OUTPUT.iter().any(|name| path == Path::new(name))
}

/// Whether an output is a stream: standard output (`-`), or a pipe or device that is there.
pub fn is_stream(path: &Path) -> bool {
    is_standard_output(path) || std::fs::metadata(path).is_ok_and(|meta| !meta.is_file() && !meta.is_dir())
}

/// Writes a line a feature as soon as it comes.
struct Stream<W: Write + Send> {
    out: BufWriter<W>,
    sequence: Sequence,
    path: PathBuf,
    features: usize,
    bytes: u64,
}

/// Opens a sink for a stream. One that nobody reads yet is waited for.
///
/// # Errors
/// Its name asks for another format, which cannot be streamed; or it cannot be opened or written.
pub fn stream(path: &Path, metadata: Metadata) -> Result<Box<dyn Sink>> {
    if let Ok(other) = Format::of(path)
        && other != Format::CityJsonSeq
    {
        let fault = InputError::new(path, format!("a stream that is named for {}", other.name()), "CityJSONSeq");
        return Err(fault
            .remedy("A pipe or device takes CityJSONSeq only: give it another name, or write a file")
            .into());
    }
    Ok(if is_standard_output(path) {
        Box::new(Stream::begin(io::stdout(), Path::new("standard output"), metadata)?)
    } else {
        let file: File = OpenOptions::new().write(true).open(path).map_err(|e| Error::io(path, "open", e))?;
        Box::new(Stream::begin(file, path, metadata)?)
    })
}

impl<W: Write + Send> Stream<W> {
    fn begin(out: W, path: &Path, metadata: Metadata) -> Result<Self> {
        let sequence = Sequence::new(metadata)?;
        let out = BufWriter::with_capacity(1 << 16, out);
        let mut stream = Self { out, sequence, path: path.to_path_buf(), features: 0, bytes: 0 };
        let head = stream.sequence.head()?;
        stream.line(&head)?;
        Ok(stream)
    }

    fn line(&mut self, line: &[u8]) -> Result<()> {
        let Self { out, path, bytes, .. } = self;
        let written = out.write_all(line).and_then(|()| out.write_all(b"\n")).and_then(|()| out.flush());
        *bytes += line.len() as u64 + 1;
        written.map_err(|e| Error::io(path.as_path(), "write", e))
    }
}

impl<W: Write + Send> Sink for Stream<W> {
    fn write(&mut self, feature: &Feature) -> Result<()> {
        let line = self.sequence.feature(feature)?.to_vec();
        self.features += 1;
        self.line(&line)
    }

    fn finish(self: Box<Self>) -> Result<Written> {
        let Self { sequence, path, features, bytes, .. } = *self;
        let (format, objects) = (Some(Format::CityJsonSeq), sequence.objects());
        Ok(Written { path, format, features, objects, bytes, notes: Vec::new() })
    }
}
