//! Places that are inside or outside: the cells around them get hard links in the cut.

use nalgebra::Point3;

use super::{Tally, local, picked};
use crate::edits::Action;
use crate::reconstruct::Partitioned;
use crate::reconstruct::complex::CellId;

/// No building has more marks than this: then it should be split, or drawn by hand.
const MOST: usize = 256;

impl Partitioned<'_> {
    /// Marks the cells around the places that the edits of the site name.
    pub(in crate::reconstruct) fn mark(&mut self, tally: &mut Tally) {
        let site = self.site;
        let mut marked = vec![None; self.complex.cells.len()];
        let places = picked(&site.edits, |edit| match edit.action {
            Action::MarkPlace { place, inside } => Some((place, inside)),
            _ => None,
        });
        let mut own = Vec::new();
        for (number, (index, (place, inside))) in places.enumerate() {
            let cell = local(&site.frame, place).and_then(|p| {
                if number >= MOST {
                    return Err(format!("the building has more than {MOST} marks"));
                }
                let cell = self
                    .cell_at(&p)
                    .ok_or_else(|| "the place lies beyond the building and the air over it".to_owned())?;
                match self.fixed.get(cell as usize).copied().flatten() {
                    Some(false) if inside => Err("the place lies beyond the footprint".to_owned()),
                    _ => Ok(cell),
                }
            });
            match cell {
                Ok(cell) => {
                    marked[cell as usize] = Some(inside);
                    own.push((index, cell, inside));
                    tally.note(index, Ok(()));
                }
                Err(why) => tally.note(index, Err(why)),
            }
        }
        // A later mark in the same cell goes before an earlier one.
        for (index, cell, inside) in own {
            if marked[cell as usize] != Some(inside) {
                tally.note(index, Err("a later mark in the same cell says otherwise".to_owned()));
            }
        }
        self.marked = marked;
    }

    /// The cell that a place is in; of several that meet there the one that it is deepest in.
    fn cell_at(&self, place: &Point3<f64>) -> Option<CellId> {
        const TOLERANCE: f64 = 1e-6;
        let planes = self.complex.planes.iter();
        let distances: Vec<f64> = planes.map(|plane| plane.to_plane().distance(place)).collect();
        let depth = |cell: CellId| {
            let facets = &self.complex.cells[cell as usize].facets;
            let own = facets.iter().map(|facet| {
                let facet = &self.complex.facets[*facet as usize];
                let distance = distances[facet.plane as usize];
                if facet.cells[0] == cell { -distance } else { distance }
            });
            own.fold(f64::INFINITY, f64::min)
        };
        let cells = (0..self.complex.cells.len() as CellId).map(|cell| (depth(cell), cell));
        let deepest = cells.max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        deepest.filter(|(depth, _)| *depth >= -TOLERANCE).map(|(_, cell)| cell)
    }

    /// Notes which marks the surface does not follow, whose cells are `inside`.
    pub(in crate::reconstruct) fn check_marks(&self, inside: &[bool], tally: &mut Tally) {
        let site = self.site;
        let places: Vec<_> = picked(&site.edits, |edit| match edit.action {
            Action::MarkPlace { place, inside } => Some((place, inside)),
            _ => None,
        })
        .collect();
        for (index, (place, wanted)) in places {
            let cell = local(&site.frame, place).ok().and_then(|p| self.cell_at(&p));
            let Some(cell) = cell.filter(|cell| self.marked.get(*cell as usize) == Some(&Some(wanted))) else {
                continue;
            };
            if inside.get(cell as usize) != Some(&wanted) {
                let why =
                    if wanted { "no solid could reach the place" } else { "the solid could not be kept off the place" };
                tally.note(index, Err(why.to_owned()));
            }
        }
    }
}
