//! What holds for files as such, and of what is in them on grids of any kind.

use proptest::prelude::*;

use super::*;

/// A file on a grid of `scale` with the boundaries of one geometry, or with real coordinates.
fn file_of(version: &str, scale: Option<f64>, objects: &Value, vertices: &Value) -> tempfile::NamedTempFile {
    let mut file = json!({"type": "CityJSON", "version": version, "CityObjects": objects, "vertices": vertices});
    if let Some(scale) = scale {
        file["transform"] = json!({"scale": [scale, scale, scale], "translate": [90_409.32, 435_440.44, 0.0]});
    }
    let out = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(out.path(), file.to_string()).unwrap();
    out
}

fn object(kind: &str, boundaries: &Value) -> Value {
    json!({"a": {"type": "GenericCityObject", "geometry": [{"type": kind, "lod": "2", "boundaries": boundaries}]}})
}

fn codes_of(file: &tempfile::NamedTempFile) -> Vec<u16> {
    report_of(file.path()).all_errors.into_iter().collect()
}

/// The faces of a box whose vertices start at `v`.
fn box_at(v: u32) -> Value {
    json!(
        [[3, 2, 1, 0], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
            .map(|f| [f.map(|i| i + v)])
    )
}

fn corners(from: [f64; 3], to: [f64; 3]) -> Vec<[f64; 3]> {
    let plan = [[0, 0], [1, 0], [1, 1], [0, 1]];
    let pick = |i: usize, far: usize| if far == 1 { to[i] } else { from[i] };
    (0..2).flat_map(|z| plan.map(|[x, y]| [pick(0, x), pick(1, y), pick(2, z)])).collect()
}

/// Codes of two boxes of 10 m as parts of a building and as a composite; they share `shared` steps of `step` metres.
fn pair(step: f64, shared: i64, real: bool, options: &Options) -> [Vec<u16>; 2] {
    let n = |metres: f64| if real { metres } else { (metres / step).round() };
    let start = 10.0 - shared as f64 * step;
    let mut vertices = corners([0.0; 3], [n(10.0); 3]);
    vertices.extend(corners([n(start), 0.0, 0.0], [n(start) + n(10.0), n(10.0), n(10.0)]));
    let vertices =
        json!(vertices.iter().map(|v| v.map(|c| if real { json!(c) } else { json!(c as i64) })).collect::<Vec<_>>());
    let part = |v: u32| {
        let solid = json!([{"type": "Solid", "lod": "2", "boundaries": [box_at(v)]}]);
        json!({"type": "BuildingPart", "parents": ["b"], "geometry": solid})
    };
    let parts = json!({"b": {"type": "Building", "children": ["p0", "p1"]}, "p0": part(0), "p1": part(8)});
    let composite = object("CompositeSolid", &json!([[box_at(0)], [box_at(8)]]));
    let (version, scale) = if real { ("1.0", None) } else { ("2.0", Some(step)) };
    [parts, composite].map(|objects| {
        let file = file_of(version, scale, &objects, &vertices);
        audit(file.path(), options, &mut |_, _| {}).unwrap().all_errors.into_iter().collect()
    })
}

#[test]
fn an_overlap_is_one_on_any_grid() {
    for (step, shared, real) in
        [(1.0, 1, false), (1.0, 1, true), (0.01, 1, false), (0.001, 2, false), (0.001, 3, false)]
    {
        assert_eq!(pair(step, shared, real, &geometry_only()), [[601], [501]], "{shared} steps of {step}");
    }
    for (step, shared) in [(1.0, 0), (0.001, 1), (0.0001, 10)] {
        assert_eq!(pair(step, shared, false, &geometry_only()), [NONE; 2], "{shared} steps of {step}");
    }
    // Without the snap distance, within which the boxes would be drawn together.
    let tolerances = Tolerances { snap: 0.0, ..Tolerances::default() };
    let exact = Options { overlap: 0.0, tolerances, ..geometry_only() };
    assert_eq!(pair(1e-6, 1, false, &exact), [[601], [501]]);
    assert_eq!(pair(1e-6, 0, false, &exact), [NONE; 2]);
}

const NONE: [u16; 0] = [];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    #[test]
    fn the_tolerance_of_overlaps_is_the_option(
        decimals in 0..5i32,
        shared in 0..20i64,
        tolerance in 0..20i64,
    ) {
        let step = 10f64.powi(-decimals);
        // As many whole steps, or half a one more.
        let tolerances = Tolerances { snap: 0.0, ..Tolerances::default() };
        let options = Options { overlap: tolerance as f64 * step / 2.0, tolerances, ..geometry_only() };
        // Of faces that are hardly wider than the tolerance it cannot be said whether they touch.
        prop_assume!(shared as f64 * step < 5.0 && tolerance as f64 * step < 2.0);
        let found = pair(step, shared, false, &options);
        let expected = if 2 * shared > tolerance { [vec![601], vec![501]] } else { [vec![], vec![]] };
        prop_assert_eq!(found, expected);
    }

    #[test]
    fn what_is_a_snap_apart_is_one_wherever_it_is(
        at in prop::array::uniform3(-1_000_000..1_000_000i64),
        by in prop::array::uniform3(-1..=1i64),
        before in prop::collection::vec(prop::array::uniform3(-9_000_000..9_000_000i64), 0..3),
    ) {
        let mut vertices = before.clone();
        let first = vertices.len();
        let to = |d: [i64; 3]| -> [i64; 3] { std::array::from_fn(|i| at[i] + d[i]) };
        vertices.extend([at, to([5_000, 0, 0]), to([5_000, 0, 4_000]), to([0, 0, 4_000])]);
        vertices.push(to(by));
        let ring = [0, 4, 1, 2, 3].map(|i| first + i);
        let file = file_of("2.0", Some(0.001), &object("MultiSurface", &json!([[ring]])), &json!(vertices));
        let apart = by.iter().map(|b| b * b).sum::<i64>();
        let found = codes_of(&file);
        prop_assert_eq!(found.contains(&102), apart <= 1, "{:?}", found);
    }
}

