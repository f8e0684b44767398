use geo::{Contains, Point, polygon};
use nalgebra::Point3;

use super::*;
use crate::site::Frame;

/// A building of 20 m by 16 m, 6 m high: roof points where `roof` holds and ground points where `ground` does, four of
/// each per square metre.
fn site(roof: impl Fn(f64, f64) -> bool, ground: impl Fn(f64, f64) -> bool) -> Site {
    let footprint =
        MultiPolygon(vec![polygon![(x: 0.0, y: 0.0), (x: 20.0, y: 0.0), (x: 20.0, y: 16.0), (x: 0.0, y: 16.0)]]);
    let places = (0..40).flat_map(|i| (0..32).map(move |j| (0.5 * f64::from(i) + 0.2, 0.5 * f64::from(j) + 0.3)));
    let of = |holds: &dyn Fn(f64, f64) -> bool, z: f64| -> Vec<Point3<f64>> {
        places.clone().filter(|&(x, y)| holds(x, y)).map(|(x, y)| Point3::new(x, y, z)).collect()
    };
    let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
    let site = Site::new("a", frame, of(&roof, 6.0), 0.0).with_footprint(&footprint);
    Site { ground_points: of(&ground, 0.1), ..site }
}

fn within(x: f64, y: f64, low: [f64; 2], high: [f64; 2]) -> bool {
    x > low[0] && x < high[0] && y > low[1] && y < high[1]
}

#[test]
fn a_courtyard_is_found_with_straight_walls() {
    let court = |x: f64, y: f64| within(x, y, [6.0, 5.0], [14.0, 11.0]);
    let open = open_ground(&site(|x, y| !court(x, y), court), 4.0);
    assert_eq!((open.0.len(), open.0[0].exterior().0.len()), (1, 5), "{open:?}");
    assert!((open.unsigned_area() - 48.0).abs() < 4.0, "{}", open.unsigned_area());
    assert!(open.contains(&Point::new(6.6, 5.6)) && !open.contains(&Point::new(5.4, 8.0)));
}

#[test]
fn a_half_that_is_gone_is_open_up_to_the_outline() {
    let site = site(|x, _| x < 11.0, |x, _| x > 11.0);
    let open = open_ground(&site, 4.0);
    let rest = site.footprint.as_ref().unwrap().difference(&open);
    assert_eq!(rest.0.len(), 1, "{rest:?}");
    assert!((rest.unsigned_area() - 11.0 * 16.0).abs() < 5.0, "{}", rest.unsigned_area());
}

#[test]
fn what_little_ground_shows_is_no_open_ground() {
    let everywhere = |_: f64, _: f64| true;
    let nowhere = |cases: &[(&str, Site)]| {
        for (case, site) in cases {
            assert!(open_ground(site, 4.0).0.is_empty(), "{case}");
        }
    };
    let shaft = |x: f64, y: f64| within(x, y, [6.0, 5.0], [7.7, 6.7]);
    let strip = |x: f64, _: f64| x < 1.2;
    let court = |x: f64, y: f64| within(x, y, [6.0, 5.0], [14.0, 11.0]);
    let mut deck = site(|x, y| !court(x, y), court);
    deck.ground_points.iter_mut().for_each(|p| p.z = 3.0);
    nowhere(&[
        ("a gateway", site(everywhere, |x, _| within(x, 1.0, [8.0, 0.0], [12.0, 2.0]))),
        ("a shaft of 3 m²", site(|x, y| !shaft(x, y), shaft)),
        ("an outline that is 1.2 m off", site(|x, y| !strip(x, y), strip)),
        ("a handful in what was not scanned", site(|x, y| !court(x, y), |x, y| within(x, y, [9.0, 8.0], [10.2, 8.4]))),
        ("a deck", deck),
        ("no ground points", site(everywhere, |_, _| false)),
    ]);
}
