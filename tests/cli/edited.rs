//! `gable reconstruct --edits`.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};
use tempfile::tempdir;

use crate::bench::*;

const HOUSE: &str = "NL.IMBAG.Pand.0503100000017310";

fn reconstruct(output: &Path, rest: &[&str]) -> Run {
    let mut command = command(["reconstruct"]);
    command.arg(data("delft_ahn3.laz")).arg("-f").arg(data("footprints.geojson")).arg("-o").arg(output);
    command
        .args(["--filter", &format!("id = '{HOUSE}'"), "--field", "height-field"])
        .args(rest)
        .output()
        .unwrap()
        .into()
}

fn read(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

#[test]
fn a_building_is_made_as_its_edits_say() {
    let folder = tempdir().unwrap();
    let [plain, edited, edits] = ["a.city.json", "b.city.json", "edits.json"].map(|name| folder.path().join(name));
    assert_eq!(reconstruct(&plain, &[]).code, 0);
    let house = |path: &Path| read(path)["CityObjects"][HOUSE]["attributes"].clone();
    let before = house(&plain);
    assert!(before["gable_edits"].is_null());
    let floor = before["gable_height_ground"].as_f64().unwrap() + 0.5;
    let write = |state: Option<&str>, crs: &str| {
        let mut building = json!({ "edits": [
            { "action": { "set-floor": { "height": floor } }, "author": "jan", "time": "2026-11-30T12:00:00Z" },
            { "action": { "mark-place": { "place": [0.0, 0.0, 0.0], "inside": true } } },
        ] });
        if let Some(state) = state {
            building["state"] = state.into();
        }
        let all = json!({ "type": "gable edits", "version": 1, "crs": crs, "buildings": { HOUSE: building } });
        fs::write(&edits, all.to_string()).unwrap();
    };
    let own = edits.to_str().unwrap();
    write(None, "EPSG:7415");
    let run = reconstruct(&edited, &["--edits", own]);
    assert_eq!(run.code, 0, "{}", run.err);
    // What does not apply is said where it is looked for.
    assert_says(&run.err, &[HOUSE, "edit 2 (mark-place) does not apply"]);
    let after = house(&edited);
    assert_eq!((&after["gable_edits"], &after["gable_edits_refused"]), (&json!(1), &json!(1)));
    assert_eq!((&after["gable_height_ground"], &after["gable_ground_source"]), (&json!(floor), &json!("edit")));
    assert!(after["gable_notes"].to_string().contains("edit 2 (mark-place) does not apply"));
    assert!(after["gable_volume_lod22"].as_f64() < before["gable_volume_lod22"].as_f64());
    let report = read(&folder.path().join("b.city.json.report.json"));
    assert_eq!(report["buildings"][0]["edits"]["refused"][0]["number"], 2);
    assert!(report["warnings"].to_string().contains("does not apply"));
    // The same bytes on any number of threads.
    let bytes = fs::read(&edited).unwrap();
    assert_eq!(reconstruct(&edited, &["--edits", own, "--overwrite", "-j", "1"]).code, 0);
    assert!(bytes == fs::read(&edited).unwrap());
    // What nobody has accepted is not followed, and that is said.
    write(Some("edited"), "EPSG:7415");
    let run = reconstruct(&edited, &["--edits", own, "--overwrite"]);
    assert_says(&run.err, &["not accepted", HOUSE]);
    assert!(fs::read(&edited).unwrap() == fs::read(&plain).unwrap());
    write(None, "EPSG:28992");
    let run = reconstruct(&edited, &["--edits", own, "--overwrite"]);
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["edits.json", "EPSG:28992", "EPSG:7415"]);
}

#[test]
fn a_file_that_holds_no_edits_is_told() {
    let folder = tempdir().unwrap();
    let [model, edits] = ["a.city.json", "edits.json"].map(|name| folder.path().join(name));
    let own = edits.to_str().unwrap();
    for (text, parts) in [
        (None, vec!["edits.json"]),
        (Some("{\"type\": \"FeatureCollection\"}"), vec!["edits.json", "version"]),
        (
            Some(
                "{\"type\": \"gable edits\", \"version\": 1,\n\"buildings\": {\"a\": {\"edits\": [{\"action\": {\"fly\": {}}}]}}}",
            ),
            vec!["edits.json", "line 2", "unknown variant `fly`", "schemas/edits.schema.json"],
        ),
    ] {
        if let Some(text) = text {
            fs::write(&edits, text).unwrap();
        }
        let run = reconstruct(&model, &["--edits", own]);
        assert_eq!(run.code, 1, "{}", run.err);
        assert_says(&run.err, &parts);
        assert!(!model.exists());
    }
    // It is not written over.
    let run = reconstruct(&edits, &["--edits", own, "--overwrite"]);
    assert!(run.code == 1 && fs::read_to_string(&edits).unwrap().contains("fly"), "{}", run.err);
}
