//! Which part of the footprints is reconstructed: those in a box, in the polygons of a file, or in both.
//!
//! A footprint is where its representative point is: a point inside it that depends on its polygon alone. Areas are
//! half-open, so that of two that share an edge each building belongs to one: a box has its left and lower edge and not its
//! right and upper one, and of polygons whose common edge has the same corners a point on it belongs to one as well.

use std::path::{Path, PathBuf};

use geo::{BoundingRect, InteriorPoint, MultiPolygon};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::journal::Journal;
use super::observer::Observer;
use crate::error::{Error, InputError, Result};
use crate::geometry::PreparedPolygon;
use crate::source::crs::Crs;
use crate::source::footprints::{self, Footprint, FootprintOptions};

/// What messages call the file of the area.
const OPTION: &str = "--limit-area";

/// What limits a run to a part of the footprints.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Limit {
    /// Smallest x and y, largest x and y, in the CRS of the tiles, which is that of the model; see [`bounds`].
    pub bounds: Option<[f64; 4]>,
    /// A file of polygons, in any format of footprints and any CRS.
    pub area: Option<PathBuf>,
}

impl Limit {
    /// Whether all footprints are wanted.
    pub fn is_none(&self) -> bool {
        self.bounds.is_none() && self.area.is_none()
    }
}

/// A box as text: `MINX,MINY,MAXX,MAXY`.
///
/// # Errors
/// What was expected.
pub fn bounds(text: &str) -> Result<[f64; 4], String> {
    const EXPECTED: &str = "four numbers are expected, MINX,MINY,MAXX,MAXY, each least below its largest";
    let numbers = text.split(',').map(|number| number.trim().parse().ok()).collect::<Option<Vec<f64>>>();
    let found = numbers.and_then(|numbers| <[f64; 4]>::try_from(numbers).ok());
    let is_box = |[x0, y0, x1, y1]: &[f64; 4]| [x0, y0, x1, y1].iter().all(|n| n.is_finite()) && x0 < x1 && y0 < y1;
    found.filter(is_box).ok_or_else(|| EXPECTED.to_owned())
}

/// The part that is wanted, in the CRS of the tiles.
pub(super) struct Area {
    bounds: Option<[f64; 4]>,
    /// The polygons of the file, where there is one.
    polygons: Option<Vec<PreparedPolygon>>,
    /// Smallest x and y, largest x and y of all that is wanted.
    extent: [f64; 4],
    /// What the user called it.
    name: String,
}

impl Area {
    /// Reads what `limit` asks for; `None` where all is wanted.
    ///
    /// # Errors
    /// The file cannot be read or has no polygon, or its CRS and `crs` have nothing to do with each other.
    pub(super) fn open(limit: &Limit, crs: &Crs, journal: &Journal<'_>) -> Result<Option<Self>> {
        let polygons = limit.area.as_deref().map(|path| read(path, crs, journal)).transpose()?;
        let of_polygons = polygons.iter().flatten().filter_map(|polygon| {
            let rect = polygon.bounding_rect()?;
            Some([rect.min().x, rect.min().y, rect.max().x, rect.max().y])
        });
        let around = of_polygons.reduce(|a, b| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]);
        let extent = match (limit.bounds, around) {
            (Some(a), Some(b)) => [a[0].max(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].min(b[3])],
            (Some(one), None) | (None, Some(one)) => one,
            (None, None) => return Ok(None),
        };
        let polygons = polygons.map(|polygons| polygons.iter().map(PreparedPolygon::new).collect());
        let named = [
            limit.bounds.map(|[x0, y0, x1, y1]| format!("--box {x0},{y0},{x1},{y1}")),
            limit.area.as_deref().map(|path| format!("{OPTION} {}", footprints::label(path).display())),
        ];
        let name = named.into_iter().flatten().collect::<Vec<_>>().join(" and ");
        Ok(Some(Self { bounds: limit.bounds, polygons, extent, name }))
    }

    /// Smallest x and y, largest x and y of what is wanted, and `margin` units around it.
    pub(super) fn extent(&self, margin: f64) -> [f64; 4] {
        let [x0, y0, x1, y1] = self.extent;
        [x0 - margin, y0 - margin, x1 + margin, y1 + margin]
    }

    /// What the user called it.
    pub(super) fn name(&self) -> &str {
        &self.name
    }

    /// Whether a place is in it.
    fn has(&self, place: [f64; 2]) -> bool {
        let [x, y] = place;
        self.bounds.is_none_or(|[x0, y0, x1, y1]| x0 <= x && x < x1 && y0 <= y && y < y1)
            && self.polygons.as_ref().is_none_or(|all| all.iter().any(|polygon| polygon.contains(place)))
    }

    /// Whether a footprint is in it: whether its representative point is.
    pub(super) fn has_footprint(&self, footprint: &Footprint) -> bool {
        let point = footprint.polygon.interior_point();
        point.is_some_and(|point| self.has([point.x(), point.y()]))
    }
}

