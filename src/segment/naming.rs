//! Points that say themselves which building they belong to.

use crate::source::footprints::Footprint;
use crate::source::points::Tile;
use std::collections::HashMap;

/// Which building points belong to: those that name one to that one, the others to the footprints that they lie in.
pub(super) struct Naming {
    /// Footprints by id; empty when no tile names a building.
    footprints: HashMap<String, usize>,
    /// Whether points that name no building belong to the footprints that they lie in, or to none.
    pub by_place: bool,
}

impl Naming {
    /// For these tiles and footprints.
    pub fn new(tiles: &[Tile], footprints: &[Footprint], by_place: bool) -> Self {
        let is_needed = tiles.iter().any(|tile| !tile.buildings.is_empty());
        let known = footprints.iter().enumerate().filter(|_| is_needed);
        Self { footprints: known.map(|(index, footprint)| (footprint.id.clone(), index)).collect(), by_place }
    }

    /// The footprint of each of the buildings of `tile`, where there is one.
    pub fn table(&self, tile: &Tile) -> Vec<Option<usize>> {
        tile.buildings.iter().map(|id| self.footprints.get(id).copied()).collect()
    }
}
