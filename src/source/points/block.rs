//! A block of point records as they stand in the file, and the columns we read from it.

use super::parcels::Parcels;
use super::placement::Placement;
use super::spill;
use las::{Transform, Vector};
use std::sync::Arc;

/// What we take from a point record.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ScanPoint {
    /// Coordinates in the units of the CRS.
    pub position: [f64; 3],
    /// ASPRS class (the overlap class 12 of the old formats stays 12).
    pub class: u8,
    /// Number of the return, from 1; 0 where the writer did not fill it in.
    pub return_number: u8,
    /// Marked as not made by the scanner.
    pub synthetic: bool,
    /// Marked as not to be used.
    pub withheld: bool,
    /// Marked as lying in the overlap of two strips (point formats 6 to 10).
    pub overlap: bool,
    /// The building that it names, as a place in [`Tile::buildings`](super::Tile::buildings); points of files name none unless
    /// the tile has [`Parcels`].
    pub building: Option<u32>,
}

impl ScanPoint {
    /// A point at `position` (CRS units) of an ASPRS class, of which nothing else is known.
    pub fn new(position: [f64; 3], class: u8) -> Self {
        Self { position, class, return_number: 0, synthetic: false, withheld: false, overlap: false, building: None }
    }
}

/// Some point records, as they stand in the file (LAS 1.4 R15, section 2.6).
#[derive(Debug, Clone)]
pub struct Block {
    bytes: Vec<u8>,
    record_len: usize,
    records: Records,
    parcels: Option<Arc<Parcels>>,
}

/// What the bytes of a record mean.
#[derive(Debug, Clone)]
pub(super) enum Records {
    /// Those of a LAS file.
    Las {
        /// Whether they are of the formats 6 to 10.
        extended: bool,
        /// From stored integers to coordinates.
        transforms: Vector<Transform>,
        /// The range of stored integers per axis that can be real.
        plausible: [(i32, i32); 3],
        /// From coordinates of the file to those of points.
        placement: Placement,
    },
    /// Those of [`spill`], in coordinates of the file.
    Spilled(Placement),
}

impl Block {
    /// An empty block for records of `record_len` bytes.
    pub(super) fn new(record_len: usize, records: Records, parcels: Option<Arc<Parcels>>) -> Self {
        Self { bytes: Vec::new(), record_len, records, parcels }
    }

    /// Makes room for `n` records and lends their bytes.
    pub(super) fn resize(&mut self, n: usize) -> &mut [u8] {
        self.bytes.resize(n * self.record_len, 0);
        &mut self.bytes
    }

    /// Keeps the first `n` records.
    pub(super) fn truncate(&mut self, n: usize) {
        self.bytes.truncate(n * self.record_len);
    }

    /// Number of records, those with absurd coordinates included.
    pub fn len(&self) -> usize {
        self.bytes.len() / self.record_len
    }

    /// Whether there is no record.
    pub fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    /// How many records have absurd coordinates.
    pub fn absurd(&self) -> usize {
        self.bytes.chunks_exact(self.record_len).filter(|r| !self.is_plausible(r)).count()
    }

    /// The points, without those with absurd coordinates.
    pub fn points(&self) -> impl Iterator<Item = ScanPoint> + '_ {
        let named = |mut point: ScanPoint| {
            if let (Some(parcels), None) = (&self.parcels, point.building) {
                point.building = parcels.building(point.position);
            }
            point
        };
        let sound = self.bytes.chunks_exact(self.record_len).filter(|r| self.is_plausible(r));
        sound.map(move |r| named(self.decode(r)))
    }

    /// The same with the intensity of each, of which it must have been streamed; 0 where the file has none.
    pub fn points_with_intensity(&self) -> impl Iterator<Item = (ScanPoint, u16)> + '_ {
        let of_las = matches!(self.records, Records::Las { .. });
        // Bytes 12 and 13 of all formats.
        let intensity = move |record: &[u8]| match record.get(12..14) {
            Some(&[low, high]) if of_las => u16::from_le_bytes([low, high]),
            _ => 0,
        };
        self.points().zip(self.records().map(intensity))
    }

    /// The records, without those with absurd coordinates, as they stand in the file.
    pub fn records(&self) -> impl Iterator<Item = &[u8]> + '_ {
        self.bytes.chunks_exact(self.record_len).filter(|r| self.is_plausible(r))
    }

    fn is_plausible(&self, record: &[u8]) -> bool {
        match &self.records {
            Records::Las { plausible, .. } => (0..3).all(|axis| {
                let value = stored(record, axis);
                plausible[axis].0 <= value && value <= plausible[axis].1
            }),
            Records::Spilled(placement) => spill::is_plausible(placement.apply(spill::position(record))),
        }
    }

    #[inline]
    fn decode(&self, record: &[u8]) -> ScanPoint {
        let (extended, transforms, placement) = match &self.records {
            Records::Las { extended, transforms, placement, .. } => (extended, transforms, placement),
            Records::Spilled(placement) => {
                let point = spill::decode(record);
                return ScanPoint { position: placement.apply(point.position), ..point };
            }
        };
        let position = placement.apply([
            transforms.x.direct(stored(record, 0)),
            transforms.y.direct(stored(record, 1)),
            transforms.z.direct(stored(record, 2)),
        ]);
        // Bytes 14 to 16 hold returns, flags and class: tables 7 (formats 0 to 5) and 15 (formats 6 to 10).
        let (returns, flags) = (record[14], record[15]);
        if *extended {
            ScanPoint {
                position,
                class: record[16],
                return_number: returns & 0x0f,
                synthetic: flags & 0x01 != 0,
                withheld: flags & 0x04 != 0,
                overlap: flags & 0x08 != 0,
                building: None,
            }
        } else {
            ScanPoint {
                position,
                class: flags & 0x1f,
                return_number: returns & 0x07,
                synthetic: flags & 0x20 != 0,
                withheld: flags & 0x80 != 0,
                overlap: false,
                building: None,
            }
        }
    }
}

#[inline]
fn stored(record: &[u8], axis: usize) -> i32 {
    let at = 4 * axis;
    i32::from_le_bytes([record[at], record[at + 1], record[at + 2], record[at + 3]])
}
