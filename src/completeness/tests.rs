//! Blocks and scans of them, drawn by hand.

use geo::{LineString, MultiPolygon, Polygon};
use nalgebra::Point3;

use super::*;
use crate::geometry::Cover;
use crate::solid::{Face, Solid, Surface, SurfaceType};

fn rectangle(min: [f64; 2], max: [f64; 2]) -> MultiPolygon<f64> {
    let ring = vec![(min[0], min[1]), (max[0], min[1]), (max[0], max[1]), (min[0], max[1])];
    MultiPolygon(vec![Polygon::new(LineString::from(ring), vec![])])
}

/// Level roofs over rectangles.
fn roofs(of: &[([f64; 2], [f64; 2], f64)]) -> Cover {
    Cover::new(of.iter().flat_map(|&([x0, y0], [x1, y1], z)| {
        let [a, b, c, d] = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]].map(|[x, y]| Point3::new(x, y, z));
        [[a, b, c], [a, c, d]]
    }))
}

/// A point each half metre of a 12 m × 10 m plan, at the heights that `height` gives.
fn scan(height: impl Fn(f64, f64) -> Option<f64>) -> Vec<Point3<f64>> {
    let places = (0..480).map(|i| (0.25 + 0.5 * f64::from(i % 24), 0.25 + 0.5 * f64::from(i / 24)));
    places.filter_map(|(x, y)| Some(Point3::new(x, y, height(x, y)?))).collect()
}

fn judge(points: &[Point3<f64>], ground_points: &[Point3<f64>], model: &Cover) -> Completeness {
    let footprint = rectangle([0.0, 0.0], [12.0, 10.0]);
    let scan = Scan { footprint: Some(&footprint), floor: 0.0, points, ground_points };
    Judge::new(&scan, &Limits::default()).judge(model)
}

fn areas(areas: &[Area]) -> Vec<f64> {
    areas.iter().map(|area| area.area).collect()
}

const WHOLE: ([f64; 2], [f64; 2]) = ([0.0, 0.0], [12.0, 10.0]);

fn flat(height: f64) -> Cover {
    roofs(&[(WHOLE.0, WHOLE.1, height)])
}

#[test]
fn a_model_as_scanned_has_no_fault() {
    let found = judge(&scan(|_, _| Some(6.0)), &[], &flat(6.0));
    // The outermost cells have points 0.75 m from the outline.
    assert_eq!(found, Completeness { judged: 120, ..Completeness::default() });
    // What is less than 1 m off is none.
    assert_eq!(judge(&scan(|_, _| Some(6.999)), &[], &flat(6.0)).missing, []);
    assert_eq!(judge(&scan(|_, _| Some(5.001)), &[], &flat(6.0)).excess, []);
}

#[test]
fn a_tower_that_the_model_lacks_is_missing_and_its_wall_is_not() {
    // 3 m × 2 m at 9 m on a roof at 6 m, and points on its walls down to the roof.
    let is_tower = |x: f64, y: f64| (4.0..7.0).contains(&x) && (3.0..5.0).contains(&y);
    let mut points = scan(|x, y| Some(if is_tower(x, y) { 9.0 } else { 6.0 }));
    let found = judge(&points, &[], &flat(6.0));
    assert_eq!((areas(&found.missing), &found.excess, &found.roofed_ground), (vec![6.0], &vec![], &vec![]));
    let area = &found.missing[0];
    assert_eq!(area.cells, [[4, 3], [4, 4], [5, 3], [5, 4], [6, 3], [6, 4]]);
    assert_eq!((area.place, area.height), (Point3::new(5.5, 3.5, 9.0), 3.0));
    assert_eq!(area.points.len(), 24);
    assert!(area.points.iter().all(|&i| points[i as usize].z == 9.0));
    // Modelled: nothing is missing, whatever hangs on its walls, inside it or a little outside.
    points.extend((0..30).map(|i| Point3::new(3.95 + 0.1 * f64::from(i % 2), 4.0, 6.0 + 0.1 * f64::from(i))));
    let model = roofs(&[(WHOLE.0, WHOLE.1, 6.0), ([4.0, 3.0], [7.0, 5.0], 9.0)]);
    let found = judge(&points, &[], &model);
    assert_eq!((areas(&found.missing), areas(&found.excess)), (vec![1.0], vec![]), "the cell of the wall alone");
}

#[test]
fn wall_points_below_a_roof_edge_are_not_roof() {
    // The building ends at x = 6, as in the model, and its wall was scanned well above the floor.
    let mut points = scan(|x, _| (x < 6.0).then_some(6.0));
    points.extend((0..40).map(|i| Point3::new(6.1, 2.25 + 0.15 * f64::from(i), 1.5 + 0.08 * f64::from(i))));
    let model = roofs(&[([0.0, 0.0], [6.0, 10.0], 6.0)]);
    assert_eq!(judge(&points, &[], &model).missing, []);
    // The same points where no roof shelters them are roof.
    let low: Vec<_> = points.into_iter().filter(|p| p.x > 6.0).collect();
    assert!(judge(&low, &[], &model).missing.len() == 1);
}

