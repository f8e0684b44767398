//! `gable pipeline` and `gable stages`.

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::Stdio;

use serde_json::{Value, json};
use tempfile::TempDir;

use crate::bench::{Run, assert_valid, command, data, delft, gable, json_of, report_of};

/// A folder that looks like the repository to a pipeline, but for what it writes.
struct Repository(TempDir);

impl Repository {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        for name in ["examples", "pipelines", "schemas"] {
            std::os::unix::fs::symlink(root.join(name), folder.path().join(name)).unwrap();
        }
        Self(folder)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// `gable pipeline ARGUMENTS`, blanks part them.
    fn pipeline(&self, arguments: &str) -> Run {
        let mut command = command(["pipeline"]);
        command.args(arguments.split_whitespace()).current_dir(self.0.path()).output().unwrap().into()
    }

    /// A pipeline from standard input.
    fn feed(&self, pipeline: &Value, arguments: &str) -> Run {
        let mut command = command(["pipeline", "--stdin"]);
        let command = command.args(arguments.split_whitespace()).current_dir(self.0.path());
        let mut child = command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        child.stdin.take().unwrap().write_all(pipeline.to_string().as_bytes()).unwrap();
        child.wait_with_output().unwrap().into()
    }
}

/// The number of buildings in a city model, and of those with a solid at LoD 2.2.
fn buildings(model: &Path) -> (usize, usize) {
    let counts = &report_of(model)["counts"];
    let count = |name: &str| counts[name].as_u64().unwrap() as usize;
    (count("written"), count("buildings_lod22"))
}

#[test]
fn the_quick_start_is_that_of_the_command() {
    let repository = Repository::new();
    let run = repository.pipeline("pipelines/quickstart.json");
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.out.contains("LoD 2.2"), "{}", run.out);
    let model = repository.path("out/quickstart.city.json");
    let by_command = repository.path("command.city.json");
    delft(&by_command, "");
    assert_eq!(fs::read(&model).unwrap(), fs::read(&by_command).unwrap());

    // Points that go through a filter, and so through a file of their own, give the same buildings; that most of them
    // were left out does not make footprints look uncovered.
    let stages = json!([
        "examples/data/delft_ahn3.laz",
        {"type": "filters.expression", "expression": "Classification == 6 || Classification == 2"},
        {"type": "writers.lod2", "footprints": "examples/data/footprints.geojson", "filename": "out/fed.city.json"},
    ]);
    let run = repository.feed(&stages, "");
    assert_eq!(run.code, 0, "{}", run.err);
    assert_eq!(fs::read(repository.path("out/fed.city.json")).unwrap(), fs::read(&by_command).unwrap());

    // A second time it exists.
    let run = repository.feed(&stages, "");
    assert_eq!(run.code, 1);
    assert!(run.err.contains("overwrite"), "{}", run.err);
}

#[test]
fn ready_made_pipelines_run() {
    let repository = Repository::new();
    for (name, least) in [("unclassified", 65), ("ground", 65), ("fast", 65), ("high-quality", 69)] {
        let run = repository.pipeline(&format!("pipelines/{name}.json"));
        assert!(run.code == 0 || run.code == 2, "{name}: {}", run.err);
        let model = repository.path(&format!("out/{name}.city.json"));
        assert_valid(&model);
        let (written, lod22) = buildings(&model);
        assert!(written == 71 && lod22 >= least, "{name}: {lod22} of {written}");
    }
}

/// The classes of the points of the bundled tile behind these stages, in the order of the file.
fn classes(repository: &Repository, stages: &[Value]) -> Vec<u8> {
    let mut all = vec![json!("examples/data/delft_ahn3.laz")];
    all.extend_from_slice(stages);
    all.push(json!({"type": "writers.text", "filename": "classes.csv", "order": "Classification:0",
        "keep_unspecified": false, "write_header": false}));
    let run = repository.feed(&Value::Array(all), "");
    assert_eq!(run.code, 0, "{}", run.err);
    let text = fs::read_to_string(repository.path("classes.csv")).unwrap();
    text.lines().map(|line| line.parse().unwrap()).collect()
}

#[test]
fn ground_is_found_where_nobody_told_it() {
    let repository = Repository::new();
    let own = classes(&repository, &[]);
    let forget = json!({"type": "filters.assign", "value": "Classification = 1"});
    for (stage, ground, roofs) in
        [(json!({"type": "filters.smrf", "window": 30}), 0.95, 0.02), (json!({"type": "filters.csf"}), 0.95, 0.02)]
    {
        let found = classes(&repository, &[forget.clone(), stage.clone()]);
        assert_eq!(found.len(), own.len());
        // Of the points that the file calls ground, and of those that it calls building, so many are ground here.
        let share = |class: u8| {
            let of_class: Vec<u8> =
                own.iter().zip(&found).filter(|(own, _)| **own == class).map(|pair| *pair.1).collect();
            of_class.iter().map(|found| f64::from(u8::from(*found == 2))).sum::<f64>() / of_class.len() as f64
        };
        println!("{stage}: {:.4} of the ground, {:.4} of the buildings", share(2), share(6));
        assert!(share(2) >= ground, "{stage}: {:.4} of the ground", share(2));
        assert!(share(6) <= roofs, "{stage}: {:.4} of the buildings", share(6));
    }
}

