//! What is decided in the page, and what becomes of it.

use std::fs;

use serde_json::{Value, json};

use super::bench::*;

fn plane(head: &Value, at: usize) -> Value {
    head["planes"][at]["at"].clone()
}

#[test]
fn the_list_begins_with_what_needs_a_person() {
    let bench = Bench::new();
    let server = bench.serve(&[]);
    let list = server.get("api/model").json();
    let rows = list["buildings"].as_array().unwrap();
    assert_eq!((&list["name"], &list["crs"]), (&json!("city.city.json"), &json!("EPSG:7415")));
    assert!(rows.len() > 1 && list["counts"]["open"] == rows.len());
    let urgency: Vec<f64> = rows.iter().map(|row| row["urgency"].as_f64().unwrap()).collect();
    assert!(urgency.is_sorted_by(|a, b| a >= b), "{urgency:?}");
    for row in rows {
        assert_eq!(row["urgency"] == 0.0, row["why"].as_array().unwrap().is_empty(), "{row}");
        let [x, y] = [0, 1].map(|axis| row["centre"][axis].as_f64().unwrap());
        assert!((84_000.0..86_000.0).contains(&x) && (446_000.0..448_000.0).contains(&y), "{row}");
    }
    let model: Value = serde_json::from_slice(&fs::read(&bench.model).unwrap()).unwrap();
    let attributes = &model["CityObjects"][HOUSE]["attributes"];
    let row = server.row(HOUSE);
    assert_eq!((&row["rmse"], &row["confidence"]), (&attributes["gable_rmse_lod22"], &attributes["gable_confidence"]));
    // Nothing is written before anything is decided.
    assert!(!bench.edits.exists());
    assert_eq!(server.get("api/edits").json()["buildings"], json!({}));
}

#[test]
fn a_building_is_given_with_its_points_planes_and_cells() {
    let bench = Bench::new();
    let server = bench.serve(&[]);
    let answer = server.get(&format!("api/building?id={HOUSE}"));
    let head = answer.head();
    assert_eq!((&head["id"], &head["state"], &head["valid"]), (&json!(HOUSE), &json!("open"), &json!(true)));
    assert_eq!(head["before"], head["now"]);
    assert!(head["footprint"][0][0].as_array().unwrap().len() > 3);
    let points = answer.column("points").len() / 3;
    assert!(points > 500);
    for name in ["point_classes", "intensity", "on", "distances", "excluded"] {
        assert_eq!(answer.column(name).len(), points, "{name}");
    }
    assert!(answer.column("point_classes").iter().all(|class| *class == 6));
    let lit = answer.column("intensity").iter().filter(|intensity| **intensity > 0).count();
    assert!(lit > points / 2, "{lit} of {points}");
    let around = answer.column("cloud").len() / 3;
    assert!(around > 100 && answer.column("classes").len() == around);
    assert!(answer.column("cloud_intensity").len() == around);
    assert!(answer.column("classes").contains(&2), "ground around the house");
    // On either side of the model, and most of them near it.
    let distances = answer.column("distances");
    assert!(distances.iter().any(|d| d % 2 == 1) && distances.iter().any(|d| *d > 0 && d % 2 == 0));
    assert!(distances.iter().filter(|d| **d < 400).count() > points / 2);
    let planes = head["planes"].as_array().unwrap();
    let on = answer.column("on");
    for (number, plane) in (1..).zip(planes) {
        let own = on.iter().filter(|label| **label == number).count();
        assert_eq!(plane["points"], own, "{plane}");
    }
    assert_eq!(answer.column("volumes").len(), answer.column("cleaned").len());
    assert_eq!(answer.column("faces"), answer.column("before_faces"));
    let faces = answer.column("face_kinds").len();
    assert_eq!(head["now"]["faces"], faces);
    assert_eq!(server.get("api/building?id=nobody").status, 404);
    assert_eq!(server.get("api/building").status, 400);
    // As browsers write it.
    assert_eq!(server.get(&format!("api/building?id={}", HOUSE.replace('.', "%2E"))).head()["id"], HOUSE);
}

