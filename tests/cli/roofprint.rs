//! Footprints of walls and outlines of roofs: LoD 2.3.

use serde_json::Value;
use tempfile::tempdir;

use crate::bench::*;

#[test]
fn roofs_hang_over_as_far_as_their_outlines_reach() {
    let folder = tempdir().unwrap();
    let model = folder.path().join("delft.city.json");
    let reconstruct = |more: &[&str]| -> Run {
        let mut command = command(["reconstruct"]);
        command.arg(data("delft_ahn3.laz")).arg("-f").arg(data("walls.geojson"));
        command.args(["--field", "height-field", "--overwrite", "-o"]).arg(&model).args(more).output().unwrap().into()
    };
    let roofs = data("footprints.geojson");
    let run = reconstruct(&["--roofprint", roofs.to_str().unwrap()]);
    assert_eq!(run.code, 0, "{}", run.err);
    let valid: Run = command(["validate"]).arg(&model).output().unwrap().into();
    assert_eq!(valid.code, 0, "{}", valid.out);
    let model: Value = serde_json::from_slice(&std::fs::read(&model).unwrap()).unwrap();
    let buildings = model["CityObjects"].as_object().unwrap().values().filter(|object| object["type"] == "Building");
    let volume = |object: &Value, lod: &str| object["attributes"][format!("gable_volume_lod{lod}")].as_f64();
    let [mut reached, mut larger] = [0, 0];
    for building in buildings {
        let (Some(within), Some(over)) = (volume(building, "22"), volume(building, "23")) else { continue };
        reached += 1;
        larger += usize::from(over > within);
    }
    assert!(reached >= 68 && larger * 10 >= reached * 9, "{reached} of 71, {larger} of them larger");
    let ceilings = model.to_string().matches("OuterCeilingSurface").count();
    assert!(ceilings >= 68, "{ceilings}");
}

#[test]
fn outlines_of_roofs_and_the_level_come_together() {
    let folder = tempdir().unwrap();
    let footprints = data("footprints.geojson");
    let cases: [(&[&str], &[&str]); 3] = [
        (&["--lod", "2.3"], &["--lod", "no outlines of roofs", "--roofprint"]),
        (&["--lod", "2.2", "--roofprint", "roofs.gpkg"], &["--roofprint", "nothing is made of", "--lod with 2.3"]),
        (&["--roofprint", "nowhere.gpkg"], &["nowhere.gpkg"]),
    ];
    for (options, told) in cases {
        let mut command = command(["reconstruct"]);
        command.arg(data("delft_ahn3.laz")).arg("-f").arg(&footprints).arg("-o").arg(folder.path().join("x.city.json"));
        let run: Run = command.args(options).output().unwrap().into();
        assert_eq!(run.code, 1, "{options:?}");
        assert_says(&run.err, told);
    }
}
