//! Which footprints a place is in, or beside.

use geo::BoundingRect;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use crate::geometry::PreparedPolygon;
use crate::site::{Frame, Site};

/// Side of the squares for which the footprints near them are looked up once, CRS units.
const SQUARE: f64 = 8.0;

/// Footprints and what is within a width around them.
pub(super) struct Near {
    tree: RTree<GeomWithData<Rectangle<[f64; 2]>, usize>>,
    footprints: Vec<Option<(Frame, PreparedPolygon)>>,
    /// Metres.
    width: f64,
}

impl Near {
    /// The footprints of these sites, and `width` metres around each.
    pub(super) fn new<'a>(sites: impl Iterator<Item = Option<&'a Site>>, width: f64) -> Self {
        let mut boxes = Vec::new();
        let footprints = sites.enumerate().map(|(index, site)| {
            let site = site?;
            let footprint = site.footprint.as_ref()?;
            let rect = footprint.bounding_rect()?;
            let corner = |x: f64, y: f64| {
                let [x, y, _] = site.frame.to_crs(&nalgebra::Point3::new(x, y, 0.0));
                [x, y]
            };
            let (low, high) = (rect.min(), rect.max());
            let aabb = AABB::from_corners(corner(low.x - width, low.y - width), corner(high.x + width, high.y + width));
            boxes.push(GeomWithData::new(Rectangle::from_aabb(aabb), index));
            Some((site.frame, PreparedPolygon::new(footprint)))
        });
        let footprints = footprints.collect();
        Self { tree: RTree::bulk_load(boxes), footprints, width }
    }

    /// The buildings whose surroundings touch a rectangle, CRS units.
    pub(super) fn touching(&self, low: [f64; 2], high: [f64; 2]) -> impl Iterator<Item = usize> + '_ {
        self.tree.locate_in_envelope_intersecting(&AABB::from_corners(low, high)).map(|found| found.data)
    }

    /// A lookup that remembers the square that it was last asked for.
    pub(super) fn lookup(&self) -> Lookup<'_> {
        Lookup { all: self, square: [i64::MIN; 2], near: Vec::new() }
    }

    fn holds(&self, index: usize, position: [f64; 3]) -> bool {
        let Some(Some((frame, footprint))) = self.footprints.get(index) else { return false };
        let local = frame.to_local(position);
        let place = [local.x, local.y];
        footprint.contains(place) || footprint.boundary_distance(place, self.width) <= self.width
    }
}

/// The footprints near a place; consecutive points of a scan mostly fall into one square.
pub(super) struct Lookup<'a> {
    all: &'a Near,
    square: [i64; 2],
    near: Vec<usize>,
}

impl Lookup<'_> {
    /// Calls `each` with the buildings in or beside whose footprint the place (CRS units) is.
    pub(super) fn at(&mut self, position: [f64; 3], mut each: impl FnMut(usize)) {
        let square = [0, 1].map(|axis| (position[axis] / SQUARE).floor() as i64);
        if square != self.square {
            self.square = square;
            let low = square.map(|cell| cell as f64 * SQUARE);
            self.near.clear();
            self.near.extend(self.all.touching(low, low.map(|edge| edge + SQUARE)));
            self.near.sort_unstable();
        }
        self.near.iter().filter(|index| self.all.holds(**index, position)).for_each(|index| each(*index));
    }
}
