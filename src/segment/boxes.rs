//! Where footprints lie.

use geo::BoundingRect;
use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree};

use super::neighbourhood::STEPS_PER_UNIT;
use crate::source::footprints::Footprint;

/// Lower and upper corner of a rectangle, CRS units.
pub(super) type Rectangle = ([f64; 2], [f64; 2]);

/// The box of a footprint and its roof, CRS units; `None` when it is empty.
pub(super) fn of(footprint: &Footprint) -> Option<Rectangle> {
    // A roof covers its footprint.
    let rect = footprint.roofprint.as_ref().unwrap_or(&footprint.polygon).bounding_rect()?;
    // A step of slack: the polygons that are asked have been snapped.
    let low = [rect.min().x, rect.min().y].map(|v| v - 2.0 / STEPS_PER_UNIT);
    Some((low, [rect.max().x, rect.max().y].map(|v| v + 2.0 / STEPS_PER_UNIT)))
}

/// The boxes of footprints, in a tree.
#[derive(Debug)]
pub(super) struct Boxes(RTree<GeomWithData<rstar::primitives::Rectangle<[f64; 2]>, u32>>);

impl Boxes {
    /// Those of these footprints that are not empty.
    pub fn new(footprints: &[Footprint]) -> Self {
        let boxes = (0..).zip(footprints).filter_map(|(index, footprint)| {
            let (low, high) = of(footprint)?;
            Some(GeomWithData::new(rstar::primitives::Rectangle::from_corners(low, high), index))
        });
        Self(RTree::bulk_load(boxes.collect()))
    }

    /// The footprints that touch a rectangle and `margin` around it, CRS units.
    pub fn near(&self, (low, high): Rectangle, margin: [f64; 2]) -> impl Iterator<Item = usize> + '_ {
        let (low, high) = ([low[0] - margin[0], low[1] - margin[1]], [high[0] + margin[0], high[1] + margin[1]]);
        self.0.locate_in_envelope_intersecting(&AABB::from_corners(low, high)).map(|found| found.data as usize)
    }

    /// Whether any footprint touches the rectangle.
    pub fn touches(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        self.near((low, high), [0.0; 2]).next().is_some()
    }

    /// All of them, each with its footprint.
    pub fn iter(&self) -> impl Iterator<Item = (usize, Rectangle)> + '_ {
        self.0.iter().map(|found| (found.data as usize, (found.geom().lower(), found.geom().upper())))
    }
}
