//! What the page is given, read back from the page and compared with figures worked out by hand.

use std::io::Read;
use std::path::{Path, PathBuf};

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::read::DeflateDecoder;
use serde_json::{Value, json};

use super::*;

/// A page read back: its head, and its columns as numbers.
struct Unpacked {
    head: Value,
    columns: Vec<(String, Vec<u64>)>,
}

impl Unpacked {
    fn new(html: &[u8]) -> Self {
        let html = std::str::from_utf8(html).unwrap();
        let (_, rest) = html.split_once("type=\"application/octet-stream\">").unwrap();
        let deflated = STANDARD.decode(rest.split_once("</script>").unwrap().0).unwrap();
        let mut bytes = Vec::new();
        DeflateDecoder::new(&deflated[..]).read_to_end(&mut bytes).unwrap();
        let (length, rest) = bytes.split_at(4);
        let (head, mut rest) = rest.split_at(u32::from_le_bytes(length.try_into().unwrap()) as usize);
        let head: Value = serde_json::from_slice(head).unwrap();
        let mut columns = Vec::new();
        for column in head["columns"].as_array().unwrap() {
            let (own, after) = rest.split_at(column[1].as_u64().unwrap() as usize);
            columns.push((column[0].as_str().unwrap().to_owned(), numbers(own)));
            rest = after;
        }
        assert!(rest.is_empty(), "bytes that belong to no column");
        Self { head, columns }
    }

    fn column(&self, name: &str) -> &[u64] {
        &self.columns.iter().find(|(known, _)| known == name).unwrap().1
    }

    /// Places in metres from the origin.
    fn places(&self, name: &str) -> Vec<[f64; 3]> {
        let mut at = [0i64; 3];
        let step = |place: &[u64]| {
            for (sum, &folded) in at.iter_mut().zip(place) {
                *sum += (folded >> 1) as i64 ^ -((folded & 1) as i64);
            }
            at.map(|steps| steps as f64 / 1000.0)
        };
        self.column(name).chunks_exact(3).map(step).collect()
    }

    /// Of each face of a model of one feature: its area from its triangles, and how many of its edges are drawn.
    fn faces(&self) -> Vec<(f64, usize)> {
        let vertices = self.places("vertices");
        let mut corners = self.column("corners").iter();
        let mut rings = self.column("rings").iter();
        let mut triangles = self.column("triangles").iter();
        let mut faces = Vec::new();
        while let Some(&count) = rings.next() {
            let corner_count: u64 = rings.by_ref().take(count as usize).sum();
            let mut vertex = 0i64;
            let mut drawn = 0;
            let mut places = Vec::new();
            for &packed in corners.by_ref().take(corner_count as usize) {
                let folded = packed >> 1;
                vertex += (folded >> 1) as i64 ^ -((folded & 1) as i64);
                drawn += (packed & 1) as usize;
                places.push(nalgebra::Point3::from(vertices[vertex as usize]));
            }
            let count = *triangles.next().unwrap() as usize;
            let own: Vec<usize> = triangles.by_ref().take(3 * count).map(|&corner| corner as usize).collect();
            let area =
                own.chunks(3).map(|t| (places[t[1]] - places[t[0]]).cross(&(places[t[2]] - places[t[0]])).norm());
            faces.push((area.sum::<f64>() / 2.0, drawn));
        }
        faces
    }
}

/// Numbers in LEB128.
fn numbers(bytes: &[u8]) -> Vec<u64> {
    let mut out = Vec::new();
    let (mut number, mut shift) = (0, 0);
    for byte in bytes {
        number |= u64::from(byte & 0x7f) << shift;
        shift += 7;
        if byte & 0x80 == 0 {
            out.push(number);
            (number, shift) = (0, 0);
        }
    }
    out
}

