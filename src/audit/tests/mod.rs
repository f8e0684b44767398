mod files;
mod relief;
mod schema;
mod templates;

use std::path::Path;

use serde_json::{Value, json};

use super::*;

/// A file with one building whose LoD 2.2 solid is a box of 10 × 10 × 5 m on a grid of `scale`, after `change`.
fn boxed(scale: f64, change: impl Fn(&mut Value)) -> tempfile::NamedTempFile {
    let n = |metres: f64| (metres / scale).round();
    let mut vertices = Vec::new();
    for z in [0.0, 5.0] {
        vertices.extend([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]].map(|[x, y]| json!([n(x), n(y), n(z)])));
    }
    let shell = json!([[[3, 2, 1, 0]], [[4, 5, 6, 7]], [[0, 1, 5, 4]], [[1, 2, 6, 5]], [[2, 3, 7, 6]], [[3, 0, 4, 7]]]);
    let surfaces = json!([{"type": "GroundSurface"}, {"type": "RoofSurface"}, {"type": "WallSurface"}]);
    let mut file = json!({
        "type": "CityJSON", "version": "2.0",
        "transform": {"scale": [scale, scale, scale], "translate": [85_000.0, 447_000.25, -3.0]},
        "metadata": {"referenceSystem": "https://www.opengis.net/def/crs/EPSG/0/7415"},
        "CityObjects": {
            "b": {"type": "Building", "children": ["b-0"], "attributes": {}},
            "b-0": {"type": "BuildingPart", "parents": ["b"], "geometry": [{
                "type": "Solid", "lod": "2.2", "boundaries": [shell],
                "semantics": {"surfaces": surfaces, "values": [[0, 1, 2, 2, 2, 2]]}
            }]}
        },
        "vertices": vertices
    });
    change(&mut file);
    let out = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(out.path(), file.to_string()).unwrap();
    out
}

/// The checks of geometry and labels alone: the files of these tests are made for them.
fn geometry_only() -> Options {
    Options { schema: false, ..Options::default() }
}

fn report_of(path: &Path) -> Report {
    audit(path, &geometry_only(), &mut |_, _| {}).unwrap()
}

/// Codes and places of the geometric and of the semantic faults.
fn findings(file: &tempfile::NamedTempFile) -> [Vec<(u16, String)>; 2] {
    let report = report_of(file.path());
    let pick = |pick: fn(&Feature) -> &Vec<Finding>| {
        report.features.iter().flat_map(pick).map(|f| (f.code, f.id.clone())).collect()
    };
    [pick(|f| &f.errors), pick(|f| &f.semantic_errors)]
}

const SOUND: [Vec<(u16, String)>; 2] = [Vec::new(), Vec::new()];
const GEOMETRY: &str = "/CityObjects/b-0/geometry/0";

fn set(file: &mut Value, pointer: &str, value: Value) {
    *file.pointer_mut(pointer).unwrap() = value;
}

#[test]
fn any_scale_is_checked_on_its_own_grid() {
    for scale in [0.001, 1e-6, 0.01, 0.5] {
        let file = boxed(scale, |_| {});
        let report = report_of(file.path());
        assert!(report.validity && report.all_semantic_errors.is_empty(), "{scale}: {report:?}");
        assert_eq!(report.grid_step, Some([scale; 3]));
        assert_eq!(report.crs.as_deref(), Some("EPSG:7415 (Amersfoort / RD New + NAP height)"));
    }
    // In feet a corner 0.004 units off its plane is 1.2 mm off it at most, and in metres 4: a quarter of it after least
    // squares.
    for (crs, expected) in [(7415, 1), (6557, 0)] {
        let file = boxed(0.001, |file| {
            set(file, "/metadata/referenceSystem", json!(format!("https://www.opengis.net/def/crs/EPSG/0/{crs}")));
            set(file, "/vertices/6/2", json!(5_005));
        });
        assert_eq!(findings(&file)[0].iter().filter(|f| f.0 == 203).count(), expected, "EPSG:{crs}");
    }
}

