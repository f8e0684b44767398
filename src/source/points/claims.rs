//! What a header claims, held against what stands in the file.
//!
//! A header whose box is plausible and wrong would make a tile pass for one that is far from all footprints, and nobody
//! would ever read a point of it. So a few points are looked at before a box is believed, and some thousands before a
//! tile is passed over.

use super::chunks::{Chunk, Compression};
use super::decode::{Decoder, Fields};
use super::header::Layout;
use super::problem::TileProblem;
use super::tile::{Extent, Origin, Tile};
use crate::source::open::Input;
use las::{Transform, Vector};
use std::io::{BufReader, Read, Seek, SeekFrom};

/// Points that are looked at when a tile is opened.
const SAMPLES: u64 = 64;
/// Points that are looked at before a tile is passed over, and chunks that they are taken from.
const PROOF: (u64, u64) = (16_384, 16);
/// Bytes of a record that say where it lies, without its height.
const PLACE: u64 = 8;
/// By so many CRS units points may lie outside the box without a word: headers are rounded.
const ROUNDING: f64 = 1.0;

impl Extent {
    /// Whether a point lies in the box by its x and y, or as near as rounding may have put it.
    pub fn holds(&self, position: [f64; 3]) -> bool {
        (0..2).all(|axis| (self.min[axis] - ROUNDING..=self.max[axis] + ROUNDING).contains(&position[axis]))
    }
}

impl Tile {
    /// Whether the points lie in the box that the header states, as far as some thousands of them tell: all of a small
    /// tile, of others some from each of several places. True where there is no box, or none can be read; and of an object,
    /// of which megabytes would be fetched for it: there the few points count that were looked at when it was opened.
    pub fn is_true_to_its_extent(&self) -> bool {
        let Some(extent) = self.extent.filter(|_| self.placement.is_identity()) else { return true };
        let Origin::Las(place) = &self.origin else { return true };
        if place.is_remote() {
            return true;
        }
        let Ok(file) = place.open() else { return true };
        let (mut file, layout) = (BufReader::new(file), self.layout());
        let mut block = self.block();
        let Some(compression) = &layout.compression else {
            return all_of_plain(&mut file, layout, self.header.transforms(), &extent);
        };
        let Some(chunks) = compression.table(&mut file, layout) else { return true };
        let taken: Vec<Chunk> =
            spread(chunks.len() as u64, PROOF.1).filter_map(|index| chunks.get(index as usize)).copied().collect();
        let share = PROOF.0 / (taken.len() as u64).max(1);
        let mut decoder = Decoder::new(file, compression, layout.record_len, Fields::Scan);
        taken.iter().all(|chunk| {
            let is_sound = compression.layers.is_none()
                || compression.checked_layers(decoder.source(), layout.record_len, chunk.start, chunk.bytes).is_some();
            if !is_sound || decoder.begin(chunk.start).is_err() {
                return true;
            }
            let (done, _) = decoder.fill(block.resize(chunk.points.min(share) as usize));
            block.truncate(done);
            block.points().all(|point| extent.holds(point.position))
        })
    }
}

impl Tile {
    /// What its header claims and what does not hold, where `outside` of `read` points lie outside its box.
    pub(crate) fn wrong_claims(&self, outside: u64, read: u64) -> impl Iterator<Item = TileProblem> {
        let tile = || self.path.clone();
        let (points, announced) = (self.unannounced, self.points);
        let unannounced = (points > 0).then(|| TileProblem::UnannouncedPoints { tile: tile(), points, announced });
        let extent = match self.stated_extent {
            None if self.extent.is_none() && read > 0 && self.is_las() => {
                Some(TileProblem::UnusableExtent { tile: tile() })
            }
            Some(_) if outside > 0 => Some(TileProblem::PointsOutsideExtent { tile: tile(), points: outside, read }),
            _ => None,
        };
        extent.into_iter().chain(unannounced)
    }
}

/// Records spread over an uncompressed file, all of a small one.
fn all_of_plain(file: &mut BufReader<Input>, layout: &Layout, transforms: &Vector<Transform>, extent: &Extent) -> bool {
    let starts = starts_of_plain(layout, if layout.points <= PROOF.0 { PROOF.0 } else { PROOF.0 / 16 });
    starts.into_iter().filter_map(|start| place(file, start, transforms)).all(|place| extent.holds(place))
}

/// Whether the box of the header holds the points, as far as a few of them tell: spread over the records of a LAS file, or
/// the first of some chunks of a LAZ file, which stand uncompressed. True where none can be read.
pub(super) fn is_plausible(
    source: &mut BufReader<Input>,
    layout: &Layout,
    transforms: &Vector<Transform>,
    extent: &Extent,
    chunks: &[Chunk],
) -> bool {
    let starts: Vec<u64> = if layout.compression.is_none() {
        starts_of_plain(layout, SAMPLES)
    } else {
        let chosen = spread(chunks.len() as u64, SAMPLES).filter_map(|index| chunks.get(index as usize));
        chosen.map(|chunk| chunk.start).collect()
    };
    source.get_mut().expect(starts.iter().map(|&start| start..start + PLACE));
    let places = starts.into_iter().filter_map(|start| place(source, start, transforms));
    let (inside, outside): (Vec<_>, Vec<_>) = places.partition(|place| extent.holds(*place));
    // Damage puts single points anywhere: those are left out later on, and the box stands.
    outside.len() * 4 <= inside.len() + outside.len()
}

/// Where the record that begins at byte `start` lies, without its height.
fn place<R: Read + Seek>(source: &mut R, start: u64, transforms: &Vector<Transform>) -> Option<[f64; 3]> {
    let mut record = [[0; 4]; 2];
    source.seek(SeekFrom::Start(start)).and_then(|_| source.read_exact(record.as_flattened_mut())).ok()?;
    let [x, y] = record.map(i32::from_le_bytes);
    Some([transforms.x.direct(x), transforms.y.direct(y), 0.0])
}

/// The bytes at which some records of an uncompressed file begin.
fn starts_of_plain(layout: &Layout, most: u64) -> Vec<u64> {
    let record_len = layout.record_len as u64;
    let held = (layout.file_size.saturating_sub(layout.data_start) / record_len.max(1)).min(layout.points);
    spread(held, most).map(|index| layout.data_start + index * record_len).collect()
}

/// At most `most` of `count` numbers, evenly spread, the first and the last among them.
fn spread(count: u64, most: u64) -> impl Iterator<Item = u64> {
    let taken = count.min(most);
    (0..taken).map(move |i| if taken > 1 { i * (count - 1) / (taken - 1) } else { 0 })
}

/// How many points stand in the file beyond those that its header announces: at least so many where they are compressed.
/// `end` is the byte at which something else begins behind them, if anything does.
pub(super) fn unannounced(layout: &Layout, end: Option<u64>, surplus: u64) -> u64 {
    match &layout.compression {
        Some(_) => surplus,
        // Without points a file is not said to be compressed.
        None if layout.points == 0 => 0,
        None => {
            let end = end.filter(|end| *end > layout.data_start).unwrap_or(layout.file_size).min(layout.file_size);
            (end.saturating_sub(layout.data_start) / (layout.record_len as u64).max(1)).saturating_sub(layout.points)
        }
    }
}

/// The chunks of a compressed file, and how many more points than announced its table lists.
pub(super) fn chunks<R: Read + Seek>(
    source: &mut R,
    layout: &Layout,
    compression: Option<&Compression>,
) -> (Vec<Chunk>, u64) {
    let Some(compression) = compression else { return (Vec::new(), 0) };
    compression.whole_table(source, layout).unwrap_or_default()
}
