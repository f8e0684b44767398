//! `--terrain`: the ground between the buildings, which they stand in.

use std::collections::{BTreeMap, BTreeSet, HashMap};
use std::fs::File;
use std::path::Path;

use serde_json::{Map, Value};
use tempfile::tempdir;
use tiff::encoder::TiffEncoder;
use tiff::encoder::colortype::Gray32Float;
use tiff::tags::Tag;

use crate::bench::*;

type Vertex = [i64; 3];

/// A model with its vertices.
struct Model {
    objects: Map<String, Value>,
    vertices: Vec<Vertex>,
}

impl Model {
    fn read(path: &Path) -> Self {
        let file = json_of(path);
        let vertex = |v: &Value| [0, 1, 2].map(|i| v[i].as_i64().unwrap());
        let vertices = file["vertices"].as_array().unwrap().iter().map(vertex).collect();
        Self { objects: file["CityObjects"].as_object().unwrap().clone(), vertices }
    }

    fn vertex(&self, index: &Value) -> Vertex {
        self.vertices[index.as_u64().unwrap() as usize]
    }

    fn ring(&self, ring: &Value) -> Vec<Vertex> {
        ring.as_array().unwrap().iter().map(|index| self.vertex(index)).collect()
    }

    /// The triangles of all terrain, by tile.
    fn terrain(&self) -> BTreeMap<String, Vec<[Vertex; 3]>> {
        let terrain = self.objects.iter().filter(|(_, object)| object["type"] == "TINRelief");
        let triangles = |object: &Value| -> Vec<[Vertex; 3]> {
            let faces = object["geometry"][0]["boundaries"].as_array().unwrap();
            faces.iter().map(|face| self.ring(&face[0]).try_into().unwrap()).collect()
        };
        terrain.map(|(id, object)| (id.clone(), triangles(object))).collect()
    }

    /// The vertices of the ground of each finest solid.
    fn outlines(&self) -> Vec<Vec<Vertex>> {
        let mut outlines = Vec::new();
        for object in self.objects.values().filter(|object| object["type"] == "BuildingPart") {
            let finest = object["geometry"].as_array().unwrap().last().unwrap();
            let semantics = &finest["semantics"];
            let faces = finest["boundaries"][0].as_array().unwrap().iter();
            for (face, surface) in faces.zip(semantics["values"][0].as_array().unwrap()) {
                if semantics["surfaces"][surface.as_u64().unwrap() as usize]["type"] == "GroundSurface" {
                    outlines.extend(face.as_array().unwrap().iter().map(|ring| self.ring(ring)));
                }
            }
        }
        outlines
    }
}

/// Whether a place is inside a ring.
fn holds(ring: &[Vertex], [x, y]: [i64; 2]) -> bool {
    let edges = ring.iter().zip(ring.iter().cycle().skip(1));
    let crossed = edges.filter(|(a, b)| {
        (a[1] > y) != (b[1] > y) && {
            let side = i128::from(b[0] - a[0]) * i128::from(y - a[1]) - i128::from(x - a[0]) * i128::from(b[1] - a[1]);
            (side > 0) == (b[1] > a[1])
        }
    });
    crossed.count() % 2 == 1
}

/// The vertices of the ground outlines that are farther than 1 mm from every vertex of the terrain, of all `count`. Those inside
/// a block, with buildings all around, are by the side.
fn off_terrain(model: &Model) -> (Vec<Vertex>, usize, usize) {
    let mut near: HashMap<[i64; 2], Vec<Vertex>> = HashMap::new();
    let square = |v: &Vertex| [0, 1].map(|i| v[i].div_euclid(20));
    for vertex in model.terrain().values().flatten().flatten() {
        near.entry(square(vertex)).or_default().push(*vertex);
    }
    let outlines = model.outlines();
    let (mut off, mut inside, mut count) = (Vec::new(), 0, 0);
    for vertex in outlines.iter().flatten() {
        count += 1;
        let [column, row] = square(vertex);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [column + i, row + j]));
        let mut found = around.filter_map(|key| near.get(&key)).flatten();
        if found.any(|v| (0..3).map(|i| (v[i] - vertex[i]).pow(2)).sum::<i64>() <= 100) {
            continue;
        }
        // Two millimetres away in nearly all directions: in some building. Between walls a millimetre apart there is no terrain.
        let beside = |angle: f64| [vertex[0] + (20.0 * angle.cos()) as i64, vertex[1] + (20.0 * angle.sin()) as i64];
        let is_built = |n: &i32| outlines.iter().any(|ring| holds(ring, beside(f64::from(*n) * 0.2618)));
        if (0..24).filter(is_built).count() >= 19 {
            inside += 1;
        } else {
            off.push(*vertex);
        }
    }
    (off, inside, count)
}

/// The edges that have a triangle on one side only.
fn lone_edges<'a>(triangles: impl IntoIterator<Item = &'a [Vertex; 3]>) -> BTreeSet<[Vertex; 2]> {
    let mut uses: BTreeMap<[Vertex; 2], usize> = BTreeMap::new();
    for t in triangles {
        for i in 0..3 {
            let (a, b) = (t[i], t[(i + 1) % 3]);
            *uses.entry([a.min(b), a.max(b)]).or_default() += 1;
        }
    }
    uses.into_iter().filter(|(_, n)| *n == 1).map(|(edge, _)| edge).collect()
}

