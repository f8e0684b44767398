//! Whole pipelines on small clouds whose results follow by hand.

mod clouds;
mod copc;
mod ept;
mod ground;
mod selection;

use std::path::{Path, PathBuf};

use serde_json::{Value, json};
use tempfile::TempDir;

use super::{Context, Outcome, Plan, Prepared, Silent, validate};
use crate::error::Result;
use crate::source::points::Tile;
use crate::source::points::fixture::{Plain, Style, write, write_copc, write_with};

/// A folder in which pipelines run; their file names are relative to it.
struct Bench(TempDir);

impl Bench {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// A tile with these points.
    fn tile(&self, name: &str, points: &[Plain]) {
        write(&self.path(name), Style::default(), points);
    }

    /// The pipeline with `@` for the folder.
    fn plan(&self, stages: &Value) -> Result<Plan> {
        let text = stages.to_string().replace('@', &format!("{}/", self.0.path().display()));
        Plan::read(&text, Path::new("test.json"), &[])
    }

    fn try_run(&self, stages: &Value) -> Result<Outcome> {
        let context = Context { observer: &Silent, command: &[] };
        Prepared::new(&self.plan(stages)?, &context)?.run(&context)
    }

    fn run(&self, stages: &Value) -> Outcome {
        self.try_run(stages).unwrap()
    }

    fn fault(&self, stages: &Value) -> String {
        self.try_run(stages).map(|_| ()).unwrap_err().to_string()
    }

    /// The rows that come out behind these stages: the dimensions in `order`.
    fn rows(&self, stages: &[Value], order: &str) -> Vec<Vec<f64>> {
        let mut stages = stages.to_vec();
        stages.push(json!({
            "type": "writers.text", "filename": "@rows.csv", "order": order, "keep_unspecified": false,
            "write_header": false, "precision": 6,
        }));
        self.run(&Value::Array(stages));
        let text = std::fs::read_to_string(self.path("rows.csv")).unwrap();
        text.lines().map(|line| line.split(',').map(|value| value.parse().unwrap()).collect()).collect()
    }

    /// The values of one dimension.
    fn column(&self, stages: &[Value], dimension: &str) -> Vec<f64> {
        self.rows(stages, dimension).into_iter().map(|row| row[0]).collect()
    }
}

/// Points at x = 0, 1, 2, …, y = 0, z = 10 x, of these classes.
fn line(classes: &[u8]) -> Vec<Plain> {
    classes.iter().enumerate().map(|(i, &class)| ([i as f64, 0.0, 10.0 * i as f64], class)).collect()
}

#[test]
fn range_and_expression_keep_what_they_say() {
    let bench = Bench::new();
    bench.tile("a.las", &line(&[1, 2, 6, 2, 6, 9]));
    let limits =
        |limits: &str| bench.column(&[json!("@a.las"), json!({"type": "filters.range", "limits": limits})], "X");
    assert_eq!(limits("Classification[2:2]"), [1.0, 3.0]);
    assert_eq!(limits("Classification[2:2],Classification[6:6],Z(10:40)"), [2.0, 3.0]);
    assert_eq!(limits("Classification![2:6]"), [0.0, 5.0]);
    let expression = |text: &str, only: &str| {
        bench.column(&[json!("@a.las"), json!({"type": "filters.expression", "expression": text, "where": only})], "X")
    };
    assert_eq!(expression("Classification == 6", "X >= 0"), [2.0, 4.0]);
    // Points that `where` leaves out pass by, in their places.
    assert_eq!(expression("Classification == 6", "X > 2"), [0.0, 1.0, 2.0, 4.0]);
}

