//! The command line of `gable edit`.

use std::fs;
use std::net::TcpListener;

use super::bench::*;

fn edit(words: &[&str]) -> Run {
    command(["edit"]).args(words).output().unwrap().into()
}

#[test]
fn what_is_missing_is_told() {
    let bench = Bench::new();
    let model = bench.model.to_str().unwrap();
    let run = edit(&["nothing.city.json"]);
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["--points"]);
    let laz = data("delft_ahn3.laz");
    let laz = laz.to_str().unwrap();
    let run = edit(&["nothing.city.json", "--points", laz]);
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["nothing.city.json"]);
    fs::remove_file(format!("{model}.report.json")).unwrap();
    let run = edit(&[model, "--points", laz]);
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["--footprints", "city.city.json.report.json"]);
    // A port that is taken.
    let taken = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = taken.local_addr().unwrap().port().to_string();
    let footprints = data("footprints.geojson");
    let all = [model, "--points", laz, "-f", footprints.to_str().unwrap(), "--no-browser"];
    let run = edit(&[&all[..], &["--port", &port]].concat());
    assert_eq!(run.code, 1);
    assert_says(&run.err, &[&port, "listen on"]);
    // What is no model, and edits in another CRS.
    let run = edit(&[&["--points", laz, "-f", all[4], "--no-browser", all[4]][..]].concat());
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["footprints.geojson", "CityJSON"]);
    fs::write(&bench.edits, r#"{"type": "gable edits", "version": 1, "crs": "EPSG:28992"}"#).unwrap();
    let run = edit(&all);
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["edits.json", "EPSG:28992", "EPSG:7415"]);
}

#[test]
fn buildings_that_are_in_one_input_only_are_told() {
    let bench = Bench::new();
    let server = bench.serve(&["--filter", &format!("id = '{HOUSE}'")]);
    let list = server.get("api/model").json();
    assert_eq!(list["buildings"].as_array().unwrap().len(), 1);
    assert!(list["notes"].to_string().contains("have no footprint here"), "{list}");
    drop(server);
    let server =
        bench.serve(&["--filter", "id >= 'NL.IMBAG.Pand.0503100000017308' AND id <= 'NL.IMBAG.Pand.0503100000017330'"]);
    let list = server.get("api/model").json();
    assert!(list["notes"].to_string().contains("are not in the model"), "{list}");
    let rows = list["buildings"].as_array().unwrap();
    assert!(rows.iter().any(|row| row["why"].to_string().contains("not in the model")));
}

#[test]
fn other_options_than_the_runs_are_told() {
    let bench = Bench::new();
    let mut server =
        bench.serve(&["--lambda", "0.9", "--edits", bench.folder.path().join("mine.json").to_str().unwrap()]);
    assert_eq!(server.building(HOUSE)["defaults"]["lambda"], 0.9);
    assert_eq!(server.decide(HOUSE, "rejected").json()["row"]["state"], "rejected");
    assert!(bench.folder.path().join("mine.json").exists() && !bench.edits.exists());
    server.child.kill().unwrap();
    let text = said(&mut server.child);
    assert_says(&text, &["lambda is 0.9 here"]);
}

#[cfg(unix)]
#[test]
fn an_interrupt_ends_it_quietly() {
    let bench = Bench::new();
    let mut server = bench.serve(&["--quiet"]);
    assert_eq!(server.decide(HOUSE, "accepted").status, 200);
    let killed = std::process::Command::new("kill").args(["-INT", &server.child.id().to_string()]).status().unwrap();
    assert!(killed.success());
    let status = server.child.wait().unwrap();
    assert_eq!(status.code(), Some(0));
    assert_eq!(said(&mut server.child), "");
    assert_eq!(bench.written()["buildings"][HOUSE]["state"], "accepted");
}
