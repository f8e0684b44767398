//! How far the tiles cover a footprint.

use super::boxes::Rectangle;
use super::neighbourhood::Place;
use crate::site::{Coverage, Frame};
use crate::source::points::Extent;
use geo::{Area, BooleanOps, BoundingRect, MultiPolygon, Rect, coord, unary_union};
use rstar::primitives::GeomWithData;
use rstar::{AABB, RTree};

/// What lies farther than this from a footprint does not cover it, seams included, metres.
pub(super) const REACH: f64 = SEAM + BESIDE;

/// Edges of tiles this close to one another are taken for one edge, metres. Extents are tight around the points, so
/// tiles that were cut from one cloud have gaps of about the spacing of the points between them, and ragged sides.
const SEAM: f64 = 1.0;
/// Extents are tight around points, which lie about this far apart, metres: what is no farther outside is covered.
const BESIDE: f64 = 0.5;
/// Shares are rounded to this many steps, so that they do not hang on the last bit of an area.
const SHARE_STEPS: f64 = 1e6;

/// The rectangles that were scanned, by where they lie.
#[derive(Debug)]
pub(super) struct Covered {
    tree: RTree<GeomWithData<rstar::primitives::Rectangle<[f64; 2]>, u32>>,
    metres_per_unit: [f64; 3],
}

impl Covered {
    /// Nothing yet.
    pub fn new(metres_per_unit: [f64; 3]) -> Self {
        Self { tree: RTree::new(), metres_per_unit }
    }

    /// Takes the extents of a tile, CRS units.
    pub fn extend(&mut self, extents: Vec<Extent>) {
        for extent in extents.into_iter().filter(|extent| !extent.is_empty()) {
            let corners = [extent.min, extent.max].map(|corner| [corner[0], corner[1]]);
            let rectangle = rstar::primitives::Rectangle::from_corners(corners[0], corners[1]);
            self.tree.insert(GeomWithData::new(rectangle, self.tree.size() as u32));
        }
    }

    /// Those near a footprint, CRS units, in the order in which they came and with seams closed. What lies elsewhere makes
    /// no difference.
    pub fn near(&self, place: &Place) -> Vec<Rectangle> {
        let Some((low, high)) = place.surroundings(REACH) else { return Vec::new() };
        let mut near: Vec<(u32, Rectangle)> = self
            .tree
            .locate_in_envelope_intersecting(&AABB::from_corners(low, high))
            .map(|found| (found.data, (found.geom().lower(), found.geom().upper())))
            .collect();
        near.sort_unstable_by_key(|(order, _)| *order);
        seamless(near.into_iter().map(|(_, rectangle)| rectangle).collect(), self.metres_per_unit)
    }
}

/// Rectangles in CRS units with seams closed: edges that nearly coincide are moved outwards to the outermost of them.
fn seamless(mut rectangles: Vec<Rectangle>, metres_per_unit: [f64; 3]) -> Vec<Rectangle> {
    for axis in 0..2 {
        let seam = SEAM / metres_per_unit[axis];
        let mut edges: Vec<(f64, usize, bool)> = Vec::with_capacity(2 * rectangles.len());
        for (index, (low, high)) in rectangles.iter().enumerate() {
            edges.push((low[axis], index, false));
            edges.push((high[axis], index, true));
        }
        edges.sort_by(|a, b| a.0.total_cmp(&b.0));
        for cluster in edges.chunk_by(|a, b| b.0 - a.0 <= seam) {
            let (Some(first), Some(last)) = (cluster.first(), cluster.last()) else { continue };
            for (_, index, is_high) in cluster {
                let (low, high) = &mut rectangles[*index];
                if *is_high {
                    high[axis] = last.0;
                } else {
                    low[axis] = first.0;
                }
            }
        }
    }
    rectangles
}

/// The share of `polygon` (local metres) that lies in any of `rectangles` (CRS units).
pub(super) fn coverage(polygon: &MultiPolygon<f64>, frame: &Frame, rectangles: &[Rectangle]) -> Coverage {
    let area = polygon.unsigned_area();
    let share = match touching(polygon, frame, rectangles, 0.0) {
        Touching::All => return Coverage { share: 1.0 },
        Touching::Some(touching) if area > 0.0 => polygon.intersection(&touching).unsigned_area() / area,
        Touching::Some(_) | Touching::None => 0.0,
    };
    Coverage { share: ((share * SHARE_STEPS).round() / SHARE_STEPS).clamp(0.0, 1.0) }
}

/// The part of `polygon` (local metres) that lies in any of `rectangles` (CRS units) or just beside them, for they are
/// tight around points; `None` where that is all of it.
pub(super) fn covered(
    polygon: &MultiPolygon<f64>,
    frame: &Frame,
    rectangles: &[Rectangle],
) -> Option<MultiPolygon<f64>> {
    let covered = match touching(polygon, frame, rectangles, BESIDE) {
        Touching::All => return None,
        Touching::Some(touching) => polygon.intersection(&touching),
        Touching::None => MultiPolygon::new(Vec::new()),
    };
    let share = covered.unsigned_area() / polygon.unsigned_area();
    (!Coverage { share }.is_complete()).then_some(covered)
}

