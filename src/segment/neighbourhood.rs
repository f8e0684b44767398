//! Which footprints are near a place.

use super::boxes::{self, Boxes, Rectangle};
use super::shelf::Shelf;
use crate::error::Result;
use crate::geometry::PreparedPolygon;
use crate::site::Frame;
use crate::source::crs::Crs;
use crate::source::footprints::Footprint;
use foldhash::fast::RandomState;
use geo::{BoundingRect, MapCoords, MultiPolygon, coord};
use std::collections::HashMap;
use std::sync::{Arc, OnceLock, PoisonError, RwLock};

/// Coordinates are rounded to this many steps per unit of the CRS, so that the same place has the same bits whatever
/// the scale and offset of the tile that it comes from.
pub(super) const STEPS_PER_UNIT: f64 = 1e6;
/// Side of the squares for which the footprints near them are looked up once, metres.
pub(super) const SQUARE: f64 = 8.0;

/// So many footprints are ready at a time: those of a few tiles.
const MOST_READY: usize = 4096;

/// The nearest multiple of the rounding step; adding zero turns −0 into 0.
pub(super) fn snap(value: f64) -> f64 {
    (value * STEPS_PER_UNIT).round() / STEPS_PER_UNIT + 0.0
}

/// The local frame of a footprint: origin at the whole CRS units below its corner, height 0.
///
/// The origin's height is 0 because the footprint has none of its own and heights of the Earth's surface are small
/// enough for a double to hold micrometres.
pub(crate) fn frame_of(polygon: &MultiPolygon<f64>, metres_per_unit: [f64; 3]) -> Frame {
    let corner = polygon.bounding_rect().map_or([0.0; 2], |rect| [rect.min().x.floor(), rect.min().y.floor()]);
    Frame { origin: [corner[0], corner[1], 0.0], metres_per_unit }
}

/// `position` (CRS units, snapped) in local metres; snapped again, since the subtraction leaves its own rounding.
pub(super) fn to_local(frame: &Frame, position: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| snap(position[axis] - frame.origin[axis]) * frame.metres_per_unit[axis])
}

/// Where a point of a tile is in local metres, to the bits that it has among the points of a site.
#[cfg(feature = "edit")]
pub(crate) fn as_collected(frame: &Frame, position: [f64; 3]) -> nalgebra::Point3<f64> {
    to_local(frame, position.map(snap)).into()
}

/// A polygon in local metres.
pub(super) fn polygon_to_local(frame: &Frame, polygon: &MultiPolygon<f64>) -> MultiPolygon<f64> {
    polygon.map_coords(|c| {
        let [x, y, _] = to_local(frame, [snap(c.x), snap(c.y), 0.0]);
        coord! { x: x, y: y }
    })
}

/// A footprint where it stands.
#[derive(Debug)]
pub(super) struct Place {
    /// Its local frame.
    pub frame: Frame,
    /// In local metres.
    pub polygon: MultiPolygon<f64>,
    prepared: OnceLock<PreparedPolygon>,
    /// The outline of its roof in local metres, where it is known.
    pub roofprint: Option<MultiPolygon<f64>>,
    under_roof: OnceLock<PreparedPolygon>,
    /// Its id, attributes and notes; without its polygons.
    pub about: Footprint,
    /// The box of both, CRS units; `None` when the footprint is empty.
    pub bounds: Option<Rectangle>,
}

impl Place {
    fn of(footprint: Footprint, metres_per_unit: [f64; 3]) -> Self {
        let frame = frame_of(&footprint.polygon, metres_per_unit);
        let polygon = polygon_to_local(&frame, &footprint.polygon);
        let roofprint = footprint.roofprint.as_ref().map(|roof| polygon_to_local(&frame, roof));
        Self {
            prepared: OnceLock::new(),
            under_roof: OnceLock::new(),
            bounds: boxes::of(&footprint),
            about: Footprint { polygon: MultiPolygon(Vec::new()), roofprint: None, ..footprint },
            frame,
            polygon,
            roofprint,
        }
    }

    /// Its polygon, prepared: of those far from all points it never is.
    pub fn prepared(&self) -> &PreparedPolygon {
        self.prepared.get_or_init(|| PreparedPolygon::new(&self.polygon))
    }

    /// Whether it contains a place, in snapped CRS units.
    pub fn contains(&self, position: [f64; 3]) -> bool {
        let [x, y, _] = to_local(&self.frame, position);
        self.prepared().contains([x, y])
    }

    /// Whether its roof lies over a place in its local metres, as far as its outline is known.
    pub fn is_under_roof(&self, local: [f64; 3]) -> bool {
        let Some(roofprint) = &self.roofprint else { return false };
        self.under_roof.get_or_init(|| PreparedPolygon::new(roofprint)).contains([local[0], local[1]])
    }

    /// The box around it and `width` metres more, CRS units; `None` when the footprint is empty.
    pub fn surroundings(&self, width: f64) -> Option<Rectangle> {
        let rect = self.polygon.bounding_rect()?;
        let Frame { origin, metres_per_unit } = self.frame;
        let place = |local: [f64; 2]| std::array::from_fn(|axis| origin[axis] + local[axis] / metres_per_unit[axis]);
        Some((place([rect.min().x - width, rect.min().y - width]), place([rect.max().x + width, rect.max().y + width])))
    }
}

