//! Tiles that are not what they should be.

use std::path::Path;

use crate::bench::*;

/// Bytes in the header of LAS 1.4: the number of points, and the scale of x.
const POINTS: usize = 247;
const SCALE: usize = 131;
/// Bytes of the header that say where the points begin.
const BEGIN: usize = 96;

/// Changes bytes of a file.
fn patch(path: &Path, at: usize, bytes: &[u8]) {
    let mut content = std::fs::read(path).unwrap();
    content[at..at + bytes.len()].copy_from_slice(bytes);
    std::fs::write(path, content).unwrap();
}

/// A folder with the house as LAZ and as LAS.
fn folder() -> tempfile::TempDir {
    let folder = house_folder();
    write_house(&folder.path().join("house.las"), None, 6);
    folder
}

/// What the report says of the tile with this name.
fn tile_of(report: &serde_json::Value, name: &str) -> serde_json::Value {
    let tiles = report["inputs"]["tiles"].as_array().unwrap();
    tiles.iter().find(|tile| tile["file"].as_str().unwrap().ends_with(name)).unwrap().clone()
}

#[test]
fn a_file_that_is_no_tile_is_refused_with_what_it_begins_with() {
    let folder = folder();
    let contents: [(&str, &[u8], &str); 4] = [
        ("zero.laz", b"", "found an empty file (0 bytes), expected a LAS, LAZ or COPC tile"),
        (
            "garbage.laz",
            b"\x00\xffgarbage in, garbage out",
            "byte 0: found '\\x00\\xffgarbag', expected the signature 'LASF'",
        ),
        ("magic.laz", b"LASG and more", "byte 0: found 'LASG and', expected the signature 'LASF'"),
        ("short.laz", b"LASF and no more", "found a file of 16 bytes, expected a header of 227 bytes"),
    ];
    for (name, content, message) in contents {
        std::fs::write(folder.path().join(name), content).unwrap();
        let run = run_in(folder.path(), name, "footprints.geojson", "");
        assert_ends(&run, 1, &[name, message, "fetch it again"]);
        let run = run_in(folder.path(), &format!("house.laz {name}"), "footprints.geojson", "--overwrite");
        assert_ends(&run, 2, &[message, "the tile is left out"]);
        assert_says(&run.out, &["could not be read or not wholly: 1 of 2", name]);
        let report = report_of(&folder.path().join("out.city.json"));
        assert_eq!(tile_of(&report, name)["left_out"], true);
        assert_eq!(report["buildings"][0]["outcome"], "lod22");
        for left in ["out.city.json", "out.city.json.report.json"] {
            std::fs::remove_file(folder.path().join(left)).unwrap();
        }
    }
}

#[test]
fn a_tile_that_is_cut_off_is_used_as_far_as_it_goes() {
    let folder = tempfile::tempdir().unwrap();
    let whole = std::fs::read(data("delft_ahn3.laz")).unwrap();
    let tile = folder.path().join("cut.laz");
    std::fs::write(&tile, &whole[..300_000]).unwrap();
    let out = folder.path().join("out.city.json");
    let run = reconstruct(&[&tile], &data("footprints.geojson"), &out, "");
    assert_ends(&run, 2, &["91577 of 141577 points are missing", "the 50000 that could be read are used"]);
    assert_says(&run.out, &["points that could not be read", "91 577", "could not be read or not wholly: 1 of 1"]);
    let report = report_of(&out);
    assert_eq!(tile_of(&report, "cut.laz")["missing_points"], 91_577);
    assert_eq!(report["counts"]["written"], 71, "footprints without points are written too");
    assert!(report["counts"]["buildings_lod22"].as_u64().unwrap() > 20);
}

#[test]
fn a_header_that_promises_too_much_is_not_believed() {
    let folder = folder();
    for name in ["house.laz", "house.las"] {
        for promised in [4000_u64, u64::MAX] {
            patch(&folder.path().join(name), POINTS, &promised.to_le_bytes());
            let run = run_in(folder.path(), name, "footprints.geojson", "--overwrite");
            let missing = format!("{} of {promised} points are missing", promised - 3360);
            assert_ends(&run, 2, &[name, &missing, "the 3360 that could be read are used"]);
            let report = report_of(&folder.path().join("out.city.json"));
            assert_eq!(tile_of(&report, name)["missing_points"], promised - 3360);
            assert_eq!(report["buildings"][0]["points"], 320);
        }
    }
}

#[test]
fn a_tile_without_a_point_is_told_from_one_that_is_broken() {
    let folder = folder();
    write_tile(&folder.path().join("empty.laz"), None, &[]);
    let run = run_in(folder.path(), "empty.laz", "footprints.geojson", "");
    assert_ends(&run, 1, &["empty.laz: found no point: the header says 0, expected tiles with points"]);
    let run = run_in(folder.path(), "empty.laz house.laz", "footprints.geojson", "");
    assert_ends(&run, 0, &["warning: ", "empty.laz: the tile holds no point"]);
    let report = report_of(&folder.path().join("out.city.json"));
    assert_eq!(tile_of(&report, "empty.laz")["problems"].as_array().unwrap().len(), 1);
}

