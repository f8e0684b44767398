//! Decompression of one chunk at a time, with a guard around the decoder.

use super::chunks::Compression;
use laz::record::{LayeredPointRecordDecompressor, RecordDecompressor, SequentialPointRecordDecompressor};
use laz::{DecompressionSelection, LazItem};
use std::fs::File;
use std::io::{self, BufReader, Seek, SeekFrom};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Which fields of a record are decoded; the others are zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fields {
    /// Those of a [`super::ScanPoint`].
    Scan,
    /// All.
    All,
}

/// Decodes the chunks of one file, one after the other.
pub(super) struct Decoder {
    records: Box<dyn RecordDecompressor<BufReader<File>>>,
    items: Vec<LazItem>,
    record_len: usize,
    fields: Fields,
}

impl Decoder {
    /// A decoder of `file`.
    pub fn new(file: BufReader<File>, compression: &Compression, record_len: usize, fields: Fields) -> Self {
        let records: Box<dyn RecordDecompressor<BufReader<File>>> = if compression.layers.is_some() {
            Box::new(LayeredPointRecordDecompressor::new(file))
        } else {
            Box::new(SequentialPointRecordDecompressor::new(file))
        };
        Self { records, items: compression.items.clone(), record_len, fields }
    }

    /// The file; its position is that of the decoder.
    pub fn source(&mut self) -> &mut BufReader<File> {
        self.records.get_mut()
    }

    /// Makes ready for the chunk that begins at byte `start`.
    ///
    /// # Errors
    /// Why it cannot.
    pub fn begin(&mut self, start: u64) -> Result<(), String> {
        self.records.reset();
        self.records.set_fields_from(&self.items).map_err(|e| e.to_string())?;
        // Layers that are not wanted are passed over, which saves half the time for point formats 6 to 10.
        let selection = match self.fields {
            Fields::Scan => {
                DecompressionSelection::base().decompress_z().decompress_classification().decompress_flags()
            }
            Fields::All => DecompressionSelection::all(),
        };
        self.records.set_selection(selection);
        self.source().seek(SeekFrom::Start(start)).map_err(|e| e.to_string())?;
        Ok(())
    }

    /// Fills `records` with the next records of the chunk; gives how many could be decoded, and why no more.
    pub fn fill(&mut self, records: &mut [u8]) -> (usize, Option<String>) {
        let mut done = 0;
        let outcome = catch_unwind(AssertUnwindSafe(|| {
            for record in records.chunks_exact_mut(self.record_len) {
                self.records.decompress_next(record)?;
                done += 1;
            }
            Ok(())
        }));
        let cause = match outcome {
            Ok(Ok(())) => None,
            Ok(Err(error)) => Some(explain(&error)),
            Err(_) => Some("the compressed data are damaged".to_owned()),
        };
        (done, cause)
    }
}

/// Why reading stopped, in words.
pub(super) fn explain(error: &io::Error) -> String {
    if error.kind() == io::ErrorKind::UnexpectedEof { "the file ends early".to_owned() } else { error.to_string() }
}
