//! Points that come without a file, kept in a nameless temporary one so that memory stays flat.
//!
//! They are kept as they come, as doubles: no scale has to be chosen, no digit is lost, and coordinates may span anything.
//! The file has no name from the moment it is made, so it goes away with its last owner however that one ends.

use super::block::ScanPoint;
use super::header::Layout;
use super::placement::Placement;
use super::tile::{Extent, HIGHEST, LARGEST, Origin, Tile};
use crate::error::{Error, InputError, Result};
use crate::source::crs::Crs;
use crate::source::reread::Reread;
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Bytes of a record: x, y, z, class, number of the return, flags, a blank, and the building; little-endian.
pub(super) const RECORD: usize = 32;
/// Bits of the flags, those of LAS 1.4 R15, table 16.
const SYNTHETIC: u8 = 0x01;
const WITHHELD: u8 = 0x04;
const OVERLAP: u8 = 0x08;
/// The building of a point that names none.
const NO_BUILDING: u32 = u32::MAX;
/// Points per tile (128 MB): tiles are read in parallel, and those that lie far from any footprint not at all.
const PART: u64 = 1 << 22;

/// Takes points and makes tiles of them.
#[derive(Debug)]
pub struct SpillWriter {
    file: BufWriter<File>,
    name: PathBuf,
    folder: PathBuf,
    points: u64,
    /// Extents of the parts, the last of them under way.
    parts: Vec<Extent>,
}

impl SpillWriter {
    /// Opens a temporary file in `folder`; `name` is what messages and reports call the points.
    ///
    /// # Errors
    /// The folder cannot be written to.
    pub fn create(folder: &Path, name: impl Into<PathBuf>) -> Result<Self> {
        let file = tempfile::tempfile_in(folder).map_err(|e| Error::io(folder, "create a temporary file in", e))?;
        let file = BufWriter::with_capacity(1 << 18, file);
        Ok(Self { file, name: name.into(), folder: folder.to_path_buf(), points: 0, parts: Vec::new() })
    }

    /// Number of points until now.
    pub fn points(&self) -> u64 {
        self.points
    }

    /// What messages and reports call the points.
    pub fn name(&self) -> &Path {
        &self.name
    }

    /// Takes a point.
    ///
    /// # Errors
    /// A coordinate is not a finite number, or the temporary file cannot be written.
    pub fn push(&mut self, point: &ScanPoint) -> Result<()> {
        let position = point.position;
        if let Some(axis) = position.iter().position(|value| !value.is_finite()) {
            let found = format!("{} = {}", ['x', 'y', 'z'][axis], position[axis]);
            let fault = InputError::new(&self.name, found, "finite coordinates").at(format!("point {}", self.points));
            return Err(fault.remedy("Leave such points out").into());
        }
        let mut record = [0; RECORD];
        encode(point, &mut record);
        self.file.write_all(&record).map_err(|e| self.fault(e))?;
        if self.points.is_multiple_of(PART) {
            self.parts.push(Extent::EMPTY);
        }
        self.points += 1;
        if let Some(extent) = self.parts.last_mut().filter(|_| is_plausible(position)) {
            extent.grow(position);
        }
        Ok(())
    }

    /// The tiles that hold the points, in `crs`. `covered` are the areas that were scanned; without any that is the
    /// extent of all points. `buildings` are the ids that the points refer to. Without a point there is one empty tile.
    ///
    /// # Errors
    /// The temporary file cannot be written.
    pub fn finish(self, crs: Option<&Crs>, covered: Vec<Extent>, buildings: Vec<String>) -> Result<Vec<Tile>> {
        let Self { file, name, folder, points, mut parts } = self;
        let file = file.into_inner().map_err(|e| Error::io(folder, "write a temporary file in", e.into_error()))?;
        let spill = Spill(Arc::new(file));
        let mut all = Extent::EMPTY;
        for part in &parts {
            all.join(part);
        }
        let everything = if covered.is_empty() && !all.is_empty() { vec![all] } else { covered };
        let mut covered = Some(everything);
        let buildings: Arc<[String]> = buildings.into();
        if parts.is_empty() {
            parts.push(Extent::EMPTY);
        }
        let tile = |(index, extent): (u64, &Extent)| {
            let start = index * PART;
            let count = PART.min(points - start);
            let layout = Layout {
                version_minor: 0,
                point_format: 0,
                data_start: start * RECORD as u64,
                data_end: None,
                file_size: points * RECORD as u64,
                points: count,
                record_len: RECORD,
                compression: None,
            };
            Tile {
                path: name.clone(),
                header: las::Header::default(),
                crs: crs.cloned(),
                crs_fault: None,
                extent: (!extent.is_empty()).then_some(*extent),
                stated_extent: None,
                points: count,
                unannounced: 0,
                version: String::new(),
                point_format: 0,
                is_copc: false,
                has_classes: true,
                // They cover it together: the first says so for all.
                covered: Some(covered.take().unwrap_or_default()),
                buildings: buildings.clone(),
                layout,
                origin: Origin::Spill(spill.clone()),
                placement: Placement::default(),
                parcels: None,
                raw_extent: (!extent.is_empty()).then_some(*extent),
            }
        };
        Ok((0..).zip(&parts).map(tile).collect())
    }

