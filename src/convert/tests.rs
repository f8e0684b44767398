use std::fs;
use std::path::Path;

use cjval::CJValidator;
use serde_json::{Value, json};

use super::*;
use crate::sink::Format;

/// A box of CityJSON: a `Building` with a part that has a Solid with one labelled face at LoD 2.2 and none at 1.2.
fn house(id: &str, x: i64, top: i64, attributes: &Value) -> (Value, Vec<[i64; 3]>) {
    let corners = [[0, 0], [4000, 0], [4000, 3000], [0, 3000]];
    let vertices = [0, top].into_iter().flat_map(|z| corners.map(|[a, b]| [x + a, b, z])).collect();
    let shell =
        json!([[[[3, 2, 1, 0]], [[4, 5, 6, 7]], [[0, 1, 5, 4]], [[1, 2, 6, 5]], [[2, 3, 7, 6]], [[3, 0, 4, 7]]]]);
    let part = format!("{id}-0");
    let objects = json!({
        id: {"type": "Building", "attributes": attributes, "children": [part],
             "address": [{"CountryName": "NL"}]},
        part: {"type": "BuildingPart", "parents": [id], "geometry": [
            {"type": "Solid", "lod": "1.2", "boundaries": shell},
            {"type": "Solid", "lod": "2.2", "boundaries": shell, "semantics": {
                "surfaces": [{"type": "RoofSurface", "slope": 0.5}], "values": [[null, 0, null, null, null, null]]}},
        ]},
    });
    (objects, vertices)
}

fn head(crs: u32) -> Value {
    json!({
        "type": "CityJSON", "version": "2.0", "CityObjects": {}, "vertices": [],
        "transform": {"scale": [0.001, 0.001, 0.001], "translate": [85_000.0, 447_000.0, 0.0]},
        "metadata": {"title": "two houses", "referenceSystem": format!("https://www.opengis.net/def/crs/EPSG/0/{crs}"),
                     "identifier": "x-1"},
    })
}

/// A sequence of houses.
fn sequence(path: &Path, crs: u32, houses: &[(Value, Vec<[i64; 3]>)]) {
    let mut text = format!("{}\n", head(crs));
    for (objects, vertices) in houses {
        let id = objects.as_object().unwrap().keys().next().unwrap();
        let feature = json!({"type": "CityJSONFeature", "id": id, "CityObjects": objects, "vertices": vertices});
        text.push_str(&feature.to_string());
        text.push('\n');
    }
    fs::write(path, text).unwrap();
}

fn run(inputs: &[&Path], output: &Path) -> Converted {
    try_run(inputs, output).unwrap()
}

fn try_run(inputs: &[&Path], output: &Path) -> Result<Converted> {
    let inputs = inputs.iter().map(|path| path.to_path_buf()).collect();
    convert(&Conversion { inputs, output: output.to_path_buf(), ..Conversion::default() }, &mut |_| {})
}

/// The objects of a file with coordinates instead of vertex numbers, as text.
fn content(path: &Path, step: f64) -> Vec<String> {
    let model = cityjson::read(path).unwrap();
    let objects = model.objects.iter().map(|object| {
        let geometries: Vec<_> = object
            .geometries
            .iter()
            .map(|geometry| {
                let faces =
                    geometry.shells.iter().flat_map(|shell| shell.faces.iter().map(move |face| (shell.solid, face)));
                let faces = faces.map(|(solid, face)| {
                    let point = |&v: &u32| model.vertices[v as usize].map(|c| (c / step).round() as i64);
                    (
                        solid,
                        face.rings.iter().map(|ring| ring.iter().map(point).collect::<Vec<_>>()).collect::<Vec<_>>(),
                        face.surface,
                    )
                });
                (geometry.lod.clone(), geometry.kind.clone(), faces.collect::<Vec<_>>(), geometry.surfaces.clone())
            })
            .collect();
        let (attributes, members) = (Value::from(object.attributes.clone()), Value::from(object.members.clone()));
        format!(
            "{} {} {:?} {:?} {attributes} {members} {geometries:?}",
            object.id, object.kind, object.parents, object.children
        )
    });
    objects.collect()
}

