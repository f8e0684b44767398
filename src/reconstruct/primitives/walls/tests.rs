use geo::{Contains, Distance, Validation, polygon};
use proptest::prelude::*;

use super::*;

fn footprint(corners: &[[f64; 2]]) -> MultiPolygon<f64> {
    let mut ring = LineString::from(corners.to_vec());
    ring.close();
    MultiPolygon(vec![Polygon::new(ring, vec![])])
}

fn count(walls: &Walls) -> usize {
    walls.outline.0[0].exterior().0.len() - 1
}

#[test]
fn a_jog_is_levelled_on_its_inner_side() {
    let jog = |y: f64| footprint(&[[0.0, 0.0], [5.0, 0.0], [5.0, y], [10.0, y], [10.0, 8.0], [0.0, 8.0]]);
    for (y, area) in [(0.05, 10.0 * 7.95), (-0.05, 80.0)] {
        let walls = Walls::new(&jog(y), 0.1);
        assert_eq!((count(&walls), walls.traces.len()), (4, 4), "{walls:?}");
        assert!((walls.outline.unsigned_area() - area).abs() < 0.3, "{walls:?}");
        assert!(is_within(&walls.outline, &jog(y)));
    }
    let walls = Walls::new(&jog(0.3), 0.1);
    assert_eq!((walls.outline, walls.traces.len()), (jog(0.3), 6));
}

#[test]
fn walls_apart_share_the_innermost_line() {
    // Two wings whose ends stand 6 cm apart, and a court whose wall is 4 cm off the line of its counterpart.
    let plan = footprint(&[
        [0.0, 0.0],
        [4.0, 0.0],
        [4.0, 5.0],
        [8.0, 5.0],
        [8.0, 0.06],
        [12.0, 0.06],
        [12.0, 9.0],
        [6.0, 9.0],
        [6.0, 5.04 + 2.0],
        [3.0, 7.04],
        [3.0, 9.0],
        [0.0, 9.0],
    ]);
    let walls = Walls::new(&plan, 0.1);
    assert_eq!(count(&walls), 12);
    let at = |y: f64| {
        let flat = |t: &&Trace| t.normal.y.abs() > 0.99 && (t.at(t.span[0]).y - y).abs() < 0.01;
        walls.traces.iter().filter(flat).map(|t| (t.normal, t.offset)).collect::<Vec<_>>()
    };
    let wings = at(0.06);
    assert!(wings.len() == 2 && wings[0] == wings[1] && at(0.0).is_empty(), "{:?}", walls.traces);
}

#[test]
fn what_is_narrower_than_the_reach_keeps_both_its_walls() {
    for width in [0.02, 0.05, 0.09, 0.15] {
        let plan = footprint(&[[0.0, 0.0], [12.0, 0.001], [12.0, width], [6.0, width], [0.0, width - 0.001]]);
        let walls = Walls::new(&plan, 0.1);
        assert!(walls.outline.unsigned_area() > LEAST_AREA * plan.unsigned_area(), "{width}: {walls:?}");
        let mut long: Vec<f64> = walls.traces.iter().filter(|t| t.length() > 5.0).map(|t| t.at(t.span[0]).y).collect();
        long.sort_by(f64::total_cmp);
        assert!(long.len() >= 2 && long[long.len() - 1] - long[0] > 0.8 * width, "{width}: {walls:?}");
    }
}

#[test]
fn needles_go_where_they_are_spikes_or_hairlines() {
    let needle = |y: f64, width: f64| {
        let middle = 5.0 + width;
        footprint(&[
            [0.0, 0.0],
            [5.0, 0.0],
            [middle, y],
            [5.0 + 2.0 * width, 0.0],
            [10.0, 0.0],
            [10.0, 8.0],
            [0.0, 8.0],
        ])
    };
    for (y, width, corners) in [(-3.0, 0.02, 4), (-3.0, 0.2, 7), (3.0, 0.001, 4), (3.0, 0.02, 7)] {
        let walls = Walls::new(&needle(y, width), 0.1);
        assert_eq!(count(&walls), corners, "{y} {width} {walls:?}");
        assert!((walls.outline.unsigned_area() - 80.0).abs() < 1.0, "{walls:?}");
    }
}