#[test]
fn the_buildings_of_the_quick_start_stand_in_valid_terrain() {
    let folder = tempdir().unwrap();
    let [with, without] = ["with.city.json", "without.city.json"].map(|name| folder.path().join(name));
    let run = delft(&with, "--terrain --terrain-tile 100");
    assert_eq!(run.code, 0, "{}", run.err);
    assert_says(&run.err, &["making the terrain: "]);
    assert_says(&run.out, &["terrain"]);
    assert_valid(&with);
    let checked = gable(["validate".as_ref(), "--strict".as_ref(), with.as_os_str()]);
    assert_eq!(checked.code, 0, "{}", checked.out);

    // The buildings are those of a run without terrain.
    assert_eq!(delft(&without, "").code, 0);
    let [model, plain] = [&with, &without].map(|path| Model::read(path));
    for (id, object) in &plain.objects {
        assert_eq!(object["attributes"], model.objects[id]["attributes"], "{id}");
    }
    assert_eq!(plain.outlines(), model.outlines());

    let (off, inside, count) = off_terrain(&model);
    assert!(off.is_empty(), "{off:?} of {count}");
    assert!(inside * 8 < count && count > 400, "{inside} of {count} are inside blocks");

    // Tiles are named after their corner, and meet without a gap: along the lines between them they share their edges.
    let terrain = model.terrain();
    assert!(terrain.len() > 6 && terrain.keys().all(|id| id.starts_with("terrain-8")), "{:?}", terrain.keys());
    let translate = json_of(&with)["transform"]["translate"].clone();
    let lone = lone_edges(terrain.values().flatten());
    let triangles: usize = terrain.values().map(Vec::len).sum();
    let sides = |t: &[Vertex; 3]| [0, 1, 2].map(|i| [t[i].min(t[(i + 1) % 3]), t[i].max(t[(i + 1) % 3])]);
    let all: BTreeSet<[Vertex; 2]> = terrain.values().flatten().flat_map(sides).collect();
    for axis in 0..2 {
        let start = translate[axis].as_f64().unwrap() as i64 * 10_000;
        let is_on_line = |v: &Vertex| (v[axis] + start).rem_euclid(1_000_000) == 0;
        let on_line: Vec<&[Vertex; 2]> = all.iter().filter(|edge| edge.iter().all(is_on_line)).collect();
        assert!(on_line.iter().filter(|edge| !lone.contains(**edge)).count() > 8, "{}", on_line.len());
        // Where an edge has no triangle on the other side there is no terrain, and no other edge either.
        for edge in on_line.iter().filter(|edge| lone.contains(**edge)) {
            let beside = on_line.iter().find(|other| {
                let [low, high] = [edge[0].max(other[0]), edge[1].min(other[1])].map(|v| v[1 - axis]);
                *other != edge && edge[0][axis] == other[0][axis] && low < high
            });
            assert!(beside.is_none(), "{edge:?} and {beside:?} lie over each other");
        }
    }

    let report = report_of(&with);
    let told = &report["terrain"];
    assert_eq!(told["triangles"], triangles);
    assert_eq!(told["options"]["terrain_tile"], 100.0);
    assert!(told["largest"].as_f64().unwrap() <= 0.1501 && told["rmse"].as_f64().unwrap() < 0.08, "{told:#}");
    assert!(
        told["points"].as_u64().unwrap() > 20_000 && told["missed"] == 0 && told["upright"].as_u64().unwrap() > 0,
        "{told:#}"
    );
    assert_eq!(report_of(&without)["terrain"], Value::Null);
}

#[test]
fn neither_threads_nor_the_cut_of_the_cloud_nor_its_order_change_the_terrain() {
    let folder = tempdir().unwrap();
    let options = "--terrain --terrain-tile 60 --terrain-error 0.1 --quiet --overwrite";
    let out = folder.path().join("out.city.jsonl");
    let bytes = |run: Run| {
        assert_eq!((run.code, run.err.as_str()), (0, ""));
        std::fs::read(&out).unwrap()
    };
    let expected = bytes(delft(&out, &format!("{options} --jobs 1")));
    assert!(bytes(delft(&out, &format!("{options} --jobs 3"))) == expected, "three threads");
    let quarters = cut_into_four(&data("delft_ahn3.laz"), folder.path());
    for order in [[0, 1, 2, 3], [3, 1, 0, 2]] {
        let tiles = order.map(|i| quarters[i].as_path());
        let run = reconstruct(&tiles, &data("footprints.geojson"), &out, options);
        assert!(bytes(run) == expected, "in four, {order:?}");
    }
    // A sequence has them behind the buildings, each a feature.
    let lines = String::from_utf8(expected).unwrap();
    let features: Vec<Value> = lines.lines().skip(1).map(|line| serde_json::from_str(line).unwrap()).collect();
    let is_terrain = |feature: &Value| {
        let id = feature["id"].as_str().unwrap();
        feature["CityObjects"][id]["type"] == "TINRelief"
    };
    let first = features.iter().position(is_terrain).unwrap();
    assert!(first == 71 && features[first..].iter().all(is_terrain) && features.len() > 75);
}

