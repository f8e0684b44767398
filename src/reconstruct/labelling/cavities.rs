//! Cavities: outside that no way leads out of.

use crate::reconstruct::complex::{CellId, Complex, OUTSIDE};

/// Makes every outside cell inside that no chain of outside cells and facets connects to the outside of the box, and
/// returns how many there were.
///
/// An airborne scanner never sees a cavity, so one is always an artefact; and each component of the inside that is
/// left has one shell without inner shells. A cavity that only an edge or a vertex connects to the outside is one
/// too. Fixed labels do not matter here: what is enclosed by the building belongs to it.
pub fn fill_cavities(complex: &Complex, inside: &mut [bool]) -> usize {
    let mut open = vec![false; inside.len()];
    let mut pending: Vec<CellId> = Vec::new();
    let visit = |cell: CellId, open: &mut Vec<bool>, pending: &mut Vec<CellId>| {
        if cell != OUTSIDE && !inside[cell as usize] && !std::mem::replace(&mut open[cell as usize], true) {
            pending.push(cell);
        }
    };
    for facet in complex.facets.iter().filter(|f| f.cells.contains(&OUTSIDE)) {
        facet.cells.iter().for_each(|&cell| visit(cell, &mut open, &mut pending));
    }
    while let Some(cell) = pending.pop() {
        for &facet in &complex.cells[cell as usize].facets {
            complex.facets[facet as usize].cells.iter().for_each(|&cell| visit(cell, &mut open, &mut pending));
        }
    }
    let mut filled = 0;
    for (label, open) in inside.iter_mut().zip(open) {
        if !*label && !open {
            *label = true;
            filled += 1;
        }
    }
    filled
}