/// All footprints, and a tree over their boxes. Those that are asked for are made ready; those that were asked for of late are
/// still ready.
pub(super) struct Neighbourhood {
    shelf: Shelf,
    ready: RwLock<HashMap<usize, Arc<Place>, RandomState>>,
    /// Where they lie.
    pub boxes: Boxes,
    metres_per_unit: [f64; 3],
    /// Radius around a footprint in which something is wanted, CRS units.
    reach: [f64; 2],
    /// Side of a lookup square, CRS units.
    square: [f64; 2],
}

impl Neighbourhood {
    /// Of `footprints` everything up to `reach` metres away is wanted.
    ///
    /// # Errors
    /// They are too many for memory, and cannot be put into a temporary file.
    pub fn new(footprints: Vec<Footprint>, crs: &Crs, reach: f64) -> Result<Self> {
        let boxes = Boxes::new(&footprints);
        let per_unit = [crs.metres_per_unit[0], crs.metres_per_unit[1]];
        Ok(Self {
            shelf: Shelf::new(footprints)?,
            ready: RwLock::default(),
            boxes,
            metres_per_unit: crs.metres_per_unit,
            reach: per_unit.map(|m| reach / m),
            square: per_unit.map(|m| SQUARE / m),
        })
    }

    /// How many footprints there are.
    pub fn len(&self) -> usize {
        self.shelf.len()
    }

    /// Footprint `index` where it stands.
    pub fn place(&self, index: usize) -> Arc<Place> {
        if let Some(place) = self.ready.read().unwrap_or_else(PoisonError::into_inner).get(&index) {
            return place.clone();
        }
        let place = Arc::new(Place::of(self.shelf.get(index), self.metres_per_unit));
        let mut ready = self.ready.write().unwrap_or_else(PoisonError::into_inner);
        if ready.len() >= MOST_READY {
            ready.clear();
        }
        ready.entry(index).or_insert(place).clone()
    }

    /// Whether all footprints that were asked for could be read.
    ///
    /// # Errors
    /// The temporary file cannot be read.
    pub fn check(&self) -> Result<()> {
        self.shelf.check()
    }

    /// Whether something is wanted of the rectangle, or of a square that it reaches into. Points are taken by squares: if a
    /// tile were asked more narrowly, what is kept of a square would hang on where tiles end.
    pub fn is_wanted(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        let side = self.square;
        // A step of slack: points are snapped before their square is looked up.
        let first = |axis: usize| ((low[axis] - 2.0 / STEPS_PER_UNIT) / side[axis]).floor() * side[axis];
        let last = |axis: usize| ((high[axis] + 2.0 / STEPS_PER_UNIT) / side[axis]).floor() * side[axis] + side[axis];
        self.is_in_reach([first(0), first(1)], [last(0), last(1)])
    }

    /// Whether something is wanted of the rectangle itself.
    fn is_in_reach(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        self.boxes.near((low, high), self.reach).next().is_some()
    }

    /// Whether the place, in snapped CRS units, is inside a footprint other than `own`.
    pub fn is_inside_another(&self, position: [f64; 3], own: usize) -> bool {
        let place = [position[0], position[1]];
        self.boxes.near((place, place), [0.0; 2]).any(|other| other != own && self.place(other).contains(position))
    }

    /// A lookup that remembers the square that it was last asked for.
    pub fn lookup(&self) -> Lookup<'_> {
        Lookup { all: self, square: [i64::MIN; 2], wanted: false, inside: Vec::new() }
    }
}

/// The footprints near a place; consecutive points of a scan mostly fall into one square.
pub(super) struct Lookup<'a> {
    all: &'a Neighbourhood,
    square: [i64; 2],
    wanted: bool,
    inside: Vec<(usize, Arc<Place>)>,
}

impl Lookup<'_> {
    /// The footprints whose boxes, or those of their roofs, touch the square around the place; `None` when nothing is wanted there.
    pub fn near(&mut self, position: [f64; 3]) -> Option<&[(usize, Arc<Place>)]> {
        let side = self.all.square;
        let square = [0, 1].map(|axis| (position[axis] / side[axis]).floor() as i64);
        if square != self.square {
            self.square = square;
            let low = [0, 1].map(|axis| square[axis] as f64 * side[axis]);
            let high = [0, 1].map(|axis| low[axis] + side[axis]);
            self.wanted = self.all.is_in_reach(low, high);
            self.inside.clear();
            let touching = self.all.boxes.near((low, high), [0.0; 2]);
            self.inside.extend(touching.map(|index| (index, self.all.place(index))));
        }
        self.wanted.then_some(self.inside.as_slice())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rectangle_is_wanted_where_it_reaches_into_a_square_of_which_anything_is() {
        let square = geo::wkt!(MULTIPOLYGON(((0. 0., 10. 0., 10. 10., 0. 10., 0. 0.))));
        let footprint = Footprint {
            id: String::new(),
            polygon: square,
            roofprint: None,
            attributes: crate::source::footprints::Attributes::default(),
            notes: Vec::new(),
        };
        let all = Neighbourhood::new(vec![footprint], &Crs::local(), 3.0).unwrap();
        // Points at x = 14 are taken, for the square from 8 to 16 is: so must be a tile that begins there.
        assert!(all.lookup().near([14.5, 2.0, 0.0]).is_some());
        assert!(all.is_wanted([14.0, 0.0], [15.0, 5.0]));
        assert!(all.lookup().near([16.5, 2.0, 0.0]).is_none());
        assert!(!all.is_wanted([16.1, 0.0], [20.0, 5.0]));
    }
}
