//! Repair of non-manifold edges and vertices by relabelling cells, and the labels that the surface works on.

use super::Labelled;
use super::boundary::Spot;
use super::incidence::contains;
use crate::reconstruct::complex::{CellId, Complex, OUTSIDE};

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
/// The cheapest group around the spot is given the other label. `round[c]` is the round in which a cell was relabelled, 0
/// for never: a cell is relabelled at most once, so that the repair ends.
pub(super) fn repair(
    labelled: &Labelled,
    inside: &mut [bool],
    member: impl Fn(CellId) -> bool,
    spot: Spot,
    (round, now): (&mut [u32], u32),
) -> Repair {
    let around = Around::new(labelled.complex, &member, spot);
    if around.cells.iter().any(|&cell| round[cell as usize] == now) {
        return Repair::Stale;
    }
    let Some((_, chosen)) = around.cheapest(labelled, inside, &member, |cell| round[cell as usize] == 0) else {
        return Repair::Impossible;
    };
    let label = !member(around.cells[chosen]);
    for cell in around.group(chosen) {
        if inside[cell as usize] != label {
            inside[cell as usize] = label;
            round[cell as usize] = now;
        }
    }
    Repair::Done
}

/// The cells around a spot.
///
/// The space there is cut into groups of cells of equal membership that hang together through facets at the spot; it is
/// non-manifold because there are too many of them.
pub(super) struct Around {
    /// The cells, ascending.
    cells: Vec<CellId>,
    /// For each of them, and last for the outside of the box, the first of its group, by way of others.
    group: Vec<usize>,
}

impl Around {
    /// The cells around a spot of the component for which `member` is true.
    pub fn new(complex: &Complex, member: &impl Fn(CellId) -> bool, spot: Spot) -> Self {
        let ends = spot.ends().map(|v| &complex.vertices[v as usize]);
        let cells: Vec<CellId> = (0..complex.cells.len() as CellId)
            .filter(|&id| ends.iter().all(|end| contains(complex, id, &complex.cells[id as usize], end)))
            .collect();
        // One more for the outside of the box.
        let outside = cells.len();
        let mut group: Vec<usize> = (0..=outside).collect();
        let index = |cell: CellId| if cell == OUTSIDE { Ok(outside) } else { cells.binary_search(&cell) };
        let is_member = |cell: CellId| cell != OUTSIDE && member(cell);
        for &cell in &cells {
            for &facet in &complex.cells[cell as usize].facets {
                let facet = &complex.facets[facet as usize];
                let [Ok(a), Ok(b)] = facet.cells.map(index) else { continue };
                let plane = &complex.planes[facet.plane as usize];
                if is_member(facet.cells[0]) == is_member(facet.cells[1])
                    && ends.iter().all(|end| plane.side(end).is_eq())
                {
                    let (a, b) = (root(&group, a), root(&group, b));
                    group[a.max(b)] = a.min(b);
                }
            }
        }
        Self { cells, group }
    }

    /// The first cells of the groups, as indices, but for that of the outside of the box.
    fn firsts(&self) -> impl Iterator<Item = usize> + '_ {
        let outside = root(&self.group, self.cells.len());
        (0..self.cells.len()).filter(move |&i| self.group[i] == i && i != outside)
    }

    /// The cells of a group, ascending.
    fn group(&self, first: usize) -> impl Iterator<Item = CellId> + '_ {
        (0..).zip(&self.cells).filter(move |(i, _)| root(&self.group, *i) == first).map(|(_, cell)| *cell)
    }

    /// The groups that do not hang together with the outside of the box.
    pub fn groups(&self) -> impl Iterator<Item = Vec<CellId>> + '_ {
        self.firsts().map(|first| self.group(first).collect())
    }

    /// The group that costs least to relabel, of those whose cells are neither fixed nor otherwise bound, with its cost.
    pub fn cheapest(
        &self,
        labelled: &Labelled,
        inside: &[bool],
        member: &impl Fn(CellId) -> bool,
        is_free: impl Fn(CellId) -> bool,
    ) -> Option<(f64, usize)> {
        let price = |first: usize| {
            let now_member = member(self.cells[first]);
            // Cells of another component already are inside: a group that turns inside leaves them as they are.
            let mut turned = self.group(first).filter(|&cell| inside[cell as usize] == now_member);
            let cost = turned.try_fold(0.0, |cost, cell| {
                (!labelled.is_fixed(cell) && is_free(cell)).then(|| cost + labelled.cost(cell, now_member))
            });
            cost.map(|cost| (cost, first))
        };
        self.firsts().filter_map(price).min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
    }
}

fn root(group: &[usize], mut i: usize) -> usize {
    while group[i] != i {
        i = group[i];
    }
    i
}
