//! What of an object will be read next: fetched ahead in pieces, a few at a time.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::Arc;

use super::client::Answer;
use super::object::{Bytes, Object};
use crate::error::{Error, InputError, Result};

/// Bytes of a piece, at most.
const PIECE: u64 = 1 << 20;
/// Bytes that are fetched ahead of the piece that is read, about, and pieces.
const AHEAD: (u64, usize) = (3 << 20, 16);
/// Pieces that are kept behind it: a chunk is read twice where its sizes or its times are looked at first.
const BEHIND: usize = 2;
/// Of what is wanted so much may come along for fewer requests, and no gap that is wider is bridged.
const BRIDGED: (f64, u64) = (0.1, 256 << 10);

/// The pieces that will be read, in order.
#[derive(Debug, Default)]
pub(super) struct Window {
    pieces: Vec<Range<u64>>,
    /// The pieces that are fetched or being fetched; the first is that of the number `first`.
    flights: VecDeque<Flight>,
    first: usize,
}

#[derive(Debug)]
enum Flight {
    Under(Answer<Result<Bytes, InputError>>),
    Here(Bytes),
}

impl Window {
    /// A window over these ranges, whatever their order, within `size`.
    pub fn over(mut ranges: Vec<Range<u64>>, size: u64) -> Self {
        ranges.retain_mut(|range| {
            range.end = range.end.min(size);
            range.start < range.end
        });
        ranges.sort_by_key(|range| range.start);
        Self { pieces: pieces(&bridged(ranges)), flights: VecDeque::new(), first: 0 }
    }

    /// The bytes from `at` to the end of the piece that holds it; `None` where that is no piece, or one that is gone.
    ///
    /// # Errors
    /// The piece cannot be read.
    pub fn at(&mut self, object: &Arc<Object>, at: u64) -> Result<Option<Bytes>> {
        let index = self.pieces.partition_point(|piece| piece.end <= at);
        if index < self.first || self.pieces.get(index).is_none_or(|piece| piece.start > at) {
            return Ok(None);
        }
        self.move_to(object, index)?;
        let place = index - self.first;
        if let Some(Flight::Under(answer)) = self.flights.get(place) {
            let ended = |e| Error::io(object.path(), "read", std::io::Error::other(e));
            let bytes = answer.recv().map_err(ended)??;
            self.flights[place] = Flight::Here(bytes);
        }
        let Some(Flight::Here(bytes)) = self.flights.get(place) else { return Ok(None) };
        let start = at - self.pieces[index].start;
        Ok(Some(bytes.slice(start as usize..)))
    }

    /// Lets go of what is behind a piece, and begins to fetch it and what follows it.
    fn move_to(&mut self, object: &Arc<Object>, index: usize) -> Result<()> {
        while self.first + BEHIND < index {
            self.flights.pop_front();
            self.first += 1;
        }
        let mut ahead = 0;
        for number in self.first..self.pieces.len() {
            if number > index && (ahead >= AHEAD.0 || number > index + AHEAD.1) {
                return Ok(());
            }
            let piece = &self.pieces[number];
            ahead += if number > index { piece.end - piece.start } else { 0 };
            if number - self.first >= self.flights.len() {
                self.flights.push_back(Flight::Under(object.begin(piece.clone())?));
            }
        }
        Ok(())
    }
}

/// The ranges with the smallest of the gaps between them closed, as far as that costs little.
fn bridged(ranges: Vec<Range<u64>>) -> Vec<Range<u64>> {
    let wanted: u64 = ranges.iter().map(|range| range.end - range.start).sum();
    let mut gaps: Vec<u64> = ranges.windows(2).map(|pair| pair[1].start.saturating_sub(pair[0].end)).collect();
    gaps.sort_unstable();
    let mut left = (wanted as f64 * BRIDGED.0) as u64;
    let mut widest = 0;
    for gap in gaps {
        if gap > left.min(BRIDGED.1) {
            // Of gaps that are equally wide there is room for all, or for none.
            widest = widest.min(gap - 1);
            break;
        }
        left -= gap;
        widest = gap;
    }
    let mut out: Vec<Range<u64>> = Vec::with_capacity(ranges.len());
    for range in ranges {
        match out.last_mut() {
            Some(last) if range.start <= last.end.saturating_add(widest) => last.end = last.end.max(range.end),
            _ => out.push(range),
        }
    }
    out
}

/// The ranges in pieces that are not too large.
fn pieces(ranges: &[Range<u64>]) -> Vec<Range<u64>> {
    let cut = |range: &Range<u64>| {
        let Range { start, end } = *range;
        (start..end).step_by(PIECE as usize).map(move |from| from..(from + PIECE).min(end))
    };
    ranges.iter().flat_map(cut).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_gaps_are_bridged_and_large_ranges_cut() {
        let ranges = vec![0..1000, 1010..2000, 50_000..51_000, 51_000..52_000, 52_200..53_000];
        assert_eq!(bridged(ranges), [0..2000, 50_000..53_000]);
        assert_eq!(bridged(vec![0..10, 8..20, 100..110]), [0..20, 100..110], "what overlaps is one");
        assert_eq!(pieces(std::slice::from_ref(&(5..PIECE + 6))), [5..PIECE + 5, PIECE + 5..PIECE + 6]);
        let window = Window::over(vec![90..200, 0..10, 300..400], 150);
        assert_eq!(window.pieces, [0..10, 90..150]);
    }
}
