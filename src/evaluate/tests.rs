//! Models from files: a small one by hand, and real buildings whose figures are known.

use std::io::Write;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::*;
use crate::solid::SurfaceType;

/// A building of one part: a block of 4 × 5 × 6 m in millimetres, over a LoD 0 footprint of 8 × 5 m.
fn block_model(lod: &Value, crs: &str) -> Value {
    let corner = |i: i64| json!([(i & 1) * 4000, (i >> 1 & 1) * 5000, (i >> 2 & 1) * 6000]);
    let mut vertices: Vec<Value> = (0..8).map(corner).collect();
    vertices.extend([json!([8000, 0, 0]), json!([8000, 5000, 0])]);
    let faces = json!([[[0, 2, 3, 1]], [[4, 5, 7, 6]], [[0, 1, 5, 4]], [[1, 3, 7, 5]], [[3, 2, 6, 7]], [[2, 0, 4, 6]]]);
    json!({
        "type": "CityJSON", "version": "2.0", "vertices": vertices,
        "transform": { "scale": [0.001, 0.001, 0.001], "translate": [85_000.5, 447_000.25, 1.0] },
        "metadata": { "referenceSystem": crs },
        "CityObjects": {
            "house-0": { "type": "BuildingPart", "parents": ["house"], "geometry": [{
                "type": "Solid", "lod": lod, "boundaries": [faces],
                "semantics": { "surfaces": [{ "type": "GroundSurface" }, { "type": "RoofSurface" }], "values": [[0, 1, null, null, null, null]] }
            }]},
            "house": { "type": "Building", "children": ["house-0"], "geometry": [
                { "type": "MultiSurface", "lod": "0", "boundaries": [[[0, 8, 9, 2]]] }
            ]},
            "lawn": { "type": "PlantCover", "geometry": [{ "type": "MultiSurface", "lod": lod, "boundaries": [[[0, 1, 3]]] }]}
        }
    })
}

fn write(model: &Value) -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("model.city.json");
    std::fs::File::create(&path).unwrap().write_all(model.to_string().as_bytes()).unwrap();
    (folder, path)
}

const RD_NAP: &str = "https://www.opengis.net/def/crs/EPSG/0/7415";

#[test]
fn a_building_is_its_parts_over_its_footprint() {
    for (given, asked) in [(json!("2.2"), "2.2"), (json!(1.3), "1.3"), (json!(2), "2")] {
        let (_folder, path) = write(&block_model(&given, RD_NAP));
        let model = read_shapes(&path, asked, None).unwrap();
        assert_eq!(model.crs.unwrap().code.as_deref(), Some("EPSG:7415"));
        assert_eq!(model.frame.origin, [85_000.0, 447_000.0, 1.0]);
        let [house] = model.shapes.as_slice() else { panic!("{:?}", model.shapes) };
        assert_eq!((house.id.as_str(), house.solids, house.faces.len()), ("house", 1, 6));
        assert!((house.volume() - 120.0).abs() < 1e-6);
        assert_eq!(house.kinds[..3], [SurfaceType::Ground, SurfaceType::Roof, SurfaceType::Wall]);
        // The footprint is twice as wide as the block: half of the points in it have no roof.
        let mut meter = PointMeter::new(&model.shapes);
        meter.add(
            &[[2.0, 2.0, 6.1], [6.0, 2.0, 6.1]]
                .map(|p| nalgebra::Point3::from(p) + nalgebra::Vector3::new(0.5, 0.25, 0.0)),
        );
        let (all, _) = meter.finish();
        assert_eq!((all.points, all.without_roof), (2, 1));
        assert!((all.vertical.unwrap().median - 0.1).abs() < 1e-6);
        assert!(model.solids[0][0].as_ref().is_ok_and(|solid| (solid.volume() - 120.0).abs() < 1e-6));
    }
}

#[test]
fn what_cannot_be_measured_is_refused() {
    let (_folder, path) = write(&block_model(&json!("2.2"), RD_NAP));
    let message = read_shapes(&path, "1.2", None).unwrap_err().to_string();
    assert!(message.contains("buildings at LoD 2.2 only") && message.contains("--lod"), "{message}");
    let (_folder, path) = write(&block_model(&json!("2.2"), "https://www.opengis.net/def/crs/EPSG/0/4979"));
    let message = read_shapes(&path, "2.2", None).unwrap_err().to_string();
    assert!(message.contains("geographic") && message.contains("Reproject"), "{message}");
}

#[test]
fn feet_become_metres() {
    // NAD83 / Oregon LCC (ft) + NAVD88 height (ftUS) has feet in both parts.
    let (_folder, path) = write(&block_model(&json!("2.2"), "https://www.opengis.net/def/crs/EPSG/0/2992"));
    let model = read_shapes(&path, "2.2", None).unwrap();
    assert!((model.shapes[0].volume() - 120.0 * 0.3048_f64.powi(3)).abs() < 1e-6);
}

#[test]
fn the_reference_lies_on_the_points_as_is_known_of_it() {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/delft-quickstart"));
    if !folder.exists() {
        println!("skipped: shared data not found");
        return;
    }
    let model = read_shapes(&folder.join("reference_3dbag_lod22.city.jsonl"), "2.2", None).unwrap();
    assert_eq!(model.shapes.len(), 11);
    let mut meter = PointMeter::new(&model.shapes);
    let filter = TileFilter { classes: &[6], frame: model.frame, crs: model.crs.as_ref() };
    assert!(meter.add_tiles(&[folder.join("delft_ahn3.laz")], filter).unwrap().is_empty());
    let found = Evaluation::new(&model.shapes, None, Some(meter.finish()), Some(&model.shapes));
    // Measured independently: −5 mm in the median, 84 % within 0.2 m.
    let vertical = found.overall.points.unwrap().vertical.unwrap();
    assert!((vertical.offset + 0.005).abs() < 0.001 && (vertical.within_0_2 - 0.84).abs() < 0.005, "{vertical:?}");
    assert_eq!(found.overall.tops.unwrap(), Tops { buildings: 11, above_0_5: 0, above_1: 0 });
    // Rays and the divergence theorem are independent routes to the volume.
    for (shape, building) in model.shapes.iter().zip(&found.buildings) {
        let overlap = building.reference.as_ref().unwrap().overlap.unwrap();
        assert!((overlap.volume / shape.volume() - 1.0).abs() < 2e-3, "{} {overlap:?}", shape.id);
        // A wall that is a millimetre off the vertical may open a ray.
        assert!(overlap.volume_iou > 0.999_999 && overlap.open_rays < 1e-3, "{overlap:?}");
    }
}
