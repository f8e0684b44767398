//! Rings that real data has, each with the answer worked out by hand.

use geo::{Area, Coord, MultiPolygon, Validation, Winding};
use proptest::prelude::*;

use super::{Outline, Ring};

fn ring(points: &[(f64, f64)]) -> Ring {
    points.iter().map(|&p| Coord::from(p)).collect()
}

fn square(x: f64, y: f64, side: f64) -> Ring {
    ring(&[(x, y), (x + side, y), (x + side, y + side), (x, y + side), (x, y)])
}

fn valid(polygons: Vec<Vec<Ring>>) -> (MultiPolygon<f64>, Vec<String>) {
    let (polygon, notes) = Outline { polygons, notes: Vec::new() }.into_valid().unwrap();
    assert!(polygon.is_valid(), "{polygon:?}");
    assert!(polygon.iter().all(|p| p.exterior().is_ccw()));
    (polygon, notes)
}

#[track_caller]
fn assert_repaired(polygons: Vec<Vec<Ring>>, parts: usize, area: f64) {
    let (polygon, notes) = valid(polygons);
    assert_eq!(polygon.0.len(), parts, "{polygon:?}");
    assert!((polygon.unsigned_area() - area).abs() < 1e-6 * area, "{} is not {area}", polygon.unsigned_area());
    assert!(!notes.is_empty());
}

#[test]
fn what_is_valid_keeps_every_bit() {
    let exterior = ring(&[(0.1, 0.2), (9.7, 0.3), (9.9, 9.1), (0.1, 0.2)]);
    let (polygon, notes) = valid(vec![vec![exterior.clone()]]);
    assert!(notes.is_empty() && polygon.0[0].exterior().0 == exterior);
    // Clockwise is valid too, but is turned.
    let (turned, notes) = valid(vec![vec![exterior.iter().rev().copied().collect()]]);
    assert!(notes.is_empty() && turned.unsigned_area() == polygon.unsigned_area());
    // A hole that touches its exterior in one point is valid.
    let (polygon, notes) =
        valid(vec![vec![square(0.0, 0.0, 4.0), ring(&[(0.0, 2.0), (2.0, 1.0), (2.0, 3.0), (0.0, 2.0)])]]);
    assert!(notes.is_empty() && polygon.0[0].interiors().len() == 1);
}

#[test]
fn a_repair_has_no_choice() {
    let star: Vec<(f64, f64)> = (0..12)
        .map(|i| f64::from(i * 5 % 12) * std::f64::consts::TAU / 12.0)
        .map(|angle| (9.0 + 8.0 * angle.cos(), 9.0 + 8.0 * angle.sin()))
        .collect();
    let closed = ring(&star.iter().chain(&star[..1]).copied().collect::<Vec<_>>());
    let first = valid(vec![vec![closed.clone(), square(8.0, 8.0, 0.5)]]);
    assert!(first.0.0.len() > 1);
    for _ in 0..20 {
        assert_eq!(valid(vec![vec![closed.clone(), square(8.0, 8.0, 0.5)]]), first);
    }
}

#[test]
fn rings_are_mended() {
    // Open, and with a vertex twice.
    assert_repaired(vec![vec![ring(&[(0.0, 0.0), (4.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)])]], 1, 16.0);
    // A bow-tie of two triangles of base 4 and height 2.
    assert_repaired(vec![vec![ring(&[(0.0, 0.0), (4.0, 4.0), (4.0, 0.0), (0.0, 4.0), (0.0, 0.0)])]], 2, 8.0);
    // A spike out of a corner and one along an edge.
    assert_repaired(
        vec![vec![ring(&[(0.0, 0.0), (4.0, 0.0), (9.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0), (0.0, 0.0)])]],
        1,
        16.0,
    );
    assert_repaired(
        vec![vec![ring(&[(0.0, 0.0), (9.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0), (0.0, 0.0)])]],
        1,
        16.0,
    );
    // An exterior that encloses its hole by touching itself.
    let banana =
        [(0.0, 0.0), (8.0, 0.0), (8.0, 8.0), (0.0, 8.0), (0.0, 0.0), (2.0, 6.0), (6.0, 6.0), (6.0, 2.0), (0.0, 0.0)];
    assert_repaired(vec![vec![ring(&banana)]], 1, 64.0 - 24.0);
    // A ring that runs around twice.
    let twice: Ring = square(0.0, 0.0, 3.0).into_iter().chain(square(0.0, 0.0, 3.0)).collect();
    assert_repaired(vec![vec![twice]], 1, 9.0);
}

