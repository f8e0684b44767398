//! In which order tiles are read.

use super::boxes::Rectangle;
use super::sweep::Reach;
use crate::source::points::Tile;

/// Tiles in columns, or in rows where those are shorter, so that what is half done at any time is about one of them. First
/// those that may hold points of anywhere: their box does not hold, or their points name their buildings.
pub(super) fn of(tiles: &[Tile]) -> Vec<Reach<'_>> {
    let mut reaches: Vec<Reach<'_>> = tiles.iter().map(|tile| Reach { tile, within: within(tile) }).collect();
    let known: Vec<Rectangle> = reaches.iter().filter_map(|reach| reach.within).collect();
    let ends = |axis: usize| {
        let low = known.iter().map(|(low, _)| low[axis]).fold(f64::INFINITY, f64::min);
        (low, known.iter().map(|(_, high)| high[axis]).fold(f64::NEG_INFINITY, f64::max))
    };
    let lengths = [0, 1].map(|axis| ends(axis).1 - ends(axis).0);
    let along = usize::from(lengths[1] > lengths[0]);
    let first = ends(along).0;
    // Boxes are tight around points: tiles of one column do not begin at the same place.
    let mut sides: Vec<f64> = known.iter().map(|(low, high)| high[along] - low[along]).collect();
    sides.sort_unstable_by(f64::total_cmp);
    let side = sides.get(sides.len() / 2).copied().filter(|side| *side > 0.0).unwrap_or(1.0);
    let place = |reach: &Reach<'_>| {
        let (low, _) = reach.within?;
        Some((((low[along] - first) / side + 0.5).floor() as i64, low[1 - along]))
    };
    // The sort is stable: what is alike stays in the order of the paths.
    reaches.sort_by(|a, b| match (place(a), place(b)) {
        (Some((column, at)), Some((other, there))) => column.cmp(&other).then(at.total_cmp(&there)),
        (a, b) => a.is_some().cmp(&b.is_some()),
    });
    reaches
}

/// Where the points of a tile lie, CRS units; `None` where that is not known.
fn within(tile: &Tile) -> Option<Rectangle> {
    if tile.points == 0 {
        // Nowhere.
        return Some(([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]));
    }
    if !tile.is_elsewhere() && (!tile.buildings.is_empty() || !tile.is_true_to_its_extent()) {
        return None;
    }
    tile.extent.map(|extent| ([extent.min[0], extent.min[1]], [extent.max[0], extent.max[1]]))
}
