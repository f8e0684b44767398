//! `gable info`.

use serde_json::Value;
use tempfile::tempdir;

use crate::bench::*;

fn info(args: &[&std::path::Path], rest: &str) -> Run {
    let mut command = command(["info"]);
    command.args(args).args(rest.split_whitespace()).output().unwrap().into()
}

#[test]
fn a_tile_and_footprints_are_described_for_a_person() {
    let run = info(&[&data("delft_ahn3.laz"), &data("footprints_wgs84.geojson")], "");
    assert_eq!(run.code, 0, "{}", run.err);
    let told = [
        "LAZ 1.4, point format 6, 141 577 points",
        "EPSG:7415 (Amersfoort / RD New + NAP height)",
        "6 building",
        "45 646",
        "54 879",
        "points/m²",
        "71 footprints",
        "71 of 71 lie on a tile",
    ];
    assert_says(&run.out, &told);
}

#[test]
fn a_tile_and_footprints_are_described_for_a_script() {
    let run = info(&[&data("delft_ahn3.laz"), &data("footprints.geojson")], "--json");
    assert_eq!(run.code, 0, "{}", run.err);
    let json: Value = serde_json::from_str(&run.out).unwrap();
    let tile = &json["tiles"][0];
    assert_eq!(tile["points"], 141_577);
    assert_eq!(tile["classes"], serde_json::json!({"1": 41_029, "2": 54_879, "6": 45_646, "9": 23}));
    assert_eq!(tile["returns"].as_object().unwrap().values().filter_map(Value::as_u64).sum::<u64>(), 141_577);
    assert_eq!(tile["crs"]["code"], "EPSG:7415");
    let footprints = &json["footprints"][0];
    assert_eq!((&footprints["footprints"], &footprints["overlap"]["touching"]), (&71.into(), &71.into()));
    assert_eq!(footprints["crs"]["code"], "EPSG:28992");
    assert_eq!(footprints["id_attribute"], "id");
}

#[test]
fn what_cannot_be_read_does_not_hide_what_can() {
    let folder = tempdir().unwrap();
    let bad = folder.path().join("bad.laz");
    std::fs::write(&bad, "no tile").unwrap();
    let run = info(&[&bad, &data("delft_ahn3.laz")], "");
    assert_eq!(run.code, 2);
    assert_says(&run.err, &["bad.laz"]);
    assert_says(&run.out, &["141 577 points"]);
    assert_eq!(info(&[&bad], "").code, 1);
    assert_eq!(info(&[&folder.path().join("nowhere.laz")], "").code, 1);
}
