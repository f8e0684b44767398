//! Ground points while they stream by: one of each half metre, put on disk as soon as there are many.
//!
//! What is kept of a cell is the point nearest to its centre. That does not depend on the order of the points, nor on how the
//! cloud was cut: what two tiles keep of one cell meets when it is read.

use std::collections::{HashMap, HashSet};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use foldhash::fast::FixedState;

use super::grid::{Grid, Place};
use crate::error::{Error, Result};

/// Cells along the side of a block.
const BLOCK: i64 = 64;
const CELLS: usize = (BLOCK * BLOCK) as usize;
/// How many blocks a collector holds: 25 MB, half a square kilometre.
const MOST_BLOCKS: usize = 512;
/// Bytes of a sample on disk: its cell in the block, its place in the cell, its height.
const RECORD: usize = 10;

/// A ground point: its place in its cell and its height, in steps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Sample {
    pub at: [u16; 2],
    pub z: i32,
}

impl Sample {
    /// What decides which point of a cell stays: how near it is to the centre, then its numbers.
    fn rank(self, cell: [i64; 2]) -> (u64, i32, [u16; 2]) {
        let off = |axis: usize| (2 * i64::from(self.at[axis]) - cell[axis]).unsigned_abs();
        (off(0) * off(0) + off(1) * off(1), self.z, self.at)
    }
}

/// The cells of a square, each with its ground point or none.
type Block = Box<[Option<Sample>]>;

/// The ground points of a run, on disk.
#[derive(Debug)]
pub struct GroundStore {
    grid: Grid,
    folder: PathBuf,
    kept: Mutex<Kept>,
}

#[derive(Debug)]
struct Kept {
    file: File,
    end: u64,
    /// Where the samples of each block are: first byte, and how many.
    chunks: HashMap<[i64; 2], Vec<(u64, u32)>, FixedState>,
    /// Blocks in which any point was seen.
    seen: HashSet<[i64; 2], FixedState>,
    /// How many ground points there were.
    points: u64,
}

impl GroundStore {
    /// An empty store in a nameless file in `folder`.
    ///
    /// # Errors
    /// The folder cannot be written to.
    pub fn create(folder: &Path, grid: Grid) -> Result<Self> {
        let file = tempfile::tempfile_in(folder).map_err(|e| Error::io(folder, "create a temporary file in", e))?;
        let kept = Kept { file, end: 0, chunks: HashMap::default(), seen: HashSet::default(), points: 0 };
        Ok(Self { grid, folder: folder.to_path_buf(), kept: Mutex::new(kept) })
    }

