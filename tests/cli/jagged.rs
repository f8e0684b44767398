//! Outlines of very many vertices.

use std::f64::consts::TAU;

use serde_json::{Value, json};
use tempfile::tempdir;

use crate::bench::*;

/// A round house of 20 m on flat ground, two points per metre each way.
fn write_round(path: &std::path::Path) {
    let axis = |i: i32| f64::from(i) * 0.5 + 0.25;
    let places = (-60..60).flat_map(|i| (-60..60).map(move |j| (axis(i), axis(j))));
    let points: Vec<_> = places
        .map(|(x, y)| {
            let is_roof = x.hypot(y) < 20.0;
            let (z, class) = if is_roof { (7.0, 6) } else { (0.0, 2) };
            (CORNER[0] + x, CORNER[1] + y, z, class)
        })
        .collect();
    write_tile(path, None, &points);
}

/// An outline of so many corners by the reach of each, metres.
fn outline(count: usize, reach: fn(usize) -> f64) -> Value {
    let ring: Vec<[f64; 2]> = (0..=count)
        .map(|i| {
            let i = i % count;
            let angle = TAU * i as f64 / count as f64;
            [CORNER[0] + reach(i) * angle.cos(), CORNER[1] + reach(i) * angle.sin()]
        })
        .collect();
    json!({"type": "Polygon", "coordinates": [ring]})
}

/// Up to 0.3 m in or out, scattered evenly enough by the golden ratio.
fn jagged(i: usize) -> f64 {
    20.0 + (i as f64 * 0.618_033_988_75).fract() * 0.6 - 0.3
}

/// Spikes of 6 m.
fn star(i: usize) -> f64 {
    if i.is_multiple_of(2) { 20.0 } else { 14.0 }
}

/// Four times as many vertices cost no more than six times as much; they cost sixteen times as much by the square.
#[test]
fn the_cost_of_an_outline_grows_with_its_vertices_and_not_with_their_square() {
    let folder = tempdir().unwrap();
    let [tile, footprints, out] = ["round.laz", "f.geojson", "m.city.json"].map(|name| folder.path().join(name));
    write_round(&tile);
    let cost = |count: usize, reach: fn(usize) -> f64| {
        write_footprints(&footprints, &[("round", outline(count, reach))]);
        let run = reconstruct(&[&tile], &footprints, &out, "--overwrite --crs EPSG:7415 --field height-field");
        assert_eq!(run.code, 0, "{}", run.err);
        let report = report_of(&out);
        assert_eq!(report["counts"]["lacking"], 0, "{report:#}");
        report["cpu_seconds"].as_f64().unwrap()
    };
    for (reach, few) in [(jagged as fn(usize) -> f64, 7_500), (star, 5_000)] {
        let [few, many] = [few, 4 * few].map(|count| cost(count, reach));
        assert!(many <= 1.0 + 6.0 * few, "{few} s and {many} s");
        assert_eq!(gable(["validate".as_ref(), out.as_os_str()]).code, 0);
    }
}
