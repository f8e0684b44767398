//! `gable plan`, `gable reconstruct --plan` and `gable merge --plan`: whatever the number of jobs, the bytes of one run.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::tempdir;

use crate::bench::*;

/// Without the network, which makes no difference here.
const FAST: &str = "--field height-field";

/// What is made a plan of.
struct Inputs {
    tiles: Vec<PathBuf>,
    footprints: PathBuf,
    rest: String,
}

impl Inputs {
    fn plan(&self, plan: &Path, rest: &str) -> Run {
        let mut command = command(["plan"]);
        command.args(&self.tiles).arg("-f").arg(&self.footprints).arg("-o").arg(plan);
        command.args(self.rest.split_whitespace()).args(rest.split_whitespace());
        command.output().unwrap().into()
    }

    fn one_run(&self, out: &Path) -> Run {
        let tiles: Vec<&Path> = self.tiles.iter().map(PathBuf::as_path).collect();
        reconstruct(&tiles, &self.footprints, out, &self.rest)
    }
}

/// The corner of Delft, cut into four tiles.
fn delft_in_four(folder: &Path) -> Inputs {
    let tiles = cut_into_four(&data("delft_ahn3.laz"), folder);
    Inputs { tiles, footprints: data("footprints.geojson"), rest: FAST.to_owned() }
}

fn do_job(plan: &Path, job: usize, rest: &str) -> Run {
    let mut command = command(["reconstruct", "--quiet", "--plan"]);
    command.arg(plan).args(["--job", &job.to_string()]).args(rest.split_whitespace());
    command.output().unwrap().into()
}

fn jobs_of(plan: &Path) -> usize {
    json_of(plan.join("plan.json"))["jobs"].as_array().unwrap().len()
}

/// Does all jobs, the last one first.
fn do_all(plan: &Path) {
    for job in (0..jobs_of(plan)).rev() {
        let run = do_job(plan, job, "");
        assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    }
}

fn merge(plan: &Path, out: &Path, rest: &str) -> Run {
    let mut command = command(["merge", "--plan"]);
    command.arg(plan).arg("-o").arg(out).args(rest.split_whitespace());
    command.output().unwrap().into()
}

/// The bytes of a file, or of all files in a folder by their names.
fn bytes(path: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    if path.is_file() {
        return [(PathBuf::new(), std::fs::read(path).unwrap())].into();
    }
    let mut all = BTreeMap::new();
    for entry in std::fs::read_dir(path).unwrap() {
        let entry = entry.unwrap();
        for (below, content) in bytes(&entry.path()) {
            let name = PathBuf::from(entry.file_name());
            all.insert(if below.as_os_str().is_empty() { name } else { name.join(below) }, content);
        }
    }
    all
}

/// A report without what differs from run to run.
fn bare(mut report: Value) -> Value {
    for building in report["buildings"].as_array_mut().unwrap() {
        building["wall_ms"] = Value::Null;
        building["cpu_ms"] = Value::Null;
    }
    ["counts", "quality", "buildings", "parameters", "segmentation", "crs", "exit_code"]
        .into_iter()
        .map(|name| (name.to_owned(), report[name].take()))
        .collect::<serde_json::Map<_, _>>()
        .into()
}

