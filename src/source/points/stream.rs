//! Handing out the points of a tile, block by block.

use super::block::{Block, ScanPoint};
use super::chunks::{Chunk, Chunking, Compression};
use super::cloud::Cloud;
use super::decode::{Decoder, Fields, explain};
use super::problem::TileProblem;
use super::spill;
use super::tile::{Origin, Tile};
use crate::error::Result;
use crate::source::open::Place;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::ops::ControlFlow;

/// Points per block: large enough to make calls cheap, small enough (600 KB) to stay in the cache and out of the way.
const BLOCK: u64 = 16_384;

/// Whether anything is wanted of the rectangle from the first to the second corner, CRS units.
pub type Region<'a> = dyn Fn([f64; 2], [f64; 2]) -> bool + Sync + 'a;

/// What came of streaming a tile.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Reading {
    /// Points that should have been read.
    pub expected: u64,
    /// Points read, those with absurd coordinates included.
    pub read: u64,
    /// Points with absurd coordinates; [`Block::points`] leaves them out.
    pub absurd: u64,
    /// Points not read because their octree node was not wanted (COPC).
    pub passed_over: u64,
    /// Why points are missing, when some are.
    pub cause: Option<String>,
}

impl Reading {
    /// What is wrong with the tile, as far as reading it showed.
    pub fn problems(&self, tile: &Tile) -> Vec<TileProblem> {
        let mut problems = Vec::new();
        if self.read < self.expected {
            problems.push(TileProblem::MissingPoints {
                tile: tile.path.clone(),
                expected: self.expected,
                read: self.read,
                cause: self.cause.clone().unwrap_or_else(|| "the file holds no more".to_owned()),
            });
        }
        if self.absurd > 0 {
            problems.push(TileProblem::AbsurdCoordinates { tile: tile.path.clone(), points: self.absurd });
        }
        problems
    }
}

impl Tile {
    /// Streams the points through `visit`, in the order of the file.
    ///
    /// With a `region`, a COPC tile is read only where it is wanted: whole octree nodes, so points outside come along.
    /// Other tiles are read whole. What is missing or damaged is told by the [`Reading`]; it is no error.
    ///
    /// # Errors
    /// The file cannot be opened; an object cannot be read any more, or was changed.
    pub fn stream(&self, region: Option<&Region>, visit: &mut dyn FnMut(&Block)) -> Result<Reading> {
        self.stream_fields(Fields::Scan, region, &mut |block| {
            visit(block);
            ControlFlow::Continue(())
        })
    }

    /// The same with the intensities, for [`Block::points_with_intensity`].
    ///
    /// # Errors
    /// As [`Self::stream`].
    pub fn stream_with_intensity(&self, region: Option<&Region>, visit: &mut dyn FnMut(&Block)) -> Result<Reading> {
        self.stream_fields(Fields::ScanAndIntensity, region, &mut |block| {
            visit(block);
            ControlFlow::Continue(())
        })
    }

    /// The same with all fields of the records decoded, for [`Block::records`], until `visit` says to stop; what was not
    /// read then is not missing.
    ///
    /// # Errors
    /// As [`Self::stream`].
    pub fn stream_records(
        &self,
        region: Option<&Region>,
        visit: &mut dyn FnMut(&Block) -> ControlFlow<()>,
    ) -> Result<Reading> {
        self.stream_fields(Fields::All, region, visit)
    }

    fn stream_fields(
        &self,
        fields: Fields,
        region: Option<&Region>,
        visit: &mut dyn FnMut(&Block) -> ControlFlow<()>,
    ) -> Result<Reading> {
        let layout = self.layout();
        let mut reading = Reading { expected: layout.points, ..Reading::default() };
        if layout.points == 0 {
            return Ok(reading);
        }
        let mut out = Output::new(self.block(), &mut reading, visit);
        let place = match &self.origin {
            Origin::Las(place) => place,
            Origin::Spill(spill) => {
                self.stream_plain(&mut spill.reader(), &mut out);
                return Ok(reading);
            }
            Origin::Cloud(cloud, place) => {
                out.reading.expected = cloud.announced().unwrap_or(layout.points);
                self.stream_cloud(cloud, place, &mut out)?;
                return Ok(reading);
            }
            Origin::Elsewhere => {
                out.reading.expected = 0;
                out.reading.passed_over = layout.points;
                return Ok(reading);
            }
        };
        let mut file = BufReader::with_capacity(1 << 16, place.open()?);
        match &layout.compression {
            None => {
                let held = layout.points.saturating_mul(layout.record_len as u64);
                file.get_mut().expect(std::iter::once(layout.data_start..layout.data_start.saturating_add(held)));
                self.stream_plain(&mut file, &mut out);
            }
            Some(compression) => {
                let nodes = region.and_then(|region| self.copc_nodes(&mut file, region));
                let chunks = match nodes {
                    Some((chunks, passed_over)) => {
                        out.reading.expected = chunks.iter().map(|c| c.points).sum();
                        out.reading.passed_over = passed_over;
                        Some(chunks)
                    }
                    None => compression.table(&mut file, layout),
                };
                match &chunks {
                    Some(chunks) => {
                        let ranges = chunks.iter().map(|chunk| chunk.start..chunk.start.saturating_add(chunk.bytes));
                        file.get_mut().expect(ranges);
                    }
                    None => file.get_mut().expect(std::iter::once(layout.data_start..layout.file_size)),
                }
                let decoder = Decoder::new(file, compression, layout.record_len, fields);
                match chunks {
                    Some(chunks) => self.stream_chunks(decoder, compression, &chunks, &mut out),
                    None => self.stream_without_table(decoder, compression, &mut out),
                }
            }
        }
        place.verdict()?;
        Ok(reading)
    }

