mod chosen;
mod formats;

use std::collections::BTreeSet;
use std::fs;
use std::path::PathBuf;

use cjval::CJValidator;
use serde_json::{Value, json};

use super::*;
use crate::building::{Building, LadderStep, Measures, Outcome, Reason, RoofHeights, RoofType, Setback};
use crate::completeness::{Extent, Extents};
use crate::error::Error;
use crate::reconstruct::blocks::block;
use crate::site::{Coverage, Frame, Ground, GroundSource};
use crate::solid::{Face, FootprintPolygon, Model, Part, Solid, Surface, SurfaceType};
use crate::source::cityjson::{self, CityModel, CityObject, Transform};
use crate::source::crs::Crs;

const STEP: [f64; 3] = [1e-4; 3];

fn frame() -> Frame {
    Frame { origin: [84_967.0, 447_497.0, -1.0], metres_per_unit: [1.0; 3] }
}

fn building(id: &str) -> Building {
    Building {
        id: id.into(),
        frame: frame(),
        attributes: serde_json::Map::new(),
        model: Model::default(),
        outcome: Outcome::Rejected { reason: Reason::NoPolygon, detail: "a null geometry".into() },
        record: crate::record::Record::default(),
        measures: Measures::default(),
        notes: Vec::new(),
    }
}

/// A gabled house of 8 m × 6 m, eaves at 3 m, ridge at 5 m along x.
fn gabled_house() -> Solid {
    let m = |x: i64, y: i64, z: i64| [x * 10_000, y * 10_000, z * 10_000];
    let vertices = vec![
        m(0, 0, 0),
        m(8, 0, 0),
        m(8, 6, 0),
        m(0, 6, 0),
        m(0, 0, 3),
        m(8, 0, 3),
        m(8, 6, 3),
        m(0, 6, 3),
        m(0, 3, 5),
        m(8, 3, 5),
    ];
    let slope = 2f64.atan2(3.0).to_degrees();
    let roof = |azimuth| Surface {
        slope: Some(slope),
        azimuth: Some(azimuth),
        heights: Some([3.0, 5.0]),
        ..Surface::of(SurfaceType::Roof)
    };
    let wall = Surface { on_footprint_edge: Some(true), ..Surface::of(SurfaceType::Wall) };
    let face = |ring: &[u32], surface| Face { rings: vec![ring.to_vec()], surface };
    Solid {
        step: STEP,
        vertices,
        faces: vec![
            face(&[3, 2, 1, 0], 0),
            face(&[4, 5, 9, 8], 1),
            face(&[6, 7, 8, 9], 2),
            face(&[0, 1, 5, 4], 3),
            face(&[1, 2, 6, 9, 5], 4),
            face(&[2, 3, 7, 6], 5),
            face(&[3, 0, 4, 8, 7], 6),
        ],
        surfaces: vec![
            Surface::of(SurfaceType::Ground),
            roof(180.0),
            roof(0.0),
            wall.clone(),
            wall.clone(),
            wall.clone(),
            wall,
        ],
    }
}

fn square(x: i64, y: i64, side: i64) -> Vec<[i64; 2]> {
    [[x, y], [x + side, y], [x + side, y + side], [x, y + side]].map(|p| p.map(|c| c * 10_000)).to_vec()
}

