//! What is for training, what for validation, what for tests: whole tiles, never buildings, since the houses of a street
//! are often the same.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::Serialize;

use super::random::hash;

/// What scans are for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Split {
    /// The weights are fitted to them.
    Train,
    /// The training is watched and calibrated on them.
    Validation,
    /// Nothing is chosen on them.
    Test,
}

impl Split {
    /// All, in the order of the shares.
    pub const ALL: [Self; 3] = [Self::Train, Self::Validation, Self::Test];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Train => "train",
            Self::Validation => "validation",
            Self::Test => "test",
        }
    }
}

/// Gives tiles to the splits so that the models of each come near its share; which tiles, follows from the seed and the
/// names alone. A split with a share gets a tile as long as there are as many tiles as splits.
pub(super) fn split(models_of: &BTreeMap<Arc<str>, usize>, shares: [f64; 3], seed: u64) -> BTreeMap<Arc<str>, Split> {
    let mut tiles: Vec<(u64, &Arc<str>, usize)> =
        models_of.iter().map(|(tile, &models)| (hash(seed, tile), tile, models)).collect();
    tiles.sort_unstable();
    let total: usize = models_of.values().sum();
    let sum: f64 = shares.iter().sum();
    let wanted = shares.map(|share| share / sum.max(f64::MIN_POSITIVE) * total as f64);
    let mut given = [0; 3];
    let mut splits: Vec<usize> = Vec::with_capacity(tiles.len());
    for (_, _, models) in &tiles {
        // The split that lacks most gets the tile.
        let lacks = |k: usize| wanted[k] - given[k] as f64;
        let chosen = (0..3).filter(|&k| shares[k] > 0.0).max_by(|&a, &b| lacks(a).total_cmp(&lacks(b)).then(b.cmp(&a)));
        let chosen = chosen.unwrap_or(0);
        given[chosen] += models;
        splits.push(chosen);
    }
    for k in 0..3 {
        let count = |k: usize, splits: &[usize]| splits.iter().filter(|&&s| s == k).count();
        let richest = (0..3).max_by_key(|&other| (count(other, &splits), std::cmp::Reverse(other))).unwrap_or(0);
        if shares[k] > 0.0 && count(k, &splits) == 0 && count(richest, &splits) > 1 {
            let smallest = (0..tiles.len()).filter(|&i| splits[i] == richest).min_by_key(|&i| (tiles[i].2, tiles[i].0));
            if let Some(tile) = smallest {
                splits[tile] = k;
            }
        }
    }
    tiles.iter().zip(splits).map(|((_, tile, _), k)| (Arc::clone(tile), Split::ALL[k])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tiles(sizes: &[usize]) -> BTreeMap<Arc<str>, usize> {
        sizes.iter().enumerate().map(|(i, &n)| (format!("tile {i}").into(), n)).collect()
    }

    fn models(tiles: &BTreeMap<Arc<str>, usize>, splits: &BTreeMap<Arc<str>, Split>) -> [usize; 3] {
        Split::ALL.map(|split| splits.iter().filter(|(_, s)| **s == split).map(|(tile, _)| tiles[tile]).sum())
    }

    #[test]
    fn shares_are_met_as_well_as_tiles_allow() {
        let many = tiles(&[50; 100]);
        assert_eq!(models(&many, &split(&many, [0.8, 0.1, 0.1], 1)), [4000, 500, 500]);
        assert_ne!(split(&many, [0.8, 0.1, 0.1], 1), split(&many, [0.8, 0.1, 0.1], 2));
        let few = tiles(&[300, 280, 260, 270, 54, 50, 100]);
        let [train, validation, test] = models(&few, &split(&few, [0.9, 0.1, 0.0], 7));
        assert!(train >= 980 && validation >= 50 && test == 0 && train + validation == 1314, "{train} {validation}");
        let one = tiles(&[10]);
        assert_eq!(models(&one, &split(&one, [0.9, 0.1, 0.0], 7)), [10, 0, 0]);
    }
}
