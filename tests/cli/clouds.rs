//! Clouds that are no tiles: PLY and text, without a coordinate reference system, of one building or of several.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::Value;
use tempfile::tempdir;

use crate::bench::*;

/// A hall of 10 m by 8 m, 5 m high, seen from all sides: points every 0.25 m on roof, walls and floor.
fn hall(corner: [f64; 3]) -> Vec<[f64; 3]> {
    let steps = |length: f64| (0..=(length * 4.0) as i32).map(|i| f64::from(i) * 0.25).collect::<Vec<_>>();
    let (xs, ys, zs) = (steps(10.0), steps(8.0), steps(5.0));
    let mut points = Vec::new();
    for &x in &xs {
        for &y in &ys {
            points.extend([[x, y, 5.0], [x, y, 0.0]]);
        }
        zs.iter().for_each(|&z| points.extend([[x, 0.0, z], [x, 8.0, z]]));
    }
    for &y in &ys {
        zs.iter().for_each(|&z| points.extend([[0.0, y, z], [10.0, y, z]]));
    }
    points.into_iter().map(|[x, y, z]| [x + corner[0], y + corner[1], z + corner[2]]).collect()
}

/// Points as text, each made by `change`.
fn write_text(path: &Path, points: &[[f64; 3]], change: impl Fn([f64; 3]) -> [f64; 3]) {
    let mut text = String::new();
    for point in points {
        let [x, y, z] = change(*point);
        writeln!(text, "{x} {y} {z} 128").unwrap();
    }
    std::fs::write(path, text).unwrap();
}

/// Points as binary PLY with normals that lie.
fn write_ply(path: &Path, points: &[[f64; 3]]) {
    let mut content = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float nx\nproperty float x\nproperty float y\n\
         property float z\nproperty uchar red\nend_header\n",
        points.len()
    )
    .into_bytes();
    for point in points {
        content.extend(1_f32.to_le_bytes());
        point.iter().for_each(|value| content.extend((*value as f32).to_le_bytes()));
        content.push(200);
    }
    std::fs::write(path, content).unwrap();
}

/// `gable reconstruct CLOUD --no-footprint -o OUT REST`.
fn run(cloud: &Path, out: &Path, rest: &str) -> Run {
    let mut command = command(["reconstruct", "--no-footprint", "--overwrite", "-o"]);
    command.arg(out).arg(cloud).args(rest.split_whitespace()).output().unwrap().into()
}

/// The volume of the only building of a model, m³.
fn volume_of(model: &Path) -> f64 {
    let model = json_of(model);
    let buildings = model["CityObjects"].as_object().unwrap().values();
    let volumes: Vec<f64> =
        buildings.filter_map(|object| object["attributes"]["gable_volume_lod22"].as_f64()).collect();
    assert_eq!(volumes.len(), 1, "{model:#}");
    volumes[0]
}

#[test]
fn a_single_object_needs_neither_classes_nor_a_reference_system() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let points = hall([3.0, 4.0, 1.0]);
    write_ply(&path("hall.ply"), &points);
    write_text(&path("hall.xyz"), &points, |p| p);
    for name in ["hall.ply", "hall.xyz"] {
        let out = path("out.city.json");
        let done = run(&path(name), &out, "");
        assert_eq!(done.code, 0, "{name}: {}{}", done.out, done.err);
        assert_says(&done.err, &["no coordinate reference system", "in metres", "the points have no classes"]);
        let model = json_of(&out);
        assert_eq!(model["metadata"]["referenceSystem"], Value::Null);
        assert_says(model["metadata"]["gable_coordinates"].as_str().unwrap(), &["local", "metres"]);
        assert_valid(&out);
        let report = report_of(&out);
        assert_eq!(report["crs"]["source"], "local");
        assert_eq!(
            (&report["buildings"][0]["id"], &report["buildings"][0]["outcome"]),
            (&"hall".into(), &"lod22".into())
        );
        // The lower walls and the floor are of the object, although nobody says so.
        assert!((volume_of(&out) - 400.0).abs() < 4.0, "{name}: {}", volume_of(&out));
    }
    let info = gable(["info".as_ref(), path("hall.ply").as_os_str()]);
    assert_eq!(info.code, 0, "{}", info.err);
    assert_says(&info.out, &["PLY (binary, little-endian)", "no classes", "unknown; give it with --crs"]);
    let tiles = run(&path("hall.ply"), &path("out.3dtiles"), "");
    assert_eq!(tiles.code, 1);
    assert_says(&tiles.err, &["a model without a CRS", "--crs"]);
    for name in ["out.gpkg", "out.obj", "out.city.jsonl"] {
        let done = run(&path("hall.ply"), &path(name), "");
        assert_eq!(done.code, 0, "{name}: {}", done.err);
    }
    let done = run(&path("hall.xyz"), &path("placed.city.json"), "--crs EPSG:7415");
    assert_eq!(done.code, 0, "{}", done.err);
    assert_says(json_of(path("placed.city.json"))["metadata"]["referenceSystem"].as_str().unwrap(), &["7415"]);
}