/// A house of 10 m by 8 m by 5 m whose roof has an opening of 2 m by 2 m onto a shaft of 1 m depth, and whose footprint is cut
/// in two triangles. Its id would end a script.
fn house() -> Value {
    let square = |low: f64, high: f64, y: f64, z: f64| {
        [[low, low, z], [high, low, z], [high, y, z], [low, y, z]].map(|p| p.map(|v| (v * 1000.0) as i64)).to_vec()
    };
    let vertices: Vec<[i64; 3]> = [
        square(0.0, 10.0, 8.0, 0.0),
        square(0.0, 10.0, 8.0, 5.0),
        square(3.0, 5.0, 5.0, 5.0),
        square(3.0, 5.0, 5.0, 4.0),
    ]
    .concat();
    let shell = json!([
        [[3, 2, 1, 0]],
        [[4, 5, 6, 7], [8, 11, 10, 9]],
        [[0, 1, 5, 4]],
        [[1, 2, 6, 5]],
        [[2, 3, 7, 6]],
        [[3, 0, 4, 7]],
        [[9, 13, 12, 8]],
        [[10, 14, 13, 9]],
        [[11, 15, 14, 10]],
        [[8, 12, 15, 11]],
        [[12, 13, 14, 15]]
    ]);
    let id = "</script><script>alert(1)</script>";
    json!({
        "type": "CityJSON", "version": "2.0",
        "transform": {"scale": [0.001, 0.001, 0.001], "translate": [85_000, 447_500, 2]},
        "CityObjects": {
            id: {
                "type": "Building", "children": ["part"],
                "attributes": {"gable_rmse_lod22": 0.125, "note": "<img src=x onerror=alert(1)>"},
                "geometry": [{"type": "MultiSurface", "lod": "0", "boundaries": [[[0, 1, 2]], [[0, 2, 3]]]}]
            },
            "part": {
                "type": "BuildingPart", "parents": [id],
                "geometry": [{
                    "type": "Solid", "lod": "2.2", "boundaries": [shell],
                    "semantics": {
                        "surfaces": [
                            {"type": "GroundSurface"}, {"type": "RoofSurface", "slope": 0.0},
                            {"type": "WallSurface"}, {"type": "WallSurface"}
                        ],
                        "values": [[0, 1, 2, 2, 3, 3, 2, 2, 2, 2, 1]]
                    }
                }]
            }
        },
        "vertices": vertices
    })
}

fn written(folder: &Path, model: &Value) -> PathBuf {
    let path = folder.join("a & <b>.city.json");
    std::fs::write(&path, model.to_string()).unwrap();
    path
}

fn page_of(model: &Value) -> (Page, Unpacked) {
    let folder = tempfile::tempdir().unwrap();
    let page = build(&written(folder.path(), model), &Options::default(), &mut |_, _| {}).unwrap();
    let unpacked = Unpacked::new(&page.html);
    (page, unpacked)
}

fn data(name: &str) -> PathBuf {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/data")).join(name)
}

#[test]
fn a_house_comes_back_with_its_areas_and_its_edges() {
    let (page, unpacked) = page_of(&house());
    let faces = unpacked.faces();
    let areas: Vec<f64> = faces.iter().map(|(area, _)| *area).collect();
    assert_eq!(areas, [40.0, 40.0, 80.0, 76.0, 50.0, 40.0, 50.0, 40.0, 2.0, 2.0, 2.0, 2.0, 4.0]);
    // The footprint has its outline and not its diagonal; the solid each of its 24 edges once.
    let drawn: Vec<usize> = faces.iter().map(|(_, drawn)| *drawn).collect();
    assert_eq!((drawn[..2].iter().sum::<usize>(), drawn[2..].iter().sum::<usize>()), (4, 24));
    assert_eq!(unpacked.column("objects"), [0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]);
    assert_eq!(unpacked.head["lods"], json!(["0", "2.2"]));
    assert_eq!(unpacked.column("lods"), [0, 0, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1]);
    // Equal semantic surfaces are one; no semantics is 0.
    assert_eq!(unpacked.column("surfaces"), [0, 0, 1, 2, 3, 3, 3, 3, 3, 3, 3, 3, 2]);
    assert_eq!(unpacked.head["surfaces"][1], json!({"type": "RoofSurface", "attributes": {"slope": 0.0}}));
    let places = unpacked.places("vertices");
    assert_eq!(places.len(), 16, "each vertex once");
    let origin = &unpacked.head["origin"];
    let crs: Vec<f64> = (0..3).map(|i| origin[i].as_f64().unwrap() + places[2][i]).collect();
    assert_eq!(crs, [85_010.0, 447_508.0, 2.0]);
    let contents = Contents {
        buildings: 1,
        lods: vec![("2.2".into(), 1)],
        triangles: 2 + 2 + 8 + 8 + 8 + 2,
        ..Contents::default()
    };
    assert_eq!(page.contents, contents);
}

#[test]
fn nothing_that_stands_in_a_file_can_speak_html() {
    let (page, unpacked) = page_of(&house());
    let html = String::from_utf8(page.html).unwrap();
    assert!(html.contains("<title>a &amp; &lt;b&gt;.city.json"), "{}", &html[..2000]);
    for tag in ["</script", "<script", "<img", "alert(1)"] {
        assert_eq!(html.matches(tag).count(), page::TEMPLATE.matches(tag).count(), "{tag}");
    }
    assert_eq!(unpacked.head["objects"][0]["id"], "</script><script>alert(1)</script>");
}

#[test]
fn faults_are_on_the_face_that_has_them() {
    let mut model = house();
    // A corner of the roof is lifted by a metre: the roof (face 1 of the solid) and no wall is off its plane, as all walls
    // that meet there stand upright.
    model["vertices"][6][2] = json!(6000);
    let (page, unpacked) = page_of(&model);
    assert_eq!(page.contents.invalid, 1);
    let faults = unpacked.head["features"][0]["faults"].as_array().unwrap();
    assert!(!faults.is_empty());
    for fault in faults.iter().filter(|fault| fault["about_labels"] == false) {
        // Two faces of the footprint come first.
        assert_eq!((&fault["object"], &fault["face"]), (&json!(1), &json!(3)), "{fault}");
    }
    assert_eq!(faults[0]["code"], 203, "{faults:?}");
}

