//! Which footprints and tiles must be known for the sites of a share of the footprints to be those of the whole run.
//!
//! A site depends on the points in and around its footprint; on the footprints that reach into the ring around it, for what
//! lies inside them is not its ground; and, where no ground was scanned around it, on the floors of its neighbours, which
//! depend on the rings around those. So beside a share stand its neighbours, and whatever reaches into the ring of any of
//! both.

use geo::{BoundingRect, Centroid, MultiPolygon};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::ground::neighbours::REACH;
use super::neighbourhood::SQUARE;
use super::options::SegmentOptions;
use crate::source::crs::Crs;
use crate::source::footprints::Footprint;
use crate::source::points::Tile;

/// A little more than is needed, metres: places are snapped before they are compared.
const SLACK: f64 = 1.0;

type Box = GeomWithData<Rectangle<[f64; 2]>, usize>;

/// Footprints with what is near them.
pub struct Company {
    /// The box of each footprint with its roof, CRS units; `None` of an empty one.
    boxes: Vec<Option<AABB<[f64; 2]>>>,
    tree: RTree<Box>,
    /// The middle of each footprint, metres of the CRS.
    middles: Vec<Option<[f64; 2]>>,
    by_middle: RTree<GeomWithData<[f64; 2], usize>>,
    /// How far from a footprint something is wanted, CRS units along x and y.
    reach: [f64; 2],
}

impl Company {
    /// Of all footprints of a run, in `crs`.
    pub fn new(footprints: &[Footprint], crs: &Crs, options: &SegmentOptions) -> Self {
        let metres = crs.metres_per_unit;
        let bounds = |polygon: &MultiPolygon<f64>| {
            let rect = polygon.bounding_rect()?;
            Some(AABB::from_corners([rect.min().x, rect.min().y], [rect.max().x, rect.max().y]))
        };
        let boxes: Vec<_> = footprints.iter().map(|f| bounds(f.roofprint.as_ref().unwrap_or(&f.polygon))).collect();
        let middle = |footprint: &Footprint| {
            let centre = footprint.polygon.centroid()?;
            Some([centre.x() * metres[0], centre.y() * metres[1]])
        };
        let middles: Vec<_> = footprints.iter().map(middle).collect();
        let in_tree =
            boxes.iter().enumerate().filter_map(|(index, aabb)| Some(GeomWithData::new((*aabb)?.into(), index)));
        let in_middles =
            middles.iter().enumerate().filter_map(|(index, place)| Some(GeomWithData::new((*place)?, index)));
        let reach = options.ring_limit.max(options.ring_width) + 2.0 * SQUARE + SLACK;
        Self {
            tree: RTree::bulk_load(in_tree.collect()),
            by_middle: RTree::bulk_load(in_middles.collect()),
            boxes,
            middles,
            reach: [reach / metres[0], reach / metres[1]],
        }
    }

    /// The middle of a footprint, metres of the CRS; `None` of an empty one.
    pub fn middle(&self, footprint: usize) -> Option<[f64; 2]> {
        self.middles.get(footprint).copied().flatten()
    }

    /// The footprints that must be known beside those of `share`, ascending; none of these is among them.
    pub fn beside(&self, share: &[usize]) -> Vec<usize> {
        let within = (REACH + SLACK).powi(2);
        let neighbours = share.iter().filter_map(|&index| self.middle(index));
        let neighbours = neighbours.flat_map(|middle| self.by_middle.locate_within_distance(middle, within));
        let mut with_floors: Vec<usize> = neighbours.map(|found| found.data).chain(share.iter().copied()).collect();
        sort(&mut with_floors);
        let around = with_floors.iter().filter_map(|&index| self.around(index));
        let reaching = around.flat_map(|around| self.tree.locate_in_envelope_intersecting(&around).collect::<Vec<_>>());
        let mut all: Vec<usize> = reaching.map(|found| found.data).chain(with_floors.iter().copied()).collect();
        sort(&mut all);
        let mut own = share.to_vec();
        sort(&mut own);
        all.retain(|index| own.binary_search(index).is_err());
        all
    }

