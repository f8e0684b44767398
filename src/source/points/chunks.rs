//! How the points of a LAZ file are cut into chunks, each of which can be decoded on its own.

use super::header::Layout;
use laz::laszip::ChunkTable;
use laz::{LazItem, LazItemType, LazVlr};
use std::io::{Read, Seek, SeekFrom};

/// How many points a chunk holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Chunking {
    /// All points are one chunk, and there is no chunk table.
    Whole,
    /// Every chunk but the last holds so many points.
    Fixed(u64),
    /// Every chunk has its own number of points.
    Variable,
}

/// How the records are compressed, checked against the header.
#[derive(Debug, Clone)]
pub(super) struct Compression {
    /// The fields of a record and the coder version of each.
    pub items: Vec<LazItem>,
    /// How the points are cut into chunks.
    pub chunking: Chunking,
    /// Number of layers when the chunks are layered (point formats 6 to 10), each with its size at the chunk's head.
    pub layers: Option<u64>,
    vlr: LazVlr,
}

/// A run of points that can be decoded on its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Chunk {
    /// Byte at which it begins.
    pub start: u64,
    /// Its length in bytes.
    pub bytes: u64,
    /// Points in it.
    pub points: u64,
}

impl Compression {
    /// The compression stated by the `LASzip` record of `header`, whose uncompressed records are `record_len` bytes.
    ///
    /// # Errors
    /// What was found and what was expected.
    pub fn of(header: &las::Header, record_len: usize) -> Result<Self, (String, String)> {
        let record = header.vlrs().iter().find(|vlr| las::laz::is_laszip_vlr(vlr));
        let Some(record) = record else {
            return Err(("none".into(), "one, because the points are compressed".into()));
        };
        let vlr = LazVlr::from_buffer(&record.data).map_err(|e| (e.to_string(), "a known compression".to_owned()))?;
        let items = vlr.items().clone();
        // The compressor number is the first field of the record; the laz crate keeps it to itself.
        let chunking = match record.data.first() {
            Some(1) => Chunking::Whole,
            Some(2 | 3) if vlr.uses_variable_size_chunks() => Chunking::Variable,
            Some(2 | 3) => Chunking::Fixed(u64::from(vlr.chunk_size())),
            other => {
                return Err((format!("compressor {}", other.copied().unwrap_or(0)), "compressor 1, 2 or 3".into()));
            }
        };
        let extended = header.point_format().is_extended;
        let first = if extended { LazItemType::Point14 } else { LazItemType::Point10 };
        if items.first().map(LazItem::item_type) != Some(first) {
            return Err((format!("{:?}", items.first().map(LazItem::item_type)), format!("{first:?} first")));
        }
        let (mut size, mut layers) = (0, 0);
        for item in &items {
            let (bytes, item_layers, layered) = extent_of(item.item_type());
            if item.size() != bytes || layered != extended {
                return Err((format!("{:?} of {} bytes", item.item_type(), item.size()), format!("{bytes} bytes")));
            }
            let versions = if layered { 3..=4 } else { 1..=2 };
            if !versions.contains(&item.version()) {
                return Err((format!("{:?} version {}", item.item_type(), item.version()), format!("{versions:?}")));
            }
            size += usize::from(bytes);
            layers += item_layers;
        }
        if size != record_len {
            return Err((format!("fields of {size} bytes in all"), format!("{record_len}, the length of a record")));
        }
        Ok(Self { items, chunking, layers: extended.then_some(layers), vlr })
    }

    /// The chunks according to the chunk table of the file; `None` when there is none or it cannot be true.
    pub fn table<R: Read + Seek>(&self, source: &mut R, layout: &Layout) -> Option<Vec<Chunk>> {
        Some(self.whole_table(source, layout)?.0)
    }

