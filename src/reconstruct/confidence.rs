//! How sure the field is of the surface: what users filter on.

use std::collections::BTreeMap;

use super::Partitioned;
use super::complex::{OUTSIDE, PlaneId};
use crate::building::Measures;
use crate::site::GroundSource;

/// How sure the field is of the boundary between the inside and the outside.
///
/// A facet of the boundary is as sure as the less sure of its two cells: the occupancy of the one inside, what the
/// occupancy of the one outside lacks to 1. Facets count by their area. A cell whose label needed no field is sure.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Confidence {
    /// Of the whole boundary above the ground, 0 to 1; `None` where there is none.
    pub building: Option<f64>,
    /// Of each plane, with whether the outside is on its positive side: sums of area times confidence, and of area.
    planes: BTreeMap<(PlaneId, bool), [f64; 2]>,
}

impl Confidence {
    /// Weighs the boundary of the cells `inside`; `areas` are those of the facets, square metres.
    pub fn new(building: &Partitioned, areas: &[f64], occupancy: &[f64], inside: &[bool]) -> Self {
        let mut planes: BTreeMap<(PlaneId, bool), [f64; 2]> = BTreeMap::new();
        let mut whole = [0.0; 2];
        let is_inside = |cell: u32| cell != OUTSIDE && inside.get(cell as usize).copied().unwrap_or(false);
        let sureness = |cell: u32| {
            let known = building.fixed.get(cell as usize).copied().flatten().is_some();
            let occupancy = occupancy.get(cell as usize).copied().unwrap_or(0.0).clamp(0.0, 1.0);
            match (cell, known) {
                (OUTSIDE, _) | (_, true) => 1.0,
                _ if is_inside(cell) => occupancy,
                _ => 1.0 - occupancy,
            }
        };
        for (facet, &area) in building.complex.facets.iter().zip(areas) {
            let [below, above] = facet.cells;
            if is_inside(below) == is_inside(above) || facet.cells.contains(&OUTSIDE) {
                continue;
            }
            let confidence = sureness(below).min(sureness(above));
            for sums in [&mut whole, planes.entry((facet.plane, is_inside(below))).or_default()] {
                sums[0] += area * confidence;
                sums[1] += area;
            }
        }
        Self { building: mean(whole), planes }
    }

    /// Of the faces on a plane, given with whether the outside is on its positive side; that of the building where no
    /// facet of the boundary is, as where slivers were taken out afterwards.
    pub fn of_plane(&self, plane: (PlaneId, bool)) -> Option<f64> {
        self.planes.get(&plane).copied().and_then(mean).or(self.building)
    }
}

/// A model with an area of this size at fault is not to be trusted at all, square metres.
const LARGEST_FAULT: f64 = 100.0;

/// How much the share of the footprint counts that is missing, in excess or roofed ground …
const AT_FAULT: f64 = 0.5;
/// … and how much the share without data: most of it is roof like that beside it.
const WITHOUT_DATA: f64 = 0.25;

/// What is left of the trust in a model whose floor was guessed: from those of its neighbours, from the lowest points around
/// it and on its walls, or from the lower end of its points.
const GUESSED_FLOOR: [f64; 3] = [0.85, 0.75, 0.5];

/// How far a whole model can be trusted: what the field is sure of ([`Measures::confidence`] as it was measured), less the
/// share of the footprint (of `area` square metres) that is at fault or without data, the share that no tile covers, and
/// the size of the largest fault: of ten square metres, a tenth. Of a model whose floor was guessed it is a share.
///
/// The weights are calibrated: with two thirds of the points of a city given, none of the buildings from 0.9 on has a
/// fault of 10 m² in all its points, where the field's sureness alone leaves one in fourteen.
pub(super) fn of_model(measures: &Measures, area: Option<f64>) -> Option<f64> {
    let field = measures.confidence?;
    let faults = measures.completeness.unwrap_or_default();
    let at_fault = faults.missing.area + faults.excess.area + faults.roofed_ground.area;
    let at_fault = area.map_or(0.0, |area| at_fault / area);
    let share = AT_FAULT * at_fault + WITHOUT_DATA * measures.no_data_share.unwrap_or(0.0);
    let covered = measures.coverage.map_or(1.0, |coverage| coverage.share);
    let largest = faults.largest() / LARGEST_FAULT;
    let floor = match measures.ground.map(|ground| ground.source) {
        Some(GroundSource::Neighbours) => GUESSED_FLOOR[0],
        Some(GroundSource::LowestPoints) => GUESSED_FLOOR[1],
        Some(GroundSource::BoundingBox) => GUESSED_FLOOR[2],
        Some(
            GroundSource::Attribute
            | GroundSource::TerrainModel
            | GroundSource::GroundPoints
            | GroundSource::ScannedFloor
            | GroundSource::Edit,
        )
        | None => 1.0,
    };
    Some(floor * field * covered * (1.0 - share).max(0.0) * (1.0 - largest).max(0.0))
}

fn mean([sum, area]: [f64; 2]) -> Option<f64> {
    (area > 0.0).then(|| sum / area)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::completeness::{Extent, Extents};
    use crate::site::{Coverage, Ground};

    #[test]
    fn a_model_is_trusted_less_for_every_fault() {
        let sound = Measures { confidence: Some(0.98), coverage: Some(Coverage { share: 1.0 }), ..Measures::default() };
        let trust = |change: &dyn Fn(&mut Measures)| {
            let mut measures = sound.clone();
            change(&mut measures);
            of_model(&measures, Some(200.0)).unwrap()
        };
        let fault = Extent { area: 10.0, largest: 10.0 };
        let close = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        close(trust(&|_| ()), 0.98);
        close(trust(&|m| m.coverage = Some(Coverage { share: 0.25 })), 0.98 * 0.25);
        close(trust(&|m| m.no_data_share = Some(0.4)), 0.98 * 0.9);
        let guessed = Ground { height: 1.0, spread: 0.1, source: GroundSource::LowestPoints };
        close(trust(&|m| m.ground = Some(guessed)), 0.98 * 0.75);
        for extents in [
            Extents { missing: fault, ..Extents::default() },
            Extents { excess: fault, ..Extents::default() },
            Extents { roofed_ground: fault, ..Extents::default() },
        ] {
            close(trust(&|m| m.completeness = Some(extents)), 0.98 * 0.975 * 0.9);
        }
        let huge = Extent { area: 900.0, largest: 900.0 };
        close(trust(&|m| m.completeness = Some(Extents { missing: huge, ..Extents::default() })), 0.0);
        assert_eq!(of_model(&Measures { confidence: None, ..sound.clone() }, Some(200.0)), None);
    }
}