    fn fault(&self, source: io::Error) -> Error {
        Error::io(&self.folder, "write a temporary file in", source)
    }
}

/// The temporary file, shared by the tiles in it.
#[derive(Debug, Clone)]
pub(super) struct Spill(Arc<File>);

impl Spill {
    /// Reads from the beginning, whatever others read at the same time.
    pub(super) fn reader(&self) -> impl Read + Seek + use<> {
        Reread::new(self.0.clone())
    }
}

/// Whether a place can be on the Earth, in any CRS and any of its units.
pub(super) fn is_plausible([x, y, z]: [f64; 3]) -> bool {
    x.abs() <= LARGEST && y.abs() <= LARGEST && z.abs() <= HIGHEST
}

/// The coordinates of a record.
#[inline]
pub(super) fn position(record: &[u8]) -> [f64; 3] {
    std::array::from_fn(|axis| f64::from_le_bytes(std::array::from_fn(|byte| record[8 * axis + byte])))
}

/// Makes a record of a point.
#[inline]
pub(super) fn encode(point: &ScanPoint, record: &mut [u8; RECORD]) {
    let ScanPoint { position, class, return_number, synthetic, withheld, overlap, building } = *point;
    let flag = |is_set: bool, bit: u8| if is_set { bit } else { 0 };
    for (bytes, value) in record.chunks_exact_mut(8).zip(position) {
        bytes.copy_from_slice(&value.to_le_bytes());
    }
    record[24] = class;
    record[25] = return_number;
    record[26] = flag(synthetic, SYNTHETIC) | flag(withheld, WITHHELD) | flag(overlap, OVERLAP);
    record[27] = 0;
    record[28..].copy_from_slice(&building.unwrap_or(NO_BUILDING).to_le_bytes());
}

/// A record of [`encode`].
#[inline]
pub(super) fn decode(record: &[u8]) -> ScanPoint {
    let (flags, building) = (record[26], u32::from_le_bytes([record[28], record[29], record[30], record[31]]));
    ScanPoint {
        position: position(record),
        class: record[24],
        return_number: record[25],
        synthetic: flags & SYNTHETIC != 0,
        withheld: flags & WITHHELD != 0,
        overlap: flags & OVERLAP != 0,
        building: (building != NO_BUILDING).then_some(building),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(tiles: &[Tile]) -> (Vec<ScanPoint>, u64) {
        let mut points = Vec::new();
        let mut absurd = 0;
        for tile in tiles {
            absurd += tile.stream(None, &mut |block| points.extend(block.points())).unwrap().absurd;
        }
        (points, absurd)
    }

    #[test]
    fn points_come_back_to_the_last_bit_and_the_file_has_no_name() {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = SpillWriter::create(folder.path(), "pushed").unwrap();
        // Further apart than 32 bits at any scale that keeps their digits.
        let a = ScanPoint { return_number: 3, overlap: true, ..ScanPoint::new([0.1 + 0.2, -5e8, 1e-9], 6) };
        let b = ScanPoint { building: Some(1), withheld: true, ..ScanPoint::new([7e8, 9e8, 80.0], 255) };
        let absurd = ScanPoint { synthetic: true, ..ScanPoint::new([1e10, 0.0, 0.0], 2) };
        for point in [a, b, absurd] {
            writer.push(&point).unwrap();
        }
        let message = writer.push(&ScanPoint::new([0.0, f64::NAN, 0.0], 2)).unwrap_err().to_string();
        assert!(message.starts_with("pushed, point 3: found y = NaN"), "{message}");
        let tiles = writer.finish(None, Vec::new(), vec!["p".into(), "q".into()]).unwrap();
        assert_eq!((tiles.len(), tiles[0].points), (1, 3));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        assert_eq!(read(&tiles), (vec![a, b], 1));
        let extent = Extent { min: [0.1 + 0.2, -5e8, 1e-9], max: [7e8, 9e8, 80.0] };
        assert_eq!((tiles[0].extent, tiles[0].areas()), (Some(extent), [extent].as_slice()));
        assert_eq!(tiles[0].buildings[1], "q");
    }

    #[test]
    fn many_points_make_several_tiles_that_cover_the_whole_together() {
        let mut writer = SpillWriter::create(&std::env::temp_dir(), "pushed").unwrap();
        for i in 0..=PART {
            writer.push(&ScanPoint::new([i as f64, 1.0, 2.0], 6)).unwrap();
        }
        let tiles = writer.finish(None, Vec::new(), Vec::new()).unwrap();
        assert_eq!(tiles.iter().map(|t| t.points).collect::<Vec<_>>(), [PART, 1]);
        let last = read(&tiles[1..]).0;
        assert_eq!(last, [ScanPoint::new([PART as f64, 1.0, 2.0], 6)]);
        assert_eq!((tiles[0].areas().len(), tiles[1].areas().len()), (1, 0));
        assert_eq!(tiles[0].areas()[0].max, [PART as f64, 1.0, 2.0]);
    }
}