/// What of some rectangles is near a polygon.
enum Touching {
    /// One of them holds all of it.
    All,
    /// These parts, in local metres.
    Some(MultiPolygon<f64>),
    /// Nothing.
    None,
}

/// What of `rectangles`, made wider by `beside` metres, touches `polygon`.
fn touching(polygon: &MultiPolygon<f64>, frame: &Frame, rectangles: &[Rectangle], beside: f64) -> Touching {
    let Some(around) = polygon.bounding_rect() else { return Touching::None };
    let local = |place: [f64; 2], by: f64| {
        let point = frame.to_local([place[0], place[1], 0.0]);
        coord! { x: point.x + by, y: point.y + by }
    };
    let mut touching = Vec::new();
    for (low, high) in rectangles {
        let (low, high) = (local(*low, -beside), local(*high, beside));
        let (min, max) = (around.min(), around.max());
        if low.x <= min.x && low.y <= min.y && high.x >= max.x && high.y >= max.y {
            return Touching::All;
        }
        // Clipped to the surroundings of the footprint, because the grid of the overlay is relative to what it is given.
        let clipped = (
            coord! { x: low.x.max(min.x - 1.0), y: low.y.max(min.y - 1.0) },
            coord! { x: high.x.min(max.x + 1.0), y: high.y.min(max.y + 1.0) },
        );
        if clipped.0.x < clipped.1.x && clipped.0.y < clipped.1.y {
            touching.push(Rect::new(clipped.0, clipped.1).to_polygon());
        }
    }
    if touching.is_empty() { Touching::None } else { Touching::Some(unary_union(&touching)) }
}

#[cfg(test)]
mod tests {
    use super::{Rectangle, coverage, covered, seamless};
    use crate::site::Frame;
    use geo::{BoundingRect, MultiPolygon, coord, polygon};

    fn extent(x: [f64; 2], y: [f64; 2]) -> Rectangle {
        ([x[0], y[0]], [x[1], y[1]])
    }

    #[test]
    fn share_of_the_union_by_hand() {
        let square = MultiPolygon::new(vec![
            polygon![(x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 10.0, y: 10.0), (x: 0.0, y: 10.0)],
        ]);
        let frame = Frame { origin: [100.0, 200.0, 0.0], metres_per_unit: [1.0; 3] };
        let share = |rectangles: &[Rectangle]| {
            coverage(&square, &frame, &seamless(rectangles.to_vec(), frame.metres_per_unit)).share
        };
        assert_eq!(share(&[extent([90.0, 120.0], [190.0, 230.0])]), 1.0);
        assert_eq!(share(&[extent([90.0, 104.0], [190.0, 230.0])]), 0.4);
        // Two overlapping halves: 6 of 10 columns, and 3 rows of the other 4.
        assert_eq!(share(&[extent([90.0, 106.0], [190.0, 230.0]), extent([103.0, 120.0], [190.0, 203.0])]), 0.72);
        assert_eq!(share(&[extent([0.0, 50.0], [0.0, 50.0])]), 0.0);
        assert_eq!(share(&[]), 0.0);
    }

    #[test]
    fn the_covered_part_ends_just_beside_the_tile() {
        let square = MultiPolygon::new(vec![
            polygon![(x: 0.0, y: 0.0), (x: 10.0, y: 0.0), (x: 10.0, y: 10.0), (x: 0.0, y: 10.0)],
        ]);
        let frame = Frame { origin: [100.0, 200.0, 0.0], metres_per_unit: [1.0; 3] };
        let part = |x: f64| covered(&square, &frame, &seamless(vec![extent([90.0, x], [190.0, 230.0])], [1.0; 3]));
        let rect = part(104.0).and_then(|part| part.bounding_rect()).unwrap();
        assert_eq!((rect.min(), rect.max()), (coord! { x: 0.0, y: 0.0 }, coord! { x: 4.5, y: 10.0 }));
        assert_eq!(part(109.6), None);
        assert!(part(95.0).is_some_and(|part| part.0.is_empty()));
    }

    #[test]
    fn ragged_quarters_cover_like_the_whole() {
        let whole = [extent([0.0, 40.0], [0.0, 40.0])];
        let quarters = [
            extent([0.0, 19.8], [0.1, 20.0]),
            extent([20.1, 39.9], [0.0, 19.7]),
            extent([0.2, 19.6], [20.3, 40.0]),
            extent([20.0, 40.0], [20.2, 39.9]),
        ];
        let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
        for corner in [5.0, 15.0, 35.0] {
            let [a, b] = [corner, corner + 8.0];
            let square = MultiPolygon::new(vec![polygon![(x: a, y: a), (x: b, y: a), (x: b, y: b), (x: a, y: b)]]);
            let share = |rectangles: &[Rectangle]| {
                coverage(&square, &frame, &seamless(rectangles.to_vec(), frame.metres_per_unit)).share
            };
            assert_eq!(share(&whole), share(&quarters), "at {corner}");
        }
    }
}