#[test]
fn what_is_modelled_above_everything_around_is_excess() {
    // The model has a part of 4 m × 4 m at 9 m that was scanned at 6 m.
    let model = roofs(&[(WHOLE.0, WHOLE.1, 6.0), ([4.0, 3.0], [8.0, 7.0], 9.0)]);
    let found = judge(&scan(|_, _| Some(6.0)), &[], &model);
    assert_eq!((areas(&found.excess), areas(&found.missing)), (vec![16.0], vec![]));
    assert_eq!((found.excess[0].place.z, found.excess[0].height), (9.0, 3.0));
    // One point as high as it within reach excuses a cell; too few points say nothing.
    let mut points = scan(|_, _| Some(6.0));
    points.push(Point3::new(4.5, 3.5, 8.5));
    assert_eq!(areas(&judge(&points, &[], &model).excess), [13.0]);
    let sparse = scan(|x, y| (x.fract() < 0.5 && y.fract() < 0.5 && (x as i32 + y as i32) % 6 == 0).then_some(6.0));
    assert_eq!(judge(&sparse, &[], &model).excess, []);
}

#[test]
fn ground_under_the_model_with_nothing_above_is_roofed() {
    let is_court = |x: f64, y: f64| (4.0..8.0).contains(&x) && (3.0..7.0).contains(&y);
    let points = scan(|x, y| (!is_court(x, y)).then_some(6.0));
    let ground = scan(|x, y| is_court(x, y).then_some(0.1));
    let found = judge(&points, &ground, &flat(6.0));
    // The corners of the court are within 0.7 m of building points.
    assert_eq!((areas(&found.roofed_ground), areas(&found.missing)), (vec![12.0], vec![]));
    assert_eq!(found.roofed_ground[0].place.z, 0.1);
    // A court that is left open, and ground that the laser saw through a glass roof, are no fault.
    let open = roofs(&[([0.0, 0.0], [12.0, 3.0], 6.0), ([0.0, 7.0], [12.0, 10.0], 6.0)]);
    assert_eq!(judge(&points, &ground, &open).roofed_ground, []);
    assert_eq!(judge(&scan(|_, _| Some(6.0)), &ground, &flat(6.0)).roofed_ground, []);
}

#[test]
fn areas_apart_are_counted_apart_and_small_ones_left_out() {
    let is_high = |x: f64, y: f64| (2.0..4.0).contains(&x) && y >= 2.0 && y < 4.0 || (8.0..9.0).contains(&x) && y < 2.0;
    let points = scan(|x, y| Some(if is_high(x, y) { 9.0 } else { 6.0 }));

    assert_eq!(areas(&judge(&points, &[], &flat(6.0)).missing), [4.0, 2.0]);
    let footprint = rectangle(WHOLE.0, WHOLE.1);
    let scan = Scan { footprint: Some(&footprint), floor: 0.0, points: &points, ground_points: &[] };
    let limits = Limits { smallest: 3.0, ..Limits::default() };
    assert_eq!(areas(&Judge::new(&scan, &limits).judge(&flat(6.0)).missing), [4.0]);
    // Smaller cells follow the margin more closely: of the second, a row of cells lies in it.
    let limits = Limits { cell: 0.5, ..Limits::default() };
    assert_eq!(areas(&Judge::new(&scan, &limits).judge(&flat(6.0)).missing), [4.0, 1.5]);
}

#[test]
fn where_there_is_no_model_it_stands_at_the_floor() {
    let points = scan(|x, _| (x < 6.0).then_some(4.0));
    let nothing = Cover::new([]);
    assert_eq!(areas(&judge(&points, &[], &nothing).missing), [60.0]);
    let footprint = rectangle(WHOLE.0, WHOLE.1);
    let scan = Scan { footprint: Some(&footprint), floor: 3.5, points: &points, ground_points: &[] };
    assert_eq!(Judge::new(&scan, &Limits::default()).judge(&nothing).missing, []);
}

#[test]
fn points_that_are_no_numbers_change_nothing() {
    let mut points = scan(|_, _| Some(6.0));
    points.extend([
        Point3::new(f64::NAN, 5.0, 50.0),
        Point3::new(5.0, 5.0, f64::INFINITY),
        Point3::new(1e300, 0.0, 9.0),
    ]);
    assert_eq!(judge(&points, &[], &flat(6.0)), judge(&scan(|_, _| Some(6.0)), &[], &flat(6.0)));
}

#[test]
fn the_tops_of_a_solid_are_the_faces_that_look_up() {
    // A wedge: its slope rises from 0 at x = 0 to 2 m at x = 2.
    let corners = [[0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0], [2, 0, 2], [2, 2, 2]];
    let rings = [vec![0, 3, 2, 1], vec![0, 4, 5, 3], vec![1, 2, 5, 4], vec![0, 1, 4], vec![3, 5, 2]];
    let solid = Solid {
        step: [1.0; 3],
        vertices: corners.to_vec(),
        faces: rings.into_iter().map(|ring| Face { rings: vec![ring], surface: 0 }).collect(),
        surfaces: vec![Surface::of(SurfaceType::Roof)],
    };
    let tops = tops([&solid]);
    assert_eq!(tops.heights(0.5, 0.5).collect::<Vec<_>>(), [0.5]);
    assert_eq!((tops.highest(1.5, 1.0), tops.highest(2.5, 1.0)), (Some(1.5), None));
}

#[test]
fn cells_that_meet_at_a_corner_only_are_apart() {
    let is_high = |x: f64, y: f64| {
        let within = |low: f64, v: f64| (low..low + 2.0).contains(&v);
        within(2.0, x) && within(2.0, y) || within(4.0, x) && within(4.0, y)
    };
    let points = scan(|x, y| Some(if is_high(x, y) { 9.0 } else { 6.0 }));
    assert_eq!(areas(&judge(&points, &[], &flat(6.0)).missing), [4.0, 4.0]);
}