#[test]
fn decisions_survive_a_restart_and_undoing_them_brings_the_bytes_back() {
    let bench = Bench::new();
    let before = bench.export("before.city.json");
    assert!(before == fs::read(&bench.model).unwrap());
    let floor = {
        let server = bench.serve(&["--author", "jan"]);
        let head = server.building(HOUSE);
        let floor = head["floor"].as_f64().unwrap() + 0.5;
        let now = server.edit(&head["revision"], &json!({ "set-floor": { "height": floor } })).head();
        assert_eq!((&now["state"], &now["edits"][0]["applied"]), (&json!("edited"), &json!(true)));
        assert!((now["now"]["floor"].as_f64().unwrap() - floor).abs() < 1e-9);
        assert!(now["now"]["volume"].as_f64() < now["before"]["volume"].as_f64());
        let now = server.edit(&now["revision"], &json!({ "switch-plane": { "plane": plane(&now, 0), "on": false } }));
        let now = now.head();
        let off: Vec<&Value> = now["planes"].as_array().unwrap().iter().filter(|plane| plane["on"] == false).collect();
        assert_eq!(off.len(), 1, "{now}");
        assert_eq!(server.row(HOUSE)["edits"], 2);
        floor
    };
    // The server was killed.
    let written = bench.written();
    assert_eq!((&written["type"], &written["crs"]), (&json!("gable edits"), &json!("EPSG:7415")));
    let own = &written["buildings"][HOUSE];
    assert_eq!((&own["state"], &own["edits"][0]["author"]), (&json!("edited"), &json!("jan")));
    assert!(own["edits"][0]["time"].as_str().unwrap().ends_with('Z'));
    let server = bench.serve(&[]);
    assert_eq!(server.row(HOUSE)["state"], "edited");
    let again = server.building(HOUSE);
    assert_eq!((again["edits"].as_array().unwrap().len(), again["edits"][1]["applied"].as_bool()), (2, Some(true)));
    assert!((again["now"]["floor"].as_f64().unwrap() - floor).abs() < 1e-9);
    // What is off can be named, and comes on again.
    let off = again["planes"].as_array().unwrap().iter().find(|plane| plane["on"] == false).unwrap()["at"].clone();
    let on = server.edit(&again["revision"], &json!({ "switch-plane": { "plane": off, "on": true } })).head();
    assert!(
        on["planes"].as_array().unwrap().iter().all(|plane| plane["on"] == true) && on["edits"][2]["applied"] == true
    );
    // Not accepted: the export is as before.
    assert!(bench.export("open.city.json") == before);
    assert_eq!(server.decide(HOUSE, "accepted").json()["row"]["urgency"], 0.0);
    assert!(bench.export("accepted.city.json") != before);
    let mut now = server.building(HOUSE);
    for left in [2, 1, 0] {
        now = server.turn("undo", &now["revision"]).head();
        assert_eq!((now["edits"].as_array().unwrap().len(), &now["undone"]), (left, &json!(3 - left)));
    }
    assert_eq!((&now["state"], &now["now"]), (&json!("open"), &now["before"]));
    assert_eq!(server.decide(HOUSE, "accepted").status, 200);
    assert!(bench.export("undone.city.json") == before);
    // Without limit, and back again.
    let same = server.turn("undo", &now["revision"]).head();
    assert_eq!((&same["revision"], same["edits"].as_array().unwrap().len()), (&now["revision"], 0));
    for _ in 0..3 {
        now = server.turn("redo", &now["revision"]).head();
    }
    assert_eq!((&now["undone"], now["edits"].as_array().unwrap().len()), (&json!(0), 3));
    let cleared = server.turn("clear", &now["revision"]).head();
    assert_eq!((&cleared["undone"], cleared["edits"].as_array().unwrap().len()), (&json!(3), 0));
    let first = server.turn("redo", &cleared["revision"]).head();
    assert_eq!(first["edits"][0]["name"], "set-floor");
}