    /// Uncompressed records: as many as the file holds.
    fn stream_plain(&self, file: &mut (impl Read + Seek), out: &mut Output) {
        let layout = self.layout();
        let held = (layout.file_size - layout.data_start) / layout.record_len as u64;
        let mut left = layout.points.min(held);
        if held < layout.points {
            out.reading.cause = Some("the file ends early".to_owned());
        }
        if let Err(error) = file.seek(SeekFrom::Start(layout.data_start)) {
            out.reading.cause = Some(explain(&error));
            return;
        }
        while left > 0 && !out.is_over {
            let n = left.min(BLOCK);
            if let Err(error) = file.read_exact(out.block.resize(n as usize)) {
                out.reading.cause = Some(explain(&error));
                return;
            }
            out.hand_out(n as usize);
            left -= n;
        }
    }

    /// Points of another kind of file, made records.
    fn stream_cloud(&self, cloud: &Cloud, place: &Place, out: &mut Output) -> Result<()> {
        let mut filled = 0;
        let fault = cloud.read(&self.path, place, &mut |position, class| {
            if let Some(record) = out.block.resize(BLOCK as usize).as_chunks_mut().0.get_mut(filled) {
                spill::encode(&ScanPoint::new(position, class), record);
                filled += 1;
            }
            if filled as u64 == BLOCK {
                out.hand_out(filled);
                filled = 0;
            }
            if out.is_over { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })?;
        if filled > 0 && !out.is_over {
            out.hand_out(filled);
        }
        out.reading.cause = fault.map(|fault| format!("{}: {}", fault.place, fault.found));
        Ok(())
    }

    /// Chunks whose places are known: one that is damaged costs its own points only.
    fn stream_chunks(&self, mut decoder: Decoder, compression: &Compression, chunks: &[Chunk], out: &mut Output) {
        for chunk in chunks {
            if out.is_over {
                return;
            }
            let mut points = chunk.points;
            if compression.layers.is_some() {
                let bytes = chunk.bytes.min(self.layout().file_size.saturating_sub(chunk.start));
                let record_len = self.layout().record_len;
                let Some(stated) = compression.checked_layers(decoder.source(), record_len, chunk.start, bytes) else {
                    out.damaged(chunk.start, "it is damaged or cut off");
                    continue;
                };
                points = points.min(stated);
            }
            if let Err(cause) = decoder.begin(chunk.start).and_then(|()| out.fill_from(&mut decoder, points)) {
                out.damaged(chunk.start, &cause);
            }
        }
    }

    /// Without a chunk table (it stands at the end, so a file that is cut off has none) every chunk begins where the one
    /// before it ends, and the first fault is the end.
    fn stream_without_table(&self, mut decoder: Decoder, compression: &Compression, out: &mut Output) {
        let layout = self.layout();
        let mut start = layout.data_start + 8;
        let mut left = layout.points;
        while left > 0 && !out.is_over {
            let bytes = layout.file_size.saturating_sub(start);
            let stated = match compression.layers {
                Some(_) => compression.checked_layers(decoder.source(), layout.record_len, start, bytes),
                None => Some(left),
            };
            let points = match (stated, compression.chunking) {
                (Some(stated), Chunking::Fixed(size)) => stated.min(size),
                (Some(stated), Chunking::Variable) if compression.layers.is_some() => stated,
                _ => 0,
            }
            .min(left);
            let outcome = if points == 0 {
                Err("the file ends early and has no chunk table".to_owned())
            } else {
                decoder.begin(start).and_then(|()| out.fill_from(&mut decoder, points))
            };
            match outcome.and_then(|()| decoder.source().stream_position().map_err(|e| e.to_string())) {
                Ok(position) => start = position,
                Err(cause) => {
                    out.damaged(start, &cause);
                    return;
                }
            }
            left -= points;
        }
    }
}

/// Where decoded blocks go.
struct Output<'a> {
    block: Block,
    reading: &'a mut Reading,
    visit: &'a mut dyn FnMut(&Block) -> ControlFlow<()>,
    is_over: bool,
    damaged_chunks: u64,
    first_cause: Option<String>,
}

impl<'a> Output<'a> {
    fn new(block: Block, reading: &'a mut Reading, visit: &'a mut dyn FnMut(&Block) -> ControlFlow<()>) -> Self {
        Self { block, reading, visit, is_over: false, damaged_chunks: 0, first_cause: None }
    }
}

impl Output<'_> {
    /// Decodes `points` records of the chunk that the decoder is at, and hands them out.
    fn fill_from(&mut self, decoder: &mut Decoder, points: u64) -> Result<(), String> {
        let mut left = points;
        while left > 0 && !self.is_over {
            let n = left.min(BLOCK);
            let (done, cause) = decoder.fill(self.block.resize(n as usize));
            self.hand_out(done);
            if let Some(cause) = cause {
                return Err(cause);
            }
            left -= n;
        }
        Ok(())
    }

    /// Notes why points of the chunk at byte `start` are missing: the first place is told, the others are counted.
    fn damaged(&mut self, start: u64, cause: &str) {
        self.damaged_chunks += 1;
        let first = self.first_cause.get_or_insert_with(|| format!("in the chunk at byte {start}: {cause}"));
        self.reading.cause = Some(match self.damaged_chunks {
            1 => first.clone(),
            several => format!("{first}; and in {} other chunk(s)", several - 1),
        });
    }

    fn hand_out(&mut self, records: usize) {
        self.block.truncate(records);
        if records > 0 {
            self.reading.read += records as u64;
            self.reading.absurd += self.block.absurd() as u64;
            self.is_over |= (self.visit)(&self.block).is_break();
            if self.is_over {
                self.reading.expected = self.reading.read;
            }
        }
    }
}
