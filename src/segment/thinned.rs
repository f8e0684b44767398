//! One point per cell: independent of order, tiling and duplicates.
//!
//! Cells are kept in blocks, so that a footprint far from all points costs a handful of look-ups, whatever its size.

use foldhash::fast::RandomState;
use std::cmp::Ordering;
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// Cells along the side of a block; a block has as many as a `u64` has bits.
const BLOCK: i32 = 8;
const CELLS: usize = (BLOCK * BLOCK) as usize;

/// Which point of a cell stands for it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Choice {
    /// The one nearest to the centre.
    Central,
    /// The lowest.
    Lowest,
}

/// One point per cell, in snapped CRS units.
#[derive(Debug)]
pub(super) struct Thinned {
    choice: Choice,
    /// Side of a cell, metres.
    metres: f64,
    /// Side of a cell, CRS units.
    side: [f64; 2],
    blocks: HashMap<[i32; 2], Box<Block>, RandomState>,
}

/// The points of neighbouring cells.
#[derive(Debug)]
struct Block {
    /// A bit for each cell that has a point.
    present: u64,
    points: [[f64; 3]; CELLS],
}

impl Block {
    /// The cells that have a point, with it; `key` is the block's own.
    fn cells(&self, key: [i32; 2]) -> impl Iterator<Item = ([i32; 2], [f64; 3])> + '_ {
        let present = (0..CELLS).filter(|slot| self.present >> slot & 1 == 1);
        present.map(move |slot| {
            let (column, row) = (slot as i32 % BLOCK, slot as i32 / BLOCK);
            ([key[0] * BLOCK + column, key[1] * BLOCK + row], self.points[slot])
        })
    }
}

impl Thinned {
    /// No point yet; cells of so many metres.
    pub fn new(choice: Choice, metres: f64, metres_per_unit: [f64; 3]) -> Self {
        let side = [metres / metres_per_unit[0], metres / metres_per_unit[1]];
        Self { choice, metres, side, blocks: HashMap::default() }
    }

    /// Takes a point, in snapped CRS units, if it stands for its cell better than the one that does.
    pub fn add(&mut self, point: [f64; 3]) {
        let cell = self.cell([point[0], point[1]]);
        let slot = (cell[1].rem_euclid(BLOCK) * BLOCK + cell[0].rem_euclid(BLOCK)) as usize;
        let empty = || Box::new(Block { present: 0, points: [[0.0; 3]; CELLS] });
        let block = self.blocks.entry(block_of(cell)).or_insert_with(empty);
        let is_taken = block.present >> slot & 1 == 1;
        if !is_taken || rank(self.choice, self.side, cell, point, block.points[slot]) == Ordering::Less {
            block.points[slot] = point;
            block.present |= 1 << slot;
        }
    }

    /// Takes over what another one kept.
    pub fn merge(&mut self, other: Self) {
        // The order of iteration does not matter: the best of a cell is the best in any order.
        for (key, block) in other.blocks {
            match self.blocks.entry(key) {
                Entry::Vacant(slot) => {
                    slot.insert(block);
                }
                Entry::Occupied(_) => block.cells(key).for_each(|(_, point)| self.add(point)),
            }
        }
    }

    /// Forgets all points in some squares of `side` metres, which is a whole number of blocks; `squares` are their columns and rows.
    pub fn forget(&mut self, squares: &[[i32; 2]], side: f64) {
        let blocks = (side / (self.metres * f64::from(BLOCK))).round() as i32;
        for square in squares {
            for row in 0..blocks {
                for column in 0..blocks {
                    self.blocks.remove(&[square[0] * blocks + column, square[1] * blocks + row]);
                }
            }
        }
    }

    /// All points, in no particular order.
    pub fn points(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        self.blocks.iter().flat_map(|(key, block)| block.cells(*key)).map(|(_, point)| point)
    }

