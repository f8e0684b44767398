//! The official schemas, and what they say of files whose geometry is sound.

use std::fmt::Write;

use cjval::CJValidator;

use super::*;

/// What is done to a file.
type Change<'a> = &'a dyn Fn(&mut Value);

fn full(path: &Path) -> Report {
    audit(path, &Options::default(), &mut |_, _| {}).unwrap()
}

/// A sequence of the objects of a CityJSON file, each feature `n` times under other ids.
fn sequence(file: &tempfile::NamedTempFile, n: usize) -> tempfile::NamedTempFile {
    let mut head: Value = serde_json::from_slice(&std::fs::read(file.path()).unwrap()).unwrap();
    let root = head.as_object_mut().unwrap();
    let objects = root.insert("CityObjects".into(), json!({})).unwrap();
    let vertices = root.insert("vertices".into(), json!([])).unwrap();
    let mut text = head.to_string();
    for i in 0..n {
        let objects =
            objects.to_string().replace("\"b\"", &format!("\"b{i}\"")).replace("\"b-0\"", &format!("\"b{i}-0\""));
        write!(
            text,
            "\n{{\"type\":\"CityJSONFeature\",\"id\":\"b{i}\",\"CityObjects\":{objects},\"vertices\":{vertices}}}"
        )
        .unwrap();
    }
    let out = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(out.path(), text).unwrap();
    out
}

#[test]
fn what_the_schema_refuses_is_told_apart_from_the_geometry() {
    let sound = boxed(0.001, |_| {});
    let report = full(sound.path());
    assert_eq!((report.schema_errors, report.notes, report.validity), (vec![], vec![], true));
    let faults: [(&str, Change<'_>, &str); 5] = [
        ("type", &|f| set(f, "/CityObjects/b/type", json!("Bulding")), "Bulding"),
        ("lod", &|f| set(f, &format!("{GEOMETRY}/lod"), json!(2.2)), "2.2"),
        ("parents", &|f| drop(f["CityObjects"]["b-0"].as_object_mut().unwrap().remove("parents")), "needs \"parents\""),
        ("surface", &|f| set(f, &format!("{GEOMETRY}/semantics/surfaces/1/type"), json!("Rooof")), "Rooof"),
        ("values", &|f| set(f, &format!("{GEOMETRY}/semantics/values"), json!([[0, 1]])), "values"),
    ];
    for (name, change, says) in faults {
        let file = boxed(0.001, change);
        for path in [file.path(), sequence(&file, 3).path()] {
            let report = full(path);
            assert!(!report.validity && report.all_errors.contains(&901), "{name}");
            let said = report.schema_errors.iter().map(|f| f.info.as_str()).collect::<Vec<_>>().join("\n");
            assert!(said.contains(says), "{name}: {said}");
            assert!(
                report.features.iter().all(|feature| feature.errors.is_empty()),
                "the geometry is checked all the same"
            );
            assert_eq!(report.invalid(), ["schema"], "{name}");
        }
        assert!(report_of(file.path()).validity, "{name}: only the schema is at fault");
    }
    // Geometry alone, and both.
    let holed = boxed(0.001, |f| {
        drop(f.pointer_mut(&format!("{GEOMETRY}/boundaries/0")).unwrap().as_array_mut().unwrap().pop());
    });
    let invalid = full(holed.path()).invalid();
    assert!(invalid.contains(&"geometry"), "{invalid:?}");
}

#[test]
fn faults_of_features_name_the_object_and_are_not_without_end() {
    let wrong = boxed(0.001, |f| set(f, "/CityObjects/b/type", json!("Bulding")));
    let report = full(sequence(&wrong, 300).path());
    assert_eq!(report.schema_errors.len(), 101);
    assert!(report.schema_errors[0].id.starts_with("coid=b"), "{:?}", report.schema_errors[0]);
    assert!(report.schema_errors[100].info.starts_with("and "), "{:?}", report.schema_errors[100]);
    // A feature that is not that of its id.
    let sound = sequence(&boxed(0.001, |_| {}), 1);
    let text = std::fs::read_to_string(sound.path()).unwrap();
    std::fs::write(sound.path(), text.replace("\"id\":\"b0\"", "\"id\":\"c\"")).unwrap();
    let report = full(sound.path());
    assert!(report.schema_errors[0].info.contains("no CityObject of its id"), "{:?}", report.schema_errors);
}

#[test]
fn an_extension_is_checked_where_its_schema_is_at_hand_and_else_is_a_note() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("made.city.json");
    let file = |value: &Value| {
        boxed(0.001, |f| {
            f["extensions"] = json!({"Noise": {"url": "https://example.org/schemas/noise.ext.json", "version": "0.5"}});
            f["CityObjects"]["b"]["attributes"] = json!({"+noise-level": value});
        })
    };
    std::fs::copy(file(&json!(50)).path(), &path).unwrap();
    let report = full(&path);
    assert!(report.validity, "{:?}", report.schema_errors);
    assert!(report.notes[0].contains("\"Noise\"") && report.notes[0].contains("noise.ext.json"), "{:?}", report.notes);
    let extension = json!({"type": "CityJSONExtension", "name": "Noise", "url": "https://example.org/schemas/noise.ext.json",
        "version": "0.5", "versionCityJSON": "2.0", "description": "", "extraAttributes": {"Building":
        {"+noise-level": {"type": "number"}}}, "extraCityObjects": {}, "extraRootProperties": {}, "extraSemanticSurfaces": {}});
    std::fs::write(folder.path().join("noise.ext.json"), extension.to_string()).unwrap();
    let report = full(&path);
    assert_eq!((report.validity, report.notes), (true, vec![]), "{:?}", report.schema_errors);
    std::fs::copy(file(&json!("loud")).path(), &path).unwrap();
    let report = full(&path);
    assert!(report.schema_errors.iter().any(|f| f.info.contains("loud")), "{:?}", report.schema_errors);
}

#[test]
fn what_the_makers_of_the_schema_warn_of_is_told_and_makes_nothing_invalid() {
    let file = boxed(0.001, |f| {
        let vertices = f["vertices"].as_array_mut().unwrap();
        // Not used and not the same: (1, 23, 4) and (12, 3, 4).
        let first = vertices[0].clone();
        vertices.extend([first, json!([1, 23, 4]), json!([12, 3, 4])]);
    });
    let rooted = boxed(0.001, |f| f["colour"] = json!("red"));
    for (path, of) in [(file.path(), ""), (sequence(&file, 3).path(), " (in 3 features)")] {
        let report = full(path);
        let n = if of.is_empty() { 1 } else { 3 };
        let vertices = if n == 1 { "vertex" } else { "vertices" };
        let expected =
            [format!("{n} {vertices}{of} at the place of another"), format!("{} vertices{of} in no geometry", 3 * n)];
        assert_eq!((report.validity, &report.schema_warnings[..]), (true, &expected[..]));
        assert_eq!(report.told(), ["warnings"]);
    }
    let report = full(rooted.path());
    assert!(report.schema_warnings[0].contains("\"colour\"") && report.schema_warnings.len() == 1, "{report:?}");
    // What cjval warns of in a whole file is told here as well.
    let text = std::fs::read_to_string(rooted.path()).unwrap();
    let found = CJValidator::from_str(&text).validate();
    assert!(found["extra_root_properties"].has_errors());
    assert_eq!(report_of(file.path()).schema_warnings, Vec::<String>::new(), "only where the schema is checked");
}
