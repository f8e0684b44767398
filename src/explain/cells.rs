//! The cells of a building and what was decided about them, as columns of numbers.

use crate::reconstruct::complex::{Complex, OUTSIDE};
use crate::reconstruct::{Partitioning, Steps};
use crate::view::packed::{Column, steps as to_steps};

/// Steps of a probability.
const OF_ONE: f64 = 1000.0;

/// Litres in a cubic metre.
const LITRES: f64 = 1000.0;

/// The columns, in the order in which they are packed.
#[derive(Debug, Default)]
pub(crate) struct Cells {
    /// Vertices of the cells.
    vertices: Column,
    /// Per facet: the number of its corners, and their vertices.
    facets: Column,
    /// Per facet: the cells below and above it, each plus 1; 0 for none.
    sides: Column,
    /// Per cell: 1 where its label is fixed, because it is beyond the footprint.
    fixed: Column,
    /// Per cell: its volume in litres.
    volumes: Column,
    /// Per cell: how much it is inside, in thousandths.
    occupancy: Column,
    /// Per cell: 1 where the cut says that it is inside.
    cut: Column,
    /// Per cell: the same after the surface was cleaned.
    cleaned: Column,
}

impl Cells {
    /// Those of a building, as far as the method got.
    pub fn of(steps: &Steps) -> Self {
        let mut cells = Self::default();
        let Some(Partitioning { complex, fixed, volumes, .. }) = &steps.partition else { return cells };
        cells.add_complex(complex);
        for fixed in fixed {
            cells.fixed.push(u64::from(fixed.is_some()));
        }
        for volume in volumes {
            cells.volumes.push((volume * LITRES).round() as u64);
        }
        if let Some(field) = &steps.field {
            let thousandths = |o: &f64| (o.clamp(0.0, 1.0) * OF_ONE).round() as u64;
            field.occupancy.iter().for_each(|o| cells.occupancy.push(thousandths(o)));
        }
        if let Some(cut) = &steps.cut {
            cut.inside.iter().for_each(|inside| cells.cut.push(u64::from(*inside)));
        }
        if let Some(surface) = &steps.surface {
            surface.inside.iter().for_each(|inside| cells.cleaned.push(u64::from(*inside)));
        }
        cells
    }

    /// The columns with their names.
    pub fn in_order(&self) -> [(&'static str, &Column); 8] {
        [
            ("vertices", &self.vertices),
            ("facets", &self.facets),
            ("sides", &self.sides),
            ("fixed", &self.fixed),
            ("volumes", &self.volumes),
            ("occupancy", &self.occupancy),
            ("cut", &self.cut),
            ("cleaned", &self.cleaned),
        ]
    }

    fn add_complex(&mut self, complex: &Complex) {
        let mut last = [0; 3];
        complex.vertices.iter().for_each(|v| self.vertices.push_place(to_steps(v.position.into()), &mut last));
        for facet in &complex.facets {
            self.facets.push_index(facet.corners.len());
            facet.corners.iter().for_each(|vertex| self.facets.push(u64::from(*vertex)));
            let cell = |cell: u32| if cell == OUTSIDE { 0 } else { u64::from(cell) + 1 };
            facet.cells.into_iter().for_each(|side| self.sides.push(cell(side)));
        }
    }
}
