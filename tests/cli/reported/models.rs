//! Rows about models: where they go, and whether they are valid. The codes of all others are in `agreement`.

use serde_json::Value;

use super::reports;
use crate::bench::*;

/// 18: standard output under both of its names.
#[test]
fn a_model_goes_to_standard_output() {
    let Some(reports) = reports() else { return };
    let folder = tempfile::tempdir().unwrap();
    for name in ["-", "/dev/stdout"] {
        let mut command = command(["reconstruct"]);
        command.arg(reports.join("base.laz")).arg("-f").arg(reports.join("base.geojson")).args(["-o", name]);
        let run: Run = command.current_dir(folder.path()).output().unwrap().into();
        assert_ends(&run, 0, &["solids at LoD 2.2         2"]);
        let lines: Vec<Value> = run.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        assert_eq!((lines.len(), &lines[0]["type"], &lines[1]["id"]), (3, &"CityJSON".into(), &"b0".into()));
    }
    assert!(names_in(folder.path()).is_empty(), "no folder of that name is made");
}

/// 20: a part of a face that is turned by rounding alone. It counts where rounding is no excuse, and is not written.
#[test]
fn a_turn_by_rounding_counts_where_it_is_asked_for() {
    let Some(reports) = reports() else { return };
    let file = reports.join("20-normals-204.city.jsonl");
    let run = gable(["validate".as_ref(), file.as_os_str()]);
    assert_ends(&run, 0, &[]);
    let run = gable(["validate".as_ref(), file.as_os_str(), "--no-rounding".as_ref()]);
    assert_ends(&run, 2, &[]);
    assert_says(&run.out, &["204 NON_PLANAR_POLYGON_NORMALS_DEVIATION"]);
}

/// 21 to 23: parts that overlap, a template that is not planar where it stands, solids that cross.
#[test]
fn faults_of_val3dity_are_found_by_its_codes() {
    let Some(reports) = reports() else { return };
    for (file, code) in [
        ("21-overlapping-parts-601.json", "601 BUILDINGPARTS_OVERLAP"),
        ("22-geometry-template-203.json", "203 NON_PLANAR_POLYGON_DISTANCE_PLANE"),
        ("23-composite-501.json", "501 INTERSECTION_SOLIDS"),
    ] {
        let run = gable(["validate".as_ref(), reports.join(file).as_os_str()]);
        assert_ends(&run, 2, &[]);
        assert_says(&run.out, &["INVALID (geometry)", code]);
        assert!(!run.out.contains("503"), "{file}: {}", run.out);
    }
}