#[test]
fn coordinates_that_cannot_be_are_left_out() {
    let folder = folder();
    let tile = folder.path().join("house.las");
    let content = std::fs::read(&tile).unwrap();
    let begin = u32::from_le_bytes(std::array::from_fn(|i| content[BEGIN + i])) as usize;
    patch(&tile, begin, &i32::MAX.to_le_bytes());
    let run = run_in(folder.path(), "house.las", "footprints.geojson", "");
    assert_ends(&run, 0, &["house.las: 1 points with impossible coordinates were left out"]);
    for scale in [f64::NAN, f64::INFINITY, 0.0] {
        patch(&tile, SCALE, &scale.to_le_bytes());
        let run = run_in(folder.path(), "house.las", "footprints.geojson", "--overwrite");
        assert_ends(&run, 1, &["house.las, coordinate scale: found [", "expected finite numbers, scales not 0"]);
    }
}

#[test]
fn a_class_that_does_not_occur_is_answered_with_those_that_do() {
    let folder = folder();
    let run = run_in(folder.path(), "house.laz", "footprints.geojson", "--building-class 17,20");
    let message = "no point of building class 17,20; the classes are 2 (3040 points), 6 (320 points)";
    assert_ends(&run, 1, &["house.laz", message, "--building-class"]);
    assert_eq!(names_in(folder.path()), ["footprints.geojson", "house.las", "house.laz"]);
}

#[test]
fn a_tile_that_is_given_twice_counts_once() {
    let folder = folder();
    assert_ends(&run_in(folder.path(), "house.laz", "footprints.geojson", ""), 0, &[]);
    let once = std::fs::read(folder.path().join("out.city.json")).unwrap();
    std::fs::copy(folder.path().join("house.laz"), folder.path().join("copy.laz")).unwrap();
    for tiles in ["house.laz house.laz", "house.laz ./house.laz", "house.laz copy.laz", "house.laz house.las"] {
        assert_ends(&run_in(folder.path(), tiles, "footprints.geojson", "--overwrite"), 0, &[]);
        assert!(std::fs::read(folder.path().join("out.city.json")).unwrap() == once, "{tiles}");
        let report = report_of(&folder.path().join("out.city.json"));
        assert_eq!(report["buildings"][0]["points"], 320, "{tiles}");
    }
}

#[test]
fn places_without_tiles_are_named() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("none")).unwrap();
    let run = run_in(folder.path(), "none", "footprints.geojson", "");
    assert_ends(
        &run,
        1,
        &["none: found a folder without .las, .laz, .ply, .xyz or .pts files", "not searched recursively"],
    );
    let run = run_in(folder.path(), "none/*.laz", "footprints.geojson", "");
    assert_ends(&run, 1, &["none/*.laz: found a pattern that matches no .las, .laz, .ply, .xyz or .pts file"]);
}

#[cfg(unix)]
#[test]
fn a_tile_that_may_not_be_read_is_named() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let tile = folder.path().join("house.laz");
    std::fs::set_permissions(&tile, std::fs::Permissions::from_mode(0o000)).unwrap();
    if std::fs::File::open(&tile).is_ok() {
        println!("skipped: this user may read everything");
        return;
    }
    let run = run_in(folder.path(), "house.laz", "footprints.geojson", "");
    assert_ends(&run, 1, &["house.laz: cannot open", "See whether you may read"]);
}

#[test]
fn real_tiles_that_went_wrong() {
    let Some(edge) = shared("edge-cases") else { return };
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out.city.json");
    let run = |tiles: &[&Path]| reconstruct(tiles, &data("footprints.geojson"), &out, "--overwrite");
    let (empty, truncated, feet) = (edge.join("empty.laz"), edge.join("truncated.laz"), edge.join("autzen-feet.laz"));
    assert_ends(&run(&[&empty]), 1, &["empty.laz: found no point"]);
    let interrupted = "truncated.laz: found a header that was never completed: the program that wrote it (PDAL";
    assert_ends(&run(&[&truncated]), 1, &[interrupted, "Make or fetch the file again"]);
    assert_ends(&run(&[&feet]), 1, &["found no overlap", "NAD_1983_HARN", "footprints.geojson"]);
    assert!(names_in(folder.path()).is_empty());
    assert_ends(&run(&[&truncated, &data("delft_ahn3.laz")]), 2, &[interrupted, "the tile is left out"]);
    let report = report_of(&out);
    assert_eq!(tile_of(&report, "truncated.laz")["left_out"], true);
    assert_eq!((&report["exit_code"], &report["counts"]["written"]), (&2.into(), &71.into()));
}
