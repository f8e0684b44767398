//! Which cells a network is asked about: those whose label it could change.

use super::height_field::{Vote, votes};
use crate::reconstruct::Partitioned;

/// The vote is sure of a cell that it calls this near to 0 or 1 …
const SURE: f64 = 0.05;
/// … if no more of it than this is in doubt.
const LITTLE_DOUBT: f64 = 0.1;
/// Where all cells of which the vote is not sure are together smaller than this share of the cells that are to be
/// decided, they do not change the model, and the network is not asked at all.
const LITTLE: f64 = 0.01;

/// What the vote says of every cell, and the cells to ask a network about.
#[derive(Debug)]
pub(super) struct Spared {
    /// The vote, 0 to 1.
    pub vote: Vec<f64>,
    /// Those to ask about, ascending.
    pub asked: Vec<u32>,
}

impl Spared {
    /// Asks about all cells where the vote knows too little of the shape to be sure of anything: without a footprint, and
    /// where something was seen under a roof.
    pub fn of(building: &Partitioned) -> Self {
        let votes = votes(building, true);
        let all = building.hypotheses.footprint.is_none() || building.hypotheses.shows_overhang;
        let is_sure = |vote: &Vote| vote.doubt <= LITTLE_DOUBT && !(SURE..=1.0 - SURE).contains(&vote.inside);
        let volume = |cell: u32| building.volumes.get(cell as usize).copied().unwrap_or(0.0);
        let asked: Vec<u32> =
            building.free().filter(|&cell| all || votes.get(cell as usize).is_none_or(|vote| !is_sure(vote))).collect();
        let [unsure, total] = [asked.iter().copied().map(volume).sum::<f64>(), building.free().map(volume).sum()];
        let asked = if !all && unsure < LITTLE * total { Vec::new() } else { asked };
        Self { vote: votes.into_iter().map(|vote| vote.inside).collect(), asked }
    }
}
