//! The ground as a surface: as simple as its points allow.

use std::cell::RefCell;

use rstar::RTree;
use rstar::primitives::GeomWithData;

use super::fit::{Fit, LEAST_NOISE, Shape, loss, sigma};

/// Points of the smallest neighbourhood through which a plane of its own is laid …
const FEWEST_NEAR: usize = 12;
/// … and most of the largest; each has four times as many as the one before.
const MOST_NEAR: usize = 192;
/// From so many points on the ground may slope.
const FEWEST_SLOPED: usize = 8;
/// Most points at which the surfaces are compared.
const MOST_ASKED: usize = 96;
/// A level or a plane that the points leave by no more than this, standard deviation in metres, is not asked for more: nothing
/// is to be gained but the noise of a scanner.
const GOOD: f64 = 0.03;
/// A simpler surface is taken until it is worse by more than so many standard errors …
const STANDARD_ERRORS: f64 = 2.0;
/// … or more than this share of the points is not of it at all: then the ground has several levels.
const MOST_LEFT_OUT: f64 = 0.25;

/// How the height of a place follows from the points.
#[derive(Debug, Clone, Copy)]
enum Form {
    /// One plane, level or sloped.
    Whole(Fit),
    /// Around every place, the plane through so many of the nearest points, near ones counting more.
    Near(usize),
}

type Tree = RTree<GeomWithData<[f64; 2], f64>>;

/// A surface through ground points.
pub(super) struct Surface {
    form: Form,
    /// The plane through all points, whether it is the surface or not.
    plane: Fit,
    tree: Tree,
    /// What a neighbourhood is gathered in.
    near: RefCell<Vec<([f64; 3], f64)>>,
}

impl Surface {
    /// The surface through `points`, local metres; `None` without any. The order of the points matters not.
    ///
    /// It is level, or a plane, or a plane around every place, of 12, 48 or 192 of the points. Each
    /// is asked for the height of points that it was not fitted to (for the whole planes it makes no difference); what it
    /// is off counts by the biweight, so that no pit or wall decides. The simplest is taken that is not worse than the
    /// best by more than twice the standard error of the difference and leaves no more than a quarter of the points out; a
    /// level or a plane as good as a scanner is taken at once. So flat ground gets one height from all its points,
    /// whatever the noise, and terraces and ramps each their own.
    pub fn of(mut points: Vec<[f64; 3]>) -> Option<Self> {
        points.sort_unstable_by(crate::segment::lexicographic);
        points.dedup();
        let weighted: Vec<([f64; 3], f64)> = points.iter().map(|p| (*p, 1.0)).collect();
        let count = points.len() as f64;
        let middle = [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / count.max(1.0));
        let level = Fit::of(&weighted, middle, Shape::Level)?;
        let plane = if points.len() < FEWEST_SLOPED { level } else { Fit::of(&weighted, middle, Shape::Plane)? };
        let places = points.iter().map(|p| GeomWithData::new([p[0], p[1]], p[2]));
        let tree = RTree::bulk_load(places.collect());
        let mut surface = Self { form: Form::Whole(level), plane, tree, near: RefCell::default() };
        if points.len() < FEWEST_SLOPED {
            return Some(surface);
        }
        let asked: Vec<&[f64; 3]> = points.iter().step_by(points.len().div_ceil(MOST_ASKED)).collect();
        let is_good = |form: &Form| {
            let off = surface.off(*form, &asked);
            let noise = sigma(off.iter().copied()).max(LEAST_NOISE);
            let left_out = off.iter().filter(|off| loss(**off, noise) >= 1.0).count() as f64;
            noise <= GOOD && left_out <= MOST_LEFT_OUT * off.len() as f64
        };
        if let Some(form) = [Form::Whole(level), Form::Whole(plane)].into_iter().find(is_good) {
            surface.form = form;
            return Some(surface);
        }
        let sizes = std::iter::successors(Some(FEWEST_NEAR), |size| Some(4 * size));
        let sizes = sizes.take_while(|size| *size <= MOST_NEAR.min(points.len() / 2)).map(Form::Near);
        let mut forms: Vec<Form> = sizes.collect();
        forms.extend([Form::Whole(plane), Form::Whole(level)]);
        forms.reverse();
        let off: Vec<Vec<f64>> = forms.iter().map(|form| surface.off(*form, &asked)).collect();
        let noise = off.iter().map(|off| sigma(off.iter().copied())).fold(f64::MAX, f64::min).max(LEAST_NOISE);
        let losses: Vec<Vec<f64>> = off.iter().map(|off| off.iter().map(|off| loss(*off, noise)).collect()).collect();
        let best = losses.iter().min_by(|a, b| mean(a).total_cmp(&mean(b)))?;
        let simplest = losses.iter().position(|losses| {
            let more: Vec<f64> = losses.iter().zip(best).map(|(a, b)| a - b).collect();
            let mean = mean(&more);
            let variance = more.iter().map(|more| (more - mean).powi(2)).sum::<f64>() / more.len() as f64;
            let left_out = losses.iter().filter(|loss| **loss >= 1.0).count() as f64 / losses.len() as f64;
            left_out <= MOST_LEFT_OUT && mean <= STANDARD_ERRORS * (variance / more.len() as f64).sqrt()
        });
        let best = losses.iter().position(|losses| std::ptr::eq(losses, best));
        surface.form = simplest.or(best).and_then(|index| forms.get(index).copied()).unwrap_or(Form::Whole(level));
        Some(surface)
    }

