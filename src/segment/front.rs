//! How far a sweep has come: which footprints wait for which tiles, and which ground nobody asks for any more.

use std::collections::HashMap;

use foldhash::fast::RandomState;

use super::boxes::Rectangle;
use super::neighbourhood::{Neighbourhood, Place};

/// Side of the squares of which the ground is forgotten once nobody asks for it any more, metres: a whole number of blocks
/// of [`Thinned`](super::thinned::Thinned), whatever its cells.
pub(super) const SQUARE: f64 = 64.0;
/// Where a footprint touches more squares than this, nothing is forgotten: to count them would take longer.
const MOST_SQUARES: usize = 1 << 14;

/// What has been read and what has not.
pub(super) struct Front {
    /// Tiles to come that may hold points of anywhere.
    pub(super) everywhere: usize,
    /// Other tiles to come around each footprint.
    pub(super) left: Vec<u32>,
    /// Footprints that were handed out: nothing is to come for them.
    pub(super) is_handed_out: Vec<bool>,
    /// How many footprints that are not done may ask for the ground of a square.
    asked: HashMap<[i32; 2], u32, RandomState>,
    /// Whether what nobody asks for is forgotten.
    forgets: bool,
    /// Squares that nobody asks for any more.
    pub(super) forgotten: Vec<[i32; 2]>,
}

impl Front {
    /// Nothing has been read. So many tiles may hold points of anywhere, and so many others of each footprint; `margin` is
    /// how far around a footprint they matter, CRS units.
    pub(super) fn new(
        everywhere: usize,
        left: Vec<u32>,
        all: &Neighbourhood,
        margin: [f64; 2],
        metres_per_unit: [f64; 3],
    ) -> Self {
        let is_handed_out = vec![false; left.len()];
        let (asked, forgotten) = (HashMap::default(), Vec::new());
        let mut front = Self { everywhere, left, is_handed_out, asked, forgets: true, forgotten };
        for (_, rectangle) in all.boxes.iter() {
            let squares = squares(rectangle, margin, metres_per_unit);
            front.forgets &= squares.clone().take(MOST_SQUARES + 1).count() <= MOST_SQUARES;
            if !front.forgets {
                front.asked.clear();
                break;
            }
            squares.for_each(|square| *front.asked.entry(square).or_default() += 1);
        }
        front
    }

    /// Nobody asks any more for the ground around a footprint.
    pub(super) fn looked(&mut self, place: &Place, margin: [f64; 2], metres_per_unit: [f64; 3]) {
        if !self.forgets {
            return;
        }
        for square in place.bounds.into_iter().flat_map(|own| squares(own, margin, metres_per_unit)) {
            let Some(asked) = self.asked.get_mut(&square) else { continue };
            *asked = asked.saturating_sub(1);
            if *asked == 0 {
                self.asked.remove(&square);
                self.forgotten.push(square);
            }
        }
    }
}

/// The squares that a rectangle and a margin around it touch.
fn squares(
    (low, high): Rectangle,
    margin: [f64; 2],
    metres_per_unit: [f64; 3],
) -> impl Iterator<Item = [i32; 2]> + Clone {
    let side = [0, 1].map(|axis| SQUARE / metres_per_unit[axis]);
    let of = |axis: usize, value: f64| (value / side[axis]).floor() as i32;
    let [columns, rows] = [0, 1].map(|axis| of(axis, low[axis] - margin[axis])..=of(axis, high[axis] + margin[axis]));
    columns.flat_map(move |column| rows.clone().map(move |row| [column, row]))
}
