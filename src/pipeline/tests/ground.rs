//! Stages that tell ground, heights above it, and groups of points.

use serde_json::{Value, json};

use super::{Bench, Plain};
use crate::source::points::fixture::{Style, write_with};

fn with(mut stage: Value, options: &Value) -> Value {
    stage.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
    stage
}

#[test]
fn heights_above_triangles() {
    let bench = Bench::new();
    // Ground z = x + 2 y in the corners of a square of 10, and a far corner; others within, beside and above a corner.
    let points: [Plain; 9] = [
        ([0.0, 0.0, 0.0], 2),
        ([10.0, 0.0, 10.0], 2),
        ([0.0, 10.0, 20.0], 2),
        ([10.0, 10.0, 30.0], 2),
        ([100.0, 100.0, 300.0], 2),
        ([4.0, 3.0, 15.0], 6),
        ([5.0, 0.0, 9.0], 6),
        ([10.0, 10.0, 31.0], 6),
        ([5.0, -2.0, 40.0], 6),
    ];
    bench.tile("a.las", &points);
    let heights = |options: Value| {
        let stage = with(json!({"type": "filters.hag_delaunay"}), &options);
        bench.column(&[json!("@a.las"), stage], "HeightAboveGround")
    };
    // Within: 15 - (4 + 6). On an edge: 9 - 5. At a corner: 31 - 30. Outside: above the nearest, one of two with 0 and 10 at
    // the same distance, of which the first of the file counts.
    assert_eq!(heights(json!({})), [0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 4.0, 1.0, 40.0]);
    assert_eq!(heights(json!({"allow_extrapolation": false})), [0.0, 0.0, 0.0, 0.0, 0.0, 5.0, 4.0, 1.0, 0.0]);
    // The three nearest of (4, 3): those at (0, 0), (10, 0) and (0, 10), whose triangle holds it.
    assert_eq!(heights(json!({"count": 3}))[5], 5.0);
    assert_eq!(heights(json!({"class": 9})), [0.0; 9]);
    let few = json!(["@a.las", {"type": "filters.hag_delaunay", "count": 2}, "@o.las"]);
    assert!(bench.fault(&few).contains("from 3"), "{}", bench.fault(&few));
    // Ground points on one line make no triangle.
    let line: [Plain; 4] = [([0.0, 0.0, 1.0], 2), ([5.0, 0.0, 2.0], 2), ([9.0, 0.0, 3.0], 2), ([8.0, 1.0, 10.0], 6)];
    bench.tile("l.las", &line);
    let stage = json!({"type": "filters.hag_delaunay"});
    assert_eq!(bench.column(&[json!("@l.las"), stage], "HeightAboveGround"), [0.0, 0.0, 0.0, 7.0]);
}

#[test]
fn clusters_are_numbered_by_their_first_points() {
    let bench = Bench::new();
    // Two above one another, a pair far off, and one alone.
    let points: [Plain; 5] = [
        ([0.0, 0.0, 0.0], 1),
        ([50.0, 0.0, 0.0], 1),
        ([0.0, 0.5, 30.0], 1),
        ([50.5, 0.0, 0.0], 1),
        ([90.0, 0.0, 0.0], 1),
    ];
    bench.tile("a.las", &points);
    let numbers = |options: Value| {
        bench.column(&[json!("@a.las"), with(json!({"type": "filters.cluster"}), &options)], "ClusterID")
    };
    assert_eq!(numbers(json!({})), [1.0, 2.0, 3.0, 2.0, 4.0]);
    assert_eq!(numbers(json!({"is3d": false})), [1.0, 2.0, 1.0, 2.0, 3.0]);
    assert_eq!(numbers(json!({"is3d": "false", "min_points": 2})), [1.0, 2.0, 1.0, 2.0, 0.0]);
    assert_eq!(numbers(json!({"max_points": 1})), [1.0, 0.0, 2.0, 0.0, 3.0]);
    assert_eq!(numbers(json!({"tolerance": 0.4, "max_points": 18_446_744_073_709_551_615_u64})).len(), 5);
}

