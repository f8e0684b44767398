//! Geometry templates in their places.

use proptest::prelude::*;

use super::*;

/// A file with one instance of a box of 1 × 2 × 3 m, after `change`.
fn instance(matrix: [f64; 16], change: impl Fn(&mut Value)) -> tempfile::NamedTempFile {
    let plan = [[0.0, 0.0], [1.0, 0.0], [1.0, 2.0], [0.0, 2.0]];
    let vertices: Vec<[f64; 3]> = [0.0, 3.0].iter().flat_map(|&z| plan.map(|[x, y]| [x, y, z])).collect();
    let shell = json!([[[3, 2, 1, 0]], [[4, 5, 6, 7]], [[0, 1, 5, 4]], [[1, 2, 6, 5]], [[2, 3, 7, 6]], [[3, 0, 4, 7]]]);
    let placed = json!({"type": "GeometryInstance", "template": 0, "boundaries": [0], "transformationMatrix": matrix});
    let mut file = json!({
        "type": "CityJSON", "version": "2.0",
        "transform": {"scale": [0.01, 0.01, 0.01], "translate": [85_000.0, 447_000.25, -3.0]},
        "CityObjects": {"t": {"type": "SolitaryVegetationObject", "geometry": [placed]}},
        "vertices": [[1, 2, 3]],
        "geometry-templates": {
            "templates": [{"type": "Solid", "lod": "3", "boundaries": [shell]}],
            "vertices-templates": vertices
        }
    });
    change(&mut file);
    let out = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(out.path(), file.to_string()).unwrap();
    out
}

fn scaled(by: f64) -> [f64; 16] {
    std::array::from_fn(|i| {
        if i == 15 {
            1.0
        } else if i % 5 == 0 {
            by
        } else {
            0.0
        }
    })
}

const BOUNDARIES: &str = "/geometry-templates/templates/0/boundaries";

#[test]
fn a_template_has_the_faults_of_what_stands_there() {
    let sound = instance(scaled(1.0), |_| {});
    assert_eq!(findings(&sound), SOUND);
    let counted = |file: &tempfile::NamedTempFile| report_of(file.path()).primitives_overview;
    assert_eq!(counted(&sound), [Overview { kind: "Solid".to_owned(), total: 1, valid: 1 }]);

    let spiked = instance(scaled(1.0), |file| set(file, &format!("{BOUNDARIES}/0/1/0"), json!([4, 5, 6, 5, 7])));
    let found = findings(&spiked)[0].clone();
    assert_eq!(found[0], (104, "coid=t|geom=0|shell=0|face=1".to_owned()), "{found:?}");
    assert_eq!(counted(&spiked), [Overview { kind: "Solid".to_owned(), total: 1, valid: 0 }]);

    // A corner that is 1 cm too high bends its faces, but by less where the template is made small.
    for (by, faulty) in [(1.0, true), (0.2, false), (100.0, true)] {
        let bent = instance(scaled(by), |file| set(file, "/geometry-templates/vertices-templates/6/2", json!(3.01)));
        assert_eq!(findings(&bent)[0].iter().any(|f| f.0 == 203), faulty, "{by}");
    }
    // A box smaller than the snap distance is a point.
    assert!(findings(&instance(scaled(1e-4), |_| {}))[0].iter().any(|f| f.0 == 102));
    // A mirrored box looks inwards.
    let mut mirrored = scaled(1.0);
    mirrored[5] = -1.0;
    assert_eq!(findings(&instance(mirrored, |_| {}))[0], [(405, "coid=t|geom=0|shell=0".to_owned())]);
}

#[test]
fn an_instance_of_nothing_is_said() {
    let geometry = "/CityObjects/t/geometry/0";
    for (pointer, value, expected) in [
        ("template", json!(7), "template 7, which does not exist"),
        ("transformationMatrix", json!([1.0, 2.0]), "without a matrix of 16 numbers"),
        ("transformationMatrix", json!(vec![0.0; 16]), "flat"),
    ] {
        let file = instance(scaled(1.0), |file| set(file, &format!("{geometry}/{pointer}"), value.clone()));
        let report = report_of(file.path());
        let errors = &report.features[0].errors;
        assert!(errors.len() == 1 && errors[0].code == 901 && errors[0].info.contains(expected), "{errors:?}");
    }
    let file = instance(scaled(1.0), |file| set(file, &format!("{BOUNDARIES}/0/1/0"), json!([4, 5, 6, 99])));
    assert_eq!(findings(&file)[0], [(901, "coid=t|geom=0|shell=0".to_owned())]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// What a template is said to be in its place is what the same box is said to be that was multiplied out before.
    #[test]
    fn it_is_as_if_it_was_written_out(
        turns in prop::array::uniform3(-3.0..3.0f64),
        by in prop::array::uniform3(0.3..3.0f64),
        skew in prop_oneof![Just(0.0), 0.1..0.5f64],
        mirrored: bool,
        fault in 0..4usize,
    ) {
        let turn = nalgebra::Rotation3::from_euler_angles(turns[0], turns[1], turns[2]).into_inner();
        let mut size = nalgebra::Matrix3::from_diagonal(&nalgebra::Vector3::from(by));
        size[(0, 1)] = skew;
        if mirrored {
            size[(0, 0)] = -size[(0, 0)];
        }
        let linear = turn * size;
        let mut matrix = [0.0; 16];
        (0..9).for_each(|i| matrix[i / 3 * 4 + i % 3] = linear[(i / 3, i % 3)]);
        matrix[15] = 1.0;
        let break_it = |file: &mut Value| match fault {
            1 => set(file, "/geometry-templates/vertices-templates/6/2", json!(3.1)),
            2 => drop(file.pointer_mut(&format!("{BOUNDARIES}/0")).unwrap().as_array_mut().unwrap().pop()),
            3 => set(file, &format!("{BOUNDARIES}/0/0/0"), json!([0, 1, 2, 3])),
            _ => {}
        };
        let in_place = instance(matrix, break_it);
        let written = instance(matrix, |file| {
            break_it(file);
            let templates = file.as_object_mut().unwrap().remove("geometry-templates").unwrap();
            file.as_object_mut().unwrap().remove("transform");
            set(file, "/version", json!("1.0"));
            set(file, "/CityObjects/t/geometry/0", templates["templates"][0].clone());
            let place = |v: &Value| -> [f64; 3] {
                let v: Vec<f64> = v.as_array().unwrap().iter().map(|c| c.as_f64().unwrap()).collect();
                (linear * nalgebra::Vector3::new(v[0], v[1], v[2])).into()
            };
            let vertices: Vec<_> = templates["vertices-templates"].as_array().unwrap().iter().map(place).collect();
            set(file, "/vertices", json!(vertices));
        });
        let codes = |file: &tempfile::NamedTempFile| report_of(file.path()).all_errors;
        prop_assert_eq!(codes(&in_place), codes(&written));
        prop_assert_eq!(codes(&in_place).is_empty(), fault == 0 && !mirrored);
    }
}
