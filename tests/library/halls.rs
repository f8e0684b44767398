//! Large halls and long rows fit their points as well as houses do, whichever field decides.

use gable::building::Outcome;
use gable::network::{Field, FieldOptions};
use gable::reconstruct::{Parameters, reconstruct};
use gable::site::{Frame, Site};
use geo::{Coord, LineString, MultiPolygon, Polygon};
use nalgebra::Point3;

/// A building of some length and depth in metres, turned by degrees, with a roof by place on it: four points per square
/// metre in disorder, with 2 cm of noise to either side.
fn scanned(id: &str, [length, depth]: [f64; 2], degrees: f64, roof: impl Fn(f64, f64) -> f64) -> Site {
    let (sine, cosine) = f64::to_radians(degrees).sin_cos();
    let turned = |x: f64, y: f64| (cosine * x - sine * y, sine * x + cosine * y);
    let mut state = 7_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31)
    };
    let points = (0..(4.0 * length * depth) as usize).map(|_| {
        let (x, y) = (length * random(), depth * random());
        let z = roof(x, y) + 0.04 * (random() - 0.5);
        let (x, y) = turned(x, y);
        Point3::new(x, y, z)
    });
    let points = points.collect();
    let corners = [(0.0, 0.0), (length, 0.0), (length, depth), (0.0, depth), (0.0, 0.0)];
    let ring: LineString<f64> = corners.iter().map(|&(x, y)| Coord::from(turned(x, y))).collect();
    let frame = Frame { origin: [85_000.0, 447_000.0, 0.0], metres_per_unit: [1.0; 3] };
    Site::new(id, frame, points, 0.0).with_footprint(&MultiPolygon(vec![Polygon::new(ring, Vec::new())]))
}

#[test]
fn halls_and_rows_fit_as_well_as_the_noise_allows() {
    let saw = |x: f64, _: f64| 8.0 + 1.5 * (x % 4.0) / 4.0;
    let steps = |x: f64, _: f64| 6.0 + 0.9 * f64::from((x / 12.0) as u32 % 2);
    let terraces = |x: f64, _: f64| 6.0 + 0.45 * (x / 12.0).floor();
    for site in [
        scanned("saw", [160.0, 60.0], 0.0, saw),
        scanned("saw turned", [140.0, 30.0], 30.0, saw),
        scanned("row", [180.0, 10.0], 45.0, steps),
        scanned("terraces", [180.0, 10.0], 30.0, terraces),
    ] {
        for field in [Field::Neural, Field::HeightField] {
            let loaded = FieldOptions { field, ..FieldOptions::default() }.load().unwrap();
            let building = reconstruct(&site, &Parameters::default(), &*loaded);
            assert_eq!(building.outcome, Outcome::Lod22, "{} {field:?}", site.id);
            let rmse = building.measures.rmse_lod22.unwrap();
            assert!(rmse <= 0.03, "{} {field:?}: {rmse}", site.id);
        }
    }
}
