//! Buildings without a footprint: a single object, or those that points name.

use std::collections::HashMap;

use geo::{MultiPolygon, Rect, coord};
use serde_json::Map;

use crate::error::Result;
use crate::segment::{BuildingClasses, NOISE, SegmentOptions};
use crate::site::{Coverage, Site};
use crate::source::footprints::Footprint;
use crate::source::points::{Extent, Tile};

/// How far the rectangle reaches beyond the outermost points, CRS units, so that they lie inside it.
const MARGIN: f64 = 1e-5;

/// The rectangle around the building points of each building that the tiles name, in the order in which they name them;
/// where they name none, that around all building points, with the id `id`. It stands in for a footprint while points are
/// collected: so such buildings are treated by the same rules as all others. A building without a building point has none.
///
/// Streams the tiles.
///
/// # Errors
/// A tile can no longer be opened.
pub(super) fn stand_ins(tiles: &[Tile], id: &str, options: &SegmentOptions) -> Result<Vec<Footprint>> {
    let is_building = |class: u8| match &options.building_classes {
        BuildingClasses::Listed(classes) => classes.contains(&class),
        BuildingClasses::Keyword(_) => !options.ground_classes.contains(&class),
    };
    let mut ids: Vec<&str> = Vec::new();
    let mut places = HashMap::new();
    for name in tiles.iter().flat_map(|tile| tile.buildings.iter()) {
        places.entry(name.as_str()).or_insert_with(|| {
            ids.push(name);
            ids.len() - 1
        });
    }
    let is_named = !ids.is_empty();
    if !is_named {
        ids.push(id);
    }
    let mut boxes = vec![Extent::EMPTY; ids.len()];
    for tile in tiles {
        let named: Vec<usize> = tile.buildings.iter().map(|name| places[name.as_str()]).collect();
        tile.stream(None, &mut |block| {
            for point in block.points() {
                let is_used = options.use_flagged.takes(point.withheld, point.synthetic);
                if !is_used || NOISE.contains(&point.class) || !is_building(point.class) {
                    continue;
                }
                let place = match point.building {
                    Some(building) => named.get(building as usize).copied(),
                    None => (!is_named).then_some(0),
                };
                if let Some(own) = place.and_then(|place| boxes.get_mut(place)) {
                    own.grow(point.position);
                }
            }
        })?;
    }
    let rectangle = |own: &Extent| {
        let (low, high) = (own.min, own.max);
        Rect::new(
            coord! { x: low[0] - MARGIN, y: low[1] - MARGIN },
            coord! { x: high[0] + MARGIN, y: high[1] + MARGIN },
        )
    };
    let found = ids.into_iter().zip(&boxes).filter(|(_, own)| !own.is_empty());
    Ok(found
        .map(|(id, own)| Footprint {
            id: id.to_owned(),
            polygon: MultiPolygon(vec![rectangle(own).to_polygon()]),
            attributes: Map::new(),
            notes: Vec::new(),
        })
        .collect())
}

/// Takes a stand-in away again: what is left is the points and the ground.
pub(super) fn without_footprint(site: Site) -> Site {
    Site {
        footprint: None,
        ground_points: Vec::new(),
        ground_line: Vec::new(),
        coverage: Coverage { share: 1.0 },
        covered: None,
        ..site
    }
}