    /// The points in the cells that touch the rectangle, in no particular order.
    pub fn within(&self, low: [f64; 2], high: [f64; 2]) -> Vec<[f64; 3]> {
        let (first, last) = (self.cell(low), self.cell(high));
        let touches = |cell: [i32; 2]| (0..2).all(|axis| (first[axis]..=last[axis]).contains(&cell[axis]));
        let mut found = Vec::new();
        let mut take = |key: [i32; 2], block: &Block| {
            found.extend(block.cells(key).filter(|(cell, _)| touches(*cell)).map(|(_, point)| point));
        };
        let (from, to) = (block_of(first), block_of(last));
        let sides = [0, 1].map(|axis| i64::from(to[axis]) - i64::from(from[axis]) + 1);
        // Footprints as wide as a country exist, by mistake or not: then it is faster to go through what there is.
        if sides[0].saturating_mul(sides[1]) > self.blocks.len() as i64 {
            self.blocks.iter().for_each(|(key, block)| take(*key, block));
            return found;
        }
        for row in from[1]..=to[1] {
            for column in from[0]..=to[0] {
                if let Some(block) = self.blocks.get(&[column, row]) {
                    take([column, row], block);
                }
            }
        }
        found
    }

    fn cell(&self, place: [f64; 2]) -> [i32; 2] {
        [0, 1].map(|axis| (place[axis] / self.side[axis]).floor() as i32)
    }
}

/// The block of a cell.
fn block_of(cell: [i32; 2]) -> [i32; 2] {
    cell.map(|c| c.div_euclid(BLOCK))
}

/// Whether `a` stands better (less) or worse (greater) for `cell` than `b`; equal only for equal points.
fn rank(choice: Choice, side: [f64; 2], cell: [i32; 2], a: [f64; 3], b: [f64; 3]) -> Ordering {
    let merit = |point: [f64; 3]| match choice {
        Choice::Lowest => point[2],
        Choice::Central => {
            let off: [f64; 2] = std::array::from_fn(|axis| point[axis] - (f64::from(cell[axis]) + 0.5) * side[axis]);
            off[0] * off[0] + off[1] * off[1]
        }
    };
    let coordinates = || a.iter().zip(&b).map(|(a, b)| a.total_cmp(b)).find(|order| order.is_ne());
    merit(a).total_cmp(&merit(b)).then_with(|| coordinates().unwrap_or(Ordering::Equal))
}

#[cfg(test)]
mod tests {
    use super::{Choice, Thinned};

    #[test]
    fn a_cell_is_represented_the_same_in_any_order_and_with_duplicates() {
        let points = [[0.4, 0.5, 3.0], [0.6, 0.5, 1.0], [0.1, 0.9, 0.5], [0.4, 0.5, 2.0]];
        for choice in [Choice::Central, Choice::Lowest] {
            let thin = |order: &[usize]| {
                let mut thinned = Thinned::new(choice, 1.0, [1.0; 3]);
                for i in order {
                    thinned.add(points[*i]);
                }
                thinned.within([0.0; 2], [0.9; 2])
            };
            let expected = if choice == Choice::Central { [0.4, 0.5, 2.0] } else { [0.1, 0.9, 0.5] };
            for order in [&[0, 1, 2, 3][..], &[3, 2, 1, 0], &[1, 3, 0, 2, 2, 1, 0, 3]] {
                assert_eq!(thin(order), [expected]);
            }
        }
    }

    #[test]
    fn rectangles_give_what_their_cells_hold_on_both_sides_of_the_origin() {
        let mut thinned = Thinned::new(Choice::Lowest, 2.0, [1.0; 3]);
        let mut halves = [Thinned::new(Choice::Lowest, 2.0, [1.0; 3]), Thinned::new(Choice::Lowest, 2.0, [1.0; 3])];
        for i in -40..40 {
            for j in -40..40 {
                let point = [f64::from(i) + 0.25, f64::from(j) + 0.25, f64::from((i * 7 + j * 13) % 11)];
                thinned.add(point);
                halves[usize::from((i + j) % 3 == 0)].add(point);
            }
        }
        let [mut whole, other] = halves;
        whole.merge(other);
        for (low, high) in [([-5.0, -3.0], [7.0, 4.0]), ([-90.0, -90.0], [90.0, 90.0]), ([38.5, 50.0], [60.0, 60.0])] {
            let sorted = |thinned: &Thinned| {
                let mut found = thinned.within(low, high);
                found.sort_unstable_by(|a, b| a.partial_cmp(b).unwrap());
                found
            };
            let cells = |axis: usize| {
                let (first, last) =
                    ((low[axis] / 2.0_f64).floor().max(-20.0), (high[axis] / 2.0_f64).floor().min(19.0));
                (last - first + 1.0).max(0.0) as usize
            };
            assert_eq!(sorted(&thinned).len(), cells(0) * cells(1), "{low:?} {high:?}");
            assert_eq!(sorted(&thinned), sorted(&whole));
        }
    }
}