    /// The tiles that the footprints of `indices` need, ascending, as places in the list that `tiles` was made of.
    pub fn tiles(&self, indices: impl IntoIterator<Item = usize>, tiles: &TileTree) -> Vec<usize> {
        let around = indices.into_iter().filter_map(|index| self.around(index));
        let touched = around.flat_map(|around| tiles.tree.locate_in_envelope_intersecting(&around).collect::<Vec<_>>());
        let mut all: Vec<usize> = touched.map(|found| found.data).chain(tiles.everywhere.iter().copied()).collect();
        sort(&mut all);
        all
    }

    /// The box of a footprint and everything around it that is wanted.
    fn around(&self, footprint: usize) -> Option<AABB<[f64; 2]>> {
        let aabb = self.boxes.get(footprint).copied().flatten()?;
        let (low, high) = (aabb.lower(), aabb.upper());
        Some(AABB::from_corners(
            [low[0] - self.reach[0], low[1] - self.reach[1]],
            [high[0] + self.reach[0], high[1] + self.reach[1]],
        ))
    }
}

/// Tiles by where their points lie.
pub struct TileTree {
    tree: RTree<Box>,
    /// Those whose points may lie anywhere.
    everywhere: Vec<usize>,
}

impl TileTree {
    /// Of these tiles, each with whether the box of its header can be relied on.
    pub fn new<'a>(tiles: impl IntoIterator<Item = (&'a Tile, bool)>) -> Self {
        let (mut boxes, mut everywhere) = (Vec::new(), Vec::new());
        for (index, (tile, is_reliable)) in tiles.into_iter().enumerate() {
            match tile.extent.filter(|_| is_reliable) {
                Some(extent) => {
                    let [low, high] = [extent.min, extent.max].map(|corner| [corner[0], corner[1]]);
                    boxes.push(GeomWithData::new(Rectangle::from_corners(low, high), index));
                }
                None if tile.points > 0 => everywhere.push(index),
                None => {}
            }
        }
        Self { tree: RTree::bulk_load(boxes), everywhere }
    }
}

fn sort(indices: &mut Vec<usize>) {
    indices.sort_unstable();
    indices.dedup();
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::source::points::Extent;

    fn square(x: f64, y: f64, side: f64) -> Footprint {
        let rect = geo::Rect::new(geo::coord! { x: x, y: y }, geo::coord! { x: x + side, y: y + side });
        Footprint {
            id: String::new(),
            polygon: MultiPolygon(vec![rect.to_polygon()]),
            roofprint: None,
            attributes: crate::source::footprints::Attributes::default(),
            notes: Vec::new(),
        }
    }

    fn metres() -> Crs {
        Crs { code: None, ..Crs::local() }
    }

    #[test]
    fn neighbours_and_what_reaches_into_their_rings_stand_beside() {
        // A small house, a hall whose middle is near and whose far end is not, a shed behind that end, and one far away.
        let all =
            [square(0.0, 0.0, 10.0), square(30.0, -60.0, 120.0), square(155.0, 0.0, 5.0), square(600.0, 0.0, 10.0)];
        let options = SegmentOptions { ring_width: 3.0, ring_limit: 20.0, ..SegmentOptions::default() };
        let company = Company::new(&all, &metres(), &options);
        assert_eq!(company.beside(&[0]), [1, 2]);
        assert_eq!(company.beside(&[3]), Vec::<usize>::new());
        assert_eq!(company.beside(&[0, 1, 2]), Vec::<usize>::new());
    }

    #[test]
    fn tiles_are_those_around_and_those_whose_place_nobody_knows() {
        let extent = |x: f64| Some(Extent { min: [x, 0.0, 0.0], max: [x + 99.0, 99.0, 9.0] });
        let tile = |x: f64| Tile::elsewhere(Path::new("t.laz"), 7, extent(x));
        let tiles = [tile(0.0), tile(100.0), tile(200.0), tile(900.0)];
        let unsure = Tile::elsewhere(Path::new("u.laz"), 7, None);
        let empty = Tile::elsewhere(Path::new("e.laz"), 0, None);
        let with_trust = tiles.iter().zip([true, true, true, false]).chain([(&unsure, true), (&empty, true)]);
        let tree = TileTree::new(with_trust);
        let options = SegmentOptions { ring_width: 3.0, ring_limit: 20.0, ..SegmentOptions::default() };
        let company = Company::new(&[square(80.0, 5.0, 10.0)], &metres(), &options);
        assert_eq!(company.tiles([0], &tree), [0, 1, 3, 4]);
    }
}