#[test]
fn tiles_are_split_reconstructed_and_converted() {
    let repository = Repository::new();
    let run = repository.pipeline("pipelines/split.json --metadata split.metadata.json");
    assert_eq!(run.code, 0, "{}", run.err);
    // 108 m by 140 m in squares of 60 m from the first point on.
    let written = json_of(repository.path("split.metadata.json"))["stages"]["writers.las"]["filename"].clone();
    assert!((4..=12).contains(&written.as_array().unwrap().len()), "{written}");

    let run = repository.pipeline("pipelines/tiles.json");
    assert_eq!(run.code, 0, "{}", run.err);
    let model = repository.path("out/tiles.city.jsonl");
    assert!(buildings(&model).1 >= 70);

    let run = repository.pipeline("pipelines/tileset.json --metadata tileset.metadata.json");
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(repository.path("out/delft.3dtiles/tileset.json").exists());
    assert_eq!(json_of(repository.path("tileset.metadata.json"))["stages"]["writers.lod2"]["features"], 71);
}

#[test]
fn feet_become_metres() {
    /// Metres per US survey foot.
    const FOOT: f64 = 1200.0 / 3937.0;
    let repository = Repository::new();
    // Delft, moved to California and counted in feet.
    let moved = |x: f64, by: f64| (x - by) / FOOT + 6_000_000.0;
    let make = json!([
        "examples/data/delft_ahn3.laz",
        {"type": "filters.assign", "value": [
            format!("X = (X - 84950) / {FOOT} + 6000000"),
            format!("Y = (Y - 447500) / {FOOT} + 6000000"),
            format!("Z = Z / {FOOT}"),
        ]},
        {"type": "writers.las", "filename": "out/feet.laz", "a_srs": "EPSG:6416+6360", "scale_x": 0.001,
            "scale_y": 0.001, "scale_z": 0.001, "offset_x": 6_000_000, "offset_y": 6_000_000},
    ]);
    let run = repository.feed(&make, "");
    assert_eq!(run.code, 0, "{}", run.err);
    let mut footprints = json_of(data("footprints.geojson"));
    footprints["crs"]["properties"]["name"] = json!("urn:ogc:def:crs:EPSG::6416");
    for feature in footprints["features"].as_array_mut().unwrap() {
        move_all(&mut feature["geometry"]["coordinates"], &|[x, y]| [moved(x, 84_950.0), moved(y, 447_500.0)]);
    }
    fs::write(repository.path("out/feet.geojson"), footprints.to_string()).unwrap();

    let run = repository.pipeline("pipelines/feet.json");
    assert_eq!(run.code, 0, "{}", run.err);
    let model = repository.path("out/feet.city.json");
    assert_valid(&model);
    assert!(buildings(&model).1 >= 70);
    // Heights in metres: the highest roof of the tile is at 16.56 m.
    let extent = &json_of(&model)["metadata"]["geographicalExtent"];
    let top = extent[5].as_f64().unwrap();
    assert!((10.0..17.0).contains(&top), "{extent}");
    assert!((extent[0].as_f64().unwrap() - 6_000_000.0 * FOOT).abs() < 200.0, "{extent}");
}

/// Moves all positions in nested arrays.
fn move_all(value: &mut Value, to: &dyn Fn([f64; 2]) -> [f64; 2]) {
    let Some(items) = value.as_array_mut() else { return };
    if let [Value::Number(x), Value::Number(y), ..] = items.as_slice() {
        let moved = to([x.as_f64().unwrap(), y.as_f64().unwrap()]);
        *value = json!(moved);
    } else {
        for item in items.iter_mut() {
            move_all(item, to);
        }
    }
}

#[test]
fn every_ready_made_pipeline_satisfies_the_schema() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let schema = json_of(root.join("schemas/pipeline.schema.json"));
    let validator = jsonschema::validator_for(&schema).unwrap();
    let mut seen = 0;
    for entry in fs::read_dir(root.join("pipelines")).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read_to_string(&path).unwrap();
        // Comments in them stand on lines of their own.
        let plain: String = text.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
        let pipeline: Value = serde_json::from_str(&plain).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
        let faults: Vec<String> = validator.iter_errors(&pipeline).map(|e| e.to_string()).collect();
        assert!(faults.is_empty(), "{}: {faults:?}", path.display());
        seen += 1;
    }
    assert!(seen >= 8);
}

