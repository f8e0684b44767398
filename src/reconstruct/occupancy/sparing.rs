//! Which cells a network is asked about: those whose label it could change.

use super::height_field::{Vote, votes};
use crate::reconstruct::Partitioned;

/// The vote is sure of a cell that it calls this near to 0 or 1 …
const SURE: f64 = 0.15;
/// … if no more of it than this is in doubt.
const LITTLE_DOUBT: f64 = 0.25;
/// Where all cells of which the vote is not sure are together smaller than this, the network is not asked at all: a part of
/// 4 m² that is a metre high is about the smallest that is missed. Cubic metres.
const LITTLE: f64 = 4.0;

/// What the vote says of every cell, and the cells to ask a network about.
#[derive(Debug)]
pub(super) struct Spared {
    /// The vote, 0 to 1.
    pub vote: Vec<f64>,
    /// Those to ask about, ascending.
    pub asked: Vec<u32>,
}

impl Spared {
    /// Asks about all cells of a building without a footprint: the vote knows its outline from the same points.
    pub fn of(building: &Partitioned) -> Self {
        let votes = votes(building, true);
        let all = building.hypotheses.footprint.is_none();
        let is_sure = |vote: &Vote| vote.doubt <= LITTLE_DOUBT && !(SURE..=1.0 - SURE).contains(&vote.inside);
        let volume = |cell: u32| building.volumes.get(cell as usize).copied().unwrap_or(0.0);
        let mut asked: Vec<u32> =
            building.free().filter(|&cell| all || votes.get(cell as usize).is_none_or(|vote| !is_sure(vote))).collect();
        if !all && asked.iter().copied().map(volume).sum::<f64>() < LITTLE {
            asked.clear();
        }
        Self { vote: votes.into_iter().map(|vote| vote.inside).collect(), asked }
    }
}
