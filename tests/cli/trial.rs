//! `gable evaluate --field`.

use crate::bench::{assert_says, gable, json_of, shared};

#[test]
fn fields_are_tried_on_generated_buildings() {
    let folder = tempfile::tempdir().unwrap();
    let json = folder.path().join("worth.json");
    let run = gable([
        "evaluate",
        "--field",
        "height-field,oracle",
        "--generate",
        "4",
        "--columns",
        "airborne-10",
        "--json",
        json.to_str().unwrap(),
    ]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.err, &["4 of 4 models, 0 left out", "airborne-10: scans "]);
    let table: Vec<&str> = run.out.lines().take(4).collect();
    assert!(table[0].starts_with("| Cell accuracy, % | airborne-10 |") && table[1].starts_with("| --"), "{}", run.out);
    assert!(table[2].starts_with("| height-field ") && table[3].starts_with("| oracle  "), "{}", run.out);
    assert!(table[3].ends_with(" 100.00 |"), "{}", run.out);
    let report = json_of(&json);
    let column = &report["columns"][0];
    assert_eq!((&column["column"], &column["seen"]), (&"airborne-10".into(), &4.into()));
    let figure = |field: usize, name: &str| column["fields"][field]["figures"][name].as_f64().unwrap();
    assert_eq!((figure(1, "cell_iou"), figure(1, "sign_near")), (1.0, 1.0));
    assert!(figure(0, "cell_iou") > 0.8 && figure(0, "cell_iou") <= 1.0);
    assert_eq!(column["fields"][0]["buildings"].as_array().unwrap().len(), 4);
}

#[test]
fn models_of_other_makers_are_truths() {
    let Some(folder) = shared("lod2-val") else { return };
    let [hague, vienna] = ["denhaag.city.json", "vienna.jsonl"].map(|name| folder.join(name));
    let run = gable([
        "evaluate",
        hague.to_str().unwrap(),
        vienna.to_str().unwrap(),
        "--field",
        "oracle",
        "--limit",
        "3",
        "--columns",
        "airborne-20",
    ]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.err, &["denhaag.city: 3 of ", "vienna: 3 of ", " left out"]);
    let buildings = run.out.lines().find(|line| line.starts_with("| oracle") && line.ends_with(" 6 |"));
    assert!(buildings.is_some(), "{}", run.out);
}

#[test]
fn what_cannot_be_tried_is_said() {
    for (arguments, says) in [
        ("evaluate --field oracle", "no closed and valid LoD 2 building"),
        ("evaluate --generate 2", "--field"),
        ("evaluate a b", "found 2 models, expected one"),
        ("evaluate --field oracle --generate 1 --columns dusk", "airborne-10"),
        ("evaluate --field oracle a --columns overhangs-full-view", "--generate"),
        ("evaluate --field oracle a --points b", "cannot be used with"),
        ("evaluate --field oracle nothing.city.json", "nothing.city.json"),
    ] {
        let run = gable(arguments.split(' '));
        assert_eq!(run.code, 1, "{arguments}");
        assert_says(&run.err, &[says]);
    }
}
