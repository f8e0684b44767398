//! Outputs that cannot be written: nothing half-written is ever seen under the final name.

use std::path::Path;

use crate::bench::*;

const INPUTS: [&str; 2] = ["footprints.geojson", "house.laz"];

/// Reconstructs the house of `folder` to `out`.
fn to(folder: &Path, out: &Path, rest: &str) -> Run {
    let (tile, footprints) = (folder.join("house.laz"), folder.join("footprints.geojson"));
    reconstruct(&[&tile], &footprints, out, &format!("--crs EPSG:7415 {rest}"))
}

#[test]
fn what_exists_is_kept_unless_told_otherwise() {
    let folder = house_folder();
    let out = folder.path().join("out.city.json");
    std::fs::write(&out, "precious").unwrap();
    assert_ends(&to(folder.path(), &out, ""), 1, &["out.city.json: found a file of that name", "--overwrite"]);
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "precious");
    assert_ends(&to(folder.path(), &out, "--overwrite"), 0, &[]);
    assert_eq!(json_of(&out)["type"], "CityJSON");
    let report = folder.path().join("report.json");
    std::fs::write(&report, "precious").unwrap();
    let run = to(folder.path(), &folder.path().join("new.city.json"), &format!("--report {}", report.display()));
    assert_ends(&run, 1, &["report.json: found a file of that name", "--overwrite"]);
    assert_eq!(std::fs::read_to_string(&report).unwrap(), "precious");
}

#[test]
fn an_input_is_never_replaced() {
    let folder = house_folder();
    let input = folder.path().join("in.json");
    std::fs::rename(folder.path().join("footprints.geojson"), &input).unwrap();
    let before = std::fs::read(&input).unwrap();
    let run = reconstruct(&[&folder.path().join("house.laz")], &input, &input, "--crs EPSG:7415 --overwrite");
    assert_ends(&run, 1, &["in.json: found an input of this run, expected a file of its own"]);
    assert!(std::fs::read(&input).unwrap() == before);
}

#[test]
fn a_folder_in_the_place_of_the_file_and_a_file_in_the_place_of_the_folder() {
    let folder = house_folder();
    let inner = folder.path().join("taken");
    std::fs::create_dir_all(inner.join("house.city.json")).unwrap();
    assert_ends(&to(folder.path(), &inner, ""), 1, &["house.city.json: found a folder, expected the name of a file"]);
    let below = folder.path().join("house.laz").join("out.city.json");
    assert_ends(&to(folder.path(), &below, ""), 1, &["house.laz"]);
}

#[test]
fn a_folder_that_is_missing_is_made() {
    let folder = house_folder();
    let out = folder.path().join("a/b/out.city.json");
    assert_ends(&to(folder.path(), &out, ""), 0, &[]);
    assert_eq!(names_in(&folder.path().join("a/b")), ["out.city.json", "out.city.json.report.json"]);
}

#[cfg(unix)]
#[test]
fn a_folder_that_cannot_be_written_to_is_found_out_before_the_work() {
    use std::os::unix::fs::PermissionsExt;
    let folder = house_folder();
    let closed = folder.path().join("closed");
    std::fs::create_dir(&closed).unwrap();
    std::fs::set_permissions(&closed, std::fs::Permissions::from_mode(0o555)).unwrap();
    if tempfile::tempfile_in(&closed).is_err() {
        let run = to(folder.path(), &closed.join("out.city.json"), "");
        assert_ends(&run, 1, &["closed: cannot write to", "See whether you may read or write there"]);
        assert!(!run.err.contains("collecting points"));
    } else {
        println!("skipped in part: this user may write everywhere");
    }
    // Nobody can make files there.
    if Path::new("/proc/self").is_dir() {
        let run = to(folder.path(), Path::new("/proc/out.city.json"), "");
        assert_ends(&run, 1, &["/proc: cannot write to"]);
        assert!(!run.err.contains("collecting points"));
    }
}