#[test]
fn real_coordinates_are_put_on_a_decimal_grid() {
    let real = |scale: f64, shift: f64| {
        let file = boxed(scale, |file| {
            file.as_object_mut().unwrap().remove("transform");
            set(file, "/version", json!("1.0"));
            for vertex in file["vertices"].as_array_mut().unwrap() {
                let at = |i: usize| vertex[i].as_f64().unwrap() * scale + 80_000.0 + shift;
                *vertex = json!([at(0), at(1), at(2)]);
            }
        });
        report_of(file.path())
    };
    for (shift, step) in [(0.0, 1.0), (0.25, 0.01), (0.123_456, 1e-6), (0.123_456_789, 1e-6)] {
        let report = real(0.001, shift);
        assert!(report.validity, "{shift}: {report:?}");
        assert_eq!(report.grid_step, Some([step; 3]), "{shift}");
    }
}

#[test]
fn what_is_not_on_the_grid_is_said() {
    let file = boxed(0.001, |file| set(file, "/vertices/6/2", json!(5_000.5)));
    assert_eq!(findings(&file)[0], [(901, "coid=b-0|geom=0|shell=0".to_owned())]);
    // Too far from the others, and so far that numbers are no longer told apart.
    for (number, expected) in [(1e14, "grid steps away from others"), (1e17, "more than 2^52 grid steps")] {
        let file = boxed(0.001, |file| set(file, "/vertices/6/2", json!(number)));
        assert_eq!(findings(&file)[0], [(901, "coid=b-0|geom=0|shell=0".to_owned())]);
        let message = report_of(file.path()).features[0].errors[0].info.clone();
        assert!(message.contains(expected) && !message.contains("are whole"), "{message}");
    }
    let file = boxed(0.001, |file| set(file, &format!("{GEOMETRY}/boundaries"), json!([[]])));
    assert_eq!(findings(&file)[0], [(902, "coid=b-0|geom=0".to_owned())]);
}

#[test]
fn near_vertices_are_one() {
    // A wall has corners of its own, half a millimetre beside those of its neighbours.
    for (apart, snap, valid) in [(5, 0.001, true), (5, 0.0, false), (20, 0.001, false)] {
        let file = boxed(0.0001, |file| {
            file["vertices"].as_array_mut().unwrap().extend([json!([apart, 0, 0]), json!([apart, 0, 50_000])]);
            set(file, &format!("{GEOMETRY}/boundaries/0/2"), json!([[8, 1, 5, 9]]));
        });
        let tolerances = Tolerances { snap, ..Tolerances::default() };
        let report = audit(file.path(), &Options { tolerances, ..geometry_only() }, &mut |_, _| {}).unwrap();
        assert_eq!(report.validity, valid, "{apart} {snap}: {report:?}");
        assert!(valid || report.all_errors.contains(&302));
    }
}

#[test]
fn faults_have_their_place() {
    let file = boxed(0.001, |file| set(file, &format!("{GEOMETRY}/boundaries/0/3/0"), json!([5, 6, 2, 1])));
    let [errors, _] = findings(&file);
    assert!(errors.len() == 4 && errors.iter().all(|f| *f == (307, "coid=b-0|geom=0|shell=0".to_owned())));
    let report = report_of(file.path());
    assert!(report.features[0].errors[0].info.starts_with("edge 1-2: faces "), "{report:?}");
    let file = boxed(0.001, |file| set(file, &format!("{GEOMETRY}/boundaries/0/3/0"), json!([1, 2, 2, 6, 5])));
    assert_eq!(findings(&file)[0], [(102, "coid=b-0|geom=0|shell=0|face=3".to_owned())]);
    // As surfaces nothing is asked of how the faces hang together.
    for (kind, valid) in [("MultiSurface", true), ("CompositeSurface", false)] {
        let file = boxed(0.001, |file| {
            let mut faces = file.pointer(&format!("{GEOMETRY}/boundaries/0")).unwrap().clone();
            faces[3][0] = json!([5, 6, 2, 1]);
            set(file, GEOMETRY, json!({"type": kind, "lod": "2", "boundaries": faces}));
        });
        assert_eq!(findings(&file) == SOUND, valid, "{kind}");
    }
}

