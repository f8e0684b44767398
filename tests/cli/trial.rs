//! `gable evaluate --field`.

use crate::bench::{Run, assert_says, command, data, gable, json_of, shared};

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
fn fields_are_tried_on_real_scans_by_points_held_out() {
    let folder = tempfile::tempdir().unwrap();
    let [tile, footprints] = ["delft_ahn3.laz", "footprints.geojson"].map(data);
    let trial = |name: &str, jobs: &str, more: &[&str]| {
        let json = folder.path().join(name);
        let mut command = command(["evaluate", "--field", "height-field", "--hold-out", "0.5", "--jobs", jobs]);
        command.args(more).arg("--json").arg(&json).arg("--points").arg(&tile).arg("--footprints").arg(&footprints);
        let run = Run::from(command.output().unwrap());
        assert_eq!(run.code, 0, "{}", run.err);
        (run, json_of(&json))
    };
    let (run, report) = trial("a.json", "1", &[]);
    assert_says(&run.out, &["| by the points held out", "height-field", "Missing, m²", "Confidence from 0.9"]);
    let figures = &report["fields"][0]["figures"];
    // Of 71 footprints 66 hold 50 points.
    assert_eq!(figures["buildings"], 66);
    let figure = |figures: &serde_json::Value, pointer: &str| figures.pointer(pointer).unwrap().as_f64().unwrap();
    assert!(
        figure(figures, "/vertical/median") < 0.05 && figure(figures, "/vertical/within_0_2") > 0.75,
        "{figures:#}"
    );
    assert!(figure(figures, "/completeness/missing/from_10") <= 3.0, "{figures:#}");
    // The same whatever the number of threads, but for the time it takes.
    let timeless = |mut report: serde_json::Value| {
        let field = &mut report["fields"][0];
        field["figures"]["cpu_ms"].take();
        field["buildings"].as_array_mut().unwrap().iter_mut().for_each(|building| drop(building["cpu_ms"].take()));
        report
    };
    let thin = ["--density", "1"];
    let (_, one) = trial("b.json", "1", &thin);
    let (_, two) = trial("c.json", "2", &thin);
    assert_eq!(timeless(one.clone()), timeless(two));
    // From fewer points, judged by the same.
    let thinned = &one["fields"][0];
    assert!(figure(&thinned["figures"], "/vertical/median") > figure(figures, "/vertical/median"));
    for (a, b) in
        thinned["buildings"].as_array().unwrap().iter().zip(report["fields"][0]["buildings"].as_array().unwrap())
    {
        assert_eq!((&a["id"], &a["held_out"]), (&b["id"], &b["held_out"]));
        assert!(a["points"].as_u64() <= b["points"].as_u64());
    }
}

#[test]
fn what_cannot_be_tried_is_said() {
    for (arguments, says) in [
        ("evaluate --field oracle", "no closed and valid LoD 2 building"),
        ("evaluate --generate 2", "--field"),
        ("evaluate --field oracle --generate 1 --points a.laz", "--hold-out"),
        ("evaluate --field oracle --points a.laz --footprints a.geojson --hold-out 0.5", "fields that need no truth"),
        ("evaluate --field height-field --points a.laz --hold-out 0.5", "--footprints"),
        ("evaluate --field height-field --points a.laz --footprints a.geojson --hold-out 1", "below 1"),
        ("evaluate a b", "found 2 models, expected one"),
        ("evaluate --field oracle --generate 1 --columns dusk", "airborne-10"),
        ("evaluate --field oracle a --columns overhangs-full-view", "--generate"),
        ("evaluate --field oracle a --reference b", "cannot be used with"),
        ("evaluate --field oracle nothing.city.json", "nothing.city.json"),
    ] {
        let run = gable(arguments.split(' '));
        assert_eq!(run.code, 1, "{arguments}");
        assert_says(&run.err, &[says]);
    }
}
