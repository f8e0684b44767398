//! Which buildings become blocks, heights that are stated, roofs of glass, and the grid of the coordinates.

use std::path::Path;

use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};

use crate::bench::*;

/// A tile with a roof at 6 m over [0, 10] × [0, 8] whose points `is_kept`, on ground that is seen elsewhere, and inside the
/// footprint where `sees_ground`.
fn folder_of(is_kept: impl Fn(usize) -> bool, sees_ground: impl Fn(usize) -> bool, properties: &Value) -> TempDir {
    let folder = tempdir().unwrap();
    let mut points = Vec::new();
    let places = (-20..40).flat_map(|i| (-20..36).map(move |j| (f64::from(i) * 0.5 + 0.25, f64::from(j) * 0.5 + 0.25)));
    for (n, (x, y)) in places.enumerate() {
        let is_roof = (0.0..10.0).contains(&x) && (0.0..8.0).contains(&y);
        let place = (CORNER[0] + x, CORNER[1] + y);
        if is_roof && is_kept(n) {
            points.push((place.0, place.1, 6.0, 6));
        }
        if !is_roof || sees_ground(n) {
            points.push((place.0, place.1, 0.0, 2));
        }
    }
    write_tile(&folder.path().join("a.las"), None, &points);
    let feature = json!({"type": "Feature", "properties": properties, "geometry": rectangle(0.0, 0.0, 10.0, 8.0)});
    let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::28992"}});
    let file = json!({"type": "FeatureCollection", "crs": crs, "features": [feature]});
    std::fs::write(folder.path().join("f.geojson"), file.to_string()).unwrap();
    folder
}

fn run(folder: &Path, rest: &str) -> Value {
    let run = run_in(folder, "a.las", "f.geojson", &format!("--overwrite {rest}"));
    assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    let out = folder.join("out.city.json");
    assert_valid(&out);
    assert_eq!(gable(["validate", "--strict", out.to_str().unwrap()]).code, 0);
    report_of(&out);
    json_of(&out)["CityObjects"]["b"]["attributes"].clone()
}

fn said(attributes: &Value, names: [&str; 2]) -> [Value; 2] {
    names.map(|name| attributes[format!("gable_{name}")].clone())
}

#[test]
fn blocks_are_made_where_they_are_asked_for() {
    let folder = folder_of(|_| true, |_| false, &json!({"id": "b", "simple": "yes"}));
    let of = |rest: &str| said(&run(folder.path(), rest), ["lod", "fallback_reason"]);
    assert_eq!(of(""), [json!("2.2"), json!(null)]);
    assert_eq!(of("--block-attribute simple"), [json!("1.2"), json!("as-asked")]);
    assert_eq!(of("--block-above 79"), [json!("1.2"), json!("as-asked")]);
    assert_eq!(of("--minimum-density 4.5"), [json!("1.2"), json!("low-density")]);
    assert_eq!(of("--maximum-no-data 0.5 --minimum-density 3.9 --block-above 81"), [json!("2.2"), json!(null)]);
    let half = folder_of(|n| n % 56 < 28, |_| false, &json!({"id": "b"}));
    let of = |rest: &str| said(&run(half.path(), rest), ["lod", "fallback_reason"]);
    assert_eq!(of("--maximum-no-data 0.2"), [json!("1.2"), json!("missing-data")]);
}

#[test]
fn a_height_that_is_stated_makes_a_block_of_what_has_no_points() {
    let folder = folder_of(|_| false, |_| false, &json!({"id": "b", "top": "7.5"}));
    // Another building has points, or there would be no model at all.
    let mut file = json_of(folder.path().join("f.geojson"));
    let other = json!({"type": "Feature", "properties": {"id": "c"}, "geometry": rectangle(12.0, 0.0, 14.0, 2.0)});
    file["features"].as_array_mut().unwrap().push(other);
    std::fs::write(folder.path().join("f.geojson"), file.to_string()).unwrap();
    let stated =
        run_in(folder.path(), "a.las", "f.geojson", "--roof-height-attribute top --building-class 6,1 --quiet");
    // Without any building point in the tile nothing can be told.
    assert_eq!(stated.code, 1, "{}", stated.err);
    let folder = folder_of(|_| false, |_| false, &json!({"id": "b", "top": "7.5"}));
    let extra = folder.path().join("b.las");
    write_tile(
        &extra,
        None,
        &[(CORNER[0] + 18.0, CORNER[1] + 15.0, 3.0, 6), (CORNER[0] + 17.0, CORNER[1] + 15.0, 3.0, 6)],
    );
    let attributes = |rest: &str| {
        let run = run_in(folder.path(), "a.las b.las", "f.geojson", &format!("--overwrite {rest}"));
        assert_eq!(run.code, 0, "{}{}", run.out, run.err);
        json_of(folder.path().join("out.city.json"))["CityObjects"]["b"]["attributes"].clone()
    };
    let datum = attributes("--roof-height-attribute top");
    assert_eq!(said(&datum, ["lod", "fallback_reason"]), [json!("1.2"), json!("no-points")]);
    assert!((datum["gable_volume_lod12"].as_f64().unwrap() - 600.0).abs() < 1.0, "{datum:#}");
    assert!(datum["gable_notes"].to_string().contains("the one that is stated"), "{datum:#}");
    let ground = attributes("--roof-height-attribute TOP --roof-height-above ground --ground-percentile 50");
    assert!((ground["gable_volume_lod12"].as_f64().unwrap() - 600.0).abs() < 1.0, "{ground:#}");
    let none = run_in(folder.path(), "a.las b.las", "f.geojson", "--overwrite");
    assert_eq!(none.code, 1, "without it there is no model: {}", none.err);
}

#[test]
fn ground_under_glass_is_no_hole() {
    // One return of three is of the glass, the others are of the ground under it.
    let folder = folder_of(|n| n % 3 == 0, |n| n % 3 != 0, &json!({"id": "b", "glass": 1}));
    let opaque = run(folder.path(), "--open-ground-area 1");
    let glass = run(folder.path(), "--open-ground-area 1 --glass-attribute glass");
    assert_eq!(said(&glass, ["success", "open_ground_area"]), [json!(true), json!(null)]);
    assert!((glass["gable_volume_lod22"].as_f64().unwrap() - 480.0).abs() < 5.0, "{glass:#}");
    assert!(glass["gable_notes"].to_string().contains("of glass"), "{glass:#}");
    assert!(opaque["gable_confidence"].as_f64() <= glass["gable_confidence"].as_f64(), "{opaque:#}");
}

#[test]
fn coordinates_stand_on_the_grid_that_is_asked_for() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("a.city.json");
    let run = delft(&out, "--field height-field --grid-scale 0.001 --translation 84000,447000,-10.5");
    assert_eq!(run.code, 0, "{}", run.err);
    let model = json_of(&out);
    assert_eq!(model["transform"], json!({"scale": [0.001, 0.001, 0.001], "translate": [84000.0, 447_000.0, -10.5]}));
    let checked = gable(["validate", "--strict", out.to_str().unwrap()]);
    assert_eq!(checked.code, 0, "{}", checked.out);
    assert_says(&checked.out, &["on a grid of 0.001 m"]);
    assert!(report_of(&out)["counts"]["buildings_lod22"].as_u64().unwrap() >= 68);
}
