//! Attributes of one name: what has to give way is told, never lost without a word.

use serde_json::json;

use crate::bench::*;

#[test]
fn attributes_that_gable_has_itself_are_kept_under_other_names_and_told() {
    let folder = house_folder();
    let path = folder.path().join("footprints.geojson");
    let mut file = json_of(&path);
    let properties = file["features"][0]["properties"].as_object_mut().unwrap();
    for (name, value) in [
        ("gable_lod", json!("old")),
        ("+noise", json!(3)),
        ("Height", json!(1)),
        ("height", json!(2)),
        ("fid", json!(8)),
    ] {
        properties.insert(name.to_owned(), value);
    }
    std::fs::write(&path, file.to_string()).unwrap();
    let run = run_in(folder.path(), "house.laz", "footprints.geojson", "--field height-field");
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.err, &["the attributes `+noise`, `gable_lod` have names that are gable's", "source_"]);
    let model = folder.path().join("out.city.json");
    let attributes = &json_of(&model)["CityObjects"]["007"]["attributes"];
    let found = ["source_gable_lod", "source_noise", "Height", "height"].map(|name| attributes[name].clone());
    assert_eq!(found, [json!("old"), json!(3), json!(1), json!(2)]);
    assert_eq!(attributes["gable_lod"], json!("2.2"));
    // In SQL both heights have one name.
    let run: Run = command(["convert".as_ref(), model.as_os_str(), "-o".as_ref()])
        .arg(folder.path().join("out.gpkg"))
        .output()
        .unwrap()
        .into();
    assert_eq!(run.code, 0, "{}", run.err);
    let said = format!("{}{}", run.out, run.err);
    assert_says(&said, &["\"height\" is \"height_2\"", "\"fid\" is \"source_fid\""]);
    assert!(!said.contains("\"id\""), "the id of the footprint is that of the building: {said}");
}
