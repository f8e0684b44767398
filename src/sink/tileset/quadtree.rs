//! Which features share a tile: a quadtree over their centres, whose cells are files of index entries.
//!
//! Nothing of a feature is held in memory: a cell that holds too many is read from front to back and dealt out to the files
//! of its four quarters.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

use super::bytes::{Put, Take};

/// Bytes of an entry.
const ENTRY: usize = 40;
/// How many features, and how many of their triangles, a tile holds at most. A single feature may have more.
const MOST_FEATURES: u64 = 256;
const MOST_TRIANGLES: u64 = 50_000;
/// How often the extent is halved. Beyond, the features stand in one place and are taken in the order of the file.
const MOST_LEVELS: usize = 20;

/// Where a feature waits, where it stands and how large it is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Entry {
    /// First byte and length in the spill file.
    pub at: u64,
    pub length: u64,
    /// The centre of its extent in CRS coordinates.
    pub centre: [f64; 2],
    pub triangles: u64,
}

impl Entry {
    fn put(self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.at.to_le_bytes());
        out.extend_from_slice(&self.length.to_le_bytes());
        self.centre.iter().for_each(|&c| out.put_f64(c));
        out.extend_from_slice(&self.triangles.to_le_bytes());
    }

    fn take(bytes: &[u8; ENTRY]) -> Option<Self> {
        let mut from = Take(bytes);
        Some(Self { at: from.u64()?, length: from.u64()?, centre: [from.f64()?, from.f64()?], triangles: from.u64()? })
    }
}

/// A cell while it is filled.
pub(super) struct CellWriter {
    file: BufWriter<File>,
    count: u64,
    triangles: u64,
}

impl CellWriter {
    /// An empty cell, in a file without a name in `folder`.
    pub(super) fn create(folder: &Path) -> io::Result<Self> {
        Ok(Self { file: BufWriter::new(tempfile::tempfile_in(folder)?), count: 0, triangles: 0 })
    }

    pub(super) fn push(&mut self, entry: Entry) -> io::Result<()> {
        let mut bytes = Vec::with_capacity(ENTRY);
        entry.put(&mut bytes);
        self.count += 1;
        self.triangles += entry.triangles;
        self.file.write_all(&bytes)
    }

    /// The cell that has been filled.
    fn finish(self, square: Square, name: String, level: usize) -> io::Result<Cell> {
        let Self { file, count, triangles } = self;
        let mut file = file.into_inner().map_err(io::IntoInnerError::into_error)?;
        file.seek(SeekFrom::Start(0))?;
        Ok(Cell { file, count, triangles, square, name, level })
    }

    /// The cell of all features, whose centres lie between `min` and `max`.
    pub(super) fn root(self, min: [f64; 2], max: [f64; 2]) -> io::Result<Cell> {
        let centre = [0, 1].map(|i| f64::midpoint(min[i], max[i]));
        let half = f64::max(max[0] - min[0], max[1] - min[1]) / 2.0;
        self.finish(Square { centre, half }, String::new(), 0)
    }
}

/// A square in CRS coordinates.
#[derive(Debug, Clone, Copy)]
struct Square {
    centre: [f64; 2],
    half: f64,
}

impl Square {
    /// The quarter in which a point lies: 0 to 3, from south-west to north-east.
    fn quarter_of(&self, point: [f64; 2]) -> usize {
        usize::from(point[0] >= self.centre[0]) + 2 * usize::from(point[1] >= self.centre[1])
    }

    fn quarter(&self, i: usize) -> Self {
        let half = self.half / 2.0;
        let side = |is_far: bool| if is_far { half } else { -half };
        Self { centre: [self.centre[0] + side(i % 2 == 1), self.centre[1] + side(i / 2 == 1)], half }
    }
}

/// A square with the features whose centre lies in it.
pub(super) struct Cell {
    file: File,
    count: u64,
    triangles: u64,
    square: Square,
    /// The quarters that lead to it, a digit each.
    name: String,
    level: usize,
}

/// What becomes of a cell.
pub(super) enum Split {
    /// Its features share a tile.
    Leaf(Vec<Entry>),
    /// Smaller cells, none of them empty.
    Cells(Vec<Cell>),
}

impl Cell {
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    pub(super) fn count(&self) -> u64 {
        self.count
    }

