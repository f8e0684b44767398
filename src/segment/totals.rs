//! What is told of points when all tiles have been read.

use std::collections::BTreeMap;

use super::unused::{self, Tally, Unused};
use super::{Meaning, PointCounts, SegmentOptions, ground};
use crate::source::points::TileProblem;

/// What a sweep has told when it is over.
#[derive(Debug, Default)]
pub struct Swept {
    /// What became of the points.
    pub counts: PointCounts,
    /// What is wrong with the tiles, sorted.
    pub problems: Vec<TileProblem>,
    /// What the user should know of the points as a whole, one sentence each.
    pub warnings: Vec<String>,
}

/// What is counted on the way there.
#[derive(Default)]
pub(super) struct Totals {
    pub(super) counts: PointCounts,
    pub(super) problems: Vec<TileProblem>,
    unused: Tally,
    /// Of footprints that are not done: points that could be of the building and are not used.
    unused_of: BTreeMap<usize, Vec<(Unused, u64)>>,
    /// Buildings with points, and those of them whose floor was guessed.
    with_points: usize,
    guessed: usize,
    /// Building points that came when their footprint had been handed out, by footprint.
    late: BTreeMap<usize, u64>,
}

impl Totals {
    /// So many points in a footprint are not used.
    pub(super) fn unused(&mut self, footprint: usize, kind: Unused, n: u64) {
        unused::add(self.unused_of.entry(footprint).or_default(), kind, n);
    }

    /// So many points came too late for a footprint.
    pub(super) fn late(&mut self, footprint: usize, n: u64) {
        *self.late.entry(footprint).or_default() += n;
    }

    /// A footprint is done that had so many points, of which this became.
    pub(super) fn see(
        &mut self,
        footprint: usize,
        used: u64,
        counts: &PointCounts,
        has_points: bool,
        is_guessed: bool,
    ) {
        if used > 0 {
            self.counts.add(counts);
        }
        let unused = self.unused_of.remove(&footprint).unwrap_or_default();
        self.unused.see(footprint, used, &unused);
        self.with_points += usize::from(has_points);
        self.guessed += usize::from(is_guessed);
    }

    /// What is told, behind the warnings that there are `already`; of so many footprints in all.
    pub(super) fn told(
        self,
        already: Vec<String>,
        footprints: usize,
        meaning: Meaning,
        options: &SegmentOptions,
    ) -> Swept {
        let Self { counts, mut problems, unused, with_points, guessed, late, .. } = self;
        let warnings = [
            unused::absent(&counts, options),
            unused.warning(footprints, options),
            ground::guesses(with_points, guessed, options).filter(|_| meaning.is_outline()),
            too_late(&late),
        ];
        problems.sort();
        Swept { counts, problems, warnings: already.into_iter().chain(warnings.into_iter().flatten()).collect() }
    }
}

/// What is said of points that came too late for their building.
fn too_late(late: &BTreeMap<usize, u64>) -> Option<String> {
    let points: u64 = late.values().sum();
    (points > 0).then(|| {
        format!(
            "{points} building points of {} footprints are left out: they lie outside the boxes that the headers of their tiles \
             state, and were read when these buildings had been made; mend the headers (reading and writing such a tile with \
             `gable pipeline` does)",
            late.len()
        )
    })
}
