//! Bad usage and bad inputs: exit code 1 and a message that says what to do.

use tempfile::tempdir;

use crate::bench::*;

#[test]
fn bad_usage_is_exit_code_1_and_a_misspelt_option_gets_the_nearest() {
    let run = gable(["reconstruct", "a.laz", "--footprint", "f.gpkg", "-o", "x.city.json"]);
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["--footprint", "--footprints"]);
    let run = gable(["reconstrut"]);
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["'reconstruct'"]);
    assert_eq!(gable::<&str>([]).code, 1);
    assert_eq!(gable(["reconstruct", "a.laz", "-o", "x.city.json"]).code, 1, "neither footprints nor --no-footprint");
    assert_eq!(gable(["reconstruct", "a.laz", "--no-footprint", "-o", "x.city.json", "--jobs", "0"]).code, 1);
}

#[test]
fn help_and_version_are_exit_code_0() {
    assert_says(&gable(["--version"]).out, &["gable ", env!("CARGO_PKG_VERSION")]);
    let help = gable(["reconstruct", "--help"]);
    assert_eq!(help.code, 0);
    let documented =
        ["Examples:", "--footprints", "--overwrite", "--crs", "--jobs", "--detector", "[default: region-growing]"];
    assert_says(&help.out, &documented);
    assert_says(&gable(["--help"]).out, &["Exit codes:", "gable info"]);
}

#[test]
fn an_existing_model_is_kept() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("delft.city.json");
    std::fs::write(&out, "precious").unwrap();
    let run = delft(&out, "");
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["delft.city.json", "--overwrite"]);
    assert_eq!(std::fs::read_to_string(&out).unwrap(), "precious");
    assert_eq!(delft(&out, "--overwrite --quiet").code, 0);
    assert_eq!(json_of(&out)["type"], "CityJSON");
}

#[test]
fn a_format_that_is_none_is_found_out_before_the_work() {
    let folder = tempdir().unwrap();
    let run = delft(&folder.path().join("delft.dwg"), "");
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["delft.dwg", ".city.json"]);
    assert!(!run.err.contains("collecting points"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "something was left behind");
}

#[test]
fn inputs_that_are_not_there_are_named() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("x.city.json");
    let run = reconstruct(&[&folder.path().join("nowhere.laz")], &data("footprints.geojson"), &out, "");
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["nowhere.laz"]);
    let run = reconstruct(&[&data("delft_ahn3.laz")], &folder.path().join("nowhere.gpkg"), &out, "");
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["nowhere.gpkg"]);
    assert!(!out.exists());
}

#[test]
fn tiles_of_which_none_can_be_read_stop_the_run() {
    let folder = tempdir().unwrap();
    let bad = folder.path().join("bad.laz");
    std::fs::write(&bad, b"no tile").unwrap();
    let run = reconstruct(&[&bad], &data("footprints.geojson"), &folder.path().join("x.city.json"), "");
    assert_eq!(run.code, 1);
    assert_says(&run.err, &["bad.laz"]);
}

/// Runs a made-up tile with the bundled footprints.
fn with_tiles(wkts: &[Option<&str>], rest: &str) -> Run {
    let folder = tempdir().unwrap();
    let tiles: Vec<_> = (0..wkts.len()).map(|i| folder.path().join(format!("tile{i}.laz"))).collect();
    for (tile, wkt) in tiles.iter().zip(wkts) {
        write_house(tile, *wkt, 6);
    }
    let tiles: Vec<_> = tiles.iter().map(std::path::PathBuf::as_path).collect();
    reconstruct(&tiles, &data("footprints.geojson"), &folder.path().join("x.city.json"), rest)
}

#[test]
fn an_unknown_crs_is_an_error_that_says_how_to_give_one() {
    let run = with_tiles(&[None], "");
    assert_eq!(run.code, 1, "{}", run.err);
    assert_says(&run.err, &["--crs", "tile0.laz", "EPSG:28992"]);
}

#[test]
fn a_crs_in_degrees_is_refused() {
    let run = with_tiles(&[Some(WGS84)], "");
    assert_eq!(run.code, 1, "{}", run.err);
    assert_says(&run.err, &["WGS 84", "projected"]);
    assert_eq!(with_tiles(&[None], "--crs EPSG:4326").code, 1);
}

#[test]
fn a_crs_that_is_none_is_refused() {
    let run = with_tiles(&[None], "--crs EPSG:nonsense");
    assert_eq!(run.code, 1, "{}", run.err);
    assert_says(&run.err, &["--crs: found `EPSG:nonsense`", "such as EPSG:7415"]);
}

#[test]
fn tiles_of_two_crs_are_an_error_that_names_both() {
    let folder = tempdir().unwrap();
    let other = folder.path().join("other.laz");
    write_house(&other, Some(UTM31), 6);
    let out = folder.path().join("x.city.json");
    let run = reconstruct(&[&data("delft_ahn3.laz"), &other], &data("footprints.geojson"), &out, "");
    assert_eq!(run.code, 1, "{}", run.err);
    assert_says(&run.err, &["EPSG:7415", "UTM zone 31N", "delft_ahn3.laz", "other.laz", "--crs"]);
}

#[test]
fn no_overlap_at_all_is_an_error_that_prints_both_extents() {
    let run = with_tiles(&[None], "--crs EPSG:28992");
    assert_eq!(run.code, 1, "{}", run.err);
    assert_says(&run.err, &["footprints.geojson", "EPSG:28992", "84990", "447"]);
}

#[test]
fn silence_ends_where_the_exit_code_is_not_0() {
    let folder = tempdir().unwrap();
    let [cut, out] = ["cut.laz", "x.city.json"].map(|name| folder.path().join(name));
    let whole = std::fs::read(data("delft_ahn3.laz")).unwrap();
    std::fs::write(&cut, &whole[..whole.len() / 2]).unwrap();
    let run = reconstruct(&[&cut], &data("footprints.geojson"), &out, "--quiet --field height-field");
    assert_eq!((run.code, run.out.as_str(), run.err.lines().count()), (2, "", 1), "{}", run.err);
    assert_says(&run.err, &["error: ", "1 tile(s) could not be read or not wholly", "points are missing"]);
    // What stands in the footprints is of another class.
    let tile = folder.path().join("house.laz");
    write_house(&tile, None, 6);
    let far = folder.path().join("far.geojson");
    write_footprints(&far, &[("a", rectangle(12.0, 12.0, 16.0, 16.0))]);
    let run = reconstruct(&[&tile], &far, &out, "--quiet --overwrite --crs EPSG:7415");
    assert_eq!((run.code, run.out.as_str(), run.err.lines().count()), (1, "", 1), "{}", run.err);
    assert_says(&run.err, &["error: no building has a model", "no footprint holds a point of building class 6"]);
}