    /// Splits the cell where it holds too much for a tile, or where its sides are longer than `widest` in units of the CRS.
    pub(super) fn split(self, folder: &Path, widest: f64) -> io::Result<Split> {
        let Self { file, count, triangles, square, name, level } = self;
        let mut reader = BufReader::new(file);
        let mut next = || -> io::Result<Option<Entry>> {
            let mut bytes = [0; ENTRY];
            reader.read_exact(&mut bytes)?;
            Ok(Entry::take(&bytes))
        };
        let is_small = count <= MOST_FEATURES && triangles <= MOST_TRIANGLES && 2.0 * square.half <= widest;
        if count <= 1 || is_small {
            let entries = (0..count).map(|_| next()).collect::<io::Result<Vec<_>>>()?;
            return Ok(Split::Leaf(entries.into_iter().flatten().collect()));
        }
        let mut quarters = Vec::new();
        for i in 0..4 {
            quarters.push((CellWriter::create(folder)?, square.quarter(i)));
        }
        for n in 0..count {
            let Some(entry) = next()? else { continue };
            let quarter = if level < MOST_LEVELS { square.quarter_of(entry.centre) } else { (n * 4 / count) as usize };
            if let Some((cell, _)) = quarters.get_mut(quarter) {
                cell.push(entry)?;
            }
        }
        let filled = quarters.into_iter().enumerate().filter(|(_, (cell, _))| cell.count > 0);
        let named = filled.map(|(i, (cell, square))| cell.finish(square, format!("{name}{i}"), level + 1));
        Ok(Split::Cells(named.collect::<io::Result<_>>()?))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn leaves(cell: Cell, folder: &Path, out: &mut Vec<(String, Vec<Entry>)>) {
        let name = cell.name().to_owned();
        match cell.split(folder, 1e3).unwrap() {
            Split::Leaf(entries) => out.push((name, entries)),
            Split::Cells(cells) => cells.into_iter().for_each(|cell| leaves(cell, folder, out)),
        }
    }

    fn tree(entries: &[Entry], min: [f64; 2], max: [f64; 2]) -> Vec<(String, Vec<Entry>)> {
        let folder = tempfile::tempdir().unwrap();
        let mut writer = CellWriter::create(folder.path()).unwrap();
        for entry in entries {
            writer.push(*entry).unwrap();
        }
        let mut out = Vec::new();
        leaves(writer.root(min, max).unwrap(), folder.path(), &mut out);
        out
    }

    #[test]
    fn every_feature_is_in_one_tile_that_is_not_too_large() {
        let entry = |i: u64| Entry { at: i, length: 1, centre: [(i % 40) as f64, (i / 40) as f64], triangles: 100 };
        let entries: Vec<Entry> = (0..1600).map(entry).collect();
        let leaves = tree(&entries, [0.0, 0.0], [39.0, 39.0]);
        let mut found: Vec<u64> = leaves.iter().flat_map(|(_, entries)| entries).map(|entry| entry.at).collect();
        found.sort_unstable();
        assert_eq!(found, (0..1600).collect::<Vec<u64>>());
        // 1600 features on a square of 40 × 40: quarters of 400 are too large, sixteenths of 100 are not.
        assert_eq!(leaves.len(), 16);
        assert_eq!(
            leaves.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>()[..5],
            ["00", "01", "02", "03", "10"]
        );
        assert_eq!(leaves[0].1[0].at, 0);
        assert!(leaves[0].1.iter().all(|entry| entry.centre[0] < 10.0 && entry.centre[1] < 10.0));
    }

    #[test]
    fn what_stands_in_one_place_is_dealt_out_in_order() {
        let entry =
            |i: u64| Entry { at: i, length: 1, centre: [5.0, 5.0], triangles: if i == 300 { 60_000 } else { 1 } };
        let entries: Vec<Entry> = (0..700).map(entry).collect();
        let leaves = tree(&entries, [5.0, 5.0], [5.0, 5.0]);
        let all: Vec<u64> = leaves.iter().flat_map(|(_, entries)| entries).map(|entry| entry.at).collect();
        assert_eq!(all, (0..700).collect::<Vec<u64>>());
        assert!(leaves.iter().all(|(_, entries)| entries.len() <= 256));
        assert!(
            leaves.iter().any(|(_, entries)| entries.len() == 1 && entries[0].at == 300),
            "too large to share a tile"
        );
    }
}
