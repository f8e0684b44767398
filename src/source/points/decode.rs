//! Decompression of one chunk at a time, with a guard around the decoder.

use super::chunks::Compression;
use super::gps_time::{Coding, GpsTimes};
use super::layered_times::LayeredTimes;
use crate::guard::guarded;
use crate::source::open::Input;
use laz::las::{v1, v2};
use laz::record::{LayeredPointRecordDecompressor, RecordDecompressor, SequentialPointRecordDecompressor};
use laz::{DecompressionSelection, LazItem, LazItemType};
use std::io::{self, BufReader, Seek, SeekFrom};

/// Which fields of a record are decoded; the others are zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Fields {
    /// Those of a [`super::ScanPoint`].
    Scan,
    /// The same and the intensity.
    ScanAndIntensity,
    /// All.
    All,
}

/// Decodes the chunks of one file, one after the other.
pub(super) struct Decoder {
    records: Records,
    items: Vec<LazItem>,
    layers: u64,
    record_len: usize,
    fields: Fields,
}

/// The decoder of the crate for either way to store records.
enum Records {
    Sequential(SequentialPointRecordDecompressor<'static, BufReader<Input>>),
    /// With the decoder of the times, when they are wanted.
    Layered(LayeredPointRecordDecompressor<'static, BufReader<Input>>, Option<LayeredTimes>),
}

impl Decoder {
    /// A decoder of `file`.
    pub fn new(file: BufReader<Input>, compression: &Compression, record_len: usize, fields: Fields) -> Self {
        let records = if compression.layers.is_some() {
            Records::Layered(LayeredPointRecordDecompressor::new(file), None)
        } else {
            Records::Sequential(SequentialPointRecordDecompressor::new(file))
        };
        let layers = compression.layers.unwrap_or(0);
        Self { records, items: compression.items.clone(), layers, record_len, fields }
    }

    /// The file; its position is that of the decoder.
    pub fn source(&mut self) -> &mut BufReader<Input> {
        match &mut self.records {
            Records::Sequential(records) => records.get_mut(),
            Records::Layered(records, _) => records.get_mut(),
        }
    }

    /// Makes ready for the chunk that begins at byte `start`.
    ///
    /// # Errors
    /// Why it cannot.
    pub fn begin(&mut self, start: u64) -> Result<(), String> {
        match &mut self.records {
            Records::Sequential(records) => {
                records.reset();
                self.items.iter().try_for_each(|item| add_field(records, *item))?;
            }
            Records::Layered(records, times) => {
                records.reset();
                records.set_fields_from(&self.items).map_err(|e| e.to_string())?;
                // Layers that are not wanted are passed over, which saves half the time.
                let of_scan =
                    DecompressionSelection::base().decompress_z().decompress_classification().decompress_flags();
                let selection = match self.fields {
                    Fields::Scan => of_scan,
                    Fields::ScanAndIntensity => of_scan.decompress_intensity(),
                    Fields::All => DecompressionSelection::all().skip_gps_time(),
                };
                records.set_selection(selection);
                if self.fields == Fields::All {
                    let read = LayeredTimes::read(records.get_mut(), start, self.record_len, self.layers);
                    *times = Some(read.map_err(|e| explain(&e))?);
                }
            }
        }
        self.source().seek(SeekFrom::Start(start)).map_err(|e| e.to_string())?;
        Ok(())
    }

    /// Fills `records` with the next records of the chunk; gives how many could be decoded, and why no more.
    pub fn fill(&mut self, records: &mut [u8]) -> (usize, Option<String>) {
        let mut done = 0;
        let outcome = guarded(|| {
            for record in records.chunks_exact_mut(self.record_len) {
                match &mut self.records {
                    Records::Sequential(decoder) => decoder.decompress_next(record)?,
                    Records::Layered(decoder, times) => {
                        decoder.decompress_next(record)?;
                        times.as_mut().map_or(Ok(()), |times| times.fill(record))?;
                    }
                }
                done += 1;
            }
            io::Result::Ok(())
        });
        let cause = match outcome {
            Ok(Ok(())) => None,
            Ok(Err(error)) => Some(explain(&error)),
            // What the decoder trips over says nothing to a reader: it takes all data for sound.
            Err(_) => Some("the compressed data are damaged".to_owned()),
        };
        (done, cause)
    }
}

/// Adds the decoder of a field as the crate does, but for [`GpsTimes`].
fn add_field(
    records: &mut SequentialPointRecordDecompressor<'static, BufReader<Input>>,
    item: LazItem,
) -> Result<(), String> {
    let bytes = usize::from(item.size());
    match (item.item_type(), item.version()) {
        (LazItemType::Point10, 1) => records.add_field_decompressor(v1::LasPoint0Decompressor::default()),
        (LazItemType::Point10, 2) => records.add_field_decompressor(v2::LasPoint0Decompressor::default()),
        (LazItemType::GpsTime, 1) => records.add_field_decompressor(v1::LasGpsTimeDecompressor::default()),
        (LazItemType::GpsTime, 2) => records.add_field_decompressor(GpsTimes::new(Coding::Sequential, 0)),
        (LazItemType::RGB12, 1) => records.add_field_decompressor(v1::LasRGBDecompressor::default()),
        (LazItemType::RGB12, 2) => records.add_field_decompressor(v2::LasRGBDecompressor::default()),
        (LazItemType::WavePacket13, 1 | 2) => records.add_field_decompressor(v1::LasWavepacketDecompressor::default()),
        (LazItemType::Byte(_), 1) => records.add_field_decompressor(v1::LasExtraByteDecompressor::new(bytes)),
        (LazItemType::Byte(_), 2) => records.add_field_decompressor(v2::LasExtraByteDecompressor::new(bytes)),
        (kind, version) => return Err(format!("{kind:?} version {version} is unknown")),
    }
    Ok(())
}

/// Why reading stopped, in words.
pub(super) fn explain(error: &io::Error) -> String {
    if error.kind() == io::ErrorKind::UnexpectedEof { "the file ends early".to_owned() } else { error.to_string() }
}