#[test]
fn assign_and_ferry_change_and_make_dimensions() {
    let bench = Bench::new();
    bench.tile("a.las", &line(&[1, 2, 6]));
    let assign = json!({"type": "filters.assign", "value": [
        "Classification = 5 WHERE Z >= 20", "Mark = X * 2 + 0.25", "Mark = Mark + 1 WHERE Mark > 3", "Intensity = 2.6"
    ]});
    let rows = bench.rows(&[json!("@a.las"), assign], "Classification,Mark,Intensity");
    // Whole dimensions take the nearest whole number.
    assert_eq!(rows, [[1.0, 0.25, 3.0], [2.0, 2.25, 3.0], [5.0, 5.25, 3.0]]);
    let older = json!({"type": "filters.assign", "assignment": "Classification[2:2]=4", "condition": "X[0:1]"});
    assert_eq!(bench.column(&[json!("@a.las"), older], "Classification"), [1.0, 4.0, 6.0]);
    let ferry = json!({"type": "filters.ferry", "dimensions": "Z=>Height, X => Y, =>Nothing", "where": "X > 0"});
    assert_eq!(
        bench.rows(&[json!("@a.las"), ferry], "Y,Height,Nothing"),
        [[0.0, 0.0, 0.0], [1.0, 10.0, 0.0], [2.0, 20.0, 0.0]]
    );
    let unfit = bench.fault(&json!(["@a.las", {"type": "filters.assign", "value": "Classification = 300"}]));
    assert!(unfit.contains("300") && unfit.contains("uint8"), "{unfit}");
    let missing = bench.fault(&json!(["@a.las", {"type": "filters.assign", "value": "Red = Hight"}]));
    assert!(missing.contains("`Hight`"), "{missing}");
}

#[test]
fn crop_keeps_inside_or_outside() {
    let bench = Bench::new();
    bench.tile("a.las", &line(&[1; 6]));
    let crop = |options: Value| {
        let mut stage = json!({"type": "filters.crop"});
        stage.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
        bench.column(&[json!("@a.las"), stage], "X")
    };
    assert_eq!(crop(json!({"bounds": "([1, 3], [-1, 1])"})), [1.0, 2.0, 3.0]);
    assert_eq!(crop(json!({"bounds": "([1, 3], [-1, 1], [20, 99])"})), [2.0, 3.0]);
    assert_eq!(crop(json!({"bounds": "([1, 3], [-1, 1])", "outside": "true"})), [0.0, 4.0, 5.0]);
    assert_eq!(crop(json!({"polygon": "POLYGON((0.5 -1, 2.5 -1, 2.5 1, 0.5 1, 0.5 -1))"})), [1.0, 2.0]);
    assert_eq!(crop(json!({"point": "POINT(3 0)", "distance": 1.5})), [2.0, 3.0, 4.0]);
    // Each area gives points of its own, though they overlap.
    let areas = json!({"bounds": ["([0, 1], [-1, 1])", "([1, 2], [-1, 1])"]});
    assert_eq!(crop(areas), [0.0, 1.0, 1.0, 2.0]);
    assert!(bench.fault(&json!(["@a.las", {"type": "filters.crop"}])).contains("no area"));
}

#[test]
fn sets_of_points_stay_apart_until_merged() {
    let bench = Bench::new();
    bench.tile("a.las", &line(&[1, 1, 1]));
    bench.tile("b.las", &line(&[2, 2, 2]));
    let head = json!({"type": "filters.head", "count": 2});
    let classes = |stages: &[Value]| bench.column(stages, "Classification");
    assert_eq!(classes(&[json!("@a.las"), json!("@b.las"), head.clone()]), [1.0, 1.0, 2.0, 2.0]);
    let merge = json!({"type": "filters.merge"});
    assert_eq!(classes(&[json!("@a.las"), json!("@b.las"), merge.clone(), head.clone()]), [1.0, 1.0]);
    // Inputs come in the order in which they are listed.
    let [a, b] = ["a", "b"].map(|tag| json!({"filename": format!("@{tag}.las"), "tag": tag}));
    let turned = json!({"type": "filters.merge", "inputs": ["b", "a"]});
    assert_eq!(classes(&[a, b, turned, head.clone()]), [2.0, 2.0]);
    // Two stages may take the points of one.
    let stages = json!([
        {"filename": "@a.las", "tag": "a"},
        {"type": "filters.head", "count": 1, "tag": "h"},
        {"type": "writers.las", "filename": "@first.las", "inputs": "h"},
        {"type": "writers.las", "filename": "@all.las", "inputs": ["a", "h"]},
    ]);
    bench.run(&stages);
    let count = |name: &str| Tile::open(bench.path(name)).unwrap().points;
    assert_eq!((count("first.las"), count("all.las")), (1, 4));
    let rest = json!({"type": "filters.head", "count": 1, "invert": true, "where": "X > 0"});
    let head = json!({"type": "filters.head", "count": 1, "where": "X > 0"});
    assert_eq!(bench.column(&[json!("@a.las"), head], "X"), [0.0, 1.0]);
    assert_eq!(bench.column(&[json!("@a.las"), rest], "X"), [0.0, 2.0]);
}