#[test]
fn an_export_is_the_run_with_the_edits() {
    let bench = Bench::new();
    let server = bench.serve(&[]);
    let head = server.building(HOUSE);
    let floor = head["floor"].as_f64().unwrap() + 0.5;
    let now = server.edit(&head["revision"], &json!({ "set-floor": { "height": floor } })).head();
    let nowhere = json!({ "mark-place": { "place": [0.0, 0.0, 0.0], "inside": true } });
    let now = server.edit(&now["revision"], &nowhere).head();
    assert_eq!(now["edits"][1]["applied"], false);
    assert!(now["edits"][1]["note"].as_str().unwrap().contains("more than"), "{now}");
    assert_eq!(server.decide(HOUSE, "accepted").status, 200);
    let exported = server.post("api/export", &json!({})).json();
    let path = exported["path"].as_str().unwrap();
    assert!(path.ends_with("city.edited.city.json"), "{path}");
    assert!(exported["warnings"].to_string().contains("does not apply"), "{exported}");
    let replayed = bench.folder.path().join("replayed.city.json");
    assert_eq!(reconstruct(&replayed, &["--edits", bench.edits.to_str().unwrap()]).code, 0);
    let replayed = fs::read(replayed).unwrap();
    assert!(fs::read(path).unwrap() == replayed);
    assert!(bench.export("exported.city.json") == replayed);
    let model: Value = serde_json::from_slice(&replayed).unwrap();
    let attributes = &model["CityObjects"][HOUSE]["attributes"];
    assert_eq!((&attributes["gable_edits"], &attributes["gable_edits_refused"]), (&json!(1), &json!(1)));
    // What a run makes is what the page showed.
    assert_eq!(
        now["now"]["rmse"].as_f64().map(|rmse| (rmse * 1e3).round()),
        attributes["gable_rmse_lod22"].as_f64().map(|rmse| (rmse * 1e3).round())
    );
    // What is there is not written over unasked.
    let run: Run = command(["edit"]).arg(&bench.model).arg("--export").arg(path).output().unwrap().into();
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["city.edited.city.json", "--overwrite"]);
}

#[test]
fn whoever_knows_an_older_building_is_told_the_revision() {
    let bench = Bench::new();
    let server = bench.serve(&[]);
    let head = server.building(HOUSE);
    let lambda = |lambda: f64| json!({ "set-parameters": { "lambda": lambda } });
    let now = server.edit(&head["revision"], &lambda(0.3)).head();
    assert_eq!((&now["lambda"], now["defaults"]["lambda"].as_f64() == Some(0.3)), (&json!(0.3), false));
    let late = server.edit(&head["revision"], &lambda(0.5));
    assert_eq!(late.status, 409);
    let told: Value = serde_json::from_slice(&late.body).unwrap();
    assert_eq!(told["revision"], now["revision"]);
    // Another program changes the file.
    let mut file = bench.written();
    file["buildings"][HOUSE]["edits"] = json!([]);
    file["buildings"]["elsewhere"] = json!({ "state": "rejected" });
    fs::write(&bench.edits, file.to_string()).unwrap();
    assert_eq!(server.edit(&now["revision"], &lambda(0.5)).status, 409);
    let again = server.building(HOUSE);
    assert_eq!(again["edits"], json!([]));
    assert_eq!(server.edit(&again["revision"], &lambda(0.5)).status, 200);
    assert_eq!(bench.written()["buildings"]["elsewhere"]["state"], "rejected");
    // What cannot be written is told, and nothing is lost.
    fs::write(&bench.edits, "{").unwrap();
    let broken = server.decide(HOUSE, "accepted");
    assert_eq!(broken.status, 500);
    assert!(broken.error().contains("edits.json"), "{}", broken.error());
    assert_eq!(fs::read_to_string(&bench.edits).unwrap(), "{");
}