#[test]
fn a_face_is_faulty_alone_and_among_others() {
    // An edge of exactly the snap distance, first with its feature's origin in it and then far from it.
    let face = json!([[3, 2, 1, 0]]);
    let corners =
        [[796_985, 449_098, 4_789], [797_762, 447_166, 4_789], [797_762, 447_166, 6_153], [796_985, 449_098, 4_790]];
    let alone = file_of("2.0", Some(0.001), &object("MultiSurface", &json!([face])), &json!(corners));
    let mut vertices = corners.to_vec();
    vertices.extend([[522_120, 238_440, 14_292], [514_876, 247_103, 14_292], [522_120, 238_440, 19_293]]);
    let faces = json!([[[4, 5, 6]], face]);
    let among = file_of("2.0", Some(0.001), &object("MultiSurface", &faces), &json!(vertices));
    assert_eq!((codes_of(&alone), codes_of(&among)), (vec![102], vec![102]));
}

#[test]
fn nothing_is_a_fault() {
    let vertices = json!(corners([0.0; 3], [10.0; 3]));
    let composite =
        |second: &Value| file_of("1.0", None, &object("CompositeSolid", &json!([[box_at(0)], second])), &vertices);
    let places = |file: &tempfile::NamedTempFile| findings(file)[0].clone();
    assert_eq!(places(&composite(&json!([]))), [(902, "coid=a|geom=0|solid=1|shell=0".to_owned())]);
    assert_eq!(places(&composite(&json!([[]]))), [(902, "coid=a|geom=0|solid=1|shell=0".to_owned())]);
    let void = file_of("1.0", None, &object("Solid", &json!([box_at(0), []])), &vertices);
    assert_eq!(places(&void), [(902, "coid=a|geom=0|shell=1".to_owned())]);
}

#[test]
fn a_file_without_transform_is_cityjson_1_0_only() {
    let vertices = json!(corners([0.0; 3], [10.0; 3]));
    let of = |version: &str| report_of(file_of(version, None, &object("Solid", &json!([box_at(0)])), &vertices).path());
    assert!(of("1.0").validity);
    for version in ["1.1", "2.0"] {
        let report = of(version);
        let [fault] = &report.dataset_errors[..] else { panic!("{report:?}") };
        assert!(!report.validity && fault.code == 901 && fault.info.contains("transform"), "{fault:?}");
        assert!(report.features[0].validity, "what can be checked is");
    }
}

#[test]
fn the_first_level_may_be_enough() {
    // A ring that collapsed opens its shell.
    let file = boxed(0.001, |file| set(file, &format!("{GEOMETRY}/boundaries/0/1/0"), json!([4, 5, 6, 5])));
    let codes = |first_level| {
        let options = Options { first_level, ..geometry_only() };
        audit(file.path(), &options, &mut |_, _| {}).unwrap().all_errors.into_iter().collect::<Vec<u16>>()
    };
    assert_eq!((codes(false), codes(true)), (vec![104, 302], vec![104]));
}

#[test]
fn a_refusal_is_a_report() {
    let path = Path::new("nowhere/at.all");
    let error = audit(path, &geometry_only(), &mut |_, _| {}).unwrap_err();
    let report = refusal(path, &geometry_only(), &error);
    assert!(!report.validity && report.all_errors.iter().eq(&[901]) && report.features.is_empty());
    assert_eq!(report.dataset_errors[0].info, error.to_string());
}

#[test]
fn an_uneven_roof_hides_no_overlap() {
    // A corner of the roof of the first box is 5 mm too high: 203 by a tolerance of 1 mm.
    let mut vertices = corners([0.0; 3], [10_000.0; 3]);
    vertices[6][2] += 5.0;
    vertices.extend(corners([9_000.0, 0.0, 0.0], [19_000.0, 10_000.0, 10_000.0]));
    let vertices = json!(vertices.iter().map(|v| v.map(|c| c as i64)).collect::<Vec<_>>());
    let part = |v: u32| {
        let solid = json!([{"type": "Solid", "lod": "2", "boundaries": [box_at(v)]}]);
        json!({"type": "BuildingPart", "parents": ["b"], "geometry": solid})
    };
    let parts = json!({"b": {"type": "Building", "children": ["p0", "p1"]}, "p0": part(0), "p1": part(8)});
    let composite = object("CompositeSolid", &json!([[box_at(0)], [box_at(8)]]));
    for (objects, code) in [(parts, 601), (composite, 501)] {
        let file = file_of("2.0", Some(0.001), &objects, &vertices);
        assert_eq!(codes_of(&file), [203, code]);
        let options = Options { first_level: true, ..geometry_only() };
        let found: Vec<u16> = audit(file.path(), &options, &mut |_, _| {}).unwrap().all_errors.into_iter().collect();
        assert_eq!(found, [203]);
    }
}
