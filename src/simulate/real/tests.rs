use geo::{Area, LineString, MultiPolygon, Polygon};
use nalgebra::Point3;

use super::super::options::ScanOptions;
use super::super::span::Span;
use super::*;
use crate::site::Frame;

/// A house of 10 m by 8 m on ground at 0, scanned every half metre: the west half is a flat roof at 3 m, the east half rises
/// from 5 m at x = 5 m by 1 m per metre. In the north-west corner, 3 m by 3 m, only the ground was seen; in the south-east one
/// nothing. A row of points lies on the wall between the halves.
pub fn real(id: &str, tile: &str) -> RealSite {
    let (mut points, mut open) = (Vec::new(), Vec::new());
    for column in 0..20 {
        for row in 0..16 {
            let (x, y) = (0.25 + 0.5 * f64::from(column), 0.25 + 0.5 * f64::from(row));
            match (x, y) {
                (..3.0, 5.0..) => open.push(Point3::new(x, y, 0.02)),
                (7.0.., ..3.0) => {}
                (..5.0, _) => points.push(Point3::new(x, y, 3.0)),
                _ => points.push(Point3::new(x, y, x)),
            }
        }
    }
    points.extend((0..16).map(|row| Point3::new(5.0, 0.25 + 0.5 * f64::from(row), 4.0)));
    let ring = LineString::from(vec![(0.0, 0.0), (10.0, 0.0), (10.0, 8.0), (0.0, 8.0), (0.0, 0.0)]);
    let mut site = Site::new(id, Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] }, points, 0.0)
        .with_footprint(&MultiPolygon(vec![Polygon::new(ring, Vec::new())]));
    site.ground_points = open;
    RealSite { tile: tile.into(), site }
}

#[test]
fn what_was_scanned_is_known_and_the_rest_is_not() {
    let seen = Seen::new(&real("house", "tile")).unwrap();
    let inside = |x, y, z| seen.is_inside(&Point3::new(x, y, z));
    // Under and over the flat roof, and within the noise of it.
    assert_eq!([2.5, 3.5, 3.02].map(|z| inside(2.0, 2.0, z)), [Some(true), Some(false), None]);
    // The slope is known as sharply where it is even.
    assert_eq!([6.8, 7.2].map(|z| inside(7.0, 6.0, z)), [Some(true), Some(false)]);
    // At the jump between the halves the heights of both are told, but not which of them holds; the points on the wall are
    // no roof.
    assert_eq!([2.5, 4.0, 5.7].map(|z| inside(4.9, 4.0, z)), [Some(true), None, Some(false)]);
    // Open ground.
    assert_eq!([0.1, 1.0, 2.0].map(|z| inside(1.5, 6.5, z)), [None, Some(false), Some(false)]);
    // Not scanned, too near the outline, near the ground, below it.
    assert_eq!(inside(9.0, 1.0, 2.0), None);
    assert_eq!(inside(0.2, 2.0, 2.0), None);
    assert_eq!(inside(2.0, 2.0, 0.1), None);
    assert_eq!(inside(2.0, 2.0, -1.0), Some(false));
    // Along the vertical, less the noise.
    assert!((seen.clearance(&Point3::new(2.0, 2.0, 1.0)) - 1.92).abs() < 1e-9);
    assert_eq!(seen.clearance(&Point3::new(9.0, 1.0, 1.0)), 0.0);
}

#[test]
fn turning_keeps_the_truth() {
    let real = real("house", "tile");
    let seen = Seen::new(&real).unwrap();
    let mut mirrored = 0;
    for seed in 0..10 {
        let turned = real.turned(&mut Random::new(seed));
        let outline = turned.site.footprint.as_ref().unwrap();
        assert!((outline.signed_area() - 80.0).abs() < 1e-9, "exteriors stay counter-clockwise");
        let again = Seen::new(&turned).unwrap();
        // Points keep their order, so that pairs of them tell where a place went.
        let [a, b, c] = [0, 40, 100].map(|i| (real.site.points[i], turned.site.points[i]));
        let side = |[a, b, c]: [Point3<f64>; 3]| (b - a).cross(&(c - a)).z.signum();
        mirrored += usize::from(side([a.0, b.0, c.0]) != side([a.1, b.1, c.1]));
        for (before, after) in real.site.points.iter().zip(&turned.site.points) {
            for height in [-1.0, 1.0] {
                let moved = |p: &Point3<f64>| Point3::new(p.x, p.y, p.z + height);
                let [here, there] = [seen.is_inside(&moved(before)), again.is_inside(&moved(after))];
                assert_eq!(here, there, "{before}");
            }
        }
    }
    assert!((1..10).contains(&mirrored));
}

#[test]
fn a_copy_is_thinner_and_has_holes() {
    let real = real("house", "tile");
    let plain = ScanOptions { density: Span::fixed(100.0), ..ScanOptions::clean() };
    let found = real.site.points.len() as f64;
    let copy = |options: &ScanOptions, seed: u64| real.copy("copy", options, &mut Random::new(seed));
    let [dense, again, other] = [1, 1, 2].map(|seed| copy(&plain, seed));
    assert_eq!(dense.points, again.points);
    assert_ne!(dense.points, other.points);
    // Four fifths at most, however dense it shall be; five standard deviations.
    assert!((dense.points.len() as f64 / found - 0.8).abs() < 0.12, "{} of {found}", dense.points.len());
    assert!(dense.points.iter().all(|p| real.site.points.contains(p)));
    assert_eq!((dense.footprint.as_ref(), dense.ground.height), (real.site.footprint.as_ref(), 0.0));
    let thin = copy(&ScanOptions { density: Span::fixed(1.0), ..plain.clone() }, 3);
    assert!((55..110).contains(&thin.points.len()), "1 per m² of 80 m²: {}", thin.points.len());
    let holed = ScanOptions { hole_chance: 1.0, hole_radius: Span::fixed(2.0), ..plain.clone() };
    let holed = copy(&holed, 4);
    let gap = real.site.points.iter().any(|p| holed.points.iter().all(|q| (q.xy() - p.xy()).norm() > 1.5));
    assert!(gap, "no hole");
    let cropped = copy(&ScanOptions { missing_chance: 1.0, roof_missing: Span::fixed(0.5), ..plain }, 5);
    assert!((cropped.points.len() as f64 / found - 0.4).abs() < 0.1, "{}", cropped.points.len());
}
