//! Inputs whose values are worked out by hand.

use geo::{LineString, MultiPolygon, Polygon};
use nalgebra::{Point2, Point3};

use super::outline::Outline;
use super::*;
use crate::reconstruct::Parameters;
use crate::record::Record;
use crate::site::{Coverage, Frame, Ground, GroundSource, Site};

/// A flat roof of 20 m × 10 m at 6 m, one point per half metre; the ground is at 1 m.
fn flat() -> Site {
    let ring = LineString::from(vec![(0.0, 0.0), (20.0, 0.0), (20.0, 10.0), (0.0, 10.0)]);
    let points = (0..800).map(|i| Point3::new(0.25 + 0.5 * f64::from(i % 40), 0.25 + 0.5 * f64::from(i / 40), 6.0));
    Site {
        id: "flat".into(),
        frame: Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] },
        footprint: Some(MultiPolygon(vec![Polygon::new(ring, vec![])])),
        points: points.collect(),
        ground_points: Vec::new(),
        ground_line: Vec::new(),
        ground: Ground { height: 1.0, spread: 0.1, source: GroundSource::GroundPoints },
        coverage: Coverage { share: 1.0 },
        covered: None,
        eaves: None,
        attributes: serde_json::Map::new(),
        record: Record::default(),
        edits: Vec::new(),
    }
}

fn close(found: &[f32], expected: &[f64]) {
    assert_eq!(found.len(), expected.len());
    for (i, (a, b)) in found.iter().zip(expected).enumerate() {
        assert!((f64::from(*a) - b).abs() < 2e-3, "{i}: {a} is not {b}");
    }
}

#[test]
fn a_place_under_a_flat_roof_is_described_as_by_hand() {
    let site = flat();
    let building = Partitioned::new(&site, &Parameters::default()).unwrap();
    let inputs = Inputs::new(&building);
    // The box is the footprint with a margin of 1 m.
    assert!((inputs.scale() - 22.0).abs() < 1e-9);
    let place = Point3::new(10.0, 1.0, 4.0);
    let mut patch = Vec::new();
    let radius = inputs.patch(&place, 4, &mut patch);
    // The four points around it lie 2 m higher and a quarter of a metre off along x and y.
    let expected = (4.0 + 0.125_f64).sqrt();
    assert!((radius - expected).abs() < 1e-6);
    let first = &patch[..7];
    close(&first[2..], &[2.0 / radius, 1.0, -2.0 / radius, 1.0, 1.0]);
    assert!((f64::from(first[0].abs()) - 0.25 / radius).abs() < 1e-6);
    let mut channels = Vec::new();
    inputs.place(&place, radius, &mut channels);
    let (below, within) = (2.0_f64, 1.0_f64);
    close(
        &channels,
        &[
            0.0,
            -4.0 / 22.0,
            3.0 / 22.0,
            0.3,
            (22.0_f64 / 20.0).ln(),
            0.5_f64.ln(),
            0.1_f64.ln(),
            radius.ln(),
            1.0,
            below / 22.0,
            (below / 2.0).tanh(),
            (below / 0.3).tanh(),
            (below / 0.05).tanh(),
            1.0,
            (within / 2.0).tanh(),
            (within / 0.3).tanh(),
            (within / 0.05).tanh(),
        ],
    );
}

#[test]
fn the_raster_sees_the_roof_where_it_is() {
    let site = flat();
    let building = Partitioned::new(&site, &Parameters::default()).unwrap();
    let inputs = Inputs::new(&building);
    let grid = 32;
    let raster = inputs.raster(grid);
    let channel = |name: &str| RASTER_CHANNELS.iter().position(|n| *n == name).unwrap();
    let at =
        |name: &str, column: usize, row: usize| f64::from(raster[channel(name) * grid * grid + row * grid + column]);
    // Pixels are 0.756 m wide; the middle of the roof is in the middle of the raster, beyond y = ±5 m is nothing.
    for (name, expected) in
        [("hit", 1.0), ("highest", 5.0 / 22.0), ("on_plane", 1.0), ("plane_upward", 1.0), ("footprint_flag", 1.0)]
    {
        assert!((at(name, 16, 16) - expected).abs() < 1e-3, "{name}");
        assert_eq!(at(name, 16, 3), 0.0, "{name}");
    }
    assert!((at("evidence_height", 16, 16) - 5.0 / 22.0).abs() < 1e-3);
    assert!(at("footprint_distance", 16, 16) > 0.8 && at("footprint_distance", 16, 3) < -0.5);
    assert!(at("layer_7", 16, 16) > 0.0 && at("layer_0", 16, 16) == 0.0);
}

