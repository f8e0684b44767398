//! Which features share a tile: a quadtree over their centres, whose cells are files of index entries.
//!
//! Nothing of a feature is held in memory: a cell that holds too many is read from front to back and dealt out to the files
//! of its four quarters.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::Path;

use super::bytes::{Put, Take};

/// Bytes of an entry.
const ENTRY: usize = 48;
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
    /// The longest side of its extent in metres: what is lost where it is not drawn.
    pub size: f64,
}

impl Entry {
    fn put(self, out: &mut Vec<u8>) {
        out.extend_from_slice(&self.at.to_le_bytes());
        out.extend_from_slice(&self.length.to_le_bytes());
        self.centre.iter().for_each(|&c| out.put_f64(c));
        out.extend_from_slice(&self.triangles.to_le_bytes());
        out.put_f64(self.size);
    }

    fn take(bytes: &[u8; ENTRY]) -> Option<Self> {
        let mut from = Take(bytes);
        Some(Self {
            at: from.u64()?,
            length: from.u64()?,
            centre: [from.f64()?, from.f64()?],
            triangles: from.u64()?,
            size: from.f64()?,
        })
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
    /// Smaller cells, none of them empty, and what stands for all of them from afar.
    Cells(Vec<Cell>, Overview),
}

/// The largest features of a cell.
#[derive(Debug, Default)]
pub(super) struct Overview {
    /// As many as a tile holds, in the order of the spill file.
    pub entries: Vec<Entry>,
    /// The size of the largest that is not among them, metres; 0 where none is left out.
    pub omitted: f64,
}

/// A feature in the order of its size, of equally large ones the first in the spill file first.
#[derive(Debug, Clone, Copy)]
struct BySize(Entry);

impl BySize {
    fn key(&self) -> (u64, Reverse<u64>) {
        // Sizes are not negative: their bits are in their order.
        (self.0.size.to_bits(), Reverse(self.0.at))
    }
}

impl PartialEq for BySize {
    fn eq(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

impl Eq for BySize {}

impl PartialOrd for BySize {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for BySize {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.key().cmp(&other.key())
    }
}

impl Overview {
    /// Of the largest features and of one more, if there are more.
    fn of(mut largest: Vec<BySize>) -> Self {
        largest.sort_unstable_by_key(|entry| Reverse(entry.key()));
        let mut triangles = 0;
        let fits = |entry: &&BySize| {
            triangles += entry.0.triangles;
            triangles <= MOST_TRIANGLES
        };
        let count = largest.iter().take(MOST_FEATURES as usize).take_while(fits).count();
        let omitted = largest.get(count).map_or(0.0, |entry| entry.0.size);
        let mut entries: Vec<Entry> = largest.into_iter().take(count).map(|entry| entry.0).collect();
        entries.sort_unstable_by_key(|entry| entry.at);
        Self { entries, omitted }
    }
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
        let mut largest: BinaryHeap<Reverse<BySize>> = BinaryHeap::new();
        for n in 0..count {
            let Some(entry) = next()? else { continue };
            largest.push(Reverse(BySize(entry)));
            if largest.len() > MOST_FEATURES as usize + 1 {
                largest.pop();
            }
            let quarter = if level < MOST_LEVELS { square.quarter_of(entry.centre) } else { (n * 4 / count) as usize };
            if let Some((cell, _)) = quarters.get_mut(quarter) {
                cell.push(entry)?;
            }
        }
        let filled = quarters.into_iter().enumerate().filter(|(_, (cell, _))| cell.count > 0);
        let named = filled.map(|(i, (cell, square))| cell.finish(square, format!("{name}{i}"), level + 1));
        let overview = Overview::of(largest.into_iter().map(|Reverse(entry)| entry).collect());
        Ok(Split::Cells(named.collect::<io::Result<_>>()?, overview))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn leaves(cell: Cell, folder: &Path, out: &mut Vec<(String, Vec<Entry>)>) {
        let name = cell.name().to_owned();
        match cell.split(folder, 1e3).unwrap() {
            Split::Leaf(entries) => out.push((name, entries)),
            Split::Cells(cells, _) => cells.into_iter().for_each(|cell| leaves(cell, folder, out)),
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
        let entry =
            |i: u64| Entry { at: i, length: 1, centre: [(i % 40) as f64, (i / 40) as f64], triangles: 100, size: 9.0 };
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
    fn an_overview_holds_the_largest_and_tells_what_it_leaves_out() {
        let folder = tempfile::tempdir().unwrap();
        let entry = |i: u64| Entry {
            at: i,
            length: 1,
            centre: [(i % 40) as f64, (i / 40) as f64],
            triangles: 100,
            size: (i * 7 % 1000) as f64,
        };
        let mut writer = CellWriter::create(folder.path()).unwrap();
        for i in 0..1000 {
            writer.push(entry(i)).unwrap();
        }
        let root = writer.root([0.0, 0.0], [39.0, 39.0]).unwrap();
        let Split::Cells(_, overview) = root.split(folder.path(), 1e3).unwrap() else { panic!("not split") };
        assert_eq!((overview.entries.len(), overview.omitted), (256, 743.0));
        assert!(overview.entries.iter().all(|entry| entry.size >= 744.0));
        assert!(overview.entries.is_sorted_by_key(|entry| entry.at));
        // What has too many triangles for a tile is left out, and that is told.
        let large = |i: u64| BySize(Entry { triangles: 20_000, ..entry(i) });
        let overview = Overview::of((0..5).map(large).collect());
        assert_eq!((overview.entries.len(), overview.omitted), (2, 14.0));
    }

    #[test]
    fn what_stands_in_one_place_is_dealt_out_in_order() {
        let entry = |i: u64| Entry {
            at: i,
            length: 1,
            centre: [5.0, 5.0],
            triangles: if i == 300 { 60_000 } else { 1 },
            size: 1.0,
        };
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
