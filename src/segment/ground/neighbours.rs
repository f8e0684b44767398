//! Floors from those of the neighbours.

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::super::lexicographic;
use super::fit::{Fit, Shape, sigma};

/// Neighbours farther than this say nothing, metres between the middles.
pub(in crate::segment) const REACH: f64 = 100.0;
/// So many of the nearest are asked …
const MOST: usize = 16;
/// … and fewer than these say nothing.
const FEWEST: usize = 3;
/// From so many on the ground may slope.
const FEWEST_SLOPED: usize = 8;
/// Where their floors lie farther from a plane than this, standard deviation in metres, they say nothing.
const MOST_UNEVEN: f64 = 1.0;

/// A floor that is known: where the middle of its building lies (metres), and its height (metres of the local frame, which
/// has no height of its own).
pub(in crate::segment) type Known = ([f64; 2], f64);

/// Floors that are known.
pub(super) struct Neighbours(RTree<GeomWithData<[f64; 2], f64>>);

impl Neighbours {
    /// The neighbours with these floors, in an order that does not depend on tiles.
    pub fn new(known: Vec<Known>) -> Self {
        Self(RTree::bulk_load(known.into_iter().map(|(place, height)| GeomWithData::new(place, height)).collect()))
    }

    /// The height at `place` of the plane through the floors of the nearest 16 buildings within 100 m, robustly (level
    /// below 8 of them), and the standard deviation about it; `None` where fewer than three are there, or where they
    /// contradict each other.
    pub fn at(&self, place: [f64; 2]) -> Option<(f64, f64)> {
        let squared = |p: &[f64; 3]| (p[0] - place[0]).powi(2) + (p[1] - place[1]).powi(2);
        let near = self.0.locate_within_distance(place, REACH * REACH);
        let mut near: Vec<[f64; 3]> = near.map(|floor| [floor.geom()[0], floor.geom()[1], floor.data]).collect();
        // Of those that are equally near, which ones come first must not hang on who else is in the tree.
        near.sort_unstable_by(|a, b| squared(a).total_cmp(&squared(b)).then_with(|| lexicographic(a, b)));
        let floors: Vec<([f64; 3], f64)> = near.into_iter().take(MOST).map(|floor| (floor, 1.0)).collect();
        if floors.len() < FEWEST {
            return None;
        }
        let shape = if floors.len() < FEWEST_SLOPED { Shape::Level } else { Shape::Plane };
        let fit = Fit::of(&floors, place, shape)?;
        let spread = sigma(floors.iter().map(|(p, _)| p[2] - fit.at([p[0], p[1]])));
        (spread <= MOST_UNEVEN).then(|| (fit.at(place), spread))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_plane_through_the_neighbours_holds_in_spite_of_a_wrong_one() {
        let slope = |x: f64, y: f64| 10.0 + 0.03 * x - 0.01 * y;
        let mut known: Vec<Known> = (0..12)
            .map(|i| (f64::from(i % 4) * 20.0, f64::from(i / 4) * 20.0))
            .map(|(x, y)| ([x, y], slope(x, y)))
            .collect();
        known[5].1 += 6.0;
        let (height, spread) = Neighbours::new(known.clone()).at([30.0, 25.0]).unwrap();
        assert!((height - slope(30.0, 25.0)).abs() < 0.02 && spread < 0.05, "{height} {spread}");
        let neighbours = Neighbours::new(known.split_off(10));
        assert_eq!((neighbours.at([30.0, 25.0]), neighbours.at([900.0, 0.0])), (None, None));
        // Twenty that are equally near, of which sixteen are asked: the same ones whoever else is known farther away.
        let ring = |i: u32| {
            let angle = f64::from(i % 4) * std::f64::consts::FRAC_PI_2;
            ([(30.0 * angle.cos()).round(), (30.0 * angle.sin()).round()], f64::from(i) * 0.01)
        };
        let near: Vec<Known> = (0..20).map(ring).collect();
        let far = (0..500).map(|i| ([f64::from(i % 25) * 9.0 + 200.0, f64::from(i / 25) * 9.0], 3.0));
        let many: Vec<Known> = far.chain(near.iter().rev().copied()).collect();
        assert_eq!(Neighbours::new(near).at([0.0; 2]), Neighbours::new(many).at([0.0; 2]));
        let uneven = vec![([0.0; 2], 0.0), ([9.0, 0.0], 5.0), ([0.0, 9.0], 12.0)];
        assert_eq!(Neighbours::new(uneven).at([1.0; 2]), None);
    }
}