#[test]
fn units_and_the_axis_upwards_are_as_they_are_said() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let points = hall([0.0; 3]);
    write_text(&path("hall.xyz"), &points, |[x, y, z]| [x / 0.3048, z / 0.3048, -y / 0.3048]);
    let out = path("out.city.json");
    let done = run(&path("hall.xyz"), &out, "--unit ft --up-axis y");
    assert_eq!(done.code, 0, "{}", done.err);
    assert!((volume_of(&out) - 400.0).abs() < 4.0);
    let info = command(["info", "--unit", "ft", "--up-axis", "y"]).arg(path("hall.xyz")).output().unwrap();
    let info = Run::from(info);
    assert_says(&info.out, &["(10.00 × 8.00 × 5.00)"]);
    // Centimetres that are taken for metres are a building of a kilometre.
    write_text(&path("far.xyz"), &points, |p| p.map(|value| value * 1000.0));
    assert_says(&run(&path("far.xyz"), &out, "").err, &["10000.000 m", "--unit"]);
    let refused = [
        ("--unit ft --crs EPSG:7415", "cannot be used with"),
        ("--up-axis w", "possible values: z, y, x"),
        ("--unit furlong", "us-ft"),
    ];
    for (options, part) in refused {
        let done = run(&path("hall.xyz"), &out, options);
        assert_eq!(done.code, 1);
        assert_says(&done.err, &[part]);
    }
    let done = run(&data("delft_ahn3.laz"), &out, "--unit ft");
    assert_eq!(done.code, 1);
    assert_says(&done.err, &["delft_ahn3.laz", "7415", "leave these options out"]);
}

#[test]
fn footprints_still_need_a_reference_system() {
    let folder = house_folder();
    let tile = folder.path().join("house.xyz");
    std::fs::write(&tile, "x,y,z,classification\n85001,447001,6,6\n85002,447001,6,6\n").unwrap();
    let mut command = command(["reconstruct", "-f"]);
    let done: Run = command
        .arg(folder.path().join("footprints.geojson"))
        .arg(&tile)
        .arg("-o")
        .arg(folder.path().join("out.city.json"))
        .output()
        .unwrap()
        .into();
    assert_eq!(done.code, 1);
    assert_says(&done.err, &["no coordinate reference system", "--crs"]);
}

#[test]
fn buildings_that_stand_apart_come_out_one_by_one() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let mut command = command(["simulate", "--generate", "3", "--seed", "6", "--clean", "--density", "8", "--scans"]);
    let made: Run = command.arg(path("town")).output().unwrap().into();
    assert_eq!(made.code, 0, "{}", made.err);
    let tile = path("town/points.laz");
    let done = run(&tile, &path("town.city.json"), "");
    assert_eq!(done.code, 0, "{}{}", done.out, done.err);
    assert_says(&done.err, &["3 buildings stand apart", "points-1 to points-3"]);
    let report = report_of(&path("town.city.json"));
    let ids: Vec<&str> = report["buildings"].as_array().unwrap().iter().map(|b| b["id"].as_str().unwrap()).collect();
    assert_eq!(ids, ["points-1", "points-2", "points-3"]);
    assert!(report["buildings"].as_array().unwrap().iter().all(|b| b["outcome"] == "lod22"), "{report:#}");
    // Cut into tiles and given in another order they are the same.
    let quarters = cut_into_four(&tile, folder.path());
    let mut again = crate::bench::command(["reconstruct", "--no-footprint", "-j", "1", "-o"]);
    let again: Run = again.arg(path("cut.city.jsonl")).args(quarters.iter().rev()).output().unwrap().into();
    assert_eq!(again.code, 0, "{}", again.err);
    let cut = std::fs::read_to_string(path("cut.city.jsonl")).unwrap();
    let whole = run(&tile, &path("points.city.jsonl"), "");
    assert_eq!(whole.code, 0);
    let whole = std::fs::read_to_string(path("points.city.jsonl")).unwrap();
    let plain = |line: &str, name: &str| line.replace(&format!("\"{name}-"), "\"");
    let features = |text: &str, name: &str| text.lines().skip(1).map(|line| plain(line, name)).collect::<Vec<_>>();
    let name = quarters[0].file_name().unwrap().to_string_lossy().split('.').next().unwrap().to_owned();
    assert_eq!(features(&cut, &name), features(&whole, "points"));
}

#[test]
fn ground_that_nobody_tells_from_buildings_is_refused_with_the_way_out() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let mut points = hall([10.0, 10.0, 0.1]);
    points.extend((0..120).flat_map(|i| (0..120).map(move |j| [f64::from(i) * 0.25, f64::from(j) * 0.25, 0.0])));
    write_text(&path("yard.xyz"), &points, |p| p);
    let done = run(&path("yard.xyz"), &path("out.city.json"), "");
    assert_eq!(done.code, 1);
    assert_says(&done.err, &["ground around", "classification", "--building-class 0"]);
    let told = run(&path("yard.xyz"), &path("out.city.json"), "--building-class 0");
    assert!(!told.err.contains("ground around"), "{}", told.err);
}