fn faults(path: &Path) -> Vec<String> {
    let text = fs::read_to_string(path).unwrap();
    let told = |validator: &CJValidator| -> Vec<String> {
        validator.validate().values().flat_map(|summary| summary.get_errors().clone()).collect()
    };
    if Format::of(path).unwrap() == Format::CityJson {
        return told(&CJValidator::from_str(&text));
    }
    let mut lines = text.lines();
    let mut validator = CJValidator::from_str(lines.next().unwrap());
    let mut out = told(&validator);
    for line in lines {
        validator.from_str_cjfeature(line).unwrap();
        out.extend(told(&validator));
    }
    out
}

#[test]
fn from_sequence_to_object_and_back_nothing_changes() {
    let folder = tempfile::tempdir().unwrap();
    let [first, whole, again] = ["a.city.jsonl", "b.city.json", "c.city.jsonl"].map(|name| folder.path().join(name));
    sequence(
        &first,
        7415,
        &[house("é 1", 0, 5000, &json!({"n": 1, "list": [1, null]})), house("b", 9000, 4000, &json!({}))],
    );
    let converted = run(&[&first], &whole);
    assert_eq!((converted.written.features, converted.written.objects), (2, 4));
    assert_eq!(converted.warnings, Vec::<String>::new());
    run(&[&whole], &again);
    assert_eq!(faults(&whole), Vec::<String>::new());
    assert_eq!(faults(&again), Vec::<String>::new());
    assert_eq!(content(&whole, 0.001), content(&first, 0.001));
    assert_eq!(content(&again, 0.001), content(&first, 0.001));
    let root: Value = serde_json::from_str(&fs::read_to_string(&whole).unwrap()).unwrap();
    assert_eq!(root["metadata"]["title"], "two houses");
    assert_eq!(root["metadata"]["identifier"], "x-1");
    assert_eq!(root["metadata"]["geographicalExtent"], json!([85_000.0, 447_000.0, 0.0, 85_013.0, 447_003.0, 5.0]));
    assert_eq!(root["transform"], head(7415)["transform"]);
}

/// Real files of other makers, when they are there.
#[test]
fn models_of_others_come_through_whole() {
    for (name, step) in
        [("lod2-val/denhaag.city.json", 0.001), ("lod2-val/vienna.jsonl", 0.001), ("lod2-train/5870_ext.jsonl", 0.001)]
    {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(name);
        if !path.exists() {
            println!("skipped: shared data not found");
            return;
        }
        let folder = tempfile::tempdir().unwrap();
        for name in ["out.city.json", "out.city.jsonl"] {
            let out = folder.path().join(name);
            let converted = run(&[&path], &out);
            println!("{}: {:?}", path.display(), converted.warnings);
            let (mut before, mut after) = (content(&path, step), content(&out, step));
            before.sort_unstable();
            after.sort_unstable();
            assert!(before == after, "{}", path.display());
        }
        // The coordinates without a CRS are taken for some of Austria's.
        let known = cityjson::features(&path).unwrap().head().reference_system.is_some();
        for name in ["out.gpkg", "out.obj", "out.3dtiles"] {
            let crs = (!known).then(|| "EPSG:31256".to_owned());
            let conversion = Conversion {
                inputs: vec![path.clone()],
                output: folder.path().join(name),
                crs,
                ..Conversion::default()
            };
            let converted = convert(&conversion, &mut |_| {}).unwrap();
            assert!(converted.written.features > 50 && converted.written.bytes > 100_000, "{converted:?}");
        }
    }
}