/// Adds a second box with these corners, in metres, and returns its shell.
fn another(file: &mut Value, from: [f64; 3], to: [f64; 3], void: bool) -> Value {
    let vertices = file["vertices"].as_array_mut().unwrap();
    let base = vertices.len();
    for i in 0..8 {
        let [x, y, z] = [[0, 1, 1, 0][i % 4], [0, 0, 1, 1][i % 4], i / 4];
        let pick = |axis: usize, far: usize| if far == 1 { to[axis] * 1e3 } else { from[axis] * 1e3 };
        vertices.push(json!([pick(0, x), pick(1, y), pick(2, z)]));
    }
    let faces = [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]];
    let faces = faces.map(|mut face| {
        if void {
            face.reverse();
        }
        json!([face.map(|v| v + base)])
    });
    json!(faces)
}

#[test]
fn voids_composites_and_parts_are_checked() {
    let with_void = |from: f64, to: f64, inwards: bool| {
        findings(&boxed(0.001, |file| {
            let void = another(file, [from, 1.0, 1.0], [to, 2.0, 2.0], inwards);
            file.pointer_mut(&format!("{GEOMETRY}/boundaries")).unwrap().as_array_mut().unwrap().push(void);
            set(file, &format!("{GEOMETRY}/semantics/values"), json!([[0, 1, 2, 2, 2, 2], null]));
        }))
    };
    let at = |code: u16, place: &str| [vec![(code, format!("coid=b-0|geom=0|{place}"))], vec![]];
    assert_eq!(with_void(1.0, 2.0, true), SOUND);
    assert_eq!(with_void(9.0, 11.0, true), at(401, "shell=1"));
    assert_eq!(with_void(19.0, 21.0, true), at(403, "shell=1"));
    assert_eq!(with_void(1.0, 2.0, false), at(405, "shell=1"));

    let composite = |from: f64| {
        findings(&boxed(0.001, |file| {
            let solid = another(file, [from, 0.0, 0.0], [from + 5.0, 5.0, 5.0], false);
            let first = file.pointer(&format!("{GEOMETRY}/boundaries")).unwrap().clone();
            let semantics = json!({"surfaces": [{"type": "RoofSurface"}], "values": null});
            let boundaries = json!([first, [solid]]);
            let geometry =
                json!({"type": "CompositeSolid", "lod": "1", "boundaries": boundaries, "semantics": semantics});
            set(file, GEOMETRY, geometry);
        }))
    };
    assert_eq!(composite(10.0), SOUND);
    assert_eq!(composite(9.0), at(501, "solid=1"));
    assert_eq!(composite(11.0), at(503, "solid=0"));

    let part = |from: f64, lod: &str| {
        findings(&boxed(0.001, |file| {
            let solid = another(file, [from, 0.0, 0.0], [from + 5.0, 5.0, 5.0], false);
            let semantics = file.pointer(&format!("{GEOMETRY}/semantics")).unwrap().clone();
            let geometry = json!({"type": "Solid", "lod": lod, "boundaries": [solid], "semantics": semantics});
            file["CityObjects"]["b-1"] = json!({"type": "BuildingPart", "parents": ["b"], "geometry": [geometry]});
            set(file, "/CityObjects/b/children", json!(["b-0", "b-1"]));
        }))
    };
    assert_eq!(part(10.0, "2.2"), SOUND);
    assert_eq!(part(9.999, "2.2"), SOUND, "a step of the grid");
    assert_eq!(part(9.99, "2.2"), [vec![(601, "coid=b-1|geom=0".to_owned())], vec![]]);
    assert_eq!(part(9.0, "1.2"), SOUND);
}