#[test]
fn every_format_takes_the_terrain() {
    let folder = tempdir().unwrap();
    let sequence = folder.path().join("out.city.jsonl");
    assert_eq!(delft(&sequence, "--terrain --quiet").code, 0);
    let checked = gable(["validate".as_ref(), "--strict".as_ref(), sequence.as_os_str()]);
    assert_eq!(checked.code, 0, "{}", checked.out);
    for name in ["out.3dtiles", "out.gpkg", "out.obj", "out.city.json"] {
        let out = folder.path().join(name);
        let run = gable(["convert".as_ref(), sequence.as_os_str(), "-o".as_ref(), out.as_os_str()]);
        assert_eq!(run.code, 0, "{name}: {}", run.err);
        assert!(!run.err.contains("in no tile"), "{name}: {}", run.err);
        let direct = folder.path().join(format!("direct-{name}"));
        assert_eq!(delft(&direct, "--terrain --quiet").code, 0, "{name}");
    }
    let obj = std::fs::read_to_string(folder.path().join("direct-out.obj")).unwrap();
    assert!(obj.contains("usemtl TINRelief") && obj.contains("o terrain-"));
    let gpkg = rusqlite::Connection::open(folder.path().join("direct-out.gpkg")).unwrap();
    let count = |sql: &str| gpkg.query_row(sql, [], |row| row.get::<_, i64>(0)).unwrap();
    assert!(count("SELECT count(*) FROM faces WHERE surface_type = 'TINRelief'") >= 4);
    assert!(count("SELECT count(*) FROM footprints WHERE type = 'TINRelief' AND gable_terrain_error = 0.15") >= 4);
    assert_eq!(
        Model::read(&folder.path().join("out.city.json")).terrain().len(),
        Model::read(&folder.path().join("direct-out.city.json")).terrain().len()
    );
}

/// A terrain model of 1 m pixels around the made-up house, rising to the east from 1 m.
fn write_model(path: &Path) {
    let mut encoder = TiffEncoder::new(File::create(path).unwrap()).unwrap();
    let mut image = encoder.new_image::<Gray32Float>(60, 60).unwrap();
    let tags = image.encoder();
    let [x, y] = [CORNER[0] - 20.0, CORNER[1] + 40.0];
    tags.write_tag(Tag::ModelPixelScaleTag, &[1.0, 1.0, 0.0][..]).unwrap();
    tags.write_tag(Tag::ModelTiepointTag, &[0.0, 0.0, 0.0, x, y, 0.0][..]).unwrap();
    tags.write_tag(Tag::GeoKeyDirectoryTag, &[1, 1, 0, 2, 1024, 0, 1, 1, 3072, 0, 1, 28992_u16][..]).unwrap();
    let heights: Vec<f32> = (0..60 * 60).map(|pixel| 1.0 + 0.05 * (pixel % 60) as f32).collect();
    image.write_data(&heights).unwrap();
}

#[test]
fn a_terrain_model_gives_the_heights_where_points_lack() {
    let folder = house_folder();
    let model = folder.path().join("model.tif");
    write_model(&model);
    // The ground points of the house lie at 0 m: nobody asks them where the terrain model has heights.
    let options = format!("--terrain --terrain-error 0.02 --dtm {}", model.display());
    for rest in ["", "--ground-class 8"] {
        let run = run_in(folder.path(), "house.laz", "footprints.geojson", &format!("{options} {rest} --overwrite"));
        assert_eq!(run.code, 0, "{}", run.err);
        let out = folder.path().join("out.city.json");
        assert_valid(&out);
        let model = Model::read(&out);
        let terrain = model.terrain();
        let (off, ..) = off_terrain(&model);
        assert!(off.is_empty() && !terrain.is_empty(), "{off:?}");
        let heights = terrain.values().flatten().flatten().map(|v| v[2]);
        let (low, high) = (heights.clone().min().unwrap(), heights.max().unwrap());
        assert!((13_000..17_000).contains(&low) && (25_000..33_000).contains(&high), "{low} {high}");
        let (id, _) = terrain.iter().next().unwrap();
        assert_eq!(model.objects[id]["attributes"]["gable_terrain_source"], "terrain-model", "{rest}");
    }
}

#[test]
fn options_of_a_terrain_need_one_and_a_terrain_needs_ground() {
    let folder = house_folder();
    let run = |rest: &str| run_in(folder.path(), "house.laz", "footprints.geojson", rest);
    assert_ends(&run("--terrain-error 0.1"), 1, &["--terrain", "--terrain-error"]);
    assert_ends(&run("--terrain --terrain-error 0"), 1, &["--terrain-error", "a number from 0.01 to 100"]);
    assert_ends(&run("--terrain --ground-class 8"), 0, &["no point of ground class 8: there is no terrain", "--dtm"]);
    assert!(Model::read(&folder.path().join("out.city.json")).terrain().is_empty());
}