#[test]
fn a_building_on_a_border_is_kept_once_and_another_of_its_id_gets_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let [west, east, out] = ["w.city.jsonl", "e.city.jsonl", "out.city.jsonl"].map(|name| folder.path().join(name));
    let of = |coverage: f64| json!({"gable_coverage": coverage});
    sequence(
        &west,
        7415,
        &[house("same", 0, 5000, &of(1.0)), house("cut", 9000, 4000, &of(0.4)), house("far", 0, 3000, &of(1.0))],
    );
    sequence(
        &east,
        7415,
        &[house("same", 0, 5000, &of(1.0)), house("cut", 9000, 6000, &of(1.0)), house("far", 90_000, 3000, &of(1.0))],
    );
    let converted = run(&[&west, &east], &out);
    let repeats: Vec<_> = converted.repeats.iter().map(|r| (r.id.as_str(), r.left_out.as_path(), r.is_same)).collect();
    assert_eq!(repeats, [("cut", west.as_path(), false), ("same", east.as_path(), true)]);
    let model = cityjson::read(&out).unwrap();
    let ids: Vec<&str> = model.objects.iter().map(|object| object.id.as_str()).collect();
    assert_eq!(ids, ["same", "same-0", "far", "far-0", "cut", "cut-0", "far-2", "far-0-2"]);
    let renamed = &model.objects[6..];
    assert_eq!((&renamed[0].children[0], &renamed[1].parents[0]), (&"far-0-2".to_owned(), &"far-2".to_owned()));
    let top = model.vertices.iter().map(|v| v[2]).fold(0.0, f64::max);
    assert_eq!(top, 6.0, "of the two that differ the one that is covered is kept");
    assert_eq!(faults(&out), Vec::<String>::new());
    let told = converted.warnings.join("\n");
    for part in ["1 features occur again with the same geometry", "cut (", "far of ", "is far-2"] {
        assert!(told.contains(part), "{told}");
    }
}

#[test]
fn files_of_different_crs_are_not_joined() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b, out] = ["a.city.jsonl", "b.city.jsonl", "out.city.jsonl"].map(|name| folder.path().join(name));
    sequence(&a, 7415, &[house("a", 0, 5000, &json!({}))]);
    sequence(&b, 28992, &[house("b", 0, 5000, &json!({}))]);
    let message = try_run(&[&a, &b], &out).unwrap_err().to_string();
    for part in [a.to_str().unwrap(), b.to_str().unwrap(), "EPSG:7415", "EPSG:28992"] {
        assert!(message.contains(part), "{message}");
    }
    assert!(!out.exists());
    let message = try_run(&[&a], &a).unwrap_err().to_string();
    assert!(message.contains("an input of this run"), "{message}");
}

#[test]
fn what_is_left_out_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let [path, out] = ["a.city.json", "out.city.jsonl"].map(|name| folder.path().join(name));
    let (mut objects, vertices) = house("a", 0, 5000, &json!({}));
    objects["a"]["geometry"] = json!([
        {"type": "MultiPoint", "lod": "1", "boundaries": [0]},
        {"type": "GeometryInstance", "template": 0, "boundaries": [0], "transformationMatrix": [1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]},
    ]);
    objects["a"]["address"] = json!({"CountryName": "NL", "location": {"type": "MultiPoint", "boundaries": [0]}});
    let mut root = head(7415);
    root["version"] = "1.0".into();
    root["CityObjects"] = objects;
    root["vertices"] = json!(vertices);
    root["appearance"] = json!({"materials": []});
    fs::write(&path, root.to_string()).unwrap();
    let told = run(&[&path], &out).warnings.join("\n");
    for part in [
        "materials and textures",
        "1 geometries of type MultiPoint",
        "1 instances of geometry templates",
        "locations of 1",
    ] {
        assert!(told.contains(part), "{told}");
    }
    assert_eq!(faults(&out), Vec::<String>::new());
    let address = &cityjson::read(&out).unwrap().objects[0].members["address"];
    assert_eq!(address, &json!([{"CountryName": "NL"}]));
}

