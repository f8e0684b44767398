//! Stages that choose points, order them, or mark those within polygons.

use serde_json::{Value, json};

use super::{Bench, line};
use crate::source::points::Tile;
use crate::source::points::fixture::{Style, write_with};

/// Six points of three pulses: the only echo of one, both of another, all three of the third; classes 1 to 6.
fn echoes(bench: &Bench) {
    const NUMBERS: [(u8, u8); 6] = [(1, 1), (1, 2), (2, 2), (1, 3), (2, 3), (3, 3)];
    write_with(&bench.path("a.las"), Style::default(), &line(&[1, 2, 3, 4, 5, 6]), |i, point| {
        (point.return_number, point.number_of_returns) = NUMBERS[i];
    });
}

#[test]
fn returns_come_by_group() {
    let bench = Bench::new();
    echoes(&bench);
    let classes = |options: Value| {
        let mut stage = json!({"type": "filters.returns"});
        stage.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
        bench.column(&[json!("@a.las"), stage], "Classification")
    };
    assert_eq!(classes(json!({})), [3.0, 6.0]);
    assert_eq!(classes(json!({"groups": "first"})), [2.0, 4.0]);
    // Group after group, whatever the order in which they are named.
    assert_eq!(classes(json!({"groups": "only, last,intermediate"})), [5.0, 3.0, 6.0, 1.0]);
    assert_eq!(classes(json!({"groups": "only", "where": "X < 4"})), [1.0, 5.0, 6.0]);
    bench.run(&json!(["@a.las", {"type": "filters.returns", "groups": "last,only"}, "@o#.las"]));
    let points = |name: &str| Tile::open(bench.path(name)).unwrap().points;
    assert_eq!((points("o1.las"), points("o2.las")), (2, 1));
    let fault = |groups: &str| bench.fault(&json!(["@a.las", {"type": "filters.returns", "groups": groups}, "@o.las"]));
    assert!(fault("lats").contains("`lats`") && fault("").contains("`groups`"));
    std::fs::write(bench.path("t.csv"), "X,Y,Z\n1,2,3\n").unwrap();
    let without = bench.fault(&json!(["@t.csv", {"type": "filters.returns"}, "@o.las"]));
    assert!(without.contains("`ReturnNumber`"), "{without}");
}

#[test]
fn decimation_steps() {
    let bench = Bench::new();
    bench.tile("a.las", &line(&[1; 10]));
    let kept = |options: Value| {
        let mut stage = json!({"type": "filters.decimation"});
        stage.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
        bench.column(&[json!("@a.las"), stage], "X")
    };
    assert_eq!(kept(json!({})).len(), 10);
    assert_eq!(kept(json!({"step": 3})), [0.0, 3.0, 6.0, 9.0]);
    assert_eq!(kept(json!({"step": 3, "offset": 1, "limit": 7})), [1.0, 4.0]);
    // 0, 2.5, 5, 7.5 and 10, rounded.
    assert_eq!(kept(json!({"step": 2.5})), [0.0, 3.0, 5.0, 8.0]);
    assert_eq!(kept(json!({"step": 4, "where": "X > 1"})), [0.0, 1.0, 2.0, 6.0]);
    assert!(bench.fault(&json!(["@a.las", {"type": "filters.decimation", "step": 0}, "@o.las"])).contains("`step`"));
    // Each set of points is counted from its own beginning.
    bench.tile("b.las", &line(&[2; 5]));
    let rows = bench.rows(
        &[json!("@a.las"), json!("@b.las"), json!({"type": "filters.decimation", "step": 4})],
        "X,Classification",
    );
    assert_eq!(rows, [[0.0, 1.0], [4.0, 1.0], [8.0, 1.0], [0.0, 2.0], [4.0, 2.0]]);
}

#[test]
fn the_last_points_are_kept_or_dropped() {
    let bench = Bench::new();
    bench.tile("a.las", &line(&[1; 5]));
    let tail = |options: Value| {
        let mut stage = json!({"type": "filters.tail"});
        stage.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
        bench.column(&[json!("@a.las"), stage], "X")
    };
    assert_eq!(tail(json!({})).len(), 5);
    assert_eq!(tail(json!({"count": 2})), [3.0, 4.0]);
    assert_eq!(tail(json!({"count": 2, "invert": true})), [0.0, 1.0, 2.0]);
    assert_eq!(tail(json!({"count": 9, "invert": true})), [0.0; 0]);
    assert_eq!(tail(json!({"count": 0})), [0.0; 0]);
}

