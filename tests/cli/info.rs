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

#[test]
fn a_city_model_is_described() {
    let folder = tempdir().unwrap();
    let model = folder.path().join("delft.city.json");
    let run: Run = command(["reconstruct"])
        .arg(data("delft_ahn3.laz"))
        .args(["--lod", "1.2,1.3,2.2", "--title", "A corner of Delft", "--field", "height-field", "-q", "-f"])
        .arg(data("footprints.geojson"))
        .arg("-o")
        .arg(&model)
        .output()
        .unwrap()
        .into();
    assert_eq!(run.code, 0, "{}", run.err);
    let told = info(&[&model], "");
    assert_eq!(told.code, 0, "{}", told.err);
    assert_says(
        &told.out,
        &[
            "CityJSON",
            "2.0",
            "A corner of Delft",
            "EPSG:7415",
            "BuildingPart",
            "Solid, LoD 1.3",
            "RoofSurface",
            "LoD 2.2: 71",
        ],
    );
    assert!(!told.out.contains("MultiSurface"), "LoD 0 was not asked for: {}", told.out);
    let json: Value = serde_json::from_str(&info(&[&model], "--json").out).unwrap();
    let model_info = &json["models"][0];
    assert_eq!(
        (&model_info["objects"]["Building"], &model_info["geometries"]["Solid, LoD 1.2"]),
        (&71.into(), &71.into())
    );
    // What only looks like one is told for what it is.
    let bad = folder.path().join("bad.city.json");
    std::fs::write(&bad, "no JSON").unwrap();
    let refused = info(&[&bad], "");
    assert_eq!(refused.code, 1);
    assert_says(&refused.err, &["bad.city.json", "a text that is no JSON"]);
}
