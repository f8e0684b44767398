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
        points.extend(zs.iter().flat_map(|&z| [[x, 0.0, z], [x, 8.0, z]]));
    }
    for &y in &ys {
        points.extend(zs.iter().flat_map(|&z| [[0.0, y, z], [10.0, y, z]]));
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
        content.extend(point.iter().flat_map(|value| (*value as f32).to_le_bytes()));
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
        assert!((volume_of(&out) - 400.0).abs() < 20.0, "{name}: {}", volume_of(&out));
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
    assert!((volume_of(&out) - 400.0).abs() < 20.0);
    let info = command(["info", "--unit", "ft", "--up-axis", "y"]).arg(path("hall.xyz")).output().unwrap();
    let info = Run::from(info);
    assert_says(&info.out, &["(10.00 × 8.00 × 5.00)"]);
    // Millimetres that were taken for metres would be a building of ten kilometres.
    write_text(&path("far.xyz"), &points, |p| p.map(|value| value * 1000.0));
    let far = run(&path("far.xyz"), &out, "");
    assert_eq!(far.code, 1);
    assert_says(&far.err, &["far.xyz", "10000 units", "--unit mm"]);
    assert_eq!(run(&path("far.xyz"), &out, "--unit mm").code, 0);
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
    // The id is that of the first file, and what is drawn by chance follows the id.
    let first = quarters.iter().min().unwrap().file_name().unwrap().to_owned();
    std::fs::create_dir(path("whole")).unwrap();
    std::fs::copy(&tile, path("whole").join(&first)).unwrap();
    let whole = run(&path("whole").join(&first), &path("whole.city.jsonl"), "");
    assert_eq!(whole.code, 0, "{}", whole.err);
    let features = |name: &str| {
        let text = std::fs::read_to_string(path(name)).unwrap();
        text.lines().skip(1).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(features("cut.city.jsonl"), features("whole.city.jsonl"));
    assert_eq!(features("cut.city.jsonl").len(), 3);
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

/// A cloud as image matching gives it, of a house of 12 m by 9 m with eaves at 5 m and a ridge at 8 m: smooth ripples of some
/// spacings that go with the place, five times more points at one end than at the other, few on walls and none on large parts
/// of their lower halves, no floor and no ground. The house has 702 m³.
fn from_photographs() -> Vec<[f64; 3]> {
    let mut state = 7_u64;
    let mut random = move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let waves: Vec<([f64; 3], f64, usize)> =
        (0..18).map(|i| (std::array::from_fn(|_| 10.0 * (random() - 0.5)), 6.3 * random(), i % 3)).collect();
    let ripple = |p: [f64; 3], size: f64| {
        let mut moved = p;
        for (k, phase, axis) in &waves {
            moved[*axis] += size * (k[0] * p[0] + k[1] * p[1] + k[2] * p[2] + phase).sin() / 3_f64.sqrt();
        }
        moved
    };
    let roof = |y: f64| 5.0 + 3.0 * (1.0 - (y - 4.5).abs() / 4.5);
    let mut points = Vec::new();
    for _ in 0..60_000 {
        let (side, a, b, chance) = (random(), random(), random(), random());
        let (p, is_wall) = match side {
            s if s < 0.5 => ([12.0 * a, 9.0 * b, roof(9.0 * b)], false),
            s if s < 0.75 => ([12.0 * a, if s < 0.62 { 0.0 } else { 9.0 }, 5.0 * b], true),
            s => ([if s < 0.87 { 0.0 } else { 12.0 }, 9.0 * a, 8.0 * b], true),
        };
        let is_hidden = is_wall && p[2] < 2.5 && (p[0] + p[1]).sin() > -0.2;
        let share = (0.2 + 0.8 * p[0] / 12.0) * if is_wall { 0.5 } else { 1.0 };
        if p[2] <= roof(p[1]) && !is_hidden && chance < share {
            points.push(ripple(p, 0.02));
        }
    }
    points
}

#[test]
fn a_house_from_photographs_comes_out_whole() {
    let folder = tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    write_ply(&path("house.ply"), &from_photographs());
    let out = path("out.city.json");
    let done = run(&path("house.ply"), &out, "");
    assert_eq!(done.code, 0, "{}{}", done.out, done.err);
    assert_valid(&out);
    let report = report_of(&out);
    assert_eq!(report["buildings"].as_array().unwrap().len(), 1);
    assert_eq!(report["buildings"][0]["outcome"], "lod22");
    assert!((volume_of(&out) / 702.0 - 1.0).abs() < 0.05, "{}", volume_of(&out));
}
