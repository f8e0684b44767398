//! What a footprint costs, before its points are known: enough to make jobs about equal.

use geo::{Area, MultiPolygon};

use crate::source::points::Tile;

/// What a building costs whatever its size, seconds of one core.
const BUILDING: f64 = 4e-3;
/// What a point in its footprint costs, seconds of one core.
const POINT: f64 = 4e-6;

/// What footprints cost.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cost {
    /// Points per square unit of the CRS.
    density: f64,
}

impl Cost {
    /// Where these tiles lie: as dense as all of them together.
    pub(super) fn new(tiles: &[Tile]) -> Self {
        let with_extent = tiles.iter().filter_map(|tile| Some((tile, tile.extent?)));
        let (points, area) = with_extent.fold((0.0, 0.0), |(points, area), (tile, extent)| {
            let own = (extent.max[0] - extent.min[0]) * (extent.max[1] - extent.min[1]);
            (points + tile.points as f64, area + own)
        });
        Self { density: if area > 0.0 { points / area } else { 0.0 } }
    }

    /// Seconds of one core, about.
    pub(super) fn of(self, polygon: &MultiPolygon<f64>) -> f64 {
        BUILDING + POINT * self.density * polygon.unsigned_area()
    }
}
