//! Prepared polygons against the plain predicates.

use super::*;

/// A star-shaped polygon with a hole, by the radii of its corners.
fn star(radii: &[f64]) -> MultiPolygon<f64> {
    let corner = |(i, r): (usize, &f64)| {
        let angle = std::f64::consts::TAU * i as f64 / radii.len() as f64;
        (r * angle.cos(), r * angle.sin())
    };
    let outer: Vec<_> = radii.iter().enumerate().map(corner).collect();
    let inner: Vec<_> = outer.iter().map(|(x, y)| (0.4 * x, 0.4 * y)).collect();
    MultiPolygon::new(vec![geo::Polygon::new(outer.into(), vec![inner.into()])])
}

proptest! {
    #[test]
    fn prepared_polygons_answer_like_geo(
        radii in prop::collection::vec(2.0..10.0_f64, 3..60),
        places in prop::collection::vec((-12.0..12.0_f64, -12.0..12.0_f64), 50),
    ) {
        let polygon = star(&radii);
        let prepared = PreparedPolygon::new(&polygon);
        let boundary = |p: Point<f64>| {
            let rings = polygon.0.iter().flat_map(|p| std::iter::once(p.exterior()).chain(p.interiors()));
            rings.map(|ring| Euclidean.distance(&p, ring)).fold(f64::INFINITY, f64::min)
        };
        for (x, y) in places {
            let place = Point::new(x, y);
            let expected = boundary(place);
            if expected > 1e-9 {
                prop_assert_eq!(prepared.contains([x, y]), polygon.contains(&place));
            }
            let found = prepared.boundary_distance([x, y], 3.0);
            let at_limit = (expected - 3.0).abs() < 1e-9;
            let agrees = if expected > 3.0 { found.is_infinite() } else { (found - expected).abs() < 1e-9 };
            prop_assert!(at_limit || agrees, "{} is not {}", found, expected);
        }
    }

    #[test]
    fn points_of_a_shared_edge_belong_to_one_side(ends in prop::array::uniform4(-100_000..100_000_i32), t in 1..1000_i32) {
        let [x0, y0, x1, y1] = ends.map(|v| f64::from(v) * 1e-3 + 85_000.0);
        let (dx, dy) = (x1 - x0, y1 - y0);
        prop_assume!(dx.hypot(dy) > 0.1);
        // Two triangles on either side of the edge, each in its own frame.
        let triangle = |side: f64| {
            let apex = (x0 + dx / 2.0 - side * dy, y0 + dy / 2.0 + side * dx);
            MultiPolygon::new(vec![geo::Polygon::new(vec![(x0, y0), (x1, y1), apex].into(), vec![])])
        };
        let at = f64::from(t) / 1000.0;
        let place = [snap(x0 + at * dx), snap(y0 + at * dy), 0.0];
        let inside = [1.0, -1.0].map(|side| {
            let polygon = triangle(side);
            let frame = frame_of(&polygon, [1.0; 3]);
            let [x, y, _] = super::super::neighbourhood::to_local(&frame, place);
            let prepared = PreparedPolygon::new(&polygon_to_local(&frame, &polygon));
            (prepared.contains([x, y]), prepared.boundary_distance([x, y], 1.0))
        });
        prop_assert!(inside.iter().all(|(_, distance)| *distance < 1e-5));
        let on_it = inside.iter().any(|(_, distance)| *distance < 1e-9);
        prop_assert!(on_it || inside[0].0 != inside[1].0);
    }
}
