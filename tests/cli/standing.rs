//! What of a footprint `gable reconstruct` builds on: open ground, uncovered parts, footprints that touch themselves.

use std::path::Path;

use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};

use crate::bench::*;

/// A tile of two points per metre and axis over x from -10 to 30 and y from -10 to 20: roof at 6 m where `roof` holds,
/// ground at 0 m elsewhere.
fn tile(roof: impl Fn(f64, f64) -> bool) -> TempDir {
    tile_of(|x, y| Some(if roof(x, y) { (6.0, 6) } else { (0.0, 2) }))
}

/// The same by the height and the class of the point at a place, if there is one.
fn tile_of(point: impl Fn(f64, f64) -> Option<(f64, u8)>) -> TempDir {
    let folder = tempdir().unwrap();
    let places = (-20..60).flat_map(|i| (-20..40).map(move |j| (f64::from(i) * 0.5 + 0.25, f64::from(j) * 0.5 + 0.25)));
    let points: Vec<_> =
        places.filter_map(|(x, y)| point(x, y).map(|(z, class)| (CORNER[0] + x, CORNER[1] + y, z, class))).collect();
    write_tile(&folder.path().join("a.las"), None, &points);
    folder
}

/// The attributes of the building and the report after a run that must succeed.
fn run(folder: &Path, rest: &str) -> (Value, Value) {
    let run = run_in(folder, "a.las", "f.geojson", &format!("--overwrite {rest}"));
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    let out = folder.join("out.city.json");
    assert_valid(&out);
    (json_of(&out)["CityObjects"]["b"]["attributes"].clone(), report_of(&out))
}

fn number(attributes: &Value, name: &str) -> f64 {
    attributes[name].as_f64().unwrap_or_else(|| panic!("{name}: {attributes:#}"))
}

#[test]
fn a_courtyard_that_nobody_drew_is_carved_or_kept() {
    let folder = tile(|x, y| {
        (0.0..20.0).contains(&x) && (0.0..14.0).contains(&y) && !((6.0..14.0).contains(&x) && (4.0..10.0).contains(&y))
    });
    write_footprints(&folder.path().join("f.geojson"), &[("b", rectangle(0.0, 0.0, 20.0, 14.0))]);
    let (carved, _) = run(folder.path(), "");
    assert!((number(&carved, "gable_open_ground_area") - 48.0).abs() < 4.0, "{carved:#}");
    assert!((number(&carved, "gable_volume_lod22") / 6.0 - 232.0).abs() < 6.0, "{carved:#}");
    assert_eq!(number(&carved, "gable_roofed_ground_area"), 0.0);
    let (kept, _) = run(folder.path(), "--open-ground keep");
    assert!((number(&kept, "gable_volume_lod22") / 6.0 - 280.0).abs() < 6.0, "{kept:#}");
    assert_eq!(kept["gable_open_ground_area"], carved["gable_open_ground_area"]);
    assert!(number(&kept, "gable_confidence") < number(&carved, "gable_confidence"));
    let (large, _) = run(folder.path(), "--open-ground-area 60");
    assert_eq!(number(&large, "gable_open_ground_area"), 0.0);
}

/// Of a footprint that holds a garage below the ground, only the houses on it stand.
#[test]
fn a_garage_below_the_ground_is_not_built_over() {
    let folder = tile(|x, y| (0.0..8.0).contains(&y) && ((0.0..8.0).contains(&x) || (12.0..20.0).contains(&x)));
    write_footprints(&folder.path().join("f.geojson"), &[("b", rectangle(-2.0, -4.0, 22.0, 12.0))]);
    let (garage, _) = run(folder.path(), "");
    assert!((number(&garage, "gable_open_ground_area") - 256.0).abs() < 8.0, "{garage:#}");
    assert!((number(&garage, "gable_volume_lod22") / 6.0 - 128.0).abs() < 6.0, "{garage:#}");
    assert!(garage["gable_notes"].to_string().contains("open ground"), "{garage:#}");
}

