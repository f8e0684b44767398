//! The points of all tiles in and around the buildings, with what the page colours them by.

use std::collections::HashMap;

use rayon::prelude::*;
use rstar::primitives::Rectangle;
use rstar::{AABB, RTree};

use crate::error::Result;
use crate::segment::NOISE;
use crate::source::points::Tile;

/// How far around the box of a building points are shown, metres: what stands beside a wall tells why it stands there.
const MARGIN: f64 = 3.0;
/// Side of the squares in which they lie, metres.
const SIDE: f64 = 32.0;

/// A point of a tile.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Near {
    /// Where, in the CRS.
    pub position: [f64; 3],
    /// Its ASPRS class.
    pub class: u8,
    /// Its intensity; 0 where the file has none.
    pub intensity: u16,
}

/// The points of all tiles in and around the buildings.
#[derive(Debug)]
pub(super) struct Around {
    /// Side of a square, units of the CRS.
    side: [f64; 2],
    squares: HashMap<[i64; 2], Vec<Near>>,
}

impl Around {
    /// Reads the tiles, on the threads of the current pool. `boxes` are those of the buildings in the CRS, smallest corner
    /// first. Withheld points and noise are left out.
    ///
    /// # Errors
    /// A tile cannot be read any more.
    pub fn read(tiles: &[Tile], boxes: &[[[f64; 2]; 2]], metres_per_unit: [f64; 3]) -> Result<Self> {
        let near = RTree::bulk_load(boxes.iter().map(|own| rectangle(&widened(own, metres_per_unit))).collect());
        let side = [0, 1].map(|axis| SIDE / metres_per_unit[axis]);
        let read: Vec<Vec<Near>> = tiles.par_iter().map(|tile| of_tile(tile, &near)).collect::<Result<_>>()?;
        let mut around = Self { side, squares: HashMap::new() };
        for near in read.into_iter().flatten() {
            around.squares.entry(around.square([near.position[0], near.position[1]])).or_default().push(near);
        }
        Ok(around)
    }

    /// Those in and around a box of the CRS.
    pub fn of(&self, own: [[f64; 2]; 2], metres_per_unit: [f64; 3]) -> impl Iterator<Item = &Near> {
        let [low, high] = widened(&own, metres_per_unit);
        let [from, to] = [low, high].map(|corner| self.square(corner));
        let columns = from[0]..=to[0];
        let squares = columns.flat_map(move |x| (from[1]..=to[1]).map(move |y| [x, y]));
        let is_in = move |near: &&Near| (0..2).all(|axis| (low[axis]..=high[axis]).contains(&near.position[axis]));
        squares.filter_map(|square| self.squares.get(&square)).flatten().filter(is_in)
    }

    fn square(&self, place: [f64; 2]) -> [i64; 2] {
        [0, 1].map(|axis| (place[axis] / self.side[axis]).floor() as i64)
    }
}

fn widened([low, high]: &[[f64; 2]; 2], metres_per_unit: [f64; 3]) -> [[f64; 2]; 2] {
    let margin = |axis: usize| MARGIN / metres_per_unit[axis];
    [[low[0] - margin(0), low[1] - margin(1)], [high[0] + margin(0), high[1] + margin(1)]]
}

fn rectangle([low, high]: &[[f64; 2]; 2]) -> Rectangle<[f64; 2]> {
    Rectangle::from_corners(*low, *high)
}

fn of_tile(tile: &Tile, near: &RTree<Rectangle<[f64; 2]>>) -> Result<Vec<Near>> {
    let wanted = |low: [f64; 2], high: [f64; 2]| {
        near.locate_in_envelope_intersecting(&AABB::from_corners(low, high)).next().is_some()
    };
    let mut found = Vec::new();
    // What is wrong with the tile was told when the buildings were collected.
    tile.stream_with_intensity(Some(&wanted), &mut |block| {
        for (point, intensity) in block.points_with_intensity() {
            let [x, y, _] = point.position;
            if !point.withheld && !NOISE.contains(&point.class) && near.locate_at_point(&[x, y]).is_some() {
                found.push(Near { position: point.position, class: point.class, intensity });
            }
        }
    })?;
    Ok(found)
}
