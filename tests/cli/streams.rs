//! Standard output and input, and pipes.
#![cfg(unix)]

use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::Stdio;

use tempfile::tempdir;

use crate::bench::*;

/// Features of a sequence: its lines but for the first, which is its head.
fn features(text: &str) -> Vec<&str> {
    let mut lines = text.lines();
    let head: serde_json::Value = serde_json::from_str(lines.next().unwrap()).unwrap();
    assert_eq!(head["type"], "CityJSON");
    lines.collect()
}

#[test]
fn a_dash_is_standard_output_and_everything_else_goes_to_standard_error() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("delft.city.jsonl");
    assert_eq!(delft(&file, "").code, 0);
    let expected = std::fs::read_to_string(&file).unwrap();
    for name in ["-", "/dev/stdout"] {
        let mut command = command(["reconstruct"]);
        command.arg(data("delft_ahn3.laz")).arg("-f").arg(data("footprints.geojson")).args(["-o", name]);
        let run: Run = command.current_dir(folder.path()).output().unwrap().into();
        assert_eq!(run.code, 0, "{}", run.err);
        assert_eq!(features(&run.out), features(&expected), "{name}");
        assert_says(&run.err, &["solids at LoD 2.2"]);
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 2, "nothing but the file and its report");
    for options in ["--resume", "--view"] {
        let run = delft(Path::new("-"), options);
        assert_eq!((run.code, run.out.as_str()), (1, ""), "{options}");
        assert_says(&run.err, &["a stream"]);
    }
}

#[test]
fn models_come_from_standard_input() {
    let folder = tempdir().unwrap();
    let file = folder.path().join("delft.city.jsonl");
    assert_eq!(delft(&file, "").code, 0);
    let bytes = std::fs::read(&file).unwrap();
    let piped = |args: &[&str]| -> Run {
        let mut child = command(args)
            .current_dir(folder.path())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (mut input, bytes) = (child.stdin.take().unwrap(), bytes.clone());
        let writer = std::thread::spawn(move || drop(input.write_all(&bytes)));
        let run = child.wait_with_output().unwrap().into();
        writer.join().unwrap();
        run
    };
    // Converting reads its input three times.
    let run = piped(&["convert", "-", "-o", "-"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_eq!(features(&run.out), features(std::str::from_utf8(&bytes).unwrap()));
    assert_says(&run.err, &["standard output: CityJSONSeq, 71 features"]);
    let run = piped(&["validate", "-"]);
    assert_eq!(run.code, 0, "{} {}", run.out, run.err);
    assert_says(&run.out, &["valid", "Building       71     71"]);
    let run = piped(&["convert", "/dev/stdin", "-o", "out.obj"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(folder.path().join("out.obj").exists());
}

#[test]
fn a_reader_that_goes_away_ends_it_quietly() {
    let mut command = command(["reconstruct"]);
    command.arg(data("delft_ahn3.laz")).arg("-f").arg(data("footprints.geojson")).args(["-q", "-o", "-"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let mut first = String::new();
    BufReader::new(child.stdout.take().unwrap()).read_line(&mut first).unwrap();
    assert!(first.starts_with("{\"type\":\"CityJSON\""), "{first}");
    let run: Run = child.wait_with_output().unwrap().into();
    assert_eq!((run.code, run.err.as_str()), (0, ""));
}

#[test]
fn pipes_get_a_sequence_and_no_other_format() {
    let folder = tempdir().unwrap();
    let tile = folder.path().join("house.laz");
    write_house(&tile, Some(UTM31), 6);
    let make = |name: &str| {
        let pipe = folder.path().join(name);
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        pipe
    };
    let pipe = make("pipe");
    let reader = {
        let pipe = pipe.clone();
        std::thread::spawn(move || {
            let mut text = String::new();
            std::fs::File::open(pipe).unwrap().read_to_string(&mut text).unwrap();
            text
        })
    };
    let run =
        gable(["reconstruct".as_ref(), tile.as_os_str(), "--no-footprint".as_ref(), "-o".as_ref(), pipe.as_os_str()]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert_eq!(features(&reader.join().unwrap()).len(), 1);
    let wrong = make("pipe.gpkg");
    let run =
        gable(["reconstruct".as_ref(), tile.as_os_str(), "--no-footprint".as_ref(), "-o".as_ref(), wrong.as_os_str()]);
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["pipe.gpkg", "takes CityJSONSeq only"]);
}