/// A narrow slope behind the ridge gave back few points: the wide one before it does not run on over it, though the
/// building is high enough elsewhere.
#[test]
fn a_slope_ends_where_its_points_end() {
    for fewer in [4, 6] {
        let folder = tile_of(|x, y| {
            let is_roof = (0.0..20.0).contains(&x) && (0.0..6.0).contains(&y);
            let number = (x / 0.5).floor() * 7.0 + (y / 0.5).floor() * 3.0;
            match (is_roof, x < 10.0, y < 4.0) {
                (false, ..) => Some((0.0, 2)),
                (true, false, _) => Some((13.0, 6)),
                (true, true, true) => Some((6.0 + y, 6)),
                (true, true, false) => (number % f64::from(fewer) == 0.0).then_some((14.0 - y, 6)),
            }
        });
        write_footprints(&folder.path().join("f.geojson"), &[("b", rectangle(0.0, 0.0, 20.0, 6.0))]);
        let (attributes, _) = run(folder.path(), "");
        assert_eq!(attributes["gable_success"], true, "{attributes:#}");
        // 1 320 m³ with a slope that runs on.
        assert!((number(&attributes, "gable_volume_lod22") - 1280.0).abs() < 15.0, "{attributes:#}");
        assert_eq!(attributes["gable_roof_planes"], 3, "{attributes:#}");
    }
}

#[test]
fn a_building_beyond_the_tile_is_partial() {
    let folder = tile(|x, y| (22.0..30.0).contains(&x) && (0.0..8.0).contains(&y));
    write_footprints(&folder.path().join("f.geojson"), &[("b", rectangle(22.0, 0.0, 42.0, 8.0))]);
    let (partial, report) = run(folder.path(), "");
    let expected = [
        ("gable_success", json!(false)),
        ("gable_lod", json!("2.2")),
        ("gable_ladder_step", json!("partial")),
        ("gable_fallback_reason", json!("incomplete")),
    ];
    for (name, value) in expected {
        assert_eq!(partial[name], value, "{name}");
    }
    assert!((number(&partial, "gable_volume_lod22") / 48.0 - 8.0).abs() < 0.5, "{partial:#}");
    assert!(number(&partial, "gable_confidence") < 0.45, "{partial:#}");
    assert_eq!((&report["counts"]["buildings_partial"], &report["counts"]["buildings_lod22"]), (&json!(1), &json!(0)));
    assert_eq!(report["buildings"][0]["outcome"], "partial");

    let (block, report) = run(folder.path(), "--partial block");
    assert_eq!((&block["gable_lod"], &block["gable_fallback_reason"]), (&json!("1.2"), &json!("incomplete")));
    assert!((number(&block, "gable_volume_lod12") / 48.0 - 20.0).abs() < 0.5, "{block:#}");
    assert_eq!(report["counts"]["buildings_lod12"], 1);
}

#[test]
fn rings_that_touch_and_sliver_holes_cost_no_part_of_the_building() {
    let folder = tile(|x, y| (0.0..20.0).contains(&x) && (0.0..14.0).contains(&y));
    let corner = |[x, y]: [f64; 2]| json!([CORNER[0] + x, CORNER[1] + y]);
    let ring = |corners: &[[f64; 2]]| -> Value { corners.iter().chain(corners.first()).map(|c| corner(*c)).collect() };
    let exterior = ring(&[[0.0, 0.0], [20.0, 0.0], [20.0, 14.0], [0.0, 14.0]]);
    let touching = ring(&[[0.0, 7.0], [6.0, 10.0], [6.0, 4.0]]);
    let sliver = ring(&[[10.0, 2.0], [18.0, 12.0], [13.985, 7.01]]);
    // The shape of the touching hole, as one ring that comes back to a point.
    let pinched =
        ring(&[[0.0, 0.0], [20.0, 0.0], [20.0, 14.0], [0.0, 14.0], [0.0, 7.0], [6.0, 10.0], [6.0, 4.0], [0.0, 7.0]]);
    for (rings, area, note) in [
        (vec![exterior.clone(), touching], 262.0, "touches itself"),
        (vec![pinched], 262.0, "touches itself"),
        (vec![exterior, sliver], 280.0, "slivers"),
    ] {
        let geometry = json!({"type": "Polygon", "coordinates": rings});
        write_footprints(&folder.path().join("f.geojson"), &[("b", geometry)]);
        let (attributes, _) = run(folder.path(), "");
        assert_eq!(attributes["gable_success"], true, "{attributes:#}");
        assert!((number(&attributes, "gable_volume_lod22") / 6.0 - area).abs() < 3.0, "{attributes:#}");
        assert!(attributes["gable_notes"].to_string().contains(note), "{attributes:#}");
    }
}
