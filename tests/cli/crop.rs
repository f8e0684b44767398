//! `--crop-only`: the points of each building in a file of its own, with an index.

use std::path::Path;

use rusqlite::Connection;
use tempfile::tempdir;

use crate::bench::*;

type Row = (String, Option<String>, Option<i64>, i64, f64);

/// Name, points in the file, building points and height of the ground of each building in an index.
fn index(path: &Path) -> Vec<Row> {
    let connection = Connection::open(path).unwrap();
    let query = "SELECT id, gable_points_file, gable_points_in_file, gable_points, gable_height_ground FROM footprints";
    let mut statement = connection.prepare(query).unwrap();
    let rows = statement.query_map([], |row| Ok((row.get(0)?, row.get(1)?, row.get(2)?, row.get(3)?, row.get(4)?)));
    rows.unwrap().map(Result::unwrap).collect()
}

#[test]
fn each_building_has_its_points_as_they_were_and_the_index_tells_of_them() {
    let folder = tempdir().unwrap();
    let out = folder.path().join("crops");
    let run = delft(&out, "--crop-only");
    assert_ends(&run, 0, &["cropping points: 141 577 points"]);
    assert_says(&run.out, &["files of points", "index.gpkg"]);
    let found = index(&out.join("index.gpkg"));
    assert_eq!(found.len(), 71);
    assert_eq!(names_in(&out).len(), 71 + 2, "an index, a report and the points");
    let mut source = las::Reader::from_path(data("delft_ahn3.laz")).unwrap();
    let format = *source.header().point_format();
    let all: Vec<las::Point> = source.read_all().unwrap().points().map(Result::unwrap).collect();
    for (id, file, points, of_building, ground) in found.iter().take(9) {
        let path = out.join(file.as_ref().unwrap());
        assert_eq!(file.as_deref(), Some(format!("{id}.laz").as_str()));
        let mut reader = las::Reader::from_path(&path).unwrap();
        assert!(reader.header().has_wkt_crs() && *reader.header().point_format() == format);
        let cropped: Vec<las::Point> = reader.read_all().unwrap().points().map(Result::unwrap).collect();
        assert_eq!(Some(cropped.len() as i64), *points);
        let of_class = |class: u8| cropped.iter().filter(|p| u8::from(p.classification) == class).count() as i64;
        assert!(of_class(6) >= *of_building && of_class(2) > 0, "{id}: ground around it is there, too");
        assert!((-1.0..2.0).contains(ground), "{id}: {ground}");
        assert!(cropped.iter().all(|point| all.contains(point)), "{id}: a point that is none of the tile");
    }
    // The crop of a building gives the same model as the tile.
    let id = &found[1].0;
    let filter = format!("id = '{id}'");
    let model = |tile: &Path, name: &str| {
        let out = folder.path().join(name);
        let footprints = data("footprints.geojson");
        let mut command = command(["reconstruct", "--field", "height-field", "--quiet", "--filter", &filter, "-o"]);
        let status = command.arg(&out).arg(tile).arg("-f").arg(footprints).status().unwrap();
        assert!(status.success());
        std::fs::read(out).unwrap()
    };
    let of_tile = model(&data("delft_ahn3.laz"), "tile.city.jsonl");
    let of_crop = model(&out.join(format!("{id}.laz")), "crop.city.jsonl");
    let volume = |bytes: &[u8]| {
        let text = String::from_utf8(bytes.to_vec()).unwrap();
        let feature: serde_json::Value = serde_json::from_str(text.lines().nth(1).unwrap()).unwrap();
        feature["CityObjects"][id]["attributes"]["gable_volume_lod22"].as_f64().unwrap()
    };
    let (tile, crop) = (volume(&of_tile), volume(&of_crop));
    assert!((tile - crop).abs() < 0.02 * tile, "{tile} {crop}");
}

#[test]
fn a_building_across_tiles_is_in_one_file_and_a_run_is_the_same_for_any_tiling() {
    let folder = tempdir().unwrap();
    let tiles = cut_into_four(&data("delft_ahn3.laz"), folder.path());
    let tiles: Vec<&Path> = tiles.iter().map(std::path::PathBuf::as_path).collect();
    let (whole, cut) = (folder.path().join("whole"), folder.path().join("cut"));
    assert_eq!(delft(&whole, "--crop-only --quiet").code, 0);
    assert_eq!(reconstruct(&tiles, &data("footprints.geojson"), &cut, "--crop-only --quiet").code, 0);
    assert_eq!(index(&whole.join("index.gpkg")), index(&cut.join("index.gpkg")));
    assert_eq!(names_in(&whole), names_in(&cut));
}

#[test]
fn what_does_not_go_with_cropping_is_refused() {
    let folder = house_folder();
    let refused = |out: &str, rest: &str, says: &[&str]| {
        let out = folder.path().join(out);
        let (tile, footprints) = (folder.path().join("house.laz"), folder.path().join("footprints.geojson"));
        let run = reconstruct(&[&tile], &footprints, &out, &format!("--crs EPSG:7415 --crop-only {rest}"));
        assert_ends(&run, 1, says);
    };
    refused("a.city.json", "", &["the name of a file", "that of a folder, with --crop-only"]);
    refused("out", "--view", &["--view"]);
    refused("out", "--resume", &["--resume"]);
    std::fs::create_dir(folder.path().join("out")).unwrap();
    std::fs::write(folder.path().join("out/007.laz"), "mine").unwrap();
    refused("out", "", &["007.laz", "1 of 1 are there", "--overwrite"]);
    assert_eq!(std::fs::read(folder.path().join("out/007.laz")).unwrap(), b"mine");
}

#[cfg(unix)]
#[test]
fn what_is_written_is_as_readable_as_other_files() {
    use std::os::unix::fs::PermissionsExt;
    let folder = house_folder();
    let out = folder.path().join("out");
    let (tile, footprints) = (folder.path().join("house.laz"), folder.path().join("footprints.geojson"));
    assert_eq!(reconstruct(&[&tile], &footprints, &out, "--crs EPSG:7415 --crop-only").code, 0);
    let scans = folder.path().join("scans");
    let run = gable(["simulate", "--generate", "1", "--scans", scans.to_str().unwrap()]);
    assert_eq!(run.code, 0, "{}", run.err);
    std::fs::write(folder.path().join("plain"), "").unwrap();
    let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode() & 0o777;
    let plain = mode(&folder.path().join("plain"));
    for file in
        [out.join("007.laz"), out.join("index.gpkg"), scans.join("points.laz"), scans.join("reference.city.json")]
    {
        assert_eq!(mode(&file), plain, "{}", file.display());
    }
}
