//! What is there and not used, guessed, or less true than it looks is told.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};

use crate::bench::*;

/// The WKT of the Dutch system with heights of a datum that nobody knows.
const UNKNOWN_HEIGHTS: &str = r#"COMPD_CS["RD + local",PROJCS["Amersfoort / RD New",GEOGCS["Amersfoort",DATUM["Amersfoort",SPHEROID["Bessel 1841",6377397.155,299.1528128]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Oblique_Stereographic"],PARAMETER["latitude_of_origin",52.1561605555556],PARAMETER["central_meridian",5.38763888888889],PARAMETER["scale_factor",0.9999079],PARAMETER["false_easting",155000],PARAMETER["false_northing",463000],UNIT["metre",1],AUTHORITY["EPSG","28992"]],VERT_CS["my geoid",VERT_DATUM["./geoid/local.bin",2005],UNIT["metre",1.0],AXIS["Up",UP]]]"#;

const RD: &str = "--crs=EPSG:28992 --footprint-crs=EPSG:28992";

/// The house of [`write_house`] as a footprint.
fn footprint(folder: &Path, corner: [f64; 2]) -> PathBuf {
    let [x, y] = corner;
    let ring = json!([[x, y], [x + 10.0, y], [x + 10.0, y + 8.0], [x, y + 8.0], [x, y]]);
    let file = json!({"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {"id": "a"},
        "geometry": {"type": "Polygon", "coordinates": [ring]}}]});
    let path = folder.join("house.geojson");
    std::fs::write(&path, file.to_string()).unwrap();
    path
}

/// Points of the house and of the ground around it.
fn house(roof: f64, ground: u8) -> Vec<(f64, f64, f64, u8)> {
    let mut points = Vec::new();
    for i in -20..40 {
        for j in -20..36 {
            let (x, y) = (f64::from(i) * 0.5 + 0.25, f64::from(j) * 0.5 + 0.25);
            if (0.0..10.0).contains(&x) && (0.0..8.0).contains(&y) {
                points.push((CORNER[0] + x, CORNER[1] + y, roof, 6));
            } else {
                points.push((CORNER[0] + x, CORNER[1] + y, 0.0, ground));
            }
        }
    }
    points
}

/// Reconstructs one house of these points.
fn run(points: &[(f64, f64, f64, u8)], rest: &str) -> (TempDir, Run) {
    let folder = tempdir().unwrap();
    let tile = folder.path().join("house.laz");
    write_tile(&tile, None, points);
    let (footprint, out) = (footprint(folder.path(), CORNER), folder.path().join("out.city.json"));
    let run = reconstruct(&[&tile], &footprint, &out, &format!("{RD} {rest}"));
    (folder, run)
}

/// The building in `out.city.json`.
fn attributes(folder: &TempDir) -> Value {
    json_of(folder.path().join("out.city.json"))["CityObjects"]["a"]["attributes"].clone()
}

#[test]
fn points_of_the_overlap_class_are_told_with_the_option_that_uses_them() {
    let folder = tempdir().unwrap();
    let tile = folder.path().join("house.las");
    write_tile(&tile, None, &house(6.0, 2));
    let mut n = 0;
    change(&tile, |record| {
        n += 1;
        record[16] = if record[16] == 6 && n % 20 > 0 { 12 } else { record[16] };
    });
    let (footprint, out) = (footprint(folder.path(), CORNER), folder.path().join("out.city.json"));
    let run = reconstruct(&[&tile], &footprint, &out, RD);
    assert_says(&run.err, &["in 1 of 1 footprints", "of class 12 (overlap)", "--building-class 6,12 would use them"]);
    let run = reconstruct(&[&tile], &footprint, &out, &format!("{RD} --building-class 6,12 --overwrite"));
    assert!(run.code == 0 && !run.err.contains("class 12"), "{}", run.err);
    let info = gable(["info".as_ref(), tile.as_os_str()]);
    assert_says(&info.out, &["of class 12 (overlap), which is used only with --building-class 6,12"]);
}

/// Changes the records of an uncompressed tile of point format 6, in which byte 15 has the flags and byte 16 the class.
fn change(tile: &Path, mut change: impl FnMut(&mut [u8])) {
    let mut bytes = std::fs::read(tile).unwrap();
    let start = u32::from_le_bytes(bytes[96..100].try_into().unwrap()) as usize;
    bytes[start..].chunks_exact_mut(30).for_each(&mut change);
    std::fs::write(tile, bytes).unwrap();
}

#[test]
fn synthetic_and_withheld_points_are_told_with_the_option_that_uses_them() {
    for (flag, is_synthetic) in [("synthetic", true), ("withheld", false)] {
        let folder = tempdir().unwrap();
        let tile = folder.path().join("house.las");
        write_tile(&tile, None, &house(6.0, 2));
        change(&tile, |record| {
            if record[16] == 6 {
                record[15] |= if is_synthetic { 1 } else { 4 };
            }
        });
        let (footprint, out) = (footprint(folder.path(), CORNER), folder.path().join("out.city.json"));
        let run = reconstruct(&[&tile], &footprint, &out, RD);
        assert_eq!(run.code, 1, "{}", run.err);
        assert_says(&run.err, &[&format!("marked as {flag}"), &format!("--use-flagged {flag} would use them")]);
        let rest = format!("{RD} --use-flagged {flag} --overwrite");
        let run = reconstruct(&[&tile], &footprint, &out, &rest);
        assert_eq!(run.code, 0, "{}", run.err);
        assert_eq!(json_of(&out)["CityObjects"]["a"]["attributes"]["gable_success"], true);
        let info = gable(["info".as_ref(), tile.as_os_str()]);
        assert_says(&info.out, &[&format!("marked as {flag} and used only with --use-flagged {flag}")]);
    }
}