/// A plain with a point in the middle of each cell of 1, a block of 10 by 10 with a height of 6, an object above the plain
/// that is the first echo of two, and a point of noise below it.
fn town(bench: &Bench) {
    let mut points: Vec<Plain> = Vec::new();
    for y in 0..40 {
        for x in 0..40 {
            let stands = (15..25).contains(&x) && (15..25).contains(&y);
            points.push(([f64::from(x) + 0.5, f64::from(y) + 0.5, if stands { 6.0 } else { 0.0 }], 0));
        }
    }
    points.push(([5.5, 5.5, 9.0], 5));
    points.push(([35.5, 35.5, -20.0], 7));
    let last = points.len() - 2;
    write_with(&bench.path("town.las"), Style::default(), &points, |i, point| {
        if i == last {
            (point.return_number, point.number_of_returns) = (1, 2);
        }
        point.is_withheld = i == last + 1;
    });
}

/// How many points have each of the classes 0, 1, 2, 5 and 7.
fn counts(bench: &Bench, stages: &[Value]) -> [usize; 5] {
    let classes = bench.column(stages, "Classification");
    [0.0, 1.0, 2.0, 5.0, 7.0].map(|wanted| classes.iter().filter(|class| **class == wanted).count())
}

#[test]
fn ground_gets_its_class_and_who_takes_no_part_keeps_it() {
    let bench = Bench::new();
    town(&bench);
    for (name, cell) in [("filters.smrf", "cell"), ("filters.csf", "resolution")] {
        let of = |options: Value| counts(&bench, &[json!("@town.las"), with(json!({"type": name}), &options)]);
        // The first echo takes no part; noise does unless it is ignored.
        assert_eq!(of(json!({"ignore": "Classification[7:7]"})), [0, 100, 1500, 1, 1], "{name}");
        assert_eq!(of(json!({"ignore": "Classification[7:7]", "returns": ""})), [0, 101, 1500, 0, 1], "{name}");
        assert_eq!(of(json!({"ignore": "Classification[7:7]", "returns": ["first"], cell: 0.5})), [1600, 0, 1, 0, 1]);
        let kept = json!({"ignore": "Classification[5:7]", "only_ground": true, "ground_class": 1, "other_class": 1});
        assert_eq!(of(kept), [100, 1500, 0, 1, 1], "{name}");
        let fault = |options: Value| {
            bench.fault(&json!(["@town.las", with(json!({"type": name}), &options), {"type": "writers.null"}]))
        };
        assert!(fault(json!({"ignore": "Classification[:]"})).contains("`returns`"));
        assert!(fault(json!({"ignore": "Hight[7:7]"})).contains("`Hight`"));
        assert!(fault(json!({"returns": "lats"})).contains("`lats`"));
        assert!(fault(json!({"ground_class": 1})).contains("`only_ground`"));
        assert!(fault(json!({cell: 0})).contains("0.0001"), "{}", fault(json!({cell: 0})));
        assert!(fault(json!({cell: 0.001})).contains("cells"), "{}", fault(json!({cell: 0.001})));
        let nowhere =
            json!(["@town.las", {"type": "filters.assign", "value": "Z = Z / 0 WHERE X < 1"}, {"type": name}]);
        assert!(bench.fault(&nowhere).contains("not finite at point 0"));
        let some =
            json!(["@town.las", {"type": "filters.assign", "value": "ReturnNumber = 0 WHERE X < 1"}, {"type": name}]);
        assert!(bench.fault(&some).contains("40 points whose ReturnNumber"), "{}", bench.fault(&some));
    }
    let flags = with(json!({"type": "filters.smrf"}), &json!({"classbits": "withheld, keypoint"}));
    assert_eq!(counts(&bench, &[json!("@town.las"), flags]), [0, 100, 1500, 1, 1]);
    let unknown = json!(["@town.las", {"type": "filters.smrf", "classbits": "overlap"}, {"type": "writers.null"}]);
    assert!(bench.fault(&unknown).contains("`overlap`"));
    // Points without echoes all take part.
    let lines: Vec<String> = (0..20).map(|i| format!("{i},{i},{}", if i == 7 { 30 } else { 0 })).collect();
    std::fs::write(bench.path("t.csv"), format!("X,Y,Z\n{}\n", lines.join("\n"))).unwrap();
    assert_eq!(counts(&bench, &[json!("@t.csv"), json!({"type": "filters.smrf"})]), [0, 1, 19, 0, 0]);
}