#[test]
fn splitter_parts_points_into_tiles() {
    let bench = Bench::new();
    // Origin at the first point, tiles of 2: x from it is 0, 1, 2, 3, 4, and -1 in the tile left of it.
    let points: Vec<Plain> = [5.0, 6.0, 7.0, 8.0, 9.0, 4.0].map(|x| ([x, 0.0, 0.0], 1)).into();
    bench.tile("a.las", &points);
    let split = |options: Value| {
        let mut stage = json!({"type": "filters.splitter", "length": 2});
        stage.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
        bench.run(&json!(["@a.las", stage, "@tile#.las"]));
        let mut tiles = Vec::new();
        while let Ok(tile) = Tile::open(bench.path(&format!("tile{}.las", tiles.len() + 1))) {
            tiles.push((tile.points, tile.extent.map(|e| (e.min[0], e.max[0]))));
            std::fs::remove_file(&tile.path).unwrap();
        }
        tiles
    };
    let span = |low, high| Some((low, high));
    // In the order of their first points.
    assert_eq!(split(json!({})), [(2, span(5.0, 6.0)), (2, span(7.0, 8.0)), (1, span(9.0, 9.0)), (1, span(4.0, 4.0))]);
    // From 4 on: 4 5 | 6 7 | 8 9.
    assert_eq!(
        split(json!({"origin_x": "4", "origin_y": -1})),
        [(2, span(4.0, 5.0)), (2, span(6.0, 7.0)), (2, span(8.0, 9.0))]
    );
    // With a buffer of 0.5 the tile from 5 to 7 reaches from 4.5 to 7.5, and so on: 5, 7 and 9 lie in two.
    let buffered = split(json!({"buffer": 0.5, "origin_y": -1}));
    assert_eq!(buffered, [(3, span(5.0, 7.0)), (2, span(4.0, 5.0)), (3, span(7.0, 9.0)), (1, span(9.0, 9.0))]);
    assert!(bench.fault(&json!(["@a.las", {"type": "filters.splitter", "length": 2, "buffer": 1}])).contains("half"));
}

#[test]
fn reprojection_takes_heights_along() {
    let bench = Bench::new();
    let style = Style { scale: 0.01, ..Style::default() };
    write(&bench.path("feet.las"), style, &[([6_000_000.0, 2_000_000.0, 1000.0], 2)]);
    let stage = |from: &str, to: &str| json!({"type": "filters.reprojection", "in_srs": from, "out_srs": to});
    let feet = 1200.0 / 3937.0;
    let near = |row: &[f64], expected: [f64; 3]| {
        // EPSG rounds the false easting of the system in feet to a thousandth, which is 0.1 mm.
        assert!(row.iter().zip(expected).all(|(a, b)| (a - b).abs() < 2e-4), "{row:?} is not {expected:?}");
    };
    let rows = bench.rows(&[json!("@feet.las"), stage("EPSG:6416+6360", "EPSG:6415+5703")], "X,Y,Z");
    near(&rows[0], [6_000_000.0 * feet, 2_000_000.0 * feet, 1000.0 * feet]);
    // Without vertical parts heights stay, as in PDAL.
    let rows = bench.rows(&[json!("@feet.las"), stage("EPSG:6416", "EPSG:6415")], "X,Y,Z");
    near(&rows[0], [6_000_000.0 * feet, 2_000_000.0 * feet, 1000.0]);
    // The centre of the Dutch system by definition, longitude first.
    write(&bench.path("rd.las"), style, &[([155_000.0, 463_000.0, 0.0], 2)]);
    let rows = bench.rows(&[json!("@rd.las"), stage("EPSG:28992", "EPSG:4289")], "X,Y");
    assert!((rows[0][0] - 5.387_639).abs() < 1e-6 && (rows[0][1] - 52.156_161).abs() < 1e-6, "{rows:?}");
    let unknown = json!(["@rd.las", {"type": "filters.reprojection", "out_srs": "EPSG:28992"}]);
    assert!(bench.fault(&unknown).contains("`in_srs`"));
}