/// Which of some footprints are within `margin` (units along x and y) of one that is wanted, those left out: what is beside
/// a building says where its ground is not.
pub(super) fn beside(footprints: &[Footprint], is_wanted: &[bool], margin: [f64; 2]) -> Vec<bool> {
    let rectangle = |footprint: &Footprint, by: [f64; 2]| {
        let rect = footprint.polygon.bounding_rect()?;
        Some(AABB::from_corners(
            [rect.min().x - by[0], rect.min().y - by[1]],
            [rect.max().x + by[0], rect.max().y + by[1]],
        ))
    };
    let wanted = footprints.iter().zip(is_wanted).filter(|(_, is_wanted)| **is_wanted);
    let boxes = wanted.filter_map(|(footprint, _)| rectangle(footprint, margin));
    let tree: RTree<GeomWithData<Rectangle<[f64; 2]>, ()>> =
        RTree::bulk_load(boxes.map(|aabb| GeomWithData::new(Rectangle::from_aabb(aabb), ())).collect());
    let is_near = |footprint: &Footprint| {
        rectangle(footprint, [0.0; 2]).is_some_and(|aabb| tree.locate_in_envelope_intersecting(&aabb).next().is_some())
    };
    footprints.iter().zip(is_wanted).map(|(footprint, is_wanted)| !is_wanted && is_near(footprint)).collect()
}

/// The polygons of a file, in `crs`.
fn read(path: &Path, crs: &Crs, journal: &Journal<'_>) -> Result<Vec<MultiPolygon<f64>>> {
    let renamed = |error: Error, remedy: &str| match error {
        Error::Input(mut fault) => {
            fault.place =
                [OPTION, &fault.place].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join(", ");
            remedy.clone_into(&mut fault.remedy);
            Error::Input(fault)
        }
        other => other,
    };
    let mut layer = footprints::read_until(path, &FootprintOptions::default(), &|| journal.interrupted())
        .map_err(|error| renamed(error, "Give a file with one layer of polygons"))?;
    let file = layer.path.display().to_string();
    if layer.crs.is_none() {
        journal.warn(&format!("{OPTION} {file} names no reference system; it is taken to be in {crs}"));
    } else {
        let told = layer.reproject(crs);
        for warning in told.map_err(|error| renamed(error, "Give the area in the reference system of the tiles"))? {
            journal.warn(&format!("{OPTION} {file}: {warning}"));
        }
    }
    if let Some(first) = layer.rejected.first() {
        let count = layer.rejected.len();
        journal
            .warn(&format!("{OPTION} {file}: {count} features are no polygons, the first of them: {}", first.reason));
    }
    if layer.footprints.is_empty() {
        let fault = InputError::new(&layer.path, "no polygon", "the polygons in which buildings are reconstructed");
        return Err(fault.at(OPTION).into());
    }
    Ok(layer.footprints.into_iter().map(|feature| feature.polygon).collect())
}

#[cfg(test)]
mod tests {
    use geo::{Rect, coord};

    use super::*;
    use crate::source::footprints::Attributes;

    fn footprint(x: f64, y: f64) -> Footprint {
        let square = Rect::new(coord! { x: x - 1.0, y: y - 1.0 }, coord! { x: x + 1.0, y: y + 1.0 });
        Footprint {
            id: String::new(),
            polygon: MultiPolygon(vec![square.to_polygon()]),
            roofprint: None,
            attributes: Attributes::default(),
            notes: Vec::new(),
        }
    }

    fn of_box(bounds: [f64; 4]) -> Area {
        Area { bounds: Some(bounds), polygons: None, extent: bounds, name: String::new() }
    }

    #[test]
    fn a_box_is_four_numbers() {
        assert_eq!(bounds("-1, 2,3.5,4e2"), Ok([-1.0, 2.0, 3.5, 400.0]));
        for bad in ["", "1,2,3", "1,2,3,4,5", "3,2,1,4", "1,2,1,4", "a,2,3,4", "0,0,inf,1", "nan,0,1,1"] {
            assert!(bounds(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn each_building_is_in_one_of_two_areas_that_share_an_edge() {
        let boxes = [[0.0, 0.0, 10.0, 10.0], [10.0, 0.0, 20.0, 10.0], [0.0, 10.0, 20.0, 20.0]].map(of_box);
        // A corner of three polygons, and a point on each of their edges.
        let polygons = [
            geo::wkt!(POLYGON((0. 0., 10. 0., 8. 10., 0. 10., 0. 0.))),
            geo::wkt!(POLYGON((10. 0., 20. 0., 20. 10., 8. 10., 10. 0.))),
            geo::wkt!(POLYGON((0. 10., 8. 10., 20. 10., 20. 20., 0. 20., 0. 10.))),
        ];
        let areas = polygons.map(|polygon| Area {
            bounds: None,
            polygons: Some(vec![PreparedPolygon::new(&MultiPolygon(vec![polygon]))]),
            extent: [0.0; 4],
            name: String::new(),
        });
        for (x, y) in [(10.0, 5.0), (10.0, 10.0), (5.0, 10.0), (9.0, 5.0), (8.0, 10.0), (14.0, 10.0), (3.0, 3.0)] {
            let house = footprint(x, y);
            assert_eq!(boxes.iter().filter(|area| area.has_footprint(&house)).count(), 1, "boxes at {x}, {y}");
            assert_eq!(areas.iter().filter(|area| area.has_footprint(&house)).count(), 1, "polygons at {x}, {y}");
        }
    }

    #[test]
    fn what_is_beside_is_not_what_is_wanted() {
        let row: Vec<Footprint> = (0..5).map(|i| footprint(f64::from(i) * 10.0, 0.0)).collect();
        let beside = beside(&row, &[false, true, false, false, false], [8.0, 1.0]);
        assert_eq!(beside, [true, false, true, false, false]);
    }
}