#[test]
fn holes_are_subtracted_and_nothing_else() {
    let exterior = square(0.0, 0.0, 10.0);
    assert_repaired(vec![vec![exterior.clone(), square(20.0, 0.0, 2.0)]], 1, 100.0);
    assert_repaired(vec![vec![exterior.clone(), square(8.0, 1.0, 4.0)]], 1, 100.0 - 8.0);
    assert_repaired(vec![vec![exterior.clone(), square(0.0, 1.0, 4.0)]], 1, 100.0 - 16.0);
    assert_repaired(vec![vec![exterior, square(2.0, 2.0, 4.0), square(4.0, 4.0, 4.0)]], 1, 100.0 - 28.0);
}

#[test]
fn parts_that_overlap_or_share_an_edge_are_united() {
    assert_repaired(vec![vec![square(0.0, 0.0, 4.0)], vec![square(2.0, 2.0, 4.0)]], 1, 28.0);
    assert_repaired(vec![vec![square(0.0, 0.0, 4.0)], vec![square(4.0, 0.0, 4.0)]], 1, 32.0);
    assert_repaired(vec![vec![square(0.0, 0.0, 4.0)], vec![square(0.0, 0.0, 4.0)]], 1, 16.0);
}

#[test]
fn degrees_are_not_snapped_away() {
    let (x, y, s) = (4.36, 52.01, 1e-4);
    let bow = ring(&[(x, y), (x + s, y + s), (x + s, y), (x, y + s), (x, y)]);
    let (polygon, _) = valid(vec![vec![bow]]);
    assert!((polygon.unsigned_area() / (s * s / 2.0) - 1.0).abs() < 1e-3, "{polygon:?}");
}

#[test]
fn what_has_no_area_is_refused() {
    for points in [
        &[(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (0.0, 0.0)][..],
        &[(0.0, 0.0), (0.0, 0.0), (0.0, 0.0)],
        &[(1.0, 1.0)],
        &[(0.0, 0.0), (5.0, 5.0), (0.0, 0.0), (5.0, 5.0), (0.0, 0.0)],
        &[(0.0, f64::NAN), (5.0, 5.0), (0.0, 1.0), (0.0, f64::NAN)],
    ] {
        assert!(Outline { polygons: vec![vec![ring(points)]], notes: Vec::new() }.into_valid().is_err(), "{points:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    /// Whatever the rings, the answer is valid polygons or a reason, and never a crash. Integer coordinates make
    /// coincident vertices and overlapping edges common.
    #[test]
    fn any_rings_become_valid_or_are_refused(
        polygons in prop::collection::vec(
            prop::collection::vec(prop::collection::vec((0..8_i32, 0..8_i32), 0..9), 0..3), 0..4),
        offset in prop::sample::select(vec![0.0, 85_000.0, 6_600_000.0]),
    ) {
        let polygons = polygons
            .into_iter()
            .map(|rings| {
                let points = |ring: Vec<(i32, i32)>| {
                    ring.into_iter().map(|(x, y)| Coord { x: offset + f64::from(x), y: f64::from(y) - offset }).collect()
                };
                rings.into_iter().map(points).collect()
            })
            .collect();
        if let Ok((polygon, _)) = (Outline { polygons, notes: Vec::new() }).into_valid() {
            prop_assert!(polygon.is_valid());
            prop_assert!(polygon.unsigned_area() > 0.0 && polygon.unsigned_area() <= 49.0 + 1e-6);
        }
    }
}
