//! Agreement with val3dity 2.6, kind by kind: each file of its tests that holds a fault of its own stands here as a house with
//! the same kind of fault, under the name that it has there, with the codes of both.
//!
//! With `GABLE_VAL3DITY=path/to/val3dity` its codes are not taken from the table alone: it is asked.

mod body;
mod cases;

use std::path::Path;
use std::process::Command;

use tempfile::tempdir;

use crate::bench::*;
use cases::{Case, cases};

/// The options by which gable judges as val3dity does.
const BY_ITS_RULES: [&str; 7] =
    ["--planarity", "0.01", "--no-rounding", "--overlap", "0", "--first-level", "--no-schema"];

/// The codes of a file, ascending.
fn codes(file: &Path, options: &[&str]) -> Vec<u16> {
    let report = file.with_extension("report.json");
    let mut command = command(["validate"]);
    let run: Run = command.arg(file).arg("--json").arg(&report).args(options).output().unwrap().into();
    assert!((0..=2).contains(&run.code), "{}: {}", file.display(), run.err);
    codes_in(&report)
}

fn codes_in(report: &Path) -> Vec<u16> {
    json_of(report)["all_errors"].as_array().unwrap().iter().map(|code| code.as_u64().unwrap() as u16).collect()
}

/// What val3dity says where it is at hand; `None` where it ends without a report.
#[expect(clippy::option_option, reason = "not asked, no answer, an answer")]
fn asked(file: &Path) -> Option<Option<Vec<u16>>> {
    let report = file.with_extension("val3dity.json");
    let program = std::env::var_os("GABLE_VAL3DITY")?;
    Command::new(program).arg(file).arg("-r").arg(&report).output().unwrap();
    Some(report.exists().then(|| codes_in(&report)))
}

#[test]
fn the_codes_are_those_of_val3dity_but_for_reasons() {
    let folder = tempdir().unwrap();
    let mut wrong = Vec::new();
    for Case { name, model, val3dity, gable, why } in cases() {
        let file = folder.path().join(format!("{name}.city.json"));
        std::fs::write(&file, model.to_string()).unwrap();
        let found = codes(&file, &["--no-schema"]);
        if found != gable {
            wrong.push(format!("{name}: {found:?} found, {gable:?} expected"));
        }
        let agrees = codes(&file, &BY_ITS_RULES) == val3dity;
        if agrees != why.is_empty() {
            wrong.push(format!(
                "{name}: by val3dity's rules {:?}, val3dity {val3dity:?}; {why}",
                codes(&file, &BY_ITS_RULES)
            ));
        }
        let asked = asked(&file);
        if let Some(said) = asked.filter(|said| said.as_deref().unwrap_or_default() != val3dity) {
            wrong.push(format!("{name}: val3dity says {said:?}, and the table {val3dity:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Public files and what was written by gable before, with their codes by val3dity and by gable with its rules.
const REPORTED: &[(&str, &[u16], &[u16])] = &[
    ("20-normals-204.city.jsonl", &[204], &[204]),
    ("21-overlapping-parts-601.json", &[601], &[601]),
    ("22-geometry-template-203.json", &[203], &[203]),
    ("23-composite-501.json", &[501], &[501]),
    // Vertices that are exactly the snap distance apart are one, whatever stands around them.
    ("validator/102-at-exactly-1mm-face.city.json", &[], &[102]),
    ("validator/102-at-exactly-1mm-feature.city.json", &[], &[102]),
    ("validator/104-rotterdam-1mm.city.json", &[104], &[102]),
    ("validator/204-3dbag.city.json", &[204], &[204]),
    ("validator/204-gable-output-bag-020.city.json", &[204], &[204]),
    ("validator/204-gable-output-bag-025.city.json", &[204], &[204]),
    ("validator/204-zurich.city.json", &[204], &[204]),
    ("validator/204_1.city.json", &[204], &[204]),
    ("validator/303_2.city.json", &[303], &[303]),
    ("validator/601-overlap-1m-grid-1m.city.json", &[601], &[601]),
    ("validator/601-overlap-1m-real-v1.0.city.json", &[601], &[601]),
    ("validator/601-overlap-2mm-grid-1mm.city.json", &[601], &[601]),
    ("validator/601-overlap-3mm-grid-1mm.city.json", &[601], &[601]),
    ("validator/dummy.json", &[102, 104, 203], &[102, 104, 203]),
    ("validator/empty_primitive.json", &[902], &[902]),
    // It has no transform; what is in it is checked all the same.
    ("validator/notransform.city.jsonl", &[901], &[203, 901]),
];

#[test]
fn reported_files_have_the_codes_of_val3dity() {
    let reported = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/reported");
    if !reported.exists() {
        println!("skipped: shared data not found");
        return;
    }
    let folder = tempdir().unwrap();
    let mut wrong = Vec::new();
    for (name, val3dity, gable) in REPORTED {
        let file = folder.path().join(Path::new(name).file_name().unwrap());
        std::fs::copy(reported.join(name), &file).unwrap();
        let found = codes(&file, &BY_ITS_RULES);
        if found != *gable {
            wrong.push(format!("{name}: {found:?} found, {gable:?} expected"));
        }
        if let Some(said) = asked(&file).filter(|said| said.as_deref().unwrap_or_default() != *val3dity) {
            wrong.push(format!("{name}: val3dity says {said:?}, and the table {val3dity:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