#[test]
fn sample_keeps_its_distance() {
    let bench = Bench::new();
    // Ten centimetres apart: with a radius of 0.25 every third is kept, for 0.3 is the first distance that is not less.
    let points: Vec<Plain> = (0..10).map(|i| ([f64::from(i) * 0.1, 0.0, 0.0], 1)).collect();
    bench.tile("a.las", &points);
    let stage = |option: &str, value: f64| json!({"type": "filters.sample", option: value});
    assert_eq!(bench.column(&[json!("@a.las"), stage("radius", 0.25)], "X"), [0.0, 0.3, 0.6, 0.9]);
    // A cube of 0.25 has a sphere of 0.2165 around it.
    assert_eq!(bench.column(&[json!("@a.las"), stage("cell", 0.25)], "X"), [0.0, 0.3, 0.6, 0.9]);
    let marked = json!({"type": "filters.sample", "radius": 0.25, "dimension": "Sampled"});
    let rows = bench.column(&[json!("@a.las"), marked], "Sampled");
    assert_eq!(rows, [1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    assert!(bench.fault(&json!(["@a.las", {"type": "filters.sample"}])).contains("one of them"));
}

#[test]
fn outliers_become_noise() {
    let bench = Bench::new();
    let mut points = line(&[1; 5]);
    for (position, _) in &mut points {
        position[2] = 0.0;
    }
    points.push(([2.0, 0.0, 50.0], 6));
    bench.tile("a.las", &points);
    let stage = json!({"type": "filters.outlier", "method": "radius", "radius": 1.5, "min_k": 1});
    assert_eq!(bench.column(&[json!("@a.las"), stage], "Classification"), [1.0, 1.0, 1.0, 1.0, 1.0, 7.0]);
    let nowhere = json!(["@a.las", {"type": "filters.assign", "value": "X = X / 0"}, {"type": "filters.outlier"}]);
    assert!(bench.fault(&nowhere).contains("not finite at point 0"));
    // Points that `where` leaves out are no neighbours, and stand behind the others.
    let stage = json!({"type": "filters.outlier", "method": "radius", "radius": 1.5, "min_k": 1, "class": 18,
        "where": "X != 1"});
    let rows = bench.rows(&[json!("@a.las"), stage], "X,Classification");
    assert_eq!(rows, [[0.0, 18.0], [2.0, 1.0], [3.0, 1.0], [4.0, 1.0], [2.0, 18.0], [1.0, 1.0]]);
}

#[test]
fn heights_above_ground() {
    let bench = Bench::new();
    let points: [Plain; 5] = [
        ([0.0, 0.0, 10.0], 2),
        ([3.0, 0.0, 16.0], 2),
        ([1.0, 0.0, 20.0], 6),
        ([3.0, 0.0, 20.0], 6),
        ([9.0, 0.0, 20.0], 6),
    ];
    bench.tile("a.las", &points);
    let heights = |options: Value| {
        let mut stage = json!({"type": "filters.hag_nn"});
        stage.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
        bench.column(&[json!("@a.las"), stage], "HeightAboveGround")
    };
    assert_eq!(heights(json!({})), [0.0, 0.0, 10.0, 4.0, 4.0]);
    // At x = 1 the squares of the distances are 1 and 4: (10 + 16/4) / (1 + 1/4) = 11.2. At x = 9 they are 36 and 81:
    // (16/36 + 10/81) / (1/36 + 1/81) = 14.153846.
    assert_eq!(heights(json!({"count": 2})), [0.0, 0.0, 8.8, 4.0, 5.846_154]);
    assert_eq!(heights(json!({"count": 2, "allow_extrapolation": false})), [0.0, 0.0, 8.8, 4.0, 0.0]);
    assert_eq!(heights(json!({"count": 2, "max_distance": 1.5})), [0.0, 0.0, 10.0, 4.0, 0.0]);
    assert_eq!(heights(json!({"class": 6}))[0], -10.0);
}

#[test]
fn stats_go_into_the_metadata() {
    let bench = Bench::new();
    bench.tile("a.las", &line(&[1, 2, 2]));
    let stats = json!({"type": "filters.stats", "dimensions": "Z,Classification", "count": "Classification"});
    let outcome = bench.run(&json!(["@a.las", stats, {"type": "writers.null"}]));
    let statistic = &outcome.metadata["stages"]["filters.stats"]["statistic"];
    assert_eq!(
        statistic[0],
        json!({"position": 0, "count": 3, "minimum": 0.0, "maximum": 20.0, "average": 10.0, "stddev": 10.0,
            "variance": 100.0, "name": "Z"})
    );
    assert_eq!(statistic[1]["counts"], json!(["1.000000/1", "2.000000/2"]));
    assert_eq!(outcome.metadata["stages"]["readers.las"]["count"], 3);
}

#[test]
fn las_files_have_what_was_asked_for() {
    let bench = Bench::new();
    let style = Style { version: (1, 2), format: 1, scale: 0.001, offset: [1.0, 2.0, 3.0] };
    write_with(&bench.path("a.las"), style, &line(&[1, 2, 6]), |i, point| {
        point.intensity = 100 + i as u16;
        point.gps_time = Some(i as f64 + 0.5);
        point.return_number = 1;
        point.number_of_returns = 2;
    });
    let header = |name: &str| Tile::open(bench.path(name)).unwrap().header;

    bench.run(&json!(["@a.las", "@plain.laz"]));
    let plain = header("plain.laz");
    assert_eq!((plain.version().minor, plain.point_format().to_u8().unwrap()), (4, 7));
    assert!(plain.point_format().is_compressed);
    assert_eq!((plain.transforms().x.scale, plain.transforms().x.offset), (0.01, 0.0));

    bench.run(&json!(["@a.las", {"type": "writers.las", "filename": "@forward.las", "forward": "all"}]));
    let forward = header("forward.las");
    assert_eq!((forward.version().minor, forward.point_format().to_u8().unwrap()), (2, 1));
    assert_eq!((forward.transforms().z.scale, forward.transforms().z.offset), (0.001, 3.0));
    assert_eq!(std::fs::metadata(bench.path("forward.las")).unwrap().len(), 227 + 3 * 28);

    // Extra dimensions and all others come back.
    let order = "X,Z,Intensity,GpsTime,ReturnNumber,Classification";
    let expected = bench.rows(&[json!("@a.las")], order);
    bench.run(&json!([
        "@a.las",
        {"type": "filters.assign", "value": "HeightAboveGround = Z / 4"},
        {"type": "writers.las", "filename": "@extra.laz", "extra_dims": "HeightAboveGround=float32", "a_srs": "EPSG:7415",
            "offset_x": "auto", "scale_x": "auto"},
    ]));
    assert_eq!(bench.rows(&[json!("@extra.laz")], order), expected);
    assert_eq!(bench.column(&[json!("@extra.laz")], "HeightAboveGround"), [0.0, 2.5, 5.0]);
    let tile = Tile::open(bench.path("extra.laz")).unwrap();
    assert_eq!(tile.crs.unwrap().code.as_deref(), Some("EPSG:7415"));
    // From 0 to 2 in 2³¹ - 1 steps.
    assert_eq!(tile.header.transforms().x.scale, 2.0 / 2_147_483_647.0);

    let far = json!(["@a.las", {"type": "filters.assign", "value": "X = 1e9"}, "@far.las"]);
    let fault = bench.fault(&far);
    assert!(
        fault.contains("X = 1000000000") && fault.contains("scale_x") && !bench.path("far.las").exists(),
        "{fault}"
    );
    let old = json!(["@a.las", {"type": "writers.las", "filename": "@o.las", "minor_version": 2, "dataformat_id": 6}]);
    assert!(bench.fault(&old).contains("LAS 1.4"));
    let forward = json!(["@a.las", {"type": "writers.las", "filename": "@o.las", "forward": "scales"}]);
    assert!(bench.fault(&forward).contains("`scale`"));
    bench.run(&json!(["@a.las", {"type": "filters.head", "count": 0}, "@none.las"]));
    assert_eq!(header("none.las").number_of_points(), 0);
}

#[test]
fn text_is_that_of_pdal() {
    let bench = Bench::new();
    bench.tile("a.las", &line(&[2, 6]));
    let text = |options: Value| {
        let mut stage = json!({"type": "writers.text", "filename": "@t.txt", "keep_unspecified": "false"});
        stage.as_object_mut().unwrap().extend(options.as_object().unwrap().clone());
        bench.run(&json!(["@a.las", stage]));
        std::fs::read_to_string(bench.path("t.txt")).unwrap()
    };
    assert_eq!(
        text(json!({"order": "X:1,Z,Classification:0"})),
        "\"X\",\"Z\",\"Classification\"\n0.0,0.000,2\n1.0,10.000,6\n"
    );
    assert_eq!(
        text(json!({"order": "Z", "precision": 0, "quote_header": false, "delimiter": ";", "newline": "\\r\\n"})),
        "Z\r\n0\r\n10\r\n"
    );
    assert_eq!(
        text(json!({"order": "Classification:0", "format": "GeoJSON", "precision": 1, "where": "X > 0"})),
        "{ \"type\": \"FeatureCollection\", \"features\": [{ \"type\":\"Feature\",\"geometry\": { \"type\": \"Point\", \
         \"coordinates\": [1.0,0.0,10.0]},\"properties\": {\"Classification\":\"6\"}}]}"
    );
    bench.run(&json!(["@a.las", "@all.csv"]));
    let head = std::fs::read_to_string(bench.path("all.csv")).unwrap();
    let names: Vec<&str> = head.lines().next().unwrap().split(',').collect();
    assert_eq!(&names[..4], ["\"X\"", "\"Y\"", "\"Z\"", "\"Intensity\""]);
    assert!(names.contains(&"\"GpsTime\"") && names.contains(&"\"ScanChannel\""));
}

#[test]
fn readers_read_a_part() {
    let bench = Bench::new();
    bench.tile("a.laz", &line(&[1, 2, 3, 4, 5]));
    let part =
        |count: u32, start: u32| json!({"type": "readers.las", "filename": "@a.laz", "count": count, "start": start});
    assert_eq!(bench.column(&[part(2, 0)], "Classification"), [1.0, 2.0]);
    assert_eq!(bench.column(&[part(9, 3)], "Classification"), [4.0, 5.0]);
    assert_eq!(bench.column(&[part(0, 0)], "Classification"), [0.0; 0]);
    let copc = json!({"type": "readers.copc", "filename": "@a.laz", "bounds": "([1, 3], [-1, 1])"});
    assert_eq!(bench.column(&[copc], "X"), [1.0, 2.0, 3.0]);
    let crs = json!([{"type": "readers.las", "filename": "@a.laz", "override_srs": "EPSG:7415"}, "@b.las"]);
    bench.run(&crs);
    assert_eq!(Tile::open(bench.path("b.las")).unwrap().crs.unwrap().code.as_deref(), Some("EPSG:7415"));
    let crs = json!([{"type": "readers.las", "filename": "@b.las", "default_srs": "EPSG:2056"}, "@c.las"]);
    bench.run(&crs);
    assert_eq!(Tile::open(bench.path("c.las")).unwrap().crs.unwrap().code.as_deref(), Some("EPSG:7415"));
    assert!(bench.fault(&json!([{"filename": "@a.laz", "override_srs": "EPSG:0"}])).contains("`override_srs`"));
    assert!(bench.fault(&json!(["@missing.las"])).contains("missing.las"));
}

#[test]
fn of_copc_only_the_wanted_nodes_are_read() {
    let bench = Bench::new();
    let node = |x: f64, class: u8| vec![([x, x, 1.0], class), ([x + 20.0, x, 1.0], class)];
    let nodes = [([0, 0, 0, 0], node(10.0, 1)), ([1, 0, 0, 0], node(20.0, 2)), ([1, 1, 1, 0], node(70.0, 3))];
    write_copc(&bench.path("a.copc.laz"), &nodes);
    let part = |option: &str, area: &str| json!({"filename": "@a.copc.laz", option: area});
    let rows = |stage: Value| bench.rows(&[stage], "X,Classification");
    assert_eq!(rows(json!("@a.copc.laz")).len(), 6);
    // The root reaches everywhere; of its points and of those of the last node only these lie within.
    assert_eq!(rows(part("bounds", "([25, 75], [0, 75])")), [[30.0, 1.0], [40.0, 2.0], [70.0, 3.0]]);
    assert_eq!(rows(part("polygon", "POLYGON((60 60, 80 60, 80 80, 60 80, 60 60))")), [[70.0, 3.0]]);
    let outcome = bench.run(&json!([part("bounds", "([60, 80], [60, 80])"), {"type": "writers.null"}]));
    assert_eq!(outcome.metadata["stages"]["readers.copc"]["read"], 1);
}

#[test]
fn two_systems_do_not_go_into_one_file() {
    let bench = Bench::new();
    bench.tile("a.las", &line(&[1]));
    let reader = |crs: &str| json!({"type": "readers.las", "filename": "@a.las", "override_srs": crs});
    let mixed = json!([reader("EPSG:7415"), reader("EPSG:2056"), "@o.las"]);
    let fault = bench.fault(&mixed);
    assert!(fault.contains("EPSG:2056") && fault.contains("filters.reprojection"), "{fault}");
    // One for each is fine.
    bench.run(&json!([reader("EPSG:7415"), reader("EPSG:2056"), "@o#.las"]));
    assert!(bench.path("o2.las").exists());
}

#[test]
fn validation_says_whether_it_streams() {
    let bench = Bench::new();
    bench.tile("a.las", &line(&[1]));
    let verdict = |stages: Value| validate(bench.plan(&stages), &Silent);
    let streams = |stage: Value| verdict(json!(["@a.las", stage, "@o.las"]))["streamable"] == true;
    assert!(streams(json!({"type": "filters.range", "limits": "Z[0:1]"})));
    assert!(streams(json!({"type": "filters.crop", "bounds": "([0,1],[0,1])"})));
    assert!(!streams(json!({"type": "filters.crop", "bounds": ["([0,1],[0,1])", "([0,1],[0,1])"]})));
    assert!(!streams(json!({"type": "filters.hag_nn"})));
    assert!(!streams(json!({"type": "writers.las", "filename": "@x.las", "offset_x": "auto"})));
    let bad = verdict(json!(["@a.las", {"type": "filters.range", "limits": "Hight[0:1]"}]));
    assert_eq!((&bad["valid"], &bad["streamable"]), (&json!(false), &json!(false)));
    assert!(bad["error_detail"].as_str().unwrap().contains("stage 2 (filters.range)"), "{bad}");
    assert!(!bench.path("o.las").exists(), "nothing is written");
}