#[test]
fn lengths_are_metres_whatever_the_units() {
    let mut model = house();
    // NAD83(2011) / Oregon GIC Lambert (ft): international feet.
    model["metadata"] = json!({"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/6557"});
    let (_, unpacked) = page_of(&model);
    let foot = 0.3048 * 0.3048;
    assert!((unpacked.faces()[2].0 - 80.0 * foot).abs() < 0.01, "{:?}", unpacked.faces()[2]);
}

#[test]
fn models_of_others_and_their_points_come_through() {
    let model = data("reference_3dbag_lod22.city.jsonl");
    let tile = data("delft_ahn3.laz");
    let options = |most_points| Options { tiles: vec![tile.clone()], most_points, ..Options::default() };
    let all = build(&model, &options(usize::MAX), &mut |_, _| {}).unwrap();
    let contents = &all.contents;
    assert_eq!((contents.buildings, contents.others, contents.invalid), (11, 0, 0));
    assert_eq!(contents.lods, [("2.2".to_owned(), 11)]);
    let unpacked = Unpacked::new(&all.html);
    assert_eq!(unpacked.head["features"].as_array().unwrap().len(), 11);

    // By hand: the points of the tile within 3 m of the box of a building.
    let city = cityjson::read(&model).unwrap();
    let boxes: Vec<[f64; 4]> = city
        .groups()
        .iter()
        .map(|group| {
            let faces =
                group.iter().flat_map(|&o| &city.objects[o].geometries).flat_map(|g| &g.shells).flat_map(|s| &s.faces);
            let start = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
            faces.flat_map(|face| &face.rings).flatten().fold(start, |b, &v| {
                let [x, y, _] = city.vertices[v as usize];
                [b[0].min(x), b[1].min(y), b[2].max(x), b[3].max(y)]
            })
        })
        .collect();
    let mut around = 0;
    let mut read = |block: &crate::source::points::Block| {
        for [x, y, _] in block.points().map(|point| point.position) {
            // To the millimetre, as the page has it.
            let m = 3.000_5;
            let is_near = |b: &[f64; 4]| b[0] - m <= x && x <= b[2] + m && b[1] - m <= y && y <= b[3] + m;
            around += usize::from(boxes.iter().any(is_near));
        }
    };
    crate::source::points::Tile::open(&tile).unwrap().stream(None, &mut read).unwrap();
    let [shown, of] = contents.points;
    assert!(around > 10_000 && of.abs_diff(around) <= 20, "{of} for {around}");
    assert_eq!((shown, unpacked.places("points").len()), (of, of));

    // A sample has the number that was asked for, and is the same every time.
    let sample = build(&model, &options(1000), &mut |_, _| {}).unwrap();
    assert_eq!(sample.contents.points, [1000, of]);
    let unpacked = Unpacked::new(&sample.html);
    assert_eq!((unpacked.places("points").len(), unpacked.column("classes").len()), (1000, 1000));
    assert_eq!(sample.html, build(&model, &options(1000), &mut |_, _| {}).unwrap().html);
}

#[test]
fn what_cannot_be_shown_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let mut model = house();
    model["CityObjects"] = json!({});
    let path = written(folder.path(), &model);
    let options = Options::default();
    let message = build(&path, &options, &mut |_, _| {}).unwrap_err().to_string();
    assert!(message.contains("no CityObject that can be read"), "{message}");
    let mut model = house();
    model["metadata"] = json!({"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/4979"});
    let path = written(folder.path(), &model);
    let message = build(&path, &options, &mut |_, _| {}).unwrap_err().to_string();
    assert!(message.contains("geographic") && message.contains("before it is shown"), "{message}");
    let path = written(folder.path(), &house());
    let report = Options { report: Some(path.clone()), ..options };
    let message = build(&path, &report, &mut |_, _| {}).unwrap_err().to_string();
    assert!(message.contains("OUT.report.json"), "{message}");
}

#[test]
fn a_page_is_named_after_its_model() {
    let name = |model: &str| path_for(Path::new(model)).display().to_string();
    assert_eq!(name("out/delft.city.json"), "out/delft.html");
    assert_eq!(name("a.CITY.JSONL"), "a.html");
    assert_eq!(name("b.json"), "b.html");
    assert_eq!(name("c"), "c.html");
}

/// Without node: the page names a hash of the sources that it was made from.
#[test]
fn the_page_is_made_from_its_sources() {
    let named = page::tests::named("src/view/page", &[]);
    assert!(page::TEMPLATE.contains(&named), "src/view/page/dist/page.html is stale: run `make page` ({named})");
}