/// All that a file may have to hold.
fn neighbourhood() -> Vec<Building> {
    let mut house = building("huis/é 七 \"1\"");
    house.model = Model {
        footprint: vec![vec![vec![[0, 0], [80_000, 0], [80_000, 60_000], [0, 60_000]]]],
        ground: 0,
        parts: vec![Part {
            lod12: block(&vec![vec![[0, 0], [80_000, 0], [80_000, 60_000], [0, 60_000]]], 0, 44_000, STEP),
            lod22: Some(gabled_house()),
            ..Part::default()
        }],
        ..Model::default()
    };
    house.outcome = Outcome::Lod22;
    house.measures = Measures {
        ground: Some(Ground { height: 0.0, spread: 0.0123, source: GroundSource::GroundPoints }),
        coverage: Some(Coverage { share: 1.0 }),
        points: 400,
        point_density: Some(400.0 / 48.0),
        no_data_share: Some(-0.0),
        roof_type: Some(RoofType::Slanted),
        roof_planes: Some(2),
        roof_heights: Some(RoofHeights { min: 2.9996, p50: 4.0, p70: 4.4, p98: 4.9, max: 5.01 }),
        ridge_height: Some(5.0),
        rmse_lod22: Some(f64::NAN),
        completeness: Some(Extents {
            missing: Extent { area: 7.0, largest: 4.0 },
            excess: Extent { area: 2.256, largest: 2.256 },
            ..Extents::default()
        }),
        volume_lod12: Some(211.2),
        ..Measures::default()
    };
    house.attributes = serde_json::from_value(json!({
        "identificatie": "0503100000018603", "big": 9_223_372_036_854_775_807_i64, "huge": u64::MAX, "+plus": 1,
        "plus": 2, "gable_lod": "old", "nested": {"a": [null, true]}, "nothing": null,
    }))
    .unwrap();

    // Two parts; the name of the first is that of another building. The first has a courtyard.
    let mut block_of_two = building("A");
    let mut courtyard = square(2, 2, 2);
    courtyard.reverse();
    let ring: FootprintPolygon = vec![square(0, 0, 6), courtyard];
    let beside: FootprintPolygon = vec![square(6, 0, 4)];
    let parts = [&ring, &beside].map(|p| Part { lod12: block(p, -5_000, 90_000, STEP), ..Part::default() }).to_vec();
    block_of_two.model = Model { footprint: vec![ring, beside], ground: -5_000, parts, ..Model::default() };
    block_of_two.frame.origin = [84_960.0, 447_490.0, 0.0];
    block_of_two.outcome = Outcome::Lod12 { reason: Reason::InvalidSolid, detail: "not closed".into() };
    block_of_two.measures.faults_lod22 = vec![302, 203];
    let setback = |step, reason, codes: &[u16]| Setback { step, reason, detail: "bad".into(), codes: codes.to_vec() };
    block_of_two.measures.setbacks = vec![
        setback(LadderStep::Lod22, Reason::InvalidSolid, &[302]),
        setback(LadderStep::Lod22Coarse, Reason::NothingInside, &[]),
        setback(LadderStep::Lod22Coarsest, Reason::InvalidSolid, &[203, 302]),
    ];
    block_of_two.notes = vec!["a hole was repaired".into()];

    let mut namesake = building("A-0");
    namesake.model.footprint = vec![vec![square(20, 20, 3)]];
    namesake.outcome = Outcome::FootprintOnly { reason: Reason::NoPoints, detail: String::new() };
    vec![house, block_of_two, namesake, building("00012")]
}

fn metadata() -> Metadata {
    Metadata {
        title: "Delft".into(),
        reference_system: reference_system("EPSG:7415"),
        crs: Some(Crs::parse("EPSG:7415").unwrap()),
        transform: Transform { scale: [1e-4; 3], translate: [84_900.0, 447_400.0, 0.0] },
        others: Metadata::making(json!({"lambda": 1.0})),
        extensions: None,
    }
}

fn encoder(buildings: &[Building]) -> Encoder {
    let ids = buildings.iter().map(|b| b.id.as_str()).collect();
    Encoder::new(ids, PointCloud { source: Some("AHN3".into()), date: None })
}

fn write(folder: &tempfile::TempDir, name: &str, buildings: &[Building]) -> (PathBuf, Written) {
    let path = folder.path().join(name);
    let mut sink = create(&path, metadata(), true).unwrap();
    let mut encoder = encoder(buildings);
    for building in buildings {
        sink.write(&encoder.feature(building)).unwrap();
    }
    let written = sink.finish().unwrap();
    assert_eq!(written.bytes, fs::metadata(&path).unwrap().len());
    (path, written)
}

