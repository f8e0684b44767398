//! Passwords in the arguments of a command line are repeated by no message.

use crate::bench::*;

/// Ways to write the address of a database that nobody runs, each with the password `hunter2`.
const ADDRESSES: [&str; 6] = [
    "PG:host=localhost port=1 user=me password=hunter2 dbname=city",
    "pg:host=localhost port=1 password = 'hun\\' hunter2 '",
    "postgresql://me:hunter2@localhost:1/city",
    "POSTGRES://me:a hunter2@localhost:1/city",
    "postgresql://me@localhost:1/city?password=hunter2",
    "PG:password='hunter2",
];

/// Runs a command line that is refused; what it says, without a password.
fn refused(words: &[&str]) -> String {
    let run = gable(words);
    let said = format!("{}{}", run.out, run.err);
    assert_eq!(run.code, 1, "{words:?}: {said}");
    assert!(!said.is_empty() && !said.contains("hunter2"), "{words:?}: {said}");
    said
}

#[test]
fn bad_usage_is_told_without_them() {
    for address in ADDRESSES {
        let joined = format!("--footprnts={address}");
        let short = format!("-x{address}");
        let set = format!("--writers.lod2.footprints={address}");
        for (words, says) in [
            // The address itself is in the wrong place,
            (&[address][..], "unrecognized subcommand"),
            (&["reconstruct", "-f", "f.gpkg", "-o", "m.gpkg", "--lambda", address], "for '--lambda"),
            (&["reconstruct", "t.laz", "-f", "f.gpkg", "-o", "m.gpkg", "--detector", address], "for '--detector"),
            (&["reconstruct", "t.laz", "-f", "f.gpkg", "-o", "m.gpkg", "--preset", address], "for '--preset"),
            (&["validate", "m.gpkg", "--planarity", address], "for '--planarity"),
            (&["pipeline", "p.json", address, address], "unexpected argument"),
            (&["completions", address], "invalid value"),
            (&["view", "m.city.json", short.as_str()], "unexpected argument '-x'"),
            // or beside something that is wrong.
            (&["reconstruct", "t.laz", joined.as_str(), "-o", "m.gpkg"], "--footprnts"),
            (&["reconstruct", "t.laz", "-f", address, "-o", "m.gpkg", "--lambda", "-1"], "invalid value '-1'"),
            (&["reconstruct", "t.laz", "-f", address, "--no-footprint", "-o", "m.gpkg"], "cannot be used with"),
            (&["reconstruct", "t.laz", "-f", address], "required arguments were not provided"),
            (&["info", address, "--nonsense"], "--nonsense"),
            (&["pipeline", "p.json", set.as_str(), "--nonsense"], "--nonsense"),
        ] {
            assert_says(&refused(words), &[says]);
        }
    }
    // What is wrong stays to be seen.
    assert_says(
        &refused(&["reconstruct", "--detector", ADDRESSES[0]]),
        &["'PG:host=localhost port=1 user=me password=*** dbname=city'"],
    );
}

#[cfg(unix)]
#[test]
fn words_that_are_no_text_are_told_without_them() {
    use std::os::unix::ffi::OsStrExt;
    let word = std::ffi::OsStr::from_bytes(b"PG:password=hunter2 dbname=M\xfcnchen");
    let run = gable(["validate".as_ref(), "m.city.json".as_ref(), "--lambda".as_ref(), word]);
    assert_eq!(run.code, 1);
    assert!(!run.err.contains("hunter2") && run.err.contains("--lambda"), "{}", run.err);
}

#[test]
fn files_and_pipelines_that_cannot_be_read_are_told_without_them() {
    let folder = tempfile::tempdir().unwrap();
    for address in ADDRESSES {
        refused(&["info", address]);
        refused(&["validate", address]);
        refused(&["view", address]);
        refused(&["convert", "m.city.json", "-o", address]);
        let stages = serde_json::json!(["t.laz", {"type": "writers.lod2", "footprints": address, "lambda": -1}]);
        let [pipeline, config] = ["pipeline.json", "gable.toml"].map(|name| folder.path().join(name));
        std::fs::write(&pipeline, stages.to_string()).unwrap();
        refused(&["pipeline", pipeline.to_str().unwrap()]);
        refused(&["pipeline", "--validate", pipeline.to_str().unwrap()]);
        let options = toml_of(&[("footprints", address), ("detector", address)]);
        std::fs::write(&config, options).unwrap();
        refused(&["reconstruct", "t.laz", "-o", "m.gpkg", "--config", config.to_str().unwrap()]);
        std::fs::write(&config, format!("footprints = {address}\n")).unwrap();
        refused(&["reconstruct", "t.laz", "-o", "m.gpkg", "--config", config.to_str().unwrap()]);
    }
}

/// A configuration of these texts.
fn toml_of(options: &[(&str, &str)]) -> String {
    let lines: Vec<String> =
        options.iter().map(|(name, text)| format!("{name} = {}\n", serde_json::json!(text))).collect();
    lines.concat()
}
