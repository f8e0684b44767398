//! The C interface: a C program is compiled against the header and the shared library, and run.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};
use std::sync::OnceLock;

use gable::source::points::ScanPoint;
use serde_json::Value;
use tempfile::TempDir;

use super::damage::write_damaged;
use super::{data, points};

/// The shared library: cargo puts it beside the tests, wherever that is.
fn library() -> PathBuf {
    let folder = std::env::current_exe().unwrap().parent().unwrap().to_path_buf();
    let name = format!("{}gable{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let candidates = [folder.join(&name), folder.join("..").join(&name)];
    candidates.iter().find(|path| path.exists()).unwrap_or_else(|| panic!("no {name} in {}", folder.display())).clone()
}

fn text(output: &Output) -> String {
    format!("{}{}", String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr))
}

/// The compiled program.
fn program() -> &'static Path {
    static PROGRAM: OnceLock<(TempDir, PathBuf)> = OnceLock::new();
    let (_, path) = PROGRAM.get_or_init(|| {
        let root = Path::new(env!("CARGO_MANIFEST_DIR"));
        let folder = tempfile::tempdir().unwrap();
        let (library, program) = (library().canonicalize().unwrap(), folder.path().join("interface"));
        let mut compiler = Command::new(std::env::var_os("CC").unwrap_or_else(|| "cc".into()));
        compiler.args(["-std=c11", "-O1", "-Wall", "-Wextra", "-Wpedantic", "-Werror"]);
        compiler.arg("-I").arg(root.join("include")).arg(root.join("tests/c/interface.c")).arg(&library);
        compiler.arg(format!("-Wl,-rpath,{}", library.parent().unwrap().display())).arg("-lm").arg("-o").arg(&program);
        let output = compiler.output().expect("a C compiler, which building gable needs too");
        assert!(output.status.success(), "{}", text(&output));
        (folder, program)
    });
    path
}

/// Writes the columns that the program reads; a point's building is its place in the table of buildings.
fn write_columns(path: &Path, points: &[ScanPoint]) {
    let mut bytes = (points.len() as u64).to_ne_bytes().to_vec();
    for axis in 0..3 {
        bytes.extend(points.iter().flat_map(|point| point.position[axis].to_ne_bytes()));
    }
    bytes.extend(points.iter().flat_map(|point| point.building.map_or(-1, i64::from).to_ne_bytes()));
    bytes.extend(points.iter().map(|point| point.class));
    fs::write(path, bytes).unwrap();
}

/// Runs the program; gives the lines, the report and what it printed.
fn run(folder: &Path, mode: &str, options: &Value, points: &[ScanPoint]) -> (Vec<String>, Value, String) {
    let [columns, lines, report] = ["points", "lines", "report"].map(|name| folder.join(name));
    write_columns(&columns, points);
    let mut command = Command::new(program());
    let output = command.args([mode, &options.to_string(), "EPSG:7415"]).args([&columns, &lines, &report]).output();
    let output = output.unwrap();
    assert!(output.status.success(), "{}", text(&output));
    let lines = fs::read_to_string(lines).unwrap().lines().map(str::to_owned).collect();
    let report = serde_json::from_str(&fs::read_to_string(report).unwrap()).unwrap();
    (lines, report, String::from_utf8(output.stdout).unwrap().trim().to_owned())
}

#[test]
fn c_gives_the_model_of_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let [by_cli, by_c] = ["cli.city.jsonl", "c.city.jsonl"].map(|name| folder.path().join(name));
    let mut command = Command::new(env!("CARGO_BIN_EXE_gable"));
    command.arg("reconstruct").arg(data("delft_ahn3.laz")).arg("-f").arg(data("footprints.geojson"));
    let output = command.args(["--field", "height-field", "--lambda", "0.2", "-o"]).arg(&by_cli).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));

    let options = serde_json::json!({
        "footprints": data("footprints.geojson"),
        "output": by_c,
        "field": "height-field",
        "lambda": 0.2,
    });
    let (lines, report, status) = run(folder.path(), "run", &options, &points());
    assert_eq!(status, "0");
    let expected = fs::read_to_string(&by_cli).unwrap();
    assert!(expected == fs::read_to_string(&by_c).unwrap(), "two models");
    // The callback gets the lines of the file; only the head, which comes first, cannot know the extent yet.
    assert_eq!(lines.len(), 72);
    assert!(lines.iter().skip(1).eq(expected.lines().skip(1)));
    let heads = [lines[0].as_str(), expected.lines().next().unwrap()];
    let [head, whole]: [Value; 2] = heads.map(|line| serde_json::from_str(line).unwrap());
    assert_eq!((&head["transform"], &head["type"]), (&whole["transform"], &"CityJSON".into()));
    assert_eq!((&report["counts"]["written"], &report["inputs"]["tiles"][0]["points"]), (&71.into(), &141_577.into()));
}