#[test]
fn only_the_levels_of_detail_that_are_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let [path, out] = ["a.city.jsonl", "out.city.json"].map(|name| folder.path().join(name));
    sequence(&path, 7415, &[house("a", 0, 5000, &json!({}))]);
    let conversion =
        Conversion { inputs: vec![path], output: out.clone(), lods: vec!["1.2".into()], ..Conversion::default() };
    convert(&conversion, &mut |_| {}).unwrap();
    let lods: Vec<String> =
        cityjson::read(&out).unwrap().objects.into_iter().flat_map(|o| o.geometries).map(|g| g.lod).collect();
    assert_eq!(lods, ["1.2"]);
}

#[test]
fn a_level_of_detail_that_is_not_there_is_an_error_or_told() {
    let folder = tempfile::tempdir().unwrap();
    let [path, out] = ["a.city.jsonl", "out.city.json"].map(|name| folder.path().join(name));
    sequence(&path, 7415, &[house("a", 0, 5000, &json!({}))]);
    let of = |lods: &[&str]| {
        let lods = lods.iter().map(|lod| (*lod).to_owned()).collect();
        let conversion = Conversion {
            inputs: vec![path.clone()],
            output: out.clone(),
            lods,
            overwrite: true,
            ..Conversion::default()
        };
        convert(&conversion, &mut |_| {})
    };
    let error = of(&["3", "1"]).unwrap_err().to_string();
    assert!(error.contains("geometry at LoD 1.2, 2.2 only, expected geometry at LoD 3 or 1"), "{error}");
    assert!(!out.exists());
    let warnings = of(&["3", "1.2"]).unwrap().warnings.join("\n");
    assert!(warnings.contains("no geometry at LoD 3; there is at 1.2, 2.2"), "{warnings}");
}

#[test]
fn extensions_of_older_versions_stay_behind() {
    let folder = tempfile::tempdir().unwrap();
    let [path, out, new] = ["a.city.json", "out.city.jsonl", "new.city.jsonl"].map(|name| folder.path().join(name));
    let (mut objects, vertices) = house("a", 0, 5000, &json!({"+noise": 3, "noise": 4, "+owner": "b"}));
    let part = objects["a-0"].clone();
    objects["t"] = json!({"type": "+Tunnelette", "geometry": part["geometry"], "children": ["t-0"]});
    objects["t-0"] = json!({"type": "BuildingPart", "parents": ["t"], "geometry": part["geometry"]});
    objects["a-0"]["geometry"][1]["semantics"] = json!({
        "surfaces": [{"type": "+Solar"}, {"type": "WallSurface"}], "values": [[null, 0, 1, 1, 1, 1]]});
    let mut root = head(7415);
    root["version"] = "1.1".into();
    root["extensions"] = json!({"Noise": {"url": "https://example.org/noise.ext.json", "version": "1.0"}});
    root["CityObjects"] = objects;
    root["vertices"] = json!(vertices);
    fs::write(&path, root.to_string()).unwrap();
    let told = run(&[&path], &out).warnings.join("\n");
    for part in ["\"Noise\" is one of CityJSON 1.1", "1 of type +Tunnelette", "1 of type +Solar", "+noise, +owner"] {
        assert!(told.contains(part), "{told}");
    }
    assert_eq!(faults(&out), Vec::<String>::new());
    let model = cityjson::read(&out).unwrap();
    assert_eq!((model.objects.len(), &model.extensions), (2, &None));
    let attributes = Value::Object(model.objects[0].attributes.clone());
    assert_eq!(attributes, json!({"noise_extension": 3, "noise": 4, "owner": "b"}));
    let labels: Vec<_> = model.objects[1].geometries[1].shells[0].faces.iter().map(|face| face.surface).collect();
    assert_eq!(labels, [None, None, Some(0), Some(0), Some(0), Some(0)]);

    // Those of 2.0 hold.
    root["version"] = "2.0".into();
    fs::write(&path, root.to_string()).unwrap();
    run(&[&path], &new);
    assert!(cityjson::features(&new).unwrap().head().extensions.is_some());
}
