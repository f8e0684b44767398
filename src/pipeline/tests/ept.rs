//! Entwine Point Tiles.

use std::fs;

use serde_json::{Value, json};

use super::Bench;

/// The dimensions of a point: scaled coordinates, a class and flags.
fn schema() -> Value {
    let axis =
        |name: &str, offset: f64| json!({"name": name, "type": "signed", "size": 4, "scale": 0.01, "offset": offset});
    json!([
        axis("X", 85_000.0),
        axis("Y", 447_000.0),
        axis("Z", 0.0),
        {"name": "Classification", "type": "unsigned", "size": 1},
        {"name": "ClassFlags", "type": "unsigned", "size": 1},
        {"name": "Mark", "type": "float", "size": 4},
    ])
}

/// A point of the schema.
fn stored(x: f64, y: f64, class: u8, flags: u8) -> Vec<u8> {
    let scaled = |value: f64| ((value * 100.0).round() as i32).to_le_bytes();
    [&scaled(x)[..], &scaled(y), &scaled(2.5), &[class, flags], &(x as f32).to_le_bytes()].concat()
}

/// A folder of three levels in a cube of 16; what is below the node 1-1-0-0 stands in a file of its own.
fn folder(bench: &Bench, change: impl Fn(&mut Value)) {
    for name in ["ept/ept-data", "ept/ept-hierarchy"] {
        fs::create_dir_all(bench.path(name)).unwrap();
    }
    let nodes = [
        ("0-0-0-0", [stored(1.0, 1.0, 1, 0), stored(15.0, 15.0, 1, 4)].concat()),
        ("1-0-0-0", stored(2.25, 3.0, 2, 1)),
        ("1-1-0-0", stored(9.0, 1.0, 2, 8)),
        ("2-3-1-0", [stored(13.0, 5.0, 3, 0), stored(14.0, 6.0, 3, 5)].concat()),
    ];
    for (name, bytes) in nodes {
        fs::write(bench.path(&format!("ept/ept-data/{name}.bin")), bytes).unwrap();
    }
    let hierarchy = |name: &str, text: Value| {
        fs::write(bench.path(&format!("ept/ept-hierarchy/{name}.json")), text.to_string()).unwrap();
    };
    hierarchy("0-0-0-0", json!({"0-0-0-0": 2, "1-0-0-0": 1, "1-1-0-0": -1, "1-0-1-0": 0}));
    hierarchy("1-1-0-0", json!({"1-1-0-0": 1, "2-3-1-0": 2}));
    let mut told = json!({
        "bounds": [85_000, 447_000, 0, 85_016, 447_016, 16],
        "dataType": "binary",
        "hierarchyType": "json",
        "points": 6,
        "schema": schema(),
        "span": 4,
        "srs": {"authority": "EPSG", "horizontal": "28992", "vertical": "5709"},
        "version": "1.1.0",
    });
    change(&mut told);
    fs::write(bench.path("ept/ept.json"), told.to_string()).unwrap();
}

#[test]
fn of_a_folder_only_the_wanted_nodes_are_read() {
    let bench = Bench::new();
    folder(&bench, |_| {});
    let rows = |stage: Value| bench.rows(&[stage], "X,Classification,Synthetic,Withheld,Overlap,Mark");
    let all = rows(json!("@ept/ept.json"));
    assert_eq!(all[1], [85_015.0, 1.0, 0.0, 1.0, 0.0, 15.0]);
    assert_eq!(all[2], [85_002.25, 2.0, 1.0, 0.0, 0.0, 2.25]);
    assert_eq!(all[5], [85_014.0, 3.0, 1.0, 1.0, 0.0, 14.0]);
    assert_eq!(rows(json!({"type": "readers.ept", "filename": "@ept"})), all);
    let part = |options: Value| {
        let mut stage = json!({"type": "readers.ept", "filename": "@ept/ept.json"});
        stage.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
        bench.column(&[stage], "X").into_iter().map(|x| x - 85_000.0).collect::<Vec<_>>()
    };
    assert_eq!(part(json!({"bounds": "([85008, 85016], [447000, 447008])"})), [9.0, 13.0, 14.0]);
    assert_eq!(part(json!({"polygon": "POLYGON((85012 447004, 85014 447004, 85013 447007, 85012 447004))"})), [13.0]);
    // Nodes of 4 cells: 4 m, 2 m, 1 m.
    assert_eq!(part(json!({"resolution": 4})), [1.0, 15.0]);
    assert_eq!(part(json!({"resolution": 2.5})).len(), 4);
    assert_eq!(part(json!({"resolution": 0.1})).len(), 6);
    assert_eq!(part(json!({"count": 3})), [1.0, 15.0, 2.25]);
    let outcome = bench.run(&json!(["@ept/ept.json", "@o.las"]));
    let told = &outcome.metadata["stages"]["readers.ept"];
    assert_eq!((&told["read"], &told["srs"]["code"]), (&json!(6), &json!("EPSG:7415")));
}

