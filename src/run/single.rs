//! Buildings without a footprint: what stands apart in the points, or those that points name.

use std::collections::HashMap;
use std::sync::Arc;

use geo::{MultiPolygon, Rect, coord};

use super::parts::{Parts, Plan};
use crate::error::{InputError, Result};
use crate::segment::{BuildingClasses, NOISE, SegmentOptions};
use crate::site::{Coverage, Site};
use crate::source::footprints::{Attributes, Footprint};
use crate::source::points::{Extent, ScanPoint, Tile};

/// How far the rectangle reaches beyond the outermost points, CRS units, so that they lie inside it.
const MARGIN: f64 = 1e-5;

/// Whether all that is there is building, and how it is to be told.
#[derive(Debug, Clone, Copy)]
pub(super) struct Look<'a> {
    /// Which points belong to a building.
    pub options: &'a SegmentOptions,
    /// Whether nobody says which points are of buildings and which of the ground.
    pub is_unclassified: bool,
    /// Metres per unit of the CRS.
    pub metres_per_unit: [f64; 3],
}

/// What stands in for footprints.
#[derive(Debug, Default)]
pub(super) struct StandIns {
    /// The rectangle around the building points of each building: so such buildings are treated by the same rules as all
    /// others.
    pub footprints: Vec<Footprint>,
    /// What is to be said.
    pub warnings: Vec<String>,
}

/// The buildings that the tiles name, in the order in which they name them; a building without a building point is none.
/// Where they name none, what stands apart in the building points: tiles are made to name it, a single object by `id` and
/// several by `id-1`, `id-2` and so on, from west to east.
///
/// Streams the tiles, twice unless there is but one object.
///
/// # Errors
/// A tile can no longer be opened; ground lies around the buildings and nobody says which points are of it.
pub(super) fn stand_ins(tiles: &mut [Tile], id: &str, look: Look<'_>) -> Result<StandIns> {
    let mut stand_ins = StandIns::default();
    if tiles.iter().all(|tile| tile.buildings.is_empty()) {
        let whole = boxes(tiles, 1, look, &|_, _| Some(0))?;
        let Some(extent) = whole.first().filter(|extent| !extent.is_empty()) else { return Ok(stand_ins) };
        let Parts { parcels, count, unused, gap } = apart(tiles, extent, look)?;
        if count == 0 || count == 1 && unused == 0 {
            stand_ins.footprints.push(footprint(id, extent));
            return Ok(stand_ins);
        }
        let ids: Vec<String> = match count {
            1 => vec![id.to_owned()],
            _ => (1..=count).map(|number| format!("{id}-{number}")).collect(),
        };
        if count > 1 {
            stand_ins.warnings.push(format!(
                "{count} buildings stand apart in the points, with nothing over {gap:.1} m between them: they are {} to {} \
                 from west to east",
                ids[0],
                ids[count - 1]
            ));
        }
        if unused > 0 {
            stand_ins
                .warnings
                .push(format!("{unused} points stand apart from all buildings, too few for one; they are left out"));
        }
        let (ids, parcels): (Arc<[String]>, _) = (ids.into(), Arc::new(parcels));
        for tile in tiles.iter_mut() {
            *tile = tile.clone().with_parcels(ids.clone(), parcels.clone());
        }
    }
    let mut ids: Vec<String> = Vec::new();
    let mut places = HashMap::new();
    for name in tiles.iter().flat_map(|tile| tile.buildings.iter()) {
        places.entry(name.clone()).or_insert_with(|| {
            ids.push(name.clone());
            ids.len() - 1
        });
    }
    let place = |tile: &Tile, point: &ScanPoint| places.get(tile.buildings.get(point.building? as usize)?).copied();
    let boxes = boxes(tiles, ids.len(), look, &place)?;
    let found = ids.iter().zip(&boxes).filter(|(_, own)| !own.is_empty());
    stand_ins.footprints.extend(found.map(|(id, own)| footprint(id, own)));
    Ok(stand_ins)
}

/// Calls `visit` with each building point that counts.
fn each_point(tiles: &[Tile], look: Look<'_>, visit: &mut dyn FnMut(&Tile, &ScanPoint)) -> Result<()> {
    let options = look.options;
    let is_building = |class: u8| match &options.building_classes {
        BuildingClasses::Listed(classes) => classes.contains(&class),
        BuildingClasses::Keyword(_) => !options.ground_classes.contains(&class),
    };
    for tile in tiles {
        tile.stream(None, &mut |block| {
            for point in block.points() {
                let is_used = options.use_flagged.takes(point.withheld, point.synthetic);
                if is_used && !NOISE.contains(&point.class) && is_building(point.class) {
                    visit(tile, &point);
                }
            }
        })?;
    }
    Ok(())
}

/// The boxes of the building points by the place that is theirs, if they have one.
fn boxes(
    tiles: &[Tile],
    count: usize,
    look: Look<'_>,
    place: &dyn Fn(&Tile, &ScanPoint) -> Option<usize>,
) -> Result<Vec<Extent>> {
    let mut boxes = vec![Extent::EMPTY; count];
    each_point(tiles, look, &mut |tile, point| {
        if let Some(own) = place(tile, point).and_then(|place| boxes.get_mut(place)) {
            own.grow(point.position);
        }
    })?;
    Ok(boxes)
}

/// What stands apart in the building points, which lie in `extent`.
fn apart(tiles: &[Tile], extent: &Extent, look: Look<'_>) -> Result<Parts> {
    let metres = look.metres_per_unit;
    let size = (0..2).map(|axis| (extent.max[axis] - extent.min[axis]) * metres[axis]).fold(0.0, f64::max);
    let mut plan = Plan::new(size, metres);
    each_point(tiles, look, &mut |_, point| plan.add(point.position))?;
    if let (true, Some(share), Some(first)) = (look.is_unclassified, plan.ground(), tiles.first()) {
        let found =
            format!("points without classes, {:.0} % of their area ground around what stands on it", 100.0 * share);
        let fault =
            InputError::new(&first.path, found, "points of buildings only, or classes that tell them from the ground");
        return Err(fault
            .remedy(
                "Classify the points (a column or property `classification`: 2 for ground, 6 for buildings), cut the ground \
                 off, give --footprints, or give --building-class 0 if all of it is building",
            )
            .into());
    }
    Ok(plan.parts())
}

fn footprint(id: &str, own: &Extent) -> Footprint {
    let (low, high) = (own.min, own.max);
    let rectangle = Rect::new(
        coord! { x: low[0] - MARGIN, y: low[1] - MARGIN },
        coord! { x: high[0] + MARGIN, y: high[1] + MARGIN },
    );
    Footprint {
        id: id.to_owned(),
        polygon: MultiPolygon(vec![rectangle.to_polygon()]),
        roofprint: None,
        attributes: Attributes::default(),
        notes: Vec::new(),
    }
}

/// Takes a stand-in away again: what is left is the points and the ground.
pub(super) fn without_footprint(site: Site) -> Site {
    Site {
        footprint: None,
        ground_points: Vec::new(),
        ground_line: Vec::new(),
        coverage: Coverage { share: 1.0 },
        covered: None,
        eaves: None,
        ..site
    }
}