/// Errors and warnings of cjval, none of which there may be.
fn faults(validator: &CJValidator) -> Vec<String> {
    validator.validate().values().flat_map(|summary| summary.get_errors().clone()).collect()
}

fn object<'a>(model: &'a CityModel, id: &str) -> &'a CityObject {
    model.objects.iter().find(|object| object.id == id).unwrap()
}

#[test]
fn cityjson_is_valid() {
    let folder = tempfile::tempdir().unwrap();
    let (path, written) = write(&folder, "out.city.json", &neighbourhood());
    assert_eq!((written.format, written.features, written.objects), (Some(Format::CityJson), 4, 7));
    let text = fs::read_to_string(path).unwrap();
    assert_eq!(faults(&CJValidator::from_str(&text)), Vec::<String>::new());
    let root: Value = serde_json::from_str(&text).unwrap();
    assert_eq!(root["metadata"]["referenceSystem"], "https://www.opengis.net/def/crs/EPSG/0/7415");
    assert_eq!(root["metadata"]["geographicalExtent"], json!([84_960.0, 447_490.0, -1.0, 84_990.0, 447_520.0, 9.0]));
    let buildings = root["CityObjects"].as_object().unwrap().values().filter(|object| object["type"] == "Building");
    for building in buildings {
        assert_eq!(building["attributes"]["gable_point_cloud_source"], "AHN3");
        assert_eq!(building["attributes"].get("gable_point_cloud_date"), None);
    }
    // (0, 0, 0) of the house is the first vertex: (84967 − 84900, 447497 − 447400, −1 − 0) · 10⁴.
    assert_eq!(root["vertices"][0], json!([670_000, 970_000, -10_000]));
}

#[test]
fn cityjsonseq_is_valid_line_by_line() {
    let folder = tempfile::tempdir().unwrap();
    let (path, written) = write(&folder, "out.city.jsonl", &neighbourhood());
    assert_eq!((written.format, written.features, written.objects), (Some(Format::CityJsonSeq), 4, 7));
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let mut validator = CJValidator::from_str(lines.next().unwrap());
    assert_eq!(faults(&validator), Vec::<String>::new());
    for line in lines {
        validator.from_str_cjfeature(line).unwrap();
        assert_eq!(faults(&validator), Vec::<String>::new());
    }
}

#[test]
fn what_is_written_is_what_is_read() {
    let folder = tempfile::tempdir().unwrap();
    let buildings = neighbourhood();
    for name in ["out.city.json", "out.city.jsonl"] {
        let model = cityjson::read(&write(&folder, name, &buildings).0).unwrap();
        assert_eq!(model.crs_code().as_deref(), Some("EPSG:7415"));
        let ids: Vec<_> = model.objects.iter().map(|object| object.id.as_str()).collect();
        let house = buildings[0].id.as_str();
        assert_eq!(ids, [house, &format!("{house}-0"), "A", "A-part-0", "A-1", "A-0", "00012"]);

        let whole = object(&model, "A");
        assert_eq!(whole.children, ["A-part-0", "A-1"]);
        assert_eq!(whole.geometries[0].lod, "0");
        assert_eq!(whole.geometries[0].shells[0].faces[0].rings.len(), 2);
        for (n, id) in whole.children.iter().enumerate() {
            let part = object(&model, id);
            assert_eq!(part.parents, ["A"]);
            let expected = buildings[1].model.parts[n].lod12.as_ref().unwrap();
            assert_same(&model.solid(&part.geometries[0], &buildings[1].frame).unwrap(), expected);
        }
        let part = object(&model, &format!("{house}-0"));
        assert_eq!(part.geometries.iter().map(|g| g.lod.as_str()).collect::<Vec<_>>(), ["1.2", "2.2"]);
        let solid = model.solid(&part.geometries[1], &frame()).unwrap();
        assert_same(&solid, &gabled_house());
        assert_eq!(solid.surfaces[1].heights, Some([3.0, 5.0]));
        assert_eq!(solid.surfaces[1].slope, Some(33.69));
        assert!((solid.volume() - 8.0 * 6.0 * 4.0).abs() < 1e-9);
        assert!(object(&model, "00012").geometries.is_empty());
    }
}

