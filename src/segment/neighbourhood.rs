//! Which footprints are near a place.

use crate::geometry::PreparedPolygon;
use crate::site::Frame;
use crate::source::crs::Crs;
use crate::source::footprints::Footprint;
use geo::{BoundingRect, MapCoords, MultiPolygon, coord};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use std::sync::OnceLock;

/// Coordinates are rounded to this many steps per unit of the CRS, so that the same place has the same bits whatever
/// the scale and offset of the tile that it comes from.
const STEPS_PER_UNIT: f64 = 1e6;
/// Side of the squares for which the footprints near them are looked up once, metres.
pub(super) const SQUARE: f64 = 8.0;

/// The nearest multiple of the rounding step; adding zero turns −0 into 0.
pub(super) fn snap(value: f64) -> f64 {
    (value * STEPS_PER_UNIT).round() / STEPS_PER_UNIT + 0.0
}

/// The local frame of a footprint: origin at the whole CRS units below its corner, height 0.
///
/// The origin's height is 0 because the footprint has none of its own and heights of the Earth's surface are small
/// enough for a double to hold micrometres.
pub(super) fn frame_of(polygon: &MultiPolygon<f64>, crs: &Crs) -> Frame {
    let corner = polygon.bounding_rect().map_or([0.0; 2], |rect| [rect.min().x.floor(), rect.min().y.floor()]);
    Frame { origin: [corner[0], corner[1], 0.0], metres_per_unit: crs.metres_per_unit }
}

/// `position` (CRS units, snapped) in local metres; snapped again, since the subtraction leaves its own rounding.
pub(super) fn to_local(frame: &Frame, position: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|axis| snap(position[axis] - frame.origin[axis]) * frame.metres_per_unit[axis])
}

/// A polygon in local metres.
pub(super) fn polygon_to_local(frame: &Frame, polygon: &MultiPolygon<f64>) -> MultiPolygon<f64> {
    polygon.map_coords(|c| {
        let [x, y, _] = to_local(frame, [snap(c.x), snap(c.y), 0.0]);
        coord! { x: x, y: y }
    })
}

/// The outline of a roof.
pub(super) struct Roofprint {
    /// In the local metres of its footprint.
    pub polygon: MultiPolygon<f64>,
    /// The same, prepared.
    prepared: PreparedPolygon,
}

/// All footprints, prepared when they are first asked, and a tree over their boxes.
pub(super) struct Neighbourhood {
    /// Local frames, one per footprint.
    pub frames: Vec<Frame>,
    /// Footprints in local metres.
    pub polygons: Vec<MultiPolygon<f64>>,
    /// The same, prepared: those far from all points never are.
    prepared: Vec<OnceLock<Box<PreparedPolygon>>>,
    /// The outlines of their roofs in local metres, where they are known.
    pub roofprints: Vec<Option<Box<Roofprint>>>,
    tree: RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>,
    /// Radius around a footprint in which something is wanted, CRS units.
    reach: [f64; 2],
    /// Side of a lookup square, CRS units.
    square: [f64; 2],
}

impl Neighbourhood {
    /// Prepares `footprints`, of which everything up to `reach` metres away is wanted.
    pub fn new(footprints: &[Footprint], crs: &Crs, reach: f64) -> Self {
        let frames: Vec<Frame> = footprints.iter().map(|f| frame_of(&f.polygon, crs)).collect();
        let polygons: Vec<_> = frames.iter().zip(footprints).map(|(f, p)| polygon_to_local(f, &p.polygon)).collect();
        let boxes = footprints.iter().enumerate().filter_map(|(index, footprint)| {
            // A roof covers its footprint.
            let rect = footprint.roofprint.as_ref().unwrap_or(&footprint.polygon).bounding_rect()?;
            // A step of slack: the polygons that are asked have been snapped.
            let low = [rect.min().x, rect.min().y].map(|v| v - 2.0 / STEPS_PER_UNIT);
            let high = [rect.max().x, rect.max().y].map(|v| v + 2.0 / STEPS_PER_UNIT);
            Some(GeomWithData::new(Rectangle::from_corners(low, high), index))
        });
        let roofprint = |(frame, footprint): (&Frame, &Footprint)| {
            let polygon = polygon_to_local(frame, footprint.roofprint.as_ref()?);
            Some(Box::new(Roofprint { prepared: PreparedPolygon::new(&polygon), polygon }))
        };
        let per_unit = [crs.metres_per_unit[0], crs.metres_per_unit[1]];
        Self {
            tree: RTree::bulk_load(boxes.collect()),
            roofprints: frames.iter().zip(footprints).map(roofprint).collect(),
            prepared: polygons.iter().map(|_| OnceLock::new()).collect(),
            polygons,
            frames,
            reach: per_unit.map(|m| reach / m),
            square: per_unit.map(|m| SQUARE / m),
        }
    }