    /// The same, and how many points the table lists beyond those that the header announces, at least.
    pub fn whole_table<R: Read + Seek>(&self, source: &mut R, layout: &Layout) -> Option<(Vec<Chunk>, u64)> {
        let first = layout.data_start.checked_add(ChunkTable::OFFSET_SIZE as u64)?;
        if self.chunking == Chunking::Whole {
            let bytes = layout.file_size.checked_sub(layout.data_start)?;
            return Some((vec![Chunk { start: layout.data_start, bytes, points: layout.points }], 0));
        }
        source.seek(SeekFrom::Start(layout.data_start)).ok()?;
        let mut at = read_u64(source)?;
        if i64::try_from(at).is_ok_and(|at| at <= layout.data_start as i64) || at == u64::MAX {
            // A writer that could not go back left the offset at the end of the file.
            source.seek(SeekFrom::Start(layout.file_size.checked_sub(8)?)).ok()?;
            at = read_u64(source)?;
        }
        if at < first || at.checked_add(8)? > layout.file_size {
            return None;
        }
        source.seek(SeekFrom::Start(at)).ok()?;
        // Low half: version, high half: number of chunks. The first point of a chunk is stored as it is.
        let chunks = read_u64(source)? >> 32;
        if chunks > (at - first) / layout.record_len as u64 {
            return None;
        }
        source.seek(SeekFrom::Start(layout.data_start)).ok()?;
        let table = ChunkTable::read_from(source, &self.vlr).ok()?;
        let mut start = first;
        let mut left = layout.points;
        let mut found = Vec::with_capacity(table.len());
        let mut surplus = 0;
        for entry in table.as_ref() {
            let end = start.checked_add(entry.byte_count).filter(|end| *end <= at)?;
            let points = entry.point_count.min(left);
            left -= points;
            if points > 0 {
                found.push(Chunk { start, bytes: entry.byte_count, points });
            }
            surplus += match self.chunking {
                Chunking::Variable => entry.point_count - points,
                // A chunk that is not announced has one point at least, and makes the one before it whole.
                _ if points == 0 && entry.byte_count > 0 => 1,
                _ => 0,
            };
            start = end;
        }
        if let (Chunking::Fixed(size), true) = (self.chunking, surplus > 0) {
            surplus = (surplus - 1).saturating_mul(size) + 1;
        }
        Some((found, surplus))
    }

    /// Whether the layer sizes at the head of the layered chunk at `start` fit into `bytes`; the decoder believes them
    /// and makes room for them at once. Also gives the number of points that the chunk states.
    pub fn checked_layers<R: Read + Seek>(
        &self,
        source: &mut R,
        record_len: usize,
        start: u64,
        bytes: u64,
    ) -> Option<u64> {
        let layers = self.layers?;
        let head = (record_len as u64).checked_add(4 + 4 * layers)?;
        source.seek(SeekFrom::Start(start.checked_add(record_len as u64)?)).ok()?;
        let points = u64::from(read_u32(source)?);
        let mut total = head;
        for _ in 0..layers {
            total += u64::from(read_u32(source)?);
        }
        (total <= bytes).then_some(points)
    }
}

/// Bytes and layers of a field, and whether it belongs to the layered formats.
fn extent_of(item: LazItemType) -> (u16, u64, bool) {
    match item {
        LazItemType::Point10 => (20, 0, false),
        LazItemType::GpsTime => (8, 0, false),
        LazItemType::RGB12 => (6, 0, false),
        LazItemType::WavePacket13 => (29, 0, false),
        LazItemType::Byte(n) => (n, 0, false),
        LazItemType::Point14 => (30, 9, true),
        LazItemType::RGB14 => (6, 1, true),
        LazItemType::RGBNIR14 => (8, 2, true),
        LazItemType::WavePacket14 => (29, 1, true),
        LazItemType::Byte14(n) => (n, u64::from(n), true),
    }
}

fn read_u64<R: Read>(source: &mut R) -> Option<u64> {
    let mut bytes = [0; 8];
    source.read_exact(&mut bytes).ok()?;
    Some(u64::from_le_bytes(bytes))
}

fn read_u32<R: Read>(source: &mut R) -> Option<u32> {
    let mut bytes = [0; 4];
    source.read_exact(&mut bytes).ok()?;
    Some(u32::from_le_bytes(bytes))
}