#[test]
fn buildings_that_are_named_need_no_footprints() {
    let folder = tempfile::tempdir().unwrap();
    // Two sheds that touch, 3 m and 5 m high, and ground around them that names nothing.
    let mut points = Vec::new();
    for (row, column) in (0..120).flat_map(|row| (0..120).map(move |column| (row, column))) {
        let [x, y] = [column, row].map(|step| f64::from(step) * 0.25);
        let shed = match x {
            _ if !(10.0..18.0).contains(&y) => None,
            _ if (8.0..14.0).contains(&x) => Some((17, 4.0)),
            _ if (14.0..22.0).contains(&x) => Some((4, 6.0)),
            _ => None,
        };
        let place = [85_000.0 + x, 447_000.0 + y];
        points.push(match shed {
            Some((id, z)) => ScanPoint { building: Some(id), ..ScanPoint::new([place[0], place[1], z], 6) },
            None => ScanPoint::new([place[0], place[1], 1.0], 2),
        });
    }
    let options = serde_json::json!({"field": "height-field"});
    let (lines, report, status) = run(folder.path(), "named", &options, &points);
    assert_eq!((status.as_str(), lines.len()), ("0", 3));
    let features: Vec<Value> = lines[1..].iter().map(|line| serde_json::from_str(line).unwrap()).collect();
    let volume = |feature: &Value| {
        let id = feature["id"].as_str().unwrap();
        feature["CityObjects"][id]["attributes"]["gable_volume_lod22"].as_f64().unwrap()
    };
    // In the order in which the points name them; without a footprint walls stand about where the points end.
    for (feature, id, expected) in [(&features[0], "17", 6.0 * 8.0 * 3.0), (&features[1], "4", 8.0 * 8.0 * 5.0)] {
        assert_eq!(feature["id"], id);
        let share = volume(feature) / expected;
        assert!((0.85..1.15).contains(&share), "{id}: {share}");
    }
    assert_eq!(report["outputs"], serde_json::json!([]));
}

#[test]
fn a_damaged_tile_is_told_and_leaves_the_host_process_running() {
    let folder = tempfile::tempdir().unwrap();
    let tile = folder.path().join("damaged.laz");
    write_damaged(&tile, 1);
    let corner = [85_000.0, 447_000.0];
    let ring = [[0.0, 0.0], [10.0, 0.0], [10.0, 8.0], [0.0, 8.0], [0.0, 0.0]];
    let ring = ring.map(|c| [c[0] + corner[0], c[1] + corner[1]]);
    let footprints = folder.path().join("footprints.geojson");
    let feature = serde_json::json!({"type": "Feature", "properties": {"id": "007"},
        "geometry": {"type": "Polygon", "coordinates": [ring]}});
    let crs = serde_json::json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::28992"}});
    let file = serde_json::json!({"type": "FeatureCollection", "crs": crs, "features": [feature]});
    fs::write(&footprints, file.to_string()).unwrap();
    let options = serde_json::json!({"tiles": [tile], "footprints": footprints, "field": "height-field"});
    let (lines, report, status) = run(folder.path(), "run", &options, &[]);
    assert_eq!((lines.len(), status.as_str(), &report["exit_code"]), (2, "2", &2.into()), "{report}");
    let tile = &report["inputs"]["tiles"][0];
    let told = tile["problems"][0].as_str().unwrap();
    assert!(told.contains("damaged.laz") && told.contains("in the chunk at byte"), "{told}");
    assert!((1..=50_000).contains(&tile["missing_points"].as_u64().unwrap()), "{tile}");
    assert_eq!(report["buildings"][0]["outcome"], "lod22");
}

#[test]
fn a_callback_stops_the_run() {
    let folder = tempfile::tempdir().unwrap();
    let (columns, model) = (folder.path().join("points"), folder.path().join("model.city.json"));
    write_columns(&columns, &points());
    let options = serde_json::json!({"footprints": data("footprints.geojson"), "output": model, "jobs": 1});
    let mut command = Command::new(program());
    let output = command.args(["cancel", &options.to_string(), "EPSG:7415"]).arg(&columns).output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
}

#[test]
fn abuse_is_an_error_and_no_crash() {
    let output = Command::new(program()).arg("abuse").output().unwrap();
    assert!(output.status.success(), "{}", text(&output));
    assert!(!text(&output).contains("panicked"), "{}", text(&output));
}
