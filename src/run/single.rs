//! A single object without a footprint.

use geo::{MultiPolygon, Rect, coord};
use serde_json::Map;

use crate::error::Result;
use crate::segment::{BuildingClasses, NOISE, SegmentOptions};
use crate::site::{Coverage, Site};
use crate::source::footprints::Footprint;
use crate::source::points::Tile;

/// How far the rectangle reaches beyond the outermost points, CRS units, so that they lie inside it.
const MARGIN: f64 = 1e-5;

/// The rectangle around all building points, which stands in for a footprint while points are collected: so a single
/// object is treated by the same rules as all others. `None` without a building point.
///
/// Streams the tiles.
///
/// # Errors
/// A tile can no longer be opened.
pub(super) fn stand_in(tiles: &[Tile], id: &str, options: &SegmentOptions) -> Result<Option<Footprint>> {
    let is_building = |class: u8| match &options.building_classes {
        BuildingClasses::Listed(classes) => classes.contains(&class),
        BuildingClasses::Keyword(_) => !options.ground_classes.contains(&class),
    };
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for tile in tiles {
        tile.stream(None, &mut |block| {
            for point in block.points() {
                if point.withheld || point.synthetic || NOISE.contains(&point.class) || !is_building(point.class) {
                    continue;
                }
                for axis in 0..2 {
                    low[axis] = low[axis].min(point.position[axis]);
                    high[axis] = high[axis].max(point.position[axis]);
                }
            }
        })?;
    }
    Ok((low[0] <= high[0]).then(|| {
        let rectangle = Rect::new(
            coord! { x: low[0] - MARGIN, y: low[1] - MARGIN },
            coord! { x: high[0] + MARGIN, y: high[1] + MARGIN },
        );
        Footprint {
            id: id.to_owned(),
            polygon: MultiPolygon(vec![rectangle.to_polygon()]),
            attributes: Map::new(),
            notes: Vec::new(),
        }
    }))
}

/// Takes the stand-in away again: what is left is the points and the ground.
pub(super) fn without_footprint(site: Site) -> Site {
    Site { footprint: None, coverage: Coverage { share: 1.0 }, ..site }
}