/// The reconstruction of the bundled tile with a limit on the size of files: that a full disk looks the same to a program
/// but for the error is the best that can be had without being root.
#[cfg(unix)]
fn with_file_limit(blocks: u32, out: &Path, rest: &str) -> Run {
    let script = format!("ulimit -f {blocks}; exec \"$@\" {rest}");
    let mut shell = std::process::Command::new("sh");
    shell.args(["-c", &script, "sh", env!("CARGO_BIN_EXE_gable"), "reconstruct", "--overwrite"]);
    shell.arg(data("delft_ahn3.laz")).arg("-f").arg(data("footprints.geojson")).arg("-o").arg(out);
    shell.output().unwrap().into()
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_nothing_under_the_final_name_and_the_work_to_resume() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.city.json");
    std::fs::write(&out, "precious").unwrap();
    let run = with_file_limit(32, &out, "");
    assert_ends(&run, 1, &["out.city.json", "cannot write", "too large", "Raise the limit", "--resume"]);
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "precious", "what was there is still there");
    assert_eq!(names_in(folder.path()), ["out.city.json", "out.city.json.partial"]);
    assert_eq!(names_in(&folder.path().join("out.city.json.partial")), ["buildings.jsonl"]);

    let run = delft(&out, "--resume");
    assert_ends(&run, 0, &["buildings are taken from there"]);
    assert!(report_of(&out)["counts"]["resumed"].as_u64().unwrap() > 0);
    assert_eq!(names_in(folder.path()), ["out.city.json", "out.city.json.report.json"]);
    let whole = folder.path().join("whole.city.json");
    assert_eq!(delft(&whole, "--quiet").code, 0);
    assert!(std::fs::read(&out).unwrap() == std::fs::read(&whole).unwrap());
}

#[test]
fn nothing_is_left_beside_what_was_asked_for() {
    let folder = house_folder();
    let out = folder.path().join("out.city.jsonl");
    assert_ends(&to(folder.path(), &out, ""), 0, &[]);
    assert_eq!(names_in(folder.path()), [INPUTS[0], INPUTS[1], "out.city.jsonl", "out.city.jsonl.report.json"]);
}

#[test]
fn a_folder_that_is_removed_during_the_run_costs_nothing() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["model.city.json", "model.gpkg", "model.3dtiles"] {
        let [whole, out] = ["whole", "out"].map(|part| folder.path().join(part));
        std::fs::create_dir_all(&out).unwrap();
        assert_eq!(delft(&whole.join(name), "--quiet").code, 0);
        let mut run = command(["reconstruct", "--quiet", "--jobs", "1"]);
        run.arg(data("delft_ahn3.laz")).arg("-f").arg(data("footprints.geojson")).arg("-o").arg(out.join(name));
        let process = run.stdout(std::process::Stdio::piped()).stderr(std::process::Stdio::piped()).spawn().unwrap();
        // The work is under way as soon as there is a building that is kept.
        let kept = out.join(format!("{name}.partial")).join("buildings.jsonl");
        while std::fs::metadata(&kept).map_or(0, |meta| meta.len()) < 20_000 {
            std::thread::sleep(std::time::Duration::from_millis(2));
        }
        std::fs::remove_dir_all(&out).unwrap();
        let run: Run = process.wait_with_output().unwrap().into();
        assert_ends(&run, 0, &[]);
        assert!(contents(&out.join(name)) == contents(&whole.join(name)), "{name}");
    }
}

/// The bytes of a file, or of all files of a folder with their names.
fn contents(path: &Path) -> Vec<(String, Vec<u8>)> {
    if path.is_file() {
        return vec![(String::new(), std::fs::read(path).unwrap())];
    }
    let of = |name: String| {
        let inner = contents(&path.join(&name));
        inner.into_iter().map(move |(below, bytes)| (format!("{name}/{below}"), bytes))
    };
    names_in(path).into_iter().flat_map(of).collect()
}