#[test]
fn options_can_be_set_and_results_told() {
    let repository = Repository::new();
    let progress = repository.path("progress");
    fs::write(&progress, "").unwrap();
    let stages = json!(["examples/data/delft_ahn3.laz", {"type": "filters.head", "tag": "first"}, "out/first.las"]);
    let arguments = "--readers.las.count=500 --filters.head.count 300 --stage.first.count=200 --metadata m.json \
        --pipeline-serialization p.json --progress progress";
    let run = repository.feed(&stages, arguments);
    assert_eq!(run.code, 0, "{}", run.err);
    let metadata = json_of(repository.path("m.json"));
    // What is left of a chunk of 500 is cut to 200.
    assert_eq!(metadata["stages"]["readers.las"]["read"], 500);
    assert_eq!(metadata["stages"]["writers.las"]["filename"], json!(["out/first.las"]));
    let serialized = json_of(repository.path("p.json"));
    assert_eq!(serialized["pipeline"][1]["count"], 200);
    assert_eq!(serialized["pipeline"][2]["type"], "writers.las");
    let lines = fs::read_to_string(&progress).unwrap();
    assert_eq!(lines, "READYFILE:out/first.las\nDONEFILE:out/first.las\n");
    let info = gable(["info", repository.path("out/first.las").to_str().unwrap()]);
    assert!(info.out.contains("200 points"), "{}", info.out);

    let run = repository.feed(&stages, "--validate");
    let verdict: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!((run.code, verdict), (0, json!({"valid": true, "streamable": true, "error_detail": ""})));
    let run = repository.feed(&json!(["examples/data/delft_ahn3.laz", {"type": "filters.haed"}]), "--validate");
    let verdict: Value = serde_json::from_str(&run.out).unwrap();
    assert_eq!((run.code, &verdict["valid"]), (1, &json!(false)));
    assert!(verdict["error_detail"].as_str().unwrap().contains("`filters.head`"), "{verdict}");

    for (arguments, told) in [
        ("missing.json", "missing.json"),
        ("pipelines/split.json --filters.splitter.lenght=5", "`length`"),
        ("pipelines/split.json --filters.crop.bounds=5", "filters.crop"),
        ("pipelines/split.json --filters.splitter.length", "`length`"),
        ("pipelines/quickstart.json --stage.model.footprints=none.gpkg --stage.model.overwrite=maybe", "true or false"),
        ("", "<FILE|--stdin>"),
    ] {
        let run = repository.pipeline(arguments);
        assert_eq!(run.code, 1, "{arguments}: {}", run.err);
        assert!(run.err.contains(told), "{arguments}: {}", run.err);
    }
}

#[test]
fn a_crop_does_not_hide_that_footprints_are_not_covered() {
    let repository = Repository::new();
    let stages = json!([
        "examples/data/delft_ahn3.laz",
        {"type": "filters.crop", "bounds": "([84900, 84950], [447470, 447610])"},
        {"type": "writers.lod2", "footprints": "examples/data/footprints.geojson", "filename": "half.city.json",
            "field": "height-field"},
    ]);
    let run = repository.feed(&stages, "--quiet");
    assert_eq!((run.code, run.out.as_str()), (0, ""), "{}", run.err);
    // 35 footprints lie wholly or partly east of x = 84 950; those of them that hold points have a model, the ten that the
    // crop cuts one of what is left.
    let counts = &report_of(&repository.path("half.city.json"))["counts"];
    assert_eq!(counts["skipped"], json!({"incomplete": 25}), "{counts}");
    assert_eq!((&counts["buildings_lod22"], &counts["buildings_partial"]), (&json!(36), &json!(10)), "{counts}");
}

#[test]
fn damage_is_told_by_the_exit_code() {
    let repository = Repository::new();
    let whole = fs::read(data("delft_ahn3.laz")).unwrap();
    fs::write(repository.path("cut.laz"), &whole[..whole.len() - 100_000]).unwrap();
    let lod2 = |name: &str| {
        json!({"type": "writers.lod2", "footprints": "examples/data/footprints.geojson", "filename": name,
            "field": "height-field"})
    };
    // Read by the writer itself, and through a filter.
    for stages in [
        json!(["cut.laz", lod2("a.city.json")]),
        json!(["cut.laz", {"type": "filters.stats"}, lod2("b.city.json")]),
        json!(["cut.laz", "out.las"]),
    ] {
        let run = repository.feed(&stages, "");
        assert_eq!(run.code, 2, "{stages}: {}", run.err);
        assert!(run.err.contains("cut.laz") && run.err.contains("missing"), "{}", run.err);
    }
}

#[test]
fn stages_are_listed_with_their_options() {
    let run = gable(["stages"]);
    assert_eq!(run.code, 0);
    for name in ["readers.copc", "filters.hag_nn", "filters.smrf", "writers.lod2"] {
        assert!(run.out.contains(name), "{}", run.out);
    }
    let run = gable(["stages", "writers.lod2"]);
    assert!(run.out.contains("footprints FILE") && run.out.contains("ring_width NUMBER"), "{}", run.out);
    let run = gable(["stages", "filters.crip"]);
    assert!(run.code == 1 && run.err.contains("`filters.crop`"), "{}", run.err);
    let run = gable(["stages", "filters.pmf"]);
    assert!(run.code == 1 && run.err.contains("pdal pipeline"), "{}", run.err);
}
