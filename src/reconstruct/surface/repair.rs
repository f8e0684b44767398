//! Repair of non-manifold edges and vertices by relabelling cells, and the labels that the surface works on.

use super::Labelled;
use super::boundary::Spot;
use super::incidence::contains;
use crate::reconstruct::complex::{CellId, OUTSIDE};

/// Share of the volume that a relabelling costs even where it follows the occupancy: the least volume decides ties.
const VOLUME_COST: f64 = 1e-3;

impl Labelled<'_> {
    /// What it costs to give a cell that is now `inside` the other label: the volume, as far as the occupancy
    /// speaks against it (cubic metres).
    pub(super) fn cost(&self, cell: CellId, inside: bool) -> f64 {
        let volume = self.volumes.get(cell as usize).copied().unwrap_or(0.0).max(0.0);
        let occupancy = self.occupancy.get(cell as usize).copied().unwrap_or(0.5);
        let against = if inside { 2.0 * occupancy - 1.0 } else { 1.0 - 2.0 * occupancy };
        volume * (VOLUME_COST + against.max(0.0))
    }

    /// Whether the label of a cell must stay.
    pub(super) fn is_fixed(&self, cell: CellId) -> bool {
        cell == OUTSIDE || self.fixed.get(cell as usize).copied().flatten().is_some()
    }
}

/// What became of a spot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Repair {
    /// Cells were relabelled.
    Done,
    /// A cell at the spot was already relabelled in this round: look again.
    Stale,
    /// Every cell that could resolve it is fixed or was relabelled before.
    Impossible,
}

/// Resolves a non-manifold spot of the component for which `member` is true.
///
/// Around the spot the space is cut into groups of cells of equal membership that hang together through facets at
/// the spot; it is non-manifold because there are too many of them. The cheapest group is given the other label.
/// `round[c]` is the round in which a cell was relabelled, 0 for never: a cell is relabelled at most once, so that
/// the repair ends.
pub(super) fn repair(
    labelled: &Labelled,
    inside: &mut [bool],
    member: impl Fn(CellId) -> bool,
    spot: Spot,
    (round, now): (&mut [u32], u32),
) -> Repair {
    let complex = labelled.complex;
    let ends = spot.ends().map(|v| &complex.vertices[v as usize]);
    let around: Vec<CellId> = (0..complex.cells.len() as CellId)
        .filter(|&id| ends.iter().all(|end| contains(complex, id, &complex.cells[id as usize], end)))
        .collect();
    if around.iter().any(|&cell| round[cell as usize] == now) {
        return Repair::Stale;
    }
    // One more for the outside of the box.
    let outside = around.len();
    let mut group: Vec<usize> = (0..=outside).collect();
    let index = |cell: CellId| if cell == OUTSIDE { Ok(outside) } else { around.binary_search(&cell) };
    let is_member = |cell: CellId| cell != OUTSIDE && member(cell);
    for &cell in &around {
        for &facet in &complex.cells[cell as usize].facets {
            let facet = &complex.facets[facet as usize];
            let [Ok(a), Ok(b)] = facet.cells.map(index) else { continue };
            let plane = &complex.planes[facet.plane as usize];
            if is_member(facet.cells[0]) == is_member(facet.cells[1]) && ends.iter().all(|end| plane.side(end).is_eq())
            {
                let (a, b) = (root(&group, a), root(&group, b));
                group[a.max(b)] = a.min(b);
            }
        }
    }
    let mut best: Option<(f64, usize)> = None;
    for candidate in (0..outside).filter(|&i| group[i] == i) {
        let now_member = member(around[candidate]);
        let mut cost = 0.0;
        let mut possible = root(&group, outside) != candidate;
        for (i, &cell) in around.iter().enumerate() {
            // Cells of another component already are inside: a group that turns inside leaves them as they are.
            if root(&group, i) == candidate && inside[cell as usize] == now_member {
                possible &= !labelled.is_fixed(cell) && round[cell as usize] == 0;
                cost += labelled.cost(cell, now_member);
            }
        }
        if possible && best.is_none_or(|(least, _)| cost < least) {
            best = Some((cost, candidate));
        }
    }
    let Some((_, chosen)) = best else { return Repair::Impossible };
    let label = !member(around[chosen]);
    for (i, &cell) in around.iter().enumerate() {
        if root(&group, i) == chosen && inside[cell as usize] != label {
            inside[cell as usize] = label;
            round[cell as usize] = now;
        }
    }
    Repair::Done
}

fn root(group: &[usize], mut i: usize) -> usize {
    while group[i] != i {
        i = group[i];
    }
    i
}
