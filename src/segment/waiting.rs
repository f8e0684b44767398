//! Points that wait until all tiles around their footprint have been read: in memory up to a budget, beyond it in a file.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, BufWriter, Read, Seek, SeekFrom, Write};

use crate::error::{Error, Result};

/// Bytes of a point.
const POINT: usize = 24;
/// Lists shorter than this stay in memory: each would cost a place in the file.
const SHORTEST: usize = 64;

/// The points of footprints, in no particular order and with duplicates.
#[derive(Debug, Default)]
pub(super) struct Waiting {
    of: BTreeMap<usize, Gathered>,
    /// Bytes in memory.
    held: usize,
    /// Most bytes in memory.
    budget: usize,
    /// What does not fit into memory: a temporary file without a name, and where it ends.
    file: Option<(File, u64)>,
}

/// What is there of one footprint.
#[derive(Debug, Default)]
struct Gathered {
    points: Vec<[f64; 3]>,
    /// First byte and number of points of pieces in the file.
    pieces: Vec<(u64, usize)>,
}

impl Waiting {
    /// None yet; no more than `budget` bytes are kept in memory.
    pub(super) fn new(budget: usize) -> Self {
        Self { budget, ..Self::default() }
    }

    /// Takes points of a footprint.
    pub(super) fn add(&mut self, index: usize, mut points: Vec<[f64; 3]>) {
        let gathered = self.of.entry(index).or_default();
        self.held += points.len() * POINT;
        if gathered.points.is_empty() {
            points.shrink_to_fit();
            gathered.points = points;
        } else {
            gathered.points.reserve_exact(points.len());
            gathered.points.append(&mut points);
        }
    }

    /// Moves points to the file until the others are within the budget, the longest lists first.
    ///
    /// # Errors
    /// The temporary file cannot be written.
    pub(super) fn settle(&mut self) -> Result<()> {
        if self.held <= self.budget {
            return Ok(());
        }
        // Half of it is cleared at once: not every point that comes shall move another one.
        let goal = self.budget / 2;
        let mut lists: Vec<(usize, usize)> = self.of.iter().map(|(index, own)| (own.points.len(), *index)).collect();
        lists.retain(|(points, _)| *points >= SHORTEST);
        lists.sort_unstable_by(|a, b| b.cmp(a));
        let spill = || -> io::Result<()> {
            if self.file.is_none() {
                self.file = Some((tempfile::tempfile()?, 0));
            }
            let Some((file, end)) = &mut self.file else { return Ok(()) };
            file.seek(SeekFrom::Start(*end))?;
            let mut writer = BufWriter::with_capacity(1 << 18, file);
            for (_, index) in lists {
                if self.held <= goal {
                    break;
                }
                let Some(gathered) = self.of.get_mut(&index) else { continue };
                let points = std::mem::take(&mut gathered.points);
                for point in &points {
                    for value in point {
                        writer.write_all(&value.to_le_bytes())?;
                    }
                }
                gathered.pieces.push((*end, points.len()));
                *end += (points.len() * POINT) as u64;
                self.held -= points.len() * POINT;
            }
            writer.flush()
        };
        spill().map_err(fault)
    }

    /// Gives the points of a footprint and forgets them.
    ///
    /// # Errors
    /// The temporary file cannot be read.
    pub(super) fn take(&mut self, index: usize) -> Result<Vec<[f64; 3]>> {
        let Some(Gathered { mut points, pieces }) = self.of.remove(&index) else { return Ok(Vec::new()) };
        self.held -= points.len() * POINT;
        let read = || -> io::Result<()> {
            let Some((file, _)) = &mut self.file else { return Ok(()) };
            let mut bytes = Vec::new();
            for (start, count) in pieces {
                file.seek(SeekFrom::Start(start))?;
                bytes.resize(count * POINT, 0);
                file.read_exact(&mut bytes)?;
                points.reserve_exact(count);
                points.extend(bytes.chunks_exact(POINT).map(|point| {
                    std::array::from_fn(|axis| f64::from_le_bytes(std::array::from_fn(|byte| point[8 * axis + byte])))
                }));
            }
            Ok(())
        };
        read().map_err(fault)?;
        Ok(points)
    }

    /// How many points of a footprint wait.
    pub(super) fn count(&self, index: usize) -> usize {
        let of = |gathered: &Gathered| gathered.points.len() + gathered.pieces.iter().map(|(_, n)| n).sum::<usize>();
        self.of.get(&index).map_or(0, of)
    }
}

fn fault(error: io::Error) -> Error {
    Error::io(std::env::temp_dir(), "use a temporary file in", error)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_come_back_whatever_the_budget() {
        let points = |index: usize, part: usize| -> Vec<[f64; 3]> {
            (0..(index * 37 + part * 11) % 300).map(|i| [i as f64 / 3.0, index as f64, part as f64]).collect()
        };
        for budget in [0, 5_000, 40_000, usize::MAX] {
            let mut waiting = Waiting::new(budget);
            for part in 0..4 {
                for index in 0..50 {
                    waiting.add(index, points(index, part));
                }
                waiting.settle().unwrap();
                assert!(waiting.held <= budget.max(50 * SHORTEST * POINT), "{budget}: {}", waiting.held);
            }
            for index in (0..50).rev() {
                let expected: Vec<_> = (0..4).flat_map(|part| points(index, part)).collect();
                assert_eq!(waiting.count(index), expected.len());
                let mut found = waiting.take(index).unwrap();
                found.sort_by(|a, b| a.partial_cmp(b).unwrap());
                let mut expected = expected;
                expected.sort_by(|a, b| a.partial_cmp(b).unwrap());
                assert_eq!(found, expected);
            }
            assert_eq!((waiting.held, waiting.take(3).unwrap().len()), (0, 0));
        }
    }
}