/// The same faces over the same points, with the same labels, whatever the order of the vertices.
fn assert_same(read: &Solid, written: &Solid) {
    assert_eq!(read.vertices.iter().collect::<BTreeSet<_>>(), written.vertices.iter().collect::<BTreeSet<_>>());
    assert_eq!(read.faces.len(), written.faces.len());
    for (a, b) in read.faces.iter().zip(&written.faces) {
        let points = |solid: &Solid, face: &Face| -> Vec<Vec<[i64; 3]>> {
            face.rings.iter().map(|ring| ring.iter().map(|&v| solid.vertices[v as usize]).collect()).collect()
        };
        assert_eq!(points(read, a), points(written, b));
        assert_eq!(read.kind(a), written.kind(b));
        let [a, b] = [&read.surfaces[a.surface as usize], &written.surfaces[b.surface as usize]];
        assert_eq!(a.on_footprint_edge, b.on_footprint_edge);
    }
}

#[test]
fn attributes_say_what_came_of_a_building() {
    let folder = tempfile::tempdir().unwrap();
    let buildings = neighbourhood();
    let model = cityjson::read(&write(&folder, "out.json", &buildings).0).unwrap();
    let house = &object(&model, &buildings[0].id).attributes;
    let expected = json!({
        "identificatie": "0503100000018603", "big": 9_223_372_036_854_775_807_i64, "huge": u64::MAX,
        "source_plus": 1, "plus": 2, "source_gable_lod": "old", "nested": {"a": [null, true]}, "nothing": null,
        "gable_success": true, "gable_lod": "2.2", "gable_ladder_step": "lod22",
        "gable_roof_type": "slanted", "gable_roof_planes": 2,
        "gable_height_ground": -1.0, "gable_height_roof_min": 2.0, "gable_height_roof_50p": 3.0,
        "gable_height_roof_70p": 3.4, "gable_height_roof_98p": 3.9, "gable_height_roof_max": 4.01, "gable_height_ridge": 4.0,
        "gable_missing_area": 7.0, "gable_missing_largest": 4.0, "gable_excess_area": 2.26,
        "gable_excess_largest": 2.26, "gable_roofed_ground_area": 0.0, "gable_roofed_ground_largest": 0.0,
        "gable_volume_lod12": 211.2, "gable_validity_lod12": [], "gable_validity_lod22": [],
        "gable_point_cloud_source": "AHN3",
        "gable_points": 400, "gable_point_density": 8.333, "gable_no_data_share": 0.0, "gable_coverage": 1.0,
        "gable_ground_source": "ground-points", "gable_ground_spread": 0.012, "gable_primitives": 0,
        "gable_notes": [
            "the attribute \"+plus\" is written as \"source_plus\"",
            "the attribute \"gable_lod\" is written as \"source_gable_lod\"",
        ],
    });
    assert_eq!(serde_json::to_string(house).unwrap(), expected.to_string(), "names, values and order");
    let fallback = &object(&model, "A").attributes;
    assert_eq!(fallback["gable_lod"], "1.2");
    assert_eq!(fallback["gable_fallback_reason"], "invalid-solid");
    assert_eq!(fallback["gable_fallback_detail"], "not closed");
    assert_eq!(fallback["gable_validity_lod22"], json!([302, 203]));
    assert_eq!(fallback["gable_ladder_step"], "lod12");
    assert_eq!(fallback["gable_ladder_reasons"], json!(["invalid-solid", "nothing-inside", "invalid-solid"]));
    assert_eq!(fallback["gable_ladder_codes"], json!([203, 302]));
    assert_eq!(fallback["gable_notes"], json!(["a hole was repaired"]));
    let rejected = &object(&model, "00012").attributes;
    assert_eq!(rejected["gable_fallback_reason"], "no-polygon");
    assert!(!rejected.contains_key("gable_lod") && rejected["gable_success"] == false);
}