#[test]
fn any_number_of_jobs_gives_the_bytes_of_one_run_in_every_format() {
    let folder = tempdir().unwrap();
    let inputs = delft_in_four(folder.path());
    let formats = ["city.jsonl", "city.json", "gpkg", "3dtiles", "obj"];
    // Of one name: an OBJ names its file of materials.
    let whole = |extension: &str| folder.path().join("whole").join(format!("m.{extension}"));
    for extension in formats {
        let run = inputs.one_run(&whole(extension));
        assert_eq!(run.code, 0, "{}{}", run.out, run.err);
    }
    for jobs in [1, 4, 64] {
        let plan = folder.path().join(format!("plan-{jobs}"));
        let planned = inputs.plan(&plan, &format!("--jobs {jobs}"));
        assert_ends(&planned, 0, &[]);
        let file = json_of(plan.join("plan.json"));
        let schema = json_of(Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas/plan.schema.json"));
        assert!(jsonschema::validator_for(&schema).unwrap().is_valid(&file));
        assert_eq!(jobs_of(&plan), jobs);
        let footprints: u64 = file["jobs"].as_array().unwrap().iter().map(|j| j["footprints"].as_u64().unwrap()).sum();
        assert_eq!(footprints, 71);
        do_all(&plan);
        for extension in formats {
            let merged = folder.path().join(format!("merged-{jobs}")).join(format!("m.{extension}"));
            let run = merge(&plan, &merged, "");
            assert_eq!(run.code, 0, "{}{}", run.out, run.err);
            assert!(bytes(&merged) == bytes(&whole(extension)), "{jobs} jobs, {extension}");
            assert_eq!(bare(report_of(&merged)), bare(report_of(&whole(extension))), "{jobs} jobs, {extension}");
        }
    }
}

#[test]
fn floors_of_neighbours_and_options_are_those_of_one_run() {
    let folder = tempdir().unwrap();
    let mut inputs = delft_in_four(folder.path());
    // No ground at all: floors come from neighbours and from lowest points.
    inputs.rest = format!(
        "{FAST} --ground-class 30 --lod 0,1.3 --attributes height_* --attribute-prefix b_ --title City \
         --box 84900,447300,85600,447900 --point-cloud-source AHN3"
    );
    let whole = folder.path().join("whole.city.jsonl");
    assert_eq!(inputs.one_run(&whole).code, 0);
    let floors: Vec<String> = json_of(folder.path().join("whole.city.jsonl.report.json"))["buildings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|building| building["ground"].to_string())
        .collect();
    assert!(floors.iter().any(|floor| floor.contains("neighbours")), "{floors:?}");
    let plan = folder.path().join("plan");
    assert_ends(&inputs.plan(&plan, "--job-size 5"), 0, &[]);
    do_all(&plan);
    let merged = folder.path().join("merged.city.jsonl");
    assert_ends(&merge(&plan, &merged, ""), 0, &[]);
    assert!(bytes(&merged) == bytes(&whole));
}

/// Houses in a row over two tiles that do not name their CRS, one without points, far away, and a feature without a polygon.
fn street(folder: &Path) -> Inputs {
    write_two_houses(folder);
    let houses = [
        ("none", line()),
        ("../b", rectangle(40.0, 0.0, 50.0, 8.0)),
        ("a/1", rectangle(0.0, 0.0, 10.0, 8.0)),
        ("far", rectangle(900.0, 0.0, 910.0, 8.0)),
        ("a/1", rectangle(15.0, 0.0, 18.0, 3.0)),
    ];
    write_footprints(&folder.join("f.geojson"), &houses);
    let tiles = ["west.laz", "east.laz"].map(|name| folder.join(name)).to_vec();
    Inputs { tiles, footprints: folder.join("f.geojson"), rest: format!("--crs EPSG:7415 {FAST}") }
}

#[test]
fn a_job_without_points_and_a_feature_without_a_polygon_are_part_of_the_whole() {
    let folder = tempdir().unwrap();
    let inputs = street(folder.path());
    let whole = folder.path().join("whole.city.jsonl");
    assert_ends(&inputs.one_run(&whole), 2, &[]);
    let plan = folder.path().join("plan");
    let planned = inputs.plan(&plan, "--jobs 4");
    assert_ends(&planned, 0, &["have no usable polygon"]);
    do_all(&plan);
    let merged = folder.path().join("merged.city.jsonl");
    assert_ends(&merge(&plan, &merged, ""), 2, &[]);
    assert!(bytes(&merged) == bytes(&whole));
    let report = report_of(&merged);
    assert_eq!(report["counts"]["skipped"]["no-polygon"], 1);
    assert_eq!(report["jobs"].as_array().unwrap().len(), 4);

    // By tile and by id: neither the order nor the names hang on the jobs.
    for name in ["{tile}.city.json", "{id}.city.json"] {
        let [one, many] = ["one", "many"].map(|part| folder.path().join(part).join(name));
        assert_ends(&inputs.one_run(&one), 2, &[]);
        assert_ends(&merge(&plan, &many, ""), 2, &[]);
        let [one, many] = [one, many].map(|path| {
            let mut files = bytes(path.parent().unwrap());
            files.remove(Path::new("gable.report.json"));
            files.retain(|name, _| name.to_string_lossy().ends_with(".city.json"));
            files
        });
        assert!(!one.is_empty() && one == many, "{name}: {:?} and {:?}", one.keys(), many.keys());
        std::fs::remove_dir_all(folder.path().join("one")).unwrap();
        std::fs::remove_dir_all(folder.path().join("many")).unwrap();
    }
    // What is in no tile at all is refused as by one run.
    let classes = Inputs { rest: format!("{} --building-class 40", inputs.rest), ..inputs };
    let refused = classes.one_run(&folder.path().join("x.city.jsonl"));
    assert_ends(&refused, 1, &["no point of building class 40"]);
    let plan = folder.path().join("plan-40");
    assert_ends(&classes.plan(&plan, "--jobs 2"), 0, &[]);
    do_all(&plan);
    assert_ends(&merge(&plan, &folder.path().join("y.city.jsonl"), ""), 1, &["no point of building class 40"]);
}

#[test]
fn what_is_missing_or_there_twice_is_listed() {
    let folder = tempdir().unwrap();
    let inputs = delft_in_four(folder.path());
    let plan = folder.path().join("plan");
    assert_ends(&inputs.plan(&plan, "--jobs 6"), 0, &[]);
    let missing = || gable(["merge", "--missing", "--plan", plan.to_str().unwrap()]);
    assert_eq!((missing().out.trim(), missing().code), ("0-5", 1));
    let out = folder.path().join("m.city.jsonl");
    for job in [0, 1, 4] {
        assert_eq!(do_job(&plan, job, "").code, 0);
    }
    let elsewhere = folder.path().join("elsewhere");
    assert_eq!(do_job(&plan, 2, &format!("--parts {}", elsewhere.display())).code, 0);
    assert_eq!(missing().out.trim(), "2-3,5");
    assert_ends(&merge(&plan, &out, ""), 1, &["3 of 6 jobs have no part: 2-3,5", "--job 2"]);
    assert!(!out.exists());
    for job in [3, 4, 5] {
        assert_eq!(do_job(&plan, job, &format!("--parts {}", elsewhere.display())).code, 0);
    }
    let own = plan.join("parts");
    let both = format!("--parts {} --parts {}", own.display(), elsewhere.display());
    assert_ends(&merge(&plan, &out, &both), 1, &["job 4 has 2 parts"]);
    std::fs::remove_file(elsewhere.join("4.part.jsonl")).unwrap();
    assert_ends(&merge(&plan, &out, &both), 0, &[]);

    // A part under the name of another, one that is cut off, and one of another plan.
    std::fs::copy(own.join("1.part.jsonl"), elsewhere.join("5.part.jsonl")).unwrap();
    assert_ends(&merge(&plan, &out, &format!("{both} --overwrite")), 1, &["5.part.jsonl: it is of job 1"]);
    let whole = std::fs::read(own.join("1.part.jsonl")).unwrap();
    std::fs::write(own.join("1.part.jsonl"), &whole[..whole.len() - 1]).unwrap();
    assert_ends(&merge(&plan, &out, &format!("{both} --overwrite")), 1, &["1.part.jsonl: it is damaged or cut off"]);
    // A bit that flips in the middle.
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    std::fs::write(own.join("1.part.jsonl"), flipped).unwrap();
    let said = merge(&plan, &out, &format!("{both} --overwrite"));
    assert_ends(&said, 1, &["1.part.jsonl: line", "is damaged or cut off", "footprints are in no part"]);
    assert_eq!(do_job(&plan, 1, "--overwrite").code, 0);
    assert!(std::fs::read(own.join("1.part.jsonl")).unwrap().len() > 1000);
    assert_eq!(do_job(&plan, 5, &format!("--overwrite --parts {}", elsewhere.display())).code, 0);
    assert_ends(&merge(&plan, &out, &format!("{both} --overwrite")), 0, &[]);
    let other = folder.path().join("other");
    assert_ends(&inputs.plan(&other, "--jobs 2"), 0, &[]);
    assert_ends(&do_job(&other, 0, &format!("--parts {}", own.display())), 1, &["another plan"]);
}

#[test]
fn a_job_that_is_done_is_not_done_again_and_one_that_was_killed_goes_on() {
    let folder = tempdir().unwrap();
    let inputs = delft_in_four(folder.path());
    let plan = folder.path().join("plan");
    assert_ends(&inputs.plan(&plan, "--jobs 2"), 0, &[]);
    let part = plan.join("parts/0.part.jsonl");
    let kept = plan.join("parts/0.part.jsonl.partial/buildings.jsonl");
    let mut child = command(["reconstruct", "--quiet", "--jobs", "1", "--job", "0", "--plan"])
        .arg(&plan)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let limit = Instant::now() + Duration::from_mins(2);
    let lines = || std::fs::read_to_string(&kept).map_or(0, |text| text.lines().count());
    while lines() < 6 && child.try_wait().unwrap().is_none() {
        assert!(Instant::now() < limit, "the job makes no headway");
        std::thread::sleep(Duration::from_micros(200));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    let was_killed = !part.exists();
    assert_eq!(do_job(&plan, 0, "").code, 0);
    let report = json_of(plan.join("parts/0.report.json"));
    assert!(!was_killed || report["counts"]["resumed"].as_u64().unwrap() >= 5, "{}", report["counts"]);
    assert_eq!(names_in(&plan.join("parts")), ["0.part.jsonl", "0.report.json"]);

    let before = std::fs::metadata(&part).unwrap().modified().unwrap();
    let again: Run = command(["reconstruct", "--job", "0", "--plan"]).arg(&plan).output().unwrap().into();
    assert_eq!(again.code, 0);
    assert_says(&again.out, &["job 0 is done already"]);
    assert_eq!(std::fs::metadata(&part).unwrap().modified().unwrap(), before);
    assert_eq!(do_job(&plan, 0, "--overwrite").code, 0);
    assert!(std::fs::metadata(&part).unwrap().modified().unwrap() > before);
}

#[test]
fn what_does_not_fit_the_plan_is_refused() {
    let folder = tempdir().unwrap();
    let inputs = delft_in_four(folder.path());
    let plan = folder.path().join("plan");
    assert_ends(&inputs.plan(&plan, "--jobs 2"), 0, &[]);
    assert_ends(&inputs.plan(&plan, "--jobs 2"), 1, &["a plan", "--overwrite"]);
    assert_ends(&do_job(&plan, 2, ""), 1, &["no job 2", "one from 0 to 1"]);
    assert_ends(&do_job(&plan, 0, "--lambda 0.2"), 1, &["--lambda", "cannot be used with", "--plan"]);
    assert_ends(&do_job(&plan, 0, "-o x.city.json"), 1, &["--output", "cannot be used with"]);
    assert_ends(&gable(["reconstruct", "--job", "0"]), 1, &["--plan"]);
    let bare = gable(["plan", "a.laz", "--no-footprint", "-o", folder.path().join("p").to_str().unwrap()]);
    assert_eq!(bare.code, 1);

    let file = plan.join("plan.json");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("\"ring_width\": 3.0", "\"ring_width\": 4.0")).unwrap();
    assert_ends(&do_job(&plan, 0, ""), 1, &["changed after it was made"]);
    std::fs::write(&file, text.replacen("\"gable\": \"0", "\"gable\": \"9", 1)).unwrap();
    assert_ends(&do_job(&plan, 0, ""), 1, &["a plan of gable 9"]);
    std::fs::write(&file, &text).unwrap();
    let share = plan.join("jobs/0.jsonl");
    let bytes = std::fs::read(&share).unwrap();
    std::fs::write(&share, &bytes[1..]).unwrap();
    assert_ends(&do_job(&plan, 0, ""), 1, &["0.jsonl", "other bytes than those of the plan"]);
    std::fs::write(&share, bytes).unwrap();
    // A tile that is another one now.
    write_house(&inputs.tiles[0], None, 6);
    let runs = [do_job(&plan, 0, ""), do_job(&plan, 1, "")];
    let refused = runs.iter().find(|run| run.code == 1).expect("one of them needs the first tile");
    assert_says(&refused.err, &["as in the plan", "make the plan anew"]);
    std::fs::create_dir(folder.path().join("used")).unwrap();
    std::fs::write(folder.path().join("used/x"), "x").unwrap();
    assert_ends(&inputs.plan(&folder.path().join("used"), "--overwrite"), 1, &["something else than a plan"]);
}