    /// Footprint `index` in its local frame, prepared.
    pub fn prepared(&self, index: usize) -> &PreparedPolygon {
        self.prepared[index].get_or_init(|| Box::new(PreparedPolygon::new(&self.polygons[index])))
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
        let envelope = AABB::from_corners(
            [low[0] - self.reach[0], low[1] - self.reach[1]],
            [high[0] + self.reach[0], high[1] + self.reach[1]],
        );
        self.tree.locate_in_envelope_intersecting(&envelope).next().is_some()
    }

    /// Whether any footprint touches the rectangle.
    pub fn touches(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        self.tree.locate_in_envelope_intersecting(&AABB::from_corners(low, high)).next().is_some()
    }

    /// The box of footprint `index` and `width` metres around it, CRS units; `None` when the footprint is empty.
    pub fn surroundings(&self, index: usize, width: f64) -> Option<([f64; 2], [f64; 2])> {
        let rect = self.polygons[index].bounding_rect()?;
        let Frame { origin, metres_per_unit } = self.frames[index];
        let place = |local: [f64; 2]| std::array::from_fn(|axis| origin[axis] + local[axis] / metres_per_unit[axis]);
        Some((place([rect.min().x - width, rect.min().y - width]), place([rect.max().x + width, rect.max().y + width])))
    }

    /// Whether the place, in snapped CRS units, is inside a footprint other than `own`.
    pub fn is_inside_another(&self, position: [f64; 3], own: usize) -> bool {
        self.tree
            .locate_in_envelope_intersecting(&AABB::from_point([position[0], position[1]]))
            .any(|found| found.data != own && self.contains(found.data, position))
    }

    /// Whether footprint `index` contains the place, in snapped CRS units.
    pub fn contains(&self, index: usize, position: [f64; 3]) -> bool {
        let [x, y, _] = to_local(&self.frames[index], position);
        self.prepared(index).contains([x, y])
    }

    /// Whether the roof of footprint `index` lies over a place in its local metres, as far as its outline is known.
    pub fn is_under_roof(&self, index: usize, local: [f64; 3]) -> bool {
        self.roofprints[index].as_ref().is_some_and(|roof| roof.prepared.contains([local[0], local[1]]))
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
    inside: Vec<usize>,
}

impl Lookup<'_> {
    /// The footprints whose boxes, or those of their roofs, touch the square around the place; `None` when nothing is wanted there.
    pub fn near(&mut self, position: [f64; 3]) -> Option<&[usize]> {
        let side = self.all.square;
        let square = [0, 1].map(|axis| (position[axis] / side[axis]).floor() as i64);
        if square != self.square {
            self.square = square;
            let low = [0, 1].map(|axis| square[axis] as f64 * side[axis]);
            let high = [0, 1].map(|axis| low[axis] + side[axis]);
            self.wanted = self.all.is_in_reach(low, high);
            self.inside.clear();
            let touching = self.all.tree.locate_in_envelope_intersecting(&AABB::from_corners(low, high));
            self.inside.extend(touching.map(|found| found.data));
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
            attributes: serde_json::Map::new(),
            notes: Vec::new(),
        };
        let all = Neighbourhood::new(&[footprint], &Crs::local(), 3.0);
        // Points at x = 14 are taken, for the square from 8 to 16 is: so must be a tile that begins there.
        assert!(all.lookup().near([14.5, 2.0, 0.0]).is_some());
        assert!(all.is_wanted([14.0, 0.0], [15.0, 5.0]));
        assert!(all.lookup().near([16.5, 2.0, 0.0]).is_none());
        assert!(!all.is_wanted([16.1, 0.0], [20.0, 5.0]));
    }
}