    /// A collector, of which any number may be at work.
    pub fn collector(&self) -> Collector<'_> {
        Collector {
            store: self,
            blocks: HashMap::default(),
            last: None,
            seen: HashSet::default(),
            last_seen: None,
            points: 0,
            fault: None,
        }
    }

    /// How many ground points came.
    pub fn points(&self) -> u64 {
        self.lock().points
    }

    pub(super) fn grid(&self) -> &Grid {
        &self.grid
    }

    /// The rectangles that hold ground points, as their smallest and largest places, in order.
    pub(super) fn extents(&self) -> Vec<[Place; 2]> {
        self.rectangles(self.lock().chunks.keys().copied().collect())
    }

    /// The rectangles that hold any points at all.
    pub(super) fn seen(&self) -> Vec<[Place; 2]> {
        self.rectangles(self.lock().seen.iter().copied().collect())
    }

    fn rectangles(&self, mut keys: Vec<[i64; 2]>) -> Vec<[Place; 2]> {
        keys.sort_unstable();
        let corner = |key: [i64; 2]| [0, 1].map(|axis| key[axis] * BLOCK * self.grid.sample[axis]);
        keys.into_iter().map(|key| [corner(key), corner(key.map(|k| k + 1)).map(|c| c - 1)]).collect()
    }

    /// Calls `visit` with the cell and the place in it of every sample in the cells from `first` to `last`; of a cell there may
    /// be several, the one with the least [rank](better) counts.
    fn read(&self, first: [i64; 2], last: [i64; 2], visit: &mut dyn FnMut([i64; 2], Sample)) -> Result<()> {
        let blocks = [first, last].map(|cell| cell.map(|c| c.div_euclid(BLOCK)));
        for row in blocks[0][1]..=blocks[1][1] {
            for column in blocks[0][0]..=blocks[1][0] {
                let key = [column, row];
                for bytes in self.chunks(key)? {
                    for record in bytes.as_chunks::<RECORD>().0 {
                        let (slot, sample) = decode(record);
                        let cell = [key[0] * BLOCK + slot % BLOCK, key[1] * BLOCK + slot / BLOCK];
                        if (0..2).all(|axis| (first[axis]..=last[axis]).contains(&cell[axis])) {
                            visit(cell, sample);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    fn chunks(&self, key: [i64; 2]) -> Result<Vec<Vec<u8>>> {
        let mut kept = self.lock();
        let Kept { file, chunks, .. } = &mut *kept;
        let Some(places) = chunks.get(&key) else { return Ok(Vec::new()) };
        let read = |&(at, count): &(u64, u32)| -> std::io::Result<Vec<u8>> {
            let mut bytes = vec![0; count as usize * RECORD];
            file.seek(SeekFrom::Start(at))?;
            file.read_exact(&mut bytes)?;
            Ok(bytes)
        };
        let all: std::io::Result<Vec<Vec<u8>>> = places.iter().map(read).collect();
        all.map_err(|e| Error::io(&self.folder, "read a temporary file in", e))
    }

    /// The samples of the cells from `first` to `last`, row by row, `None` where there is none.
    ///
    /// # Errors
    /// The temporary file cannot be read.
    pub(super) fn window(&self, first: [i64; 2], last: [i64; 2]) -> Result<Vec<Option<Sample>>> {
        let size = [0, 1].map(|axis| (last[axis] - first[axis] + 1).max(0) as usize);
        let mut window: Vec<Option<Sample>> = vec![None; size[0] * size[1]];
        self.read(first, last, &mut |cell, sample| {
            let slot = (cell[1] - first[1]) as usize * size[0] + (cell[0] - first[0]) as usize;
            better(&mut window[slot], sample, self.grid.sample);
        })?;
        Ok(window)
    }

    fn lock(&self) -> MutexGuard<'_, Kept> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Keeps the one of two samples that stands for the cell.
fn better(slot: &mut Option<Sample>, sample: Sample, cell: [i64; 2]) {
    if slot.is_none_or(|known| sample.rank(cell) < known.rank(cell)) {
        *slot = Some(sample);
    }
}

/// Takes ground points; see [`GroundStore`].
#[derive(Debug)]
pub struct Collector<'a> {
    store: &'a GroundStore,
    blocks: HashMap<[i64; 2], Block, FixedState>,
    /// The block of the point before: neighbours in a scan are neighbours on the ground.
    last: Option<([i64; 2], Block)>,
    /// The blocks in which any point was seen, the last of them by itself.
    seen: HashSet<[i64; 2], FixedState>,
    last_seen: Option<[i64; 2]>,
    points: u64,
    fault: Option<Error>,
}

impl Collector<'_> {
    /// Takes a point in CRS units: what is not of the ground only tells that something was scanned there.
    pub fn add(&mut self, position: [f64; 3], is_ground: bool) {
        let grid = &self.store.grid;
        let Some((place, z)) = Grid::of_position(position) else { return };
        let cell = grid.cell(place);
        let key = cell.map(|c| c.div_euclid(BLOCK));
        if self.last_seen != Some(key) {
            self.last_seen = Some(key);
            self.seen.insert(key);
        }
        if !is_ground {
            return;
        }
        self.points += 1;
        let at = [0, 1].map(|axis| (place[axis] - cell[axis] * grid.sample[axis]) as u16);
        let slot = (cell[1].rem_euclid(BLOCK) * BLOCK + cell[0].rem_euclid(BLOCK)) as usize;
        let sample = grid.sample;
        if self.last.as_ref().is_none_or(|(last, _)| *last != key) {
            self.turn_to(key);
        }
        if let Some((_, block)) = &mut self.last {
            better(&mut block[slot], Sample { at, z }, sample);
        }
    }

    fn turn_to(&mut self, key: [i64; 2]) {
        if let Some((last, block)) = self.last.take() {
            self.blocks.insert(last, block);
        }
        if self.blocks.len() >= MOST_BLOCKS {
            self.flush();
        }
        let block = self.blocks.remove(&key).unwrap_or_else(|| vec![None; CELLS].into_boxed_slice());
        self.last = Some((key, block));
    }

    /// Puts what is held on disk.
    fn flush(&mut self) {
        let mut blocks: Vec<([i64; 2], Block)> = self.blocks.drain().chain(self.last.take()).collect();
        blocks.sort_unstable_by_key(|(key, _)| *key);
        let mut bytes = Vec::new();
        let mut kept = self.store.lock();
        kept.points += std::mem::take(&mut self.points);
        kept.seen.extend(self.seen.iter().copied());
        for (key, block) in blocks {
            bytes.clear();
            for (slot, sample) in block.iter().enumerate() {
                if let Some(sample) = sample {
                    encode(slot as u16, *sample, &mut bytes);
                }
            }
            let at = kept.end;
            let written = kept.file.seek(SeekFrom::Start(at)).and_then(|_| kept.file.write_all(&bytes));
            if let Err(e) = written {
                self.fault.get_or_insert(Error::io(&self.store.folder, "write a temporary file in", e));
                return;
            }
            kept.end += bytes.len() as u64;
            kept.chunks.entry(key).or_default().push((at, (bytes.len() / RECORD) as u32));
        }
    }

    /// Ends the work of this collector.
    ///
    /// # Errors
    /// The temporary file could not be written.
    pub fn finish(mut self) -> Result<()> {
        self.flush();
        self.fault.map_or(Ok(()), Err)
    }
}

fn encode(slot: u16, sample: Sample, out: &mut Vec<u8>) {
    out.extend_from_slice(&slot.to_le_bytes());
    for at in &sample.at {
        out.extend_from_slice(&at.to_le_bytes());
    }
    out.extend_from_slice(&sample.z.to_le_bytes());
}

fn decode(record: &[u8; RECORD]) -> (i64, Sample) {
    let [s0, s1, x0, x1, y0, y1, z0, z1, z2, z3] = *record;
    let short = |bytes: [u8; 2]| u16::from_le_bytes(bytes);
    let at = [short([x0, x1]), short([y0, y1])];
    (i64::from(short([s0, s1])), Sample { at, z: i32::from_le_bytes([z0, z1, z2, z3]) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Random;
    use crate::terrain::TerrainOptions;

    #[test]
    fn what_is_kept_does_not_depend_on_order_or_cut() {
        let grid = Grid::new(&TerrainOptions::default(), [1.0; 3]);
        let mut random = Random::new(4);
        let points: Vec<[f64; 3]> =
            (0..4000).map(|_| [random.between(-40.0, 40.0), random.between(-3.0, 90.0), random.unit()]).collect();
        let folder = tempfile::tempdir().unwrap();
        let (first, last) = (grid.cell([-400_000, -30_000]), grid.cell([400_000, 900_000]));
        let window = |cuts: &[&[usize]]| {
            let store = GroundStore::create(folder.path(), grid).unwrap();
            for cut in cuts {
                let mut collector = store.collector();
                cut.iter().for_each(|i| collector.add(points[*i], true));
                collector.finish().unwrap();
            }
            assert!(store.points() >= 4000);
            store.window(first, last).unwrap()
        };
        let mut order: Vec<usize> = (0..points.len()).collect();
        let expected = window(&[&order]);
        assert!(expected.iter().flatten().count() > 3000);
        random.shuffle(&mut order);
        assert_eq!(window(&[&order]), expected);
        // Cut in three, one part of it twice.
        assert_eq!(window(&[&order[3000..], &order[..1500], &order[1000..3000]]), expected);
    }
}
