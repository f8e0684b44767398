//! What the labelling is told: the occupancy of the cells, and which facets the evidence asks for.

use super::complex::{self, OUTSIDE};
use super::labelling::{self, Cost, Evidence};
use super::{Hypotheses, Parameters, Partitioned};
use crate::geometry::Aabb;

/// The label of each cell, inside or not, by the cut (paper, section 3.4) that follows these occupancies; `height_field`
/// says whether nothing may hang over. Nor may anything where the scan saw nothing under a roof: what a field makes of
/// walls that it must guess is no overhang.
pub fn label(building: &Partitioned, occupancy: &[f64], height_field: bool, parameters: &Parameters) -> Vec<bool> {
    with_evidence(building, occupancy, height_field, |evidence| {
        labelling::label(&building.complex, evidence, &parameters.labelling)
    })
}

/// What labels cost by the same evidence.
pub(super) fn cost(
    building: &Partitioned,
    occupancy: &[f64],
    height_field: bool,
    parameters: &Parameters,
    inside: &[bool],
) -> Cost {
    with_evidence(building, occupancy, height_field, |evidence| {
        labelling::cost(&building.complex, evidence, &parameters.labelling, inside)
    })
}

fn with_evidence<T>(
    building: &Partitioned,
    occupancy: &[f64],
    height_field: bool,
    ask: impl FnOnce(&Evidence) -> T,
) -> T {
    let Partitioned { hypotheses, complex, volumes, fixed, .. } = building;
    let height_field = height_field || !hypotheses.shows_overhang;
    let areas = complex.facet_areas();
    let support = facet_support(complex, hypotheses, fixed);
    let noise = hypotheses.noise;
    let (fixed, marked) = (&*building.decided(), &building.marked[..]);
    ask(&Evidence { occupancy, volumes, areas: &areas, support: &support, fixed, marked, height_field, noise })
}

/// Share of each facet that the evidence asks for, so that it costs no smoothness: roofs where the roof map sees their
/// plane, undersides and, without a footprint, walls where they were scanned, and walls on the footprint's outline.
fn facet_support(complex: &complex::Complex, hypotheses: &Hypotheses, fixed: &[Option<bool>]) -> Vec<f64> {
    let undersides: Vec<(complex::PlaneId, Aabb)> = hypotheses.undersides(complex).collect();
    let walls: Vec<(complex::PlaneId, Aabb)> = hypotheses.seen_walls(complex).collect();
    let covered = |cell: u32| cell != OUTSIDE && fixed.get(cell as usize).copied().flatten().is_none();
    (0u32..)
        .zip(&complex.facets)
        .map(|(id, facet)| {
            let [below, above] = facet.cells.map(covered);
            if below != above {
                return 1.0;
            }
            let corners = complex.facet_positions(id);
            let count = corners.len().max(1) as f64;
            let centre = corners.fold(nalgebra::Vector3::zeros(), |sum, p| sum + p.coords) / count;
            let within = |seen: &Aabb| (0..2).all(|i| seen.min[i] <= centre[i] && centre[i] <= seen.max[i]);
            // The box of a wall along an axis has no width.
            let along = |seen: &Aabb| (0..3).all(|i| seen.min[i] - 0.1 <= centre[i] && centre[i] <= seen.max[i] + 0.1);
            if walls.iter().any(|(plane, seen)| *plane == facet.plane && along(seen)) {
                return 1.0;
            }
            if undersides.iter().any(|(plane, seen)| *plane == facet.plane && within(seen)) {
                return 1.0;
            }
            let seen = hypotheses.map.pixel_at(&centre.xy().into()).map(|[c, r]| hypotheses.map.label(c, r));
            let plane = seen.and_then(|label| complex.primitive_planes.get(label as usize)).map(|p| p.plane);
            if plane == Some(facet.plane) { 1.0 } else { 0.0 }
        })
        .collect()
}
