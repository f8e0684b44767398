//! COPC files that are written.

use las::copc::CopcReader;
use serde_json::json;

use super::Bench;
use crate::source::points::Tile;
use crate::source::points::fixture::{Style, write_with};

/// A roof over a plain, enough for several nodes.
fn town(bench: &Bench) -> usize {
    let points: Vec<_> = (0..60_000)
        .map(|i| {
            let (x, y) = (f64::from(i % 300), f64::from(i / 300));
            let stands = (100.0..140.0).contains(&x) && (50.0..90.0).contains(&y);
            ([85_000.0 + x, 447_000.0 + y, if stands { 12.5 } else { 0.25 }], if stands { 6 } else { 2 })
        })
        .collect();
    write_with(&bench.path("town.las"), Style::default(), &points, |i, point| {
        point.gps_time = Some(1000.0 + i as f64);
        point.return_number = 1 + u8::from(i % 3 == 0);
        point.number_of_returns = 2;
    });
    points.len()
}

#[test]
fn what_is_written_is_read_again() {
    let bench = Bench::new();
    let count = town(&bench);
    let order = "GpsTime,X,Y,Z,Classification,ReturnNumber,Mark";
    let mark = json!({"type": "filters.assign", "value": "Mark = X - 84999.5"});
    let writer = json!({"filename": "@town.copc.laz", "extra_dims": "Mark=float32", "forward": "scale"});
    let outcome = bench.run(&json!(["@town.las", mark.clone(), writer]));
    assert!(outcome.metadata["stages"]["writers.copc"]["nodes"].as_u64() > Some(4));
    let sorted = |file: &str, further: &[serde_json::Value]| {
        let mut stages = vec![json!(file)];
        stages.extend_from_slice(further);
        stages.push(json!({"type": "filters.sort", "dimension": "GpsTime"}));
        bench.rows(&stages, order)
    };
    let rows = sorted("@town.las", &[mark]);
    assert_eq!((rows.len(), &rows), (count, &sorted("@town.copc.laz", &[])));

    // By the library's reader, node by node.
    let mut reader = CopcReader::from_path(bench.path("town.copc.laz")).unwrap();
    let info = reader.header().copc_info_vlr().unwrap();
    assert_eq!((info.gpstime_minimum, info.gpstime_maximum), (1000.0, 1000.0 + count as f64 - 1.0));
    let entries: Vec<_> = reader.hierarchy_entries().collect();
    assert_eq!(entries.iter().map(|entry| entry.point_count as usize).sum::<usize>(), count);
    for entry in entries {
        let node = entry.key.bounds(&info);
        let points = reader.read_entry(&entry).unwrap();
        assert_eq!(points.points().count(), entry.point_count as usize);
        for point in points.points() {
            let point = point.unwrap();
            assert!((node.min.x..=node.max.x).contains(&point.x) && (node.min.z..=node.max.z).contains(&point.z));
        }
    }
    // A corner of it, of which only the nodes that touch it are read.
    let corner = json!({"filename": "@town.copc.laz", "bounds": "([85000, 85009], [447000, 447004])"});
    assert_eq!(bench.column(&[corner], "X").len(), 50);
    // The same again gives the same bytes.
    let bytes = std::fs::read(bench.path("town.copc.laz")).unwrap();
    bench.run(&json!(["@town.copc.laz", {"type": "filters.sort", "dimension": "GpsTime"},
        {"filename": "@again.copc.laz", "extra_dims": "all", "forward": "all"}]));
    assert!(bytes == std::fs::read(bench.path("again.copc.laz")).unwrap());
}

#[test]
fn headers_say_what_there_is() {
    let bench = Bench::new();
    town(&bench);
    let part = json!({"filename": "@town.las", "count": 90});
    let colours = json!({"type": "filters.ferry", "dimensions": "=>Red,=>Green,=>Blue"});
    let writer = json!({"filename": "@c.copc.laz", "a_srs": "EPSG:7415", "scale_z": "auto", "offset_x": "auto",
        "system_id": "MERGE", "creation_year": 2020, "creation_doy": 45});
    bench.run(&json!([part, colours, writer]));
    let tile = Tile::open(bench.path("c.copc.laz")).unwrap();
    let header = &tile.header;
    assert_eq!((tile.is_copc, tile.point_format, tile.points), (true, 7, 90));
    assert_eq!(tile.crs.as_ref().and_then(|crs| crs.code.clone()).as_deref(), Some("EPSG:7415"));
    assert_eq!((header.system_identifier(), header.has_wkt_crs()), ("MERGE", true));
    assert_eq!((header.transforms().x.offset, header.bounds().max.x), (85_000.0, 85_089.0));
    assert_eq!([1, 2, 3].map(|n| header.number_of_points_by_return(n)), [Some(60), Some(30), None]);
    let none = json!([{"filename": "@town.las", "count": 0}, "@none.copc.laz"]);
    assert!(bench.fault(&none).contains("no points"), "{}", bench.fault(&none));
    let far = json!(["@town.las", {"filename": "@far.copc.laz", "scale_x": 1e-8}]);
    assert!(bench.fault(&far).contains("`offset_x`"), "{}", bench.fault(&far));
    assert!(!bench.path("far.copc.laz").exists() && !bench.path("none.copc.laz").exists());
}
