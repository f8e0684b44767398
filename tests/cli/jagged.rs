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

/// Its outline with a vertex every so often, up to 0.3 m in or out.
fn outline(count: usize) -> Value {
    let ring: Vec<[f64; 2]> = (0..=count)
        .map(|i| {
            let i = i % count;
            // Scattered evenly enough by the golden ratio.
            let off = (i as f64 * 0.618_033_988_75).fract() * 0.6 - 0.3;
            let angle = TAU * i as f64 / count as f64;
            [CORNER[0] + (20.0 + off) * angle.cos(), CORNER[1] + (20.0 + off) * angle.sin()]
        })
        .collect();
    json!({"type": "Polygon", "coordinates": [ring]})
}

/// Four times as many vertices cost no more than six times as much; they cost sixteen times as much by the square.
#[test]
fn the_cost_of_an_outline_grows_with_its_vertices_and_not_with_their_square() {
    let folder = tempdir().unwrap();
    let [tile, footprints, out] = ["round.laz", "f.geojson", "m.city.json"].map(|name| folder.path().join(name));
    write_round(&tile);
    let cost = |count: usize| {
        write_footprints(&footprints, &[("round", outline(count))]);
        let run = reconstruct(&[&tile], &footprints, &out, "--overwrite --crs EPSG:7415 --field height-field");
        assert_eq!(run.code, 0, "{}", run.err);
        let report = report_of(&out);
        assert_eq!(report["counts"]["lacking"], 0, "{report:#}");
        report["cpu_seconds"].as_f64().unwrap()
    };
    let [few, many] = [7_500, 30_000].map(cost);
    assert!(many <= 1.0 + 6.0 * few, "{few} s and {many} s");
    assert_eq!(gable(["validate".as_ref(), out.as_os_str()]).code, 0);
}