#[test]
fn the_code_of_a_place_is_bilinear() {
    let grid = 8;
    // A map that is linear in x and y between the centres of the outer pixels, and its double.
    let mut maps = Vec::new();
    for factor in [1.0_f32, 2.0] {
        maps.extend((0..64).map(|i| factor * ((i % grid) as f32 + 10.0 * (i / grid) as f32)));
    }
    let pixel = 2.0 * HALF_WIDTH / grid as f64;
    let mut values = Vec::new();
    lookup(&maps, 2, grid, -HALF_WIDTH + 2.75 * pixel, -HALF_WIDTH + 4.0 * pixel, &mut values);
    close(&values, &[2.25 + 35.0, 2.0 * (2.25 + 35.0)]);
    values.clear();
    lookup(&maps, 2, grid, -9.0, 9.0, &mut values);
    close(&values, &[70.0, 140.0]);
}

#[test]
fn the_distance_to_an_outline_is_positive_inside_and_negative_in_a_courtyard() {
    let ring = |a: f64, b: f64| LineString::from(vec![(a, a), (b, a), (b, b), (a, b)]);
    let outline = Outline::new(&MultiPolygon(vec![Polygon::new(ring(0.0, 10.0), vec![ring(4.0, 6.0)])]));
    for (x, y, distance) in [(1.0, 5.0, 1.0), (5.0, 5.0, -1.0), (-3.0, -4.0, -5.0), (3.0, 3.0, 2.0_f64.sqrt())] {
        assert!((outline.distance(&Point2::new(x, y)) - distance).abs() < 1e-12, "{x} {y}");
    }
}

#[test]
fn a_small_cloud_is_repeated_and_not_padded() {
    let mut site = flat();
    site.points.truncate(60);
    let building = Partitioned::new(&site, &Parameters::default()).unwrap();
    let inputs = Inputs::new(&building);
    let subsample = inputs.subsample(100);
    assert_eq!(subsample.len(), 300);
    assert_eq!(subsample[..120], subsample[180..]);
    assert!(subsample.chunks_exact(3).all(|p| (f64::from(p[2]) - 5.0 / 22.0).abs() < 1e-3));
    let mut first: Vec<[u32; 3]> =
        subsample[..180].chunks_exact(3).map(|p| [0, 1, 2].map(|i| p[i].to_bits())).collect();
    first.sort_unstable();
    first.dedup();
    assert_eq!(first.len(), 60, "drawn without replacement");
    let mut patch = Vec::new();
    inputs.patch(&Point3::new(5.0, 5.0, 2.0), 100, &mut patch);
    assert_eq!(patch[..7 * 40], patch[7 * 60..]);
}

#[test]
fn a_hall_is_looked_at_through_windows_and_a_house_as_a_whole() {
    let hall = |length: f64| {
        let ring = LineString::from(vec![(0.0, 0.0), (length, 0.0), (length, 40.0), (0.0, 40.0)]);
        let columns = length as usize;
        let points =
            (0..40 * columns).map(|i| Point3::new((i % columns) as f64 + 0.5, (i / columns) as f64 + 0.5, 6.0));
        Site { footprint: Some(MultiPolygon(vec![Polygon::new(ring, vec![])])), points: points.collect(), ..flat() }
    };
    let (house, hall) = (hall(100.0), hall(160.0));
    let building = Partitioned::new(&house, &Parameters::default()).unwrap();
    let whole = Inputs::new(&building);
    let windows = Windows::new(&whole);
    assert_eq!((windows.inputs().len(), windows.at(&Point3::new(90.0, 30.0, 3.0))), (1, 0));
    assert_eq!(windows.inputs()[0].raster(32), whole.raster(32));

    let building = Partitioned::new(&hall, &Parameters::default()).unwrap();
    let whole = Inputs::new(&building);
    let windows = Windows::new(&whole);
    // The box has a margin of 1 m; four windows of 40.5 m and their rims.
    assert_eq!(windows.inputs().len(), 4);
    for (place, at) in [(-9.0, 0), (1.0, 0), (45.0, 1), (90.0, 2), (159.0, 3), (999.0, 3)] {
        let place = Point3::new(place, 20.0, 3.0);
        assert_eq!(windows.at(&place), at, "{place}");
        let seen = &windows.inputs()[at];
        assert!((seen.scale() - 52.0).abs() < 1e-9, "{}", seen.scale());
        let field = seen.to_field(&place);
        assert!(!(0.0..160.0).contains(&place.x) || field.x.abs() < 0.5, "{field}");
    }
    assert!((whole.scale() - 162.0).abs() < 1e-9);
    // The rim of a window shows what is beyond it.
    let raster = windows.inputs()[1].raster(32);
    assert!((0..32).all(|column| raster[16 * 32 + column] == 1.0), "hit everywhere in the middle row");
}