#[test]
fn labels_and_attributes_do_not_make_invalid() {
    let semantic = |change: &dyn Fn(&mut Value)| {
        let file = boxed(0.001, change);
        let report = report_of(file.path());
        assert!(report.validity, "{report:?}");
        report.all_semantic_errors.into_iter().collect::<Vec<u16>>()
    };
    let values = format!("{GEOMETRY}/semantics/values");
    assert_eq!(semantic(&|file| set(file, &values, json!([[0, 1, 2, null, 2, 2]]))), [801]);
    assert_eq!(semantic(&|file| set(file, &values, json!(null))), [801]);
    assert_eq!(semantic(&|file| set(file, &values, json!([[1, 1, 2, 2, 2, 2]]))), [802]);
    assert_eq!(semantic(&|file| set(file, &values, json!([[0, 2, 2, 2, 2, 2]]))), [803]);
    assert_eq!(semantic(&|file| set(file, &values, json!([[0, 0, 2, 2, 2, 2]]))), [804, 805]);

    let attribute = |name: &str, value: f64| {
        semantic(&|file| {
            set(file, "/CityObjects/b/attributes", json!({"gable_volume_lod22": 500.0, name: value}));
        })
    };
    assert_eq!(attribute("gable_volume_lod22", 500.0), [0u16; 0]);
    assert_eq!(attribute("gable_volume_lod22", 500.1), [807]);
    assert_eq!(attribute("volume", 7.0), [0u16; 0]);
    assert_eq!(attribute("gable_height_ground", -3.0), [0u16; 0]);
    assert_eq!(attribute("gable_height_ground", -2.99), [806]);
    assert_eq!(attribute("gable_height_roof_max", 1.6), [0u16; 0]);
    assert_eq!(attribute("gable_height_roof_max", 1.4), [806]);

    // A roof that falls to the west by one in two.
    let roof = |members: Value| {
        semantic(&|file| {
            set(file, "/CityObjects/b/attributes", json!({"gable_lod": "2.2"}));
            set(file, "/vertices/5/2", json!(10_000));
            set(file, "/vertices/6/2", json!(10_000));
            let surface = file.pointer_mut(&format!("{GEOMETRY}/semantics/surfaces/1")).unwrap();
            surface.as_object_mut().unwrap().extend(members.as_object().unwrap().clone());
        })
    };
    let right = json!({"slope": 26.57, "azimuth": 270.0, "height_min": 2.0, "height_max": 7.0});
    assert_eq!(roof(right), [0u16; 0]);
    assert_eq!(roof(json!({"slope": 30.0})), [808]);
    assert_eq!(roof(json!({"azimuth": 90.0})), [808]);
    assert_eq!(roof(json!({"height_max": 7.1})), [806]);
}

#[test]
fn a_broken_feature_is_a_fault_of_the_file() {
    let whole: Value = serde_json::from_slice(&std::fs::read(boxed(0.001, |_| {}).path()).unwrap()).unwrap();
    let mut head = whole.clone();
    head["CityObjects"] = json!({});
    head["vertices"] = json!([]);
    let feature = |id: &str| {
        let objects =
            whole["CityObjects"].to_string().replace("\"b\"", &format!("\"{id}\"")).replace("b-0", &format!("{id}-0"));
        format!(
            "{{\"type\":\"CityJSONFeature\",\"id\":\"{id}\",\"CityObjects\":{objects},\"vertices\":{}}}",
            whole["vertices"]
        )
    };
    let broken = feature("x").replace("[7,6]", "[7,66]").replace("4,7", "4,77");
    let text = format!("{head}\n{}\n{broken}\n{}\n", feature("a"), feature("c"));
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), text).unwrap();
    let mut told = (0, 0);
    let report =
        audit(file.path(), &geometry_only(), &mut |features, bytes| told = (features, told.1 + bytes)).unwrap();
    assert_eq!(told, (2, std::fs::metadata(file.path()).unwrap().len()));
    assert_eq!(
        report.features.iter().map(|f| (f.id.as_str(), f.validity)).collect::<Vec<_>>(),
        [("a", true), ("c", true)]
    );
    assert!(!report.validity && report.dataset_errors[0].info.contains("line 3"), "{report:?}");
    assert_eq!(report.all_errors.into_iter().collect::<Vec<_>>(), [901]);
}