    /// Its height at a place.
    pub fn at(&self, place: [f64; 2]) -> f64 {
        self.height(self.form, place, false).unwrap_or_else(|| self.plane.at(place))
    }

    /// The height of the plane through all of its points.
    pub fn plane_at(&self, place: [f64; 2]) -> f64 {
        self.plane.at(place)
    }

    /// Distance from a place to the nearest point, metres.
    pub fn distance(&self, place: [f64; 2]) -> f64 {
        let nearest = self.tree.nearest_neighbor_iter_with_distance_2(&place).next();
        nearest.map_or(f64::INFINITY, |(_, squared)| squared.sqrt())
    }

    /// How far points lie above the surface of another form that does not know them.
    fn off(&self, form: Form, points: &[&[f64; 3]]) -> Vec<f64> {
        let off = |p: &&[f64; 3]| Some(p[2] - self.height(form, [p[0], p[1]], true)?);
        points.iter().map(|point| off(point).unwrap_or(0.0)).collect()
    }

    /// The height at a place; `blind` to a point there, where near points alone decide.
    fn height(&self, form: Form, place: [f64; 2], blind: bool) -> Option<f64> {
        let count = match form {
            Form::Whole(fit) => return Some(fit.at(place)),
            Form::Near(count) => count,
        };
        let mut near = self.near.borrow_mut();
        near.clear();
        let found = self.tree.nearest_neighbor_iter_with_distance_2(&place);
        let found = found.filter(|(_, squared)| !blind || *squared > 0.0).take(count + 1);
        near.extend(found.map(|(point, squared)| ([point.geom()[0], point.geom()[1], point.data], squared)));
        // Tricube, with the one beyond the neighbourhood as its rim.
        let rim = near.last()?.1.max(f64::MIN_POSITIVE).sqrt();
        for (_, weight) in near.iter_mut() {
            *weight = (1.0 - (weight.sqrt() / rim).powi(3)).max(0.0).powi(3);
        }
        Fit::of(&near, place, Shape::Plane).map(|fit| fit.at(place))
    }
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Random;

    /// Points of a ring of 3 m around a square of 10 m, one each square metre, on what `height` says.
    fn ring(seed: u64, noise: f64, height: impl Fn(f64, f64) -> f64) -> Vec<[f64; 3]> {
        let mut random = Random::new(seed);
        let mut points = Vec::new();
        for column in 0..16 {
            for row in 0..16 {
                let (x, y) = (f64::from(column) - 3.0 + random.unit(), f64::from(row) - 3.0 + random.unit());
                if !((0.0..10.0).contains(&x) && (0.0..10.0).contains(&y)) {
                    points.push([x, y, height(x, y) + noise * random.bell()]);
                }
            }
        }
        points
    }

    #[test]
    fn flat_ground_is_as_sure_as_all_of_its_points() {
        for seed in 0..20 {
            let surface = Surface::of(ring(seed, 0.03, |_, _| 2.0)).unwrap();
            for place in [[0.0, 0.0], [5.0, 0.0], [10.0, 10.0]] {
                assert!((surface.at(place) - 2.0).abs() < 0.015, "{seed} {place:?} {}", surface.at(place));
            }
        }
    }

    #[test]
    fn slopes_terraces_and_ramps_keep_their_shape() {
        let at = |height: fn(f64, f64) -> f64, place: [f64; 2]| {
            let surface = Surface::of(ring(3, 0.03, height)).unwrap();
            (surface.at(place), height(place[0], place[1]))
        };
        let slope = |x: f64, _: f64| 1.0 - x;
        let terrace = |_: f64, y: f64| if y < 5.0 { 0.0 } else { 2.0 };
        let ramp = |x: f64, y: f64| if y < 0.0 { 0.15 * x.max(0.0) } else { 0.0 };
        for (height, place) in [
            (slope as fn(f64, f64) -> f64, [10.0, 5.0]),
            (slope, [0.0, 5.0]),
            (terrace, [5.0, 0.0]),
            (terrace, [5.0, 10.0]),
            (terrace, [0.0, 1.0]),
            (ramp, [8.0, -0.5]),
            (ramp, [5.0, 10.0]),
        ] {
            let (found, expected) = at(height, place);
            assert!((found - expected).abs() < 0.12, "{place:?} {found} {expected}");
        }
    }

    #[test]
    fn a_few_points_give_their_middle_and_none_nothing() {
        let points = vec![[0.0, 0.0, 1.0], [1.0, 0.0, 1.2], [0.0, 4.0, 1.1], [9.0, 1.0, -30.0]];
        let surface = Surface::of(points).unwrap();
        assert!((surface.at([3.0, 3.0]) - 1.1).abs() < 0.1, "{}", surface.at([3.0, 3.0]));
        assert!((surface.distance([1.0, 2.0]) - 2.0).abs() < 1e-9);
        assert!(Surface::of(Vec::new()).is_none());
    }

    #[test]
    fn the_order_of_the_points_changes_nothing() {
        let mut points = ring(5, 0.05, |x, y| 0.02 * x * y);
        let expected = Surface::of(points.clone()).unwrap().at([10.0, 5.0]);
        points.reverse();
        points.extend_from_slice(&points.clone()[..20]);
        assert_eq!(Surface::of(points).unwrap().at([10.0, 5.0]).to_bits(), expected.to_bits());
    }
}