#[test]
fn a_court_stays_open() {
    let court: LineString<f64> =
        vec![(3.0, 3.0), (3.02, 6.0), (3.0, 9.0), (9.0, 9.0), (9.0, 3.0), (5.0, 3.04), (3.0, 3.0)].into();
    let outer = polygon![(x: 0.0, y: 0.0), (x: 12.0, y: 0.0), (x: 12.0, y: 12.0), (x: 0.0, y: 12.0)];
    let plan = MultiPolygon(vec![Polygon::new(outer.exterior().clone(), vec![court.clone()])]);
    let walls = Walls::new(&plan, 0.1);
    assert_eq!(walls.outline.0[0].interiors().len(), 1);
    assert_eq!(walls.outline.0[0].interiors()[0].0.len(), 5);
    assert!(
        walls.outline.0[0].interiors()[0]
            .coords()
            .all(|c| { !Polygon::new(court.clone(), vec![]).contains(&geo::Point::from(*c)) })
    );
}

#[test]
fn outlines_of_very_many_vertices_stand_back_vertex_by_vertex() {
    let mut random = crate::geometry::Random::new(5);
    let count = 6_000;
    let corner = |i: usize| {
        let (angle, radius) = (std::f64::consts::TAU * i as f64 / f64::from(count), random.between(19.7, 20.3));
        [radius * angle.cos(), radius * angle.sin()]
    };
    let jagged = footprint(&(0..count as usize).map(corner).collect::<Vec<_>>());
    let walls = Walls::new(&jagged, 0.1);
    assert!(is_within(&walls.outline, &jagged) && walls.outline.is_valid());
    assert!(walls.traces.len() < count as usize / 2, "{}", walls.traces.len());
    assert!(walls.outline.unsigned_area() > 0.95 * jagged.unsigned_area());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// A ring of 8 to 40 corners around a rectangle, turned, each up to 0.15 m off.
    #[test]
    fn walls_never_leave_the_footprint_nor_stand_far_back(
        per_side in 2_usize..10,
        off in prop::collection::vec((-0.15..0.15_f64, -0.15..0.15_f64), 40),
        angle in 0.0..1.5_f64,
        reach in 0.02..0.4_f64,
    ) {
        let (sin, cos) = angle.sin_cos();
        let ring: Vec<[f64; 2]> = (0..4 * per_side)
            .map(|i| {
                let t = (i % per_side) as f64 / per_side as f64;
                let [x, y] = match i / per_side {
                    0 => [12.0 * t, 0.0],
                    1 => [12.0, 8.0 * t],
                    2 => [12.0 - 12.0 * t, 8.0],
                    _ => [0.0, 8.0 - 8.0 * t],
                };
                let (x, y) = (x + off[i].0, y + off[i].1);
                [cos * x - sin * y, sin * x + cos * y]
            })
            .collect();
        let plan = footprint(&ring);
        prop_assume!(plan.is_valid());
        let walls = Walls::new(&plan, reach);
        prop_assert!(is_within(&walls.outline, &plan));
        prop_assert!(walls.outline.is_valid());
        prop_assert!(walls.traces.len() <= ring.len());
        // No corner of the footprint is farther from the walls than the walls may stand back, but for the corners.
        let line = walls.outline.0[0].exterior();
        for corner in &ring {
            let far = Euclidean.distance(&geo::Point::from(*corner), line);
            prop_assert!(far <= MOST_MOVED * reach, "{far}");
        }
        // The traces are the edges of the outline.
        for (trace, edge) in walls.traces.iter().zip(line.lines()) {
            for end in [edge.start, edge.end] {
                prop_assert!(trace.distance(&Point2::new(end.x, end.y)).abs() < 1e-6);
            }
        }
    }
}
