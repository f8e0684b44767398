//! Objects that were scanned all round, and walls that tell more than a footprint.

use geo::{Contains, LineString, MultiPolygon, Polygon};
use nalgebra::Point3;

use super::*;
use crate::geometry::Random;
use crate::site::Frame;

/// Points on all sides of a flat house of `height` over an outline, `per_metre`² of them, with noise along every axis.
fn scanned(outline: &[(f64, f64)], height: f64, density: f64, noise: f64) -> Vec<Point3<f64>> {
    let mut random = Random::new(17);
    let polygon = Polygon::new(LineString::from(outline.to_vec()), vec![]);
    let mut points = Vec::new();
    for (a, b) in polygon.exterior().lines().map(|line| (line.start, line.end)) {
        let length = (b.x - a.x).hypot(b.y - a.y);
        for _ in 0..(length * height * density) as usize {
            let (t, z) = (random.unit(), height * random.unit());
            points.push(Point3::new(a.x + t * (b.x - a.x), a.y + t * (b.y - a.y), z));
        }
    }
    let rect = geo::BoundingRect::bounding_rect(&polygon).unwrap();
    for z in [0.0, height] {
        for _ in 0..(rect.width() * rect.height() * density) as usize {
            let (x, y) = (rect.min().x + rect.width() * random.unit(), rect.min().y + rect.height() * random.unit());
            if polygon.contains(&geo::Point::new(x, y)) {
                points.push(Point3::new(x, y, z));
            }
        }
    }
    for p in &mut points {
        *p += nalgebra::Vector3::from_fn(|_, _| noise * random.bell());
    }
    points
}

const ELL: [(f64, f64); 6] = [(0.0, 0.0), (14.0, 0.0), (14.0, 6.0), (8.0, 6.0), (8.0, 11.0), (0.0, 11.0)];

/// The object on ground that was guessed far too low.
fn object(points: Vec<Point3<f64>>) -> Site {
    let frame = Frame { origin: [85_000.0, 447_000.0, 0.0], metres_per_unit: [1.0; 3] };
    let mut site = Site::new("object", frame, points, -1.5);
    site.ground.source = GroundSource::BoundingBox;
    site
}

#[test]
fn walls_and_floor_of_an_object_stand_where_they_were_scanned() {
    for (noise, most) in [(0.0, 0.002), (0.05, 0.01), (0.2, 0.03)] {
        let site = object(scanned(&ELL, 6.0, 25.0, noise));
        let building = reconstruct(&site, &Parameters::default(), &occupancy::HeightField);
        assert_eq!(building.outcome, Outcome::Lod22, "noise {noise}: {:?}", building.measures.setbacks);
        let solid = building.model.lod22().next().unwrap();
        let expected = (14.0 * 6.0 + 8.0 * 5.0) * 6.0;
        assert!((solid.volume() / expected - 1.0).abs() < most, "noise {noise}: {} of {expected}", solid.volume());
        assert_eq!(solid.faces.len(), 8, "noise {noise}");
        assert!(building.notes.iter().any(|note| note.contains("floor was scanned")), "{:?}", building.notes);
    }
}

#[test]
fn a_scanned_wall_without_a_place_in_the_footprint_is_told() {
    let seen = [(0.0, 0.0), (10.0, 0.0), (10.0, 8.0), (0.0, 8.0)];
    let said = |width: f64| {
        let outline = [(0.0, 0.0), (width, 0.0), (width, 8.0), (0.0, 8.0)];
        let footprint = MultiPolygon(vec![Polygon::new(LineString::from(outline.to_vec()), vec![])]);
        let points = scanned(&seen, 6.0, 12.0, 0.01);
        let site = Site::new("object", Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] }, points, 0.0);
        let building = reconstruct(&site.with_footprint(&footprint), &Parameters::default(), &occupancy::HeightField);
        building.notes.iter().any(|note| note.contains("where the footprint has none"))
    };
    assert!(said(12.0));
    assert!(!said(10.1));
}
