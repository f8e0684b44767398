//! Reading an object back and forth, as a file is read.

use std::io::{self, Read, Seek, SeekFrom};
use std::ops::Range;
use std::sync::Arc;

use super::cache::BLOCK;
use super::object::Object;
use super::window::Window;
use crate::error::{Error, Result};
use crate::source::reread::Reread;

/// From so many blocks in a row on, whoever reads is taken to go on to the end.
const IN_A_ROW: u32 = 4;

/// A reader at a place of an object. What it is told that will be read is fetched ahead; other places are read in blocks.
#[derive(Debug)]
pub(crate) struct ObjectReader {
    object: Arc<Object>,
    at: u64,
    window: Window,
    /// The block that was read last, and how many before it were read in a row.
    last: Option<(u64, u32)>,
    whole: Option<Reread>,
}

impl ObjectReader {
    /// A reader at the beginning.
    pub fn new(object: Arc<Object>) -> Self {
        let whole = object.whole().map(|file| Reread::new(file.clone()));
        Self { object, at: 0, window: Window::default(), last: None, whole }
    }

    /// Says which ranges will be read next.
    pub fn expect(&mut self, ranges: Vec<Range<u64>>) {
        if self.whole.is_none() {
            self.window = Window::over(ranges, self.object.size());
        }
    }

    fn fill(&mut self, buffer: &mut [u8]) -> Result<usize> {
        self.object.verdict()?;
        if let Some(whole) = &mut self.whole {
            let seeked = whole.seek(SeekFrom::Start(self.at)).and_then(|_| whole.read(buffer));
            return seeked.map_err(|e| Error::io(self.object.path(), "read the temporary copy of", e));
        }
        if self.at >= self.object.size() || buffer.is_empty() {
            return Ok(0);
        }
        if let Some(bytes) = self.window.at(&self.object, self.at)? {
            return Ok(copied(&bytes, buffer));
        }
        let index = self.at / BLOCK;
        self.last = match self.last {
            Some((last, row)) if last == index => Some((index, row)),
            Some((last, row)) if last + 1 == index => Some((index, row + 1)),
            _ => Some((index, 0)),
        };
        if self.last.is_some_and(|(_, row)| row >= IN_A_ROW) {
            self.last = None;
            self.window = Window::over(std::iter::once(self.at..self.object.size()).collect(), self.object.size());
            if let Some(bytes) = self.window.at(&self.object, self.at)? {
                return Ok(copied(&bytes, buffer));
            }
        }
        let block = self.object.block(index)?;
        let start = (self.at - index * BLOCK) as usize;
        Ok(copied(block.get(start..).unwrap_or_default(), buffer))
    }
}

/// Copies as much as there is room for.
fn copied(bytes: &[u8], buffer: &mut [u8]) -> usize {
    let count = bytes.len().min(buffer.len());
    buffer[..count].copy_from_slice(&bytes[..count]);
    count
}

impl Read for ObjectReader {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.fill(buffer).map_err(io::Error::other)?;
        self.at += count as u64;
        Ok(count)
    }
}

impl Seek for ObjectReader {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let (base, offset) = match to {
            SeekFrom::Start(at) => (at, 0),
            SeekFrom::Current(offset) => (self.at, offset),
            SeekFrom::End(offset) => (self.object.size(), offset),
        };
        self.at = base.checked_add_signed(offset).ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.at)
    }
}