#[test]
fn a_floor_that_was_guessed_is_told_and_trusted_less() {
    let (known, _) = run(&house(6.0, 2), "");
    let (guessed, run_of_guess) = run(&house(6.0, 1), "");
    assert_says(&run_of_guess.err, &["the floors of 1 of 1 buildings were guessed", "ground class 2"]);
    let (known, guessed) = (attributes(&known), attributes(&guessed));
    assert_says(&guessed["gable_notes"].to_string(), &["no ground points around it"]);
    let confidence = |of: &Value| of["gable_confidence"].as_f64().unwrap();
    assert!(confidence(&guessed) < 0.8 * confidence(&known), "{known} {guessed}");
    // A roof that lies hardly above the ground.
    let (low, run_of_low) = run(&house(0.6, 2), "");
    let flat = attributes(&low);
    let outcome = (flat["gable_success"].as_bool(), flat["gable_fallback_reason"].as_str());
    assert_eq!(outcome, (Some(false), Some("too-low")), "{flat} {}", run_of_low.err);
    assert_says(flat["gable_fallback_detail"].as_str().unwrap(), &["above the ground, less than 1 m"]);
}

#[test]
fn a_roof_alone_is_no_success() {
    // A gable of 45°, and nothing below its eaves.
    let gable = |(x, y, roof, class)| (x, y, roof + 4.0 - f64::abs(y - CORNER[1] - 4.0), class);
    let points: Vec<_> = house(6.0, 2).into_iter().filter(|point| point.3 == 6).map(gable).collect();
    let (folder, run_of_roof) = run(&points, "");
    let attributes = attributes(&folder);
    let outcome = (attributes["gable_success"].as_bool(), attributes["gable_fallback_reason"].as_str());
    assert_eq!(outcome, (Some(false), Some("too-low")), "{attributes} {}", run_of_roof.err);
    assert_says(attributes["gable_fallback_detail"].as_str().unwrap(), &["nothing tells of the floor"]);
    assert_eq!(attributes["gable_ground_source"], "bounding-box");
}

#[test]
fn a_stated_floor_must_be_there() {
    let (_, run_of_name) = run(&house(6.0, 2), "--ground-attribute maaiveld");
    assert_eq!(run_of_name.code, 1);
    assert_says(&run_of_name.err, &["house.geojson", "no attribute \"maaiveld\"", "--ground-attribute"]);
    let (_, run_of_model) = run(&house(6.0, 2), "--dtm nowhere.tif");
    assert_eq!(run_of_model.code, 1);
    assert_says(&run_of_model.err, &["nowhere.tif: found no such file or folder"]);
}

#[test]
fn classes_that_do_not_occur_are_told() {
    let points = house(6.0, 2);
    let (_, run_of_ground) = run(&points, "--ground-class 8");
    assert_says(&run_of_ground.err, &["no point is of class 8 of --ground-class; the classes are 2 (", "6 ("]);
    let (_, run_of_building) = run(&points, "--building-class 6,60");
    assert_says(&run_of_building.err, &["no point is of class 60 of --building-class"]);
}

#[test]
fn heights_of_an_unknown_datum_leave_the_horizontal_system() {
    let folder = tempdir().unwrap();
    let tile = folder.path().join("house.laz");
    write_tile(&tile, Some(UNKNOWN_HEIGHTS), &house(6.0, 2));
    let (footprint, out) = (footprint(folder.path(), CORNER), folder.path().join("out.city.json"));
    let run = reconstruct(&[&tile], &footprint, &out, "--footprint-crs EPSG:28992");
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.err, &["nobody knows the vertical system `my geoid`", "EPSG:28992"]);
    assert_eq!(json_of(&out)["metadata"]["referenceSystem"], "https://www.opengis.net/def/crs/EPSG/0/28992");
    let tiles = folder.path().join("out.3dtiles");
    let converted = gable(["convert".as_ref(), out.as_os_str(), "-o".as_ref(), tiles.as_os_str()]);
    assert_eq!(converted.code, 0, "{}", converted.err);
    let direct = folder.path().join("direct.3dtiles");
    let run = reconstruct(&[&tile], &footprint, &direct, "--footprint-crs EPSG:28992");
    assert_eq!(run.code, 0, "{}", run.err);
}

#[test]
fn metres_that_are_none_are_told_and_corrected() {
    let folder = tempdir().unwrap();
    let tile = folder.path().join("house.laz");
    // Delft, 52 degrees north: a metre of EPSG:3857 is 0.616 m.
    let corner = [485_000.0, 6_797_000.0];
    let points: Vec<_> = house(6.0, 2)
        .into_iter()
        .map(|(x, y, z, class)| (x - CORNER[0] + corner[0], y - CORNER[1] + corner[1], z, class))
        .collect();
    write_tile(&tile, None, &points);
    let (footprint, out) = (footprint(folder.path(), corner), folder.path().join("out.city.json"));
    let run = reconstruct(&[&tile], &footprint, &out, "--crs EPSG:3857 --footprint-crs EPSG:3857");
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.err, &["a metre of EPSG:3857", "is 0.61", "m on the ground here"]);
    let volume = json_of(&out)["CityObjects"]["a"]["attributes"]["gable_volume_lod22"].as_f64().unwrap();
    assert!((volume / (80.0 * 6.0 * 0.616 * 0.616) - 1.0).abs() < 0.02, "{volume}");
    let info = gable(["info".as_ref(), tile.as_os_str(), "--crs".as_ref(), "EPSG:3857".as_ref()]);
    assert_says(&info.out, &["a metre of EPSG:3857"]);
}
