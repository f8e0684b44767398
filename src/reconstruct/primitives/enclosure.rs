//! Walls around a region of the roof map, for want of lines in its outline.

use nalgebra::{Point2, Vector2};

use super::PrimitiveKind;
use super::trace::Trace;

/// The four sides of the smallest rectangle around some corners of a region, points of the plan, whose sides run along one
/// of the directions `main` (unit vectors) and at right angles to it; none without corners.
///
/// The pixels of a region end half a spacing of the points beyond them on average, and so do these walls.
pub fn around(corners: &[Point2<f64>], main: &[Vector2<f64>]) -> Vec<Trace> {
    let rectangle = |along: &Vector2<f64>| {
        let across = Vector2::new(-along.y, along.x);
        let range = |axis: &Vector2<f64>| {
            corners
                .iter()
                .map(|p| axis.dot(&p.coords))
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], t| [low.min(t), high.max(t)])
        };
        let ([a, b], [c, d]) = (range(along), range(&across));
        let at = |s: f64, t: f64| Point2::from(along * s + across * t);
        ((b - a) * (d - c), [at(a, c), at(b, c), at(b, d), at(a, d)])
    };
    if corners.is_empty() {
        return Vec::new();
    }
    let smallest = main.iter().map(rectangle).min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, corners)) = smallest else { return Vec::new() };
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).filter_map(|(a, b)| Trace::between(*a, *b, PrimitiveKind::HeightJump)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rectangle_follows_the_direction_in_which_it_is_smallest() {
        let diagonal = Vector2::new(1.0, 1.0).normalize();
        let corners = [[0.0, 1.0], [1.0, 0.0], [4.0, 3.0], [3.0, 4.0], [2.0, 2.0]].map(Point2::from);
        let sides = around(&corners, &[Vector2::x(), diagonal]);
        let mut lengths: Vec<f64> = sides.iter().map(Trace::length).collect();
        lengths.sort_by(f64::total_cmp);
        let expected = [2.0_f64.sqrt(), 2.0_f64.sqrt(), 18.0_f64.sqrt(), 18.0_f64.sqrt()];
        assert!(lengths.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-9), "{lengths:?}");
        assert!(sides.iter().any(|side| side.distance(&Point2::new(0.5, 0.5)).abs() < 1e-9));
        assert!(around(&[], &[Vector2::x()]).is_empty());
    }
}