#[test]
fn the_table_of_attributes_is_sound() {
    let names: BTreeSet<_> = ATTRIBUTES.iter().map(|attribute| attribute.name).collect();
    assert_eq!(names.len(), ATTRIBUTES.len());
    assert!(ATTRIBUTES.iter().all(|a| a.name.starts_with("gable_") && !a.meaning.is_empty()));
}

#[test]
fn heights_are_in_the_units_of_the_crs() {
    let foot = 0.3048;
    let mut tower = building("t");
    tower.frame = Frame { origin: [0.0, 0.0, 100.0], metres_per_unit: [foot; 3] };
    tower.measures.ground = Some(Ground { height: 10.0 * foot, spread: 1.0, source: GroundSource::LowestPoints });
    let attributes = attributes::Chosen::default().of(&tower, &PointCloud::default());
    assert_eq!(attributes["gable_height_ground"], 110.0);
    assert_eq!(attributes["gable_ground_spread"], 1.0);
}

#[test]
fn the_same_buildings_give_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["out.city.json", "out.city.jsonl"] {
        let first = fs::read(write(&folder, name, &neighbourhood()).0).unwrap();
        let again = fs::read(write(&folder, name, &neighbourhood()).0).unwrap();
        assert!(first == again);
    }
}

#[test]
fn an_empty_model_is_valid() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["out.city.json", "out.city.jsonl"] {
        let text = fs::read_to_string(write(&folder, name, &[]).0).unwrap();
        assert_eq!(faults(&CJValidator::from_str(&text)), Vec::<String>::new());
    }
}

#[test]
fn nothing_is_replaced_or_left_behind_unasked() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("out.city.jsonl");
    fs::write(&path, "old").unwrap();
    let message = create(&path, Metadata::default(), false).err().unwrap().to_string();
    assert!(message.contains("existing file") && message.contains("--overwrite"), "{message}");
    let mut sink = create(&path, Metadata::default(), true).unwrap();
    sink.write(&encoder(&[]).feature(&building("a"))).unwrap();
    drop(sink);
    assert_eq!(fs::read_to_string(&path).unwrap(), "old");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "the temporary file is gone");

    // A file that appears while we work is not replaced either.
    let late = folder.path().join("late.json");
    let sink = create(&late, Metadata::default(), false).unwrap();
    fs::write(&late, "other").unwrap();
    assert!(matches!(sink.finish(), Err(Error::Input(_))));
    assert_eq!(fs::read_to_string(&late).unwrap(), "other");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2);
}

#[test]
fn what_cannot_be_written_is_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let message = create(&folder.path().join("out.stl"), Metadata::default(), false).err().unwrap().to_string();
    for extension in [".city.json", ".city.jsonl", ".3dtiles", ".gpkg", ".obj"] {
        assert!(message.contains(extension), "{message}");
    }
    let missing = create(&folder.path().join("nowhere/out.json"), Metadata::default(), false);
    assert!(matches!(missing, Err(Error::Io { .. })));
    let urn = Metadata { reference_system: Some("urn:ogc:def:crs:EPSG::7415".into()), ..Metadata::default() };
    assert!(matches!(create(&folder.path().join("out.json"), urn, false), Err(Error::Input(_))));
    assert_eq!(reference_system("EPSG:28992+5709"), None);
}

#[test]
fn writing_is_quick() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("many.city.json");
    let mut sink = create(&path, Metadata::default(), false).unwrap();
    let mut house = neighbourhood().swap_remove(0);
    let mut encoder = Encoder::default();
    let start = std::time::Instant::now();
    for i in 0..2000 {
        house.id = format!("house {i}");
        house.frame.origin[0] += 10.0;
        sink.write(&encoder.feature(&house)).unwrap();
    }
    let spent = start.elapsed().as_secs_f64() * 1e3 / 2000.0;
    println!("{spent:.3} ms per building");
    assert!(spent < 5.0, "{spent} ms: ten times the 0.5 ms that it may take on an idle machine");
    assert_eq!(sink.finish().unwrap().objects, 4000);
}