#[test]
fn laz_nodes_have_flags_too() {
    let bench = Bench::new();
    folder(&bench, |told| {
        told["dataType"] = json!("laszip");
        told["schema"].as_array_mut().unwrap().retain(|field| field["name"] != "ClassFlags" && field["name"] != "Mark");
    });
    fs::write(bench.path("ept/ept-hierarchy/0-0-0-0.json"), r#"{"0-0-0-0": 2}"#).unwrap();
    bench.tile("t.las", &[([85_001.0, 447_001.0, 1.0], 2), ([85_009.0, 447_009.0, 1.0], 6)]);
    let withheld = json!({"type": "filters.assign", "value": "Withheld = 1 WHERE X > 85005"});
    bench.run(&json!(["@t.las", withheld, {"type": "writers.las", "filename": "@ept/ept-data/0-0-0-0.laz"}]));
    let rows = bench.rows(&[json!("@ept/ept.json")], "X,Classification,Withheld");
    assert_eq!(rows, [[85_001.0, 2.0, 0.0], [85_009.0, 6.0, 1.0]]);
}

#[test]
fn what_is_wrong_with_a_folder_is_told() {
    let bench = Bench::new();
    let fault = |part: &str, change: &dyn Fn(&mut Value)| {
        folder(&bench, change);
        let message = bench.fault(&json!(["@ept/ept.json", {"type": "writers.null"}]));
        assert!(message.contains("ept.json") && message.contains(part), "{message}");
    };
    fault("\"zstandard\" as \"dataType\"", &|told| told["dataType"] = json!("zstandard"));
    fault("no box", &|told| told["bounds"] = json!([0, 0, 0, -1, 1, 1]));
    fault("missing field `span`", &|told| drop(told.as_object_mut().unwrap().remove("span")));
    fault("0 as \"span\"", &|told| told["span"] = json!(0));
    fault("X of 3 bytes", &|told| told["schema"][0]["size"] = json!(3));
    fault("no Z", &|told| told["schema"][2]["name"] = json!("Height"));
    fault("x twice", &|told| told["schema"][3]["name"] = json!("x"));
    let read = |further: Value| {
        let mut stage = json!({"filename": "@ept/ept.json"});
        stage.as_object_mut().unwrap().extend(further.as_object().unwrap().clone());
        json!([stage, {"type": "writers.null"}])
    };
    let broken = |name: &str, bytes: &str, part: &str| {
        folder(&bench, |_| {});
        fs::write(bench.path(name), bytes).unwrap();
        let message = bench.fault(&read(json!({})));
        assert!(message.contains(part), "{message}");
    };
    broken("ept/ept-hierarchy/0-0-0-0.json", "[1]", "node names");
    broken("ept/ept-hierarchy/0-0-0-0.json", r#"{"0-1-0-0": 1}"#, "`0-1-0-0`");
    broken("ept/ept-hierarchy/0-0-0-0.json", r#"{"0-0-0-0": -5}"#, "-5 points");
    broken("ept/ept-hierarchy/1-1-0-0.json", r#"{"1-1-0-0": -1}"#, "itself");
    broken("ept/ept-data/1-0-0-0.bin", "short", "5 bytes, expected 1 points of 18 bytes");
    // Or what can be read is.
    let outcome = bench.run(&read(json!({"ignore_unreadable": true})));
    assert_eq!((outcome.exit_code, &outcome.metadata["stages"]["readers.ept"]["read"]), (2, &json!(5)));
    fs::remove_file(bench.path("ept/ept-data/0-0-0-0.bin")).unwrap();
    assert!(bench.fault(&read(json!({}))).contains("0-0-0-0.bin"));
}