#[test]
fn sorting_keeps_the_order_of_equals() {
    let bench = Bench::new();
    bench.tile("a.las", &line(&[3, 1, 2, 1, 3, 2]));
    let sort = |dimensions: Value, order: &str| {
        bench.rows(
            &[json!("@a.las"), json!({"type": "filters.sort", "dimensions": dimensions, "order": order})],
            "Classification,X",
        )
    };
    let by_class = [[1.0, 1.0], [1.0, 3.0], [2.0, 2.0], [2.0, 5.0], [3.0, 0.0], [3.0, 4.0]];
    assert_eq!(sort(json!("Classification"), "ASC"), by_class);
    assert_eq!(
        sort(json!("Classification"), "desc"),
        [[3.0, 0.0], [3.0, 4.0], [2.0, 2.0], [2.0, 5.0], [1.0, 1.0], [1.0, 3.0]]
    );
    // The last one counts most.
    assert_eq!(sort(json!(["X", "Classification"]), "ASC"), by_class);
    assert_eq!(
        sort(json!("X, Classification"), "DESC"),
        [[3.0, 4.0], [3.0, 0.0], [2.0, 5.0], [2.0, 2.0], [1.0, 3.0], [1.0, 1.0]]
    );
    let older = json!({"type": "filters.sort", "dimension": "Z", "order": "DESC"});
    assert_eq!(bench.column(&[json!("@a.las"), older], "X"), [5.0, 4.0, 3.0, 2.0, 1.0, 0.0]);
    let nothing = json!(["@a.las", {"type": "filters.assign", "value": "Mark = 0 / 0 WHERE X == 1"},
        {"type": "filters.sort", "dimensions": "Mark"}, {"type": "filters.tail", "count": 1},
        {"type": "writers.text", "filename": "@last.csv", "order": "X:0", "keep_unspecified": false, "write_header": false}]);
    bench.run(&nothing);
    assert_eq!(std::fs::read_to_string(bench.path("last.csv")).unwrap(), "1\n");
    assert!(
        bench.fault(&json!(["@a.las", {"type": "filters.sort", "dimension": "Hight"}, "@o.las"])).contains("`Hight`")
    );
}

/// Polygons with attributes, x from 0.5 to 2.5 and from 2 to 4.5.
fn polygons(bench: &Bench, crs: &str, values: [Value; 2]) {
    let ring = |low: f64, high: f64| json!([[[low, -1.0], [high, -1.0], [high, 1.0], [low, 1.0], [low, -1.0]]]);
    let feature = |low, high, value: &Value| {
        json!({"type": "Feature", "geometry": {"type": "Polygon", "coordinates": ring(low, high)},
            "properties": {"CLS": value, "name": "a shed"}})
    };
    let [first, second] = values;
    let text = json!({"type": "FeatureCollection",
        "crs": {"type": "name", "properties": {"name": crs}},
        "features": [feature(0.5, 2.5, &first), feature(2.0, 4.5, &second)]});
    std::fs::write(bench.path("p.geojson"), text.to_string()).unwrap();
}

#[test]
fn points_get_the_value_of_their_polygon() {
    let bench = Bench::new();
    bench.tile("a.las", &line(&[1; 6]));
    let overlay = |options: Value| {
        let mut stage = json!({"type": "filters.overlay", "dimension": "Classification", "datasource": "@p.geojson"});
        stage.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
        stage
    };
    let classes = |options: Value| bench.column(&[json!("@a.las"), overlay(options)], "Classification");
    polygons(&bench, "EPSG:28992", [json!(6), json!("9")]);
    // At x = 2 both hold the point, the first counts.
    assert_eq!(classes(json!({"column": "CLS"})), [1.0, 6.0, 6.0, 9.0, 9.0, 1.0]);
    assert_eq!(classes(json!({})), [1.0, 6.0, 6.0, 9.0, 9.0, 1.0]);
    assert_eq!(classes(json!({"where": "X != 3"})), [1.0, 6.0, 6.0, 1.0, 9.0, 1.0]);
    polygons(&bench, "EPSG:28992", [Value::Null, json!(9)]);
    assert_eq!(classes(json!({"column": "CLS"})), [1.0, 1.0, 9.0, 9.0, 9.0, 1.0]);

    let fault = |options: Value| bench.fault(&json!(["@a.las", overlay(options), "@o.las"]));
    assert!(fault(json!({"column": "name"})).contains("`a shed`"));
    assert!(fault(json!({"column": "cls2"})).contains("CLS"));
    assert!(fault(json!({"dimension": "Mark"})).contains("=>Mark"));
    assert!(fault(json!({"datasource": "@none.gpkg"})).contains("none.gpkg"));
    polygons(&bench, "EPSG:28992", [json!(300), json!(9)]);
    let unfit = fault(json!({"column": "CLS"}));
    assert!(unfit.contains("300") && unfit.contains("uint8"), "{unfit}");
}

#[test]
fn polygons_are_taken_to_the_system_of_the_points() {
    let bench = Bench::new();
    // Square degrees around the centre of the Dutch system, for points at the centre and 200 km east of it.
    let ring = json!([[[5.0, 52.0], [6.0, 52.0], [6.0, 53.0], [5.0, 53.0], [5.0, 52.0]]]);
    let text = json!({"type": "FeatureCollection", "features": [
        {"type": "Feature", "geometry": {"type": "Polygon", "coordinates": ring}, "properties": {"CLS": 6}}]});
    std::fs::write(bench.path("p.geojson"), text.to_string()).unwrap();
    bench.tile("a.las", &[([155_000.0, 463_000.0, 0.0], 1), ([255_000.0, 463_000.0, 0.0], 1)]);
    let stages = [
        json!({"type": "readers.las", "filename": "@a.las", "override_srs": "EPSG:28992"}),
        json!({"type": "filters.overlay", "dimension": "Classification", "datasource": "@p.geojson", "column": "CLS"}),
    ];
    assert_eq!(bench.column(&stages, "Classification"), [6.0, 1.0]);
}
