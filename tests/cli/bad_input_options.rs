//! Options that are out of range, contradict each other or are misspelt.

use crate::bench::*;

/// Runs the house with these options.
fn with(options: &str) -> Run {
    let folder = house_folder();
    let run = run_in(folder.path(), "house.laz", "footprints.geojson", options);
    assert!(run.code == 0 || names_in(folder.path()) == ["footprints.geojson", "house.laz"], "something was written");
    run
}

#[test]
fn values_out_of_range_are_refused_with_the_range() {
    let cases = [
        ("--lambda -1", "invalid value '-1' for '--lambda", "a number from 0 to 1000 is expected"),
        ("--lambda=nan", "invalid value 'nan'", "a number from 0 to 1000 is expected"),
        ("--step-height inf", "invalid value 'inf' for '--step-height", "a number from 0 to 100 is expected"),
        ("--footprint-tolerance 1e9", "invalid value '1e9'", "a number from 0 to 10 is expected"),
        ("--neighbours 3", "invalid value '3'", "a whole number from 4 to 64 is expected"),
        ("--neighbours 7.5", "invalid value '7.5'", "a whole number from 4 to 64 is expected"),
        ("--ring-area -3", "invalid value '-3'", "a whole number from 0 to 100000 is expected"),
        ("--ground-percentile 101", "invalid value '101'", "a number from 0 to 100 is expected"),
        ("--jobs 0", "invalid value '0' for '--jobs", "a whole number from 1 to 1024 is expected"),
        ("--jobs -1", "invalid value '-1' for '--jobs", "a whole number from 1 to 1024 is expected"),
        ("--jobs 100000", "invalid value '100000'", "a whole number from 1 to 1024 is expected"),
        ("--ground-class 256", "invalid value '256'", "0..=255"),
        ("--building-class 6,256", "found '6,256'", "classes from 0 to 255"),
        ("--point-cloud-date 2014-02-30", "invalid value '2014-02-30'", "expected a date"),
    ];
    for (options, found, expected) in cases {
        assert_ends(&with(options), 1, &[found, expected]);
    }
    assert_ends(&with("--lambda 0 --minimum-feature 0 --step-height 0"), 0, &[]);
}

#[test]
fn contradictions_are_refused() {
    let cases: [(&str, &[&str]); 5] = [
        ("--no-footprint", &["'--footprints <FILE>' cannot be used with '--no-footprint'"]),
        ("--quiet --verbose", &["'--quiet' cannot be used with '--verbose'"]),
        ("--building-class 2,6", &["found class 2 as building and as ground", "each class in one of them"]),
        ("--building-class 6,7", &["--building-class: found class 7, which is noise and never used"]),
        (
            "--minimum-tolerance 6",
            &["found a least tolerance of 6 and a largest of 5", "the first not above the second"],
        ),
    ];
    for (options, says) in cases {
        assert_ends(&with(options), 1, says);
    }
}

#[test]
fn what_is_misspelt_gets_the_nearest() {
    let cases: [(&str, &[&str]); 8] = [
        ("--lamda 0.1", &["'--lamda'", "'--lambda'"]),
        ("--detector ransack", &["a similar value exists: 'ransac'", "region-growing"]),
        ("--partition adaptiv", &["a similar value exists: 'adaptive'"]),
        ("--id-attribute idd", &["no attribute `idd`", "Did you mean `id`? There are: id"]),
        ("--layer footprint", &["no layer `footprint`", "Did you mean `footprints`?"]),
        ("--filter idd=3", &["filter `idd=3`", "Did you mean `id`?"]),
        ("--filter id=", &["filter `id=`"]),
        ("--footprint-crs EPGS:7415", &["--footprint-crs: found `EPGS:7415`", "such as EPSG:7415"]),
    ];
    for (options, says) in cases {
        assert_ends(&with(options), 1, says);
    }
    let run = gable(["recontruct"]);
    assert_ends(&run, 1, &["'reconstruct'"]);
}

#[cfg(unix)]
#[test]
fn pipes_and_devices_are_told_and_do_not_hang() {
    let folder = house_folder();
    let pipe = folder.path().join("pipe.laz");
    assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
    assert_ends(&gable(["info".as_ref(), pipe.as_os_str()]), 1, &["pipe.laz: found a pipe, not a file"]);
    let footprints = folder.path().join("pipe.geojson");
    std::fs::rename(&pipe, &footprints).unwrap();
    assert_ends(&gable(["info".as_ref(), footprints.as_os_str()]), 1, &["pipe.geojson: found a pipe, not a file"]);
    // Whatever else is read from a file.
    for option in ["--dtm", "--model"] {
        let run =
            run_in(folder.path(), "house.laz", "footprints.geojson", &format!("{option} {}", footprints.display()));
        assert_ends(&run, 1, &["pipe.geojson: found a pipe, not a file"]);
    }
    let model = data("reference_3dbag_lod22.city.jsonl");
    let page = folder.path().join("page.html");
    let view = [model.as_os_str(), "-o".as_ref(), page.as_os_str(), "--report".as_ref(), footprints.as_os_str()];
    let run = gable(std::iter::once("view".as_ref()).chain(view));
    assert_ends(&run, 1, &["pipe.geojson: found a pipe, not a file"]);
    assert_ends(&gable(["validate", "/dev/zero"]), 1, &["/dev/zero: found a device, not a file"]);
    // A file without end in all but name.
    let zeros = folder.path().join("zeros.city.json");
    std::fs::File::create(&zeros).unwrap().set_len(1 << 40).unwrap();
    assert_ends(&gable(["validate".as_ref(), zeros.as_os_str()]), 1, &["zeros.city.json, at its beginning"]);
}
