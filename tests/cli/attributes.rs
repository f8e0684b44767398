//! Which attributes are written, and what gable's own are called.

use std::collections::BTreeSet;

use tempfile::tempdir;

use crate::bench::*;

#[test]
fn attributes_are_chosen_and_a_prefix_is_found_again() {
    let folder = house_folder();
    let file = |name: &str| folder.path().join(name);
    let chosen =
        "--footprint-attributes none --attributes lod,height_r*,volume_lod22,coverage,points --attribute-prefix bag:";
    let run = run_in(folder.path(), "house.laz", "footprints.geojson", chosen);
    assert_ends(&run, 0, &[]);
    let out = file("out.city.json");
    assert_valid(&out);
    let mut model = json_of(&out);
    let attributes = model["CityObjects"]["007"]["attributes"].as_object().unwrap();
    let names: BTreeSet<&str> = attributes.keys().map(String::as_str).collect();
    let expected = [
        "bag:lod",
        "bag:height_roof_min",
        "bag:height_roof_50p",
        "bag:height_roof_70p",
        "bag:height_roof_98p",
        "bag:height_roof_max",
        "bag:volume_lod22",
        "bag:points",
        "bag:coverage",
    ];
    assert_eq!(names, expected.into());
    assert_eq!(model["metadata"]["gable_attribute_prefix"], "bag:");
    // Who reads the model finds them.
    assert_says(&gable(["info", out.to_str().unwrap()]).out, &["2.2"]);
    model["CityObjects"]["007"]["attributes"]["bag:volume_lod22"] = 1.0.into();
    std::fs::write(&out, model.to_string()).unwrap();
    let said = gable(["validate", out.to_str().unwrap()]);
    assert_says(&said.out, &["807"]);
    let sequence = file("converted.city.jsonl");
    let converted = gable(["convert", out.to_str().unwrap(), "-o", sequence.to_str().unwrap()]);
    assert_ends(&converted, 0, &[]);
    assert_says(&gable(["validate", sequence.to_str().unwrap()]).out, &["807"]);
}

#[test]
fn the_default_is_all_attributes_and_says_nothing_of_a_prefix() {
    let folder = house_folder();
    assert_ends(&run_in(folder.path(), "house.laz", "footprints.geojson", ""), 0, &[]);
    let model = json_of(folder.path().join("out.city.json"));
    assert_eq!(model["metadata"].get("gable_attribute_prefix"), None);
    let attributes = &model["CityObjects"]["007"]["attributes"];
    assert_eq!((&attributes["id"], &attributes["gable_lod"]), (&"007".into(), &"2.2".into()));
    assert_eq!((&attributes["gable_ridges"], &attributes["gable_ridge_length"]), (&0.into(), &0.0.into()));
}

#[test]
fn attributes_that_do_not_exist_are_refused() {
    let folder = house_folder();
    let refused = |rest: &str, says: &[&str]| {
        assert_ends(&run_in(folder.path(), "house.laz", "footprints.geojson", rest), 1, says);
    };
    refused("--attributes heights_*", &["--attributes", "no attribute heights_*"]);
    refused("--attributes hight_ridge", &["the nearest is height_ridge"]);
    refused("--attribute-prefix +x", &["--attribute-prefix", "letters, digits"]);
    refused("--footprint-attributes id,ids", &["footprints.geojson", "no attribute `ids`", "Did you mean `id`?"]);
    refused("--block-attribute simple", &["--block-attribute", "no attribute `simple`"]);
    assert!(!folder.path().join("out.city.json").exists());
}

#[test]
fn the_better_of_two_is_kept_whatever_the_prefix() {
    let folder = tempdir().unwrap();
    write_house(&folder.path().join("house.laz"), None, 6);
    write_footprints(&folder.path().join("footprints.geojson"), &[("007", rectangle(0.0, 0.0, 10.0, 8.0))]);
    let mut models = Vec::new();
    for (name, points) in [("few", 9), ("many", 900)] {
        let run = run_in(folder.path(), "house.laz", "footprints.geojson", "--overwrite --attribute-prefix x_");
        assert_ends(&run, 0, &[]);
        let mut model = json_of(folder.path().join("out.city.json"));
        let object = &mut model["CityObjects"]["007"]["attributes"];
        (object["x_points"], object["who"]) = (points.into(), name.into());
        let path = folder.path().join(format!("{name}.city.json"));
        std::fs::write(&path, model.to_string()).unwrap();
        models.push(path);
    }
    let both = folder.path().join("both.city.json");
    let args = ["merge", models[0].to_str().unwrap(), models[1].to_str().unwrap(), "-o", both.to_str().unwrap()];
    assert_ends(&gable(args), 0, &[]);
    let both = json_of(&both);
    assert_eq!(both["CityObjects"]["007"]["attributes"]["who"], "many");
    assert_eq!(both["metadata"]["gable_attribute_prefix"], "x_");
}
