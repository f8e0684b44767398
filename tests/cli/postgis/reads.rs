//! What is read: the same as from files, all types, only what lies at the tiles.

use std::fmt::Write;
use std::path::Path;

use serde_json::json;
use tempfile::tempdir;

use super::server::{HOUSE, run_house, server};
use crate::bench::*;

/// WKB of the ring of a polygon.
fn wkb(rings: &serde_json::Value) -> Vec<u8> {
    let rings = rings.as_array().unwrap();
    let mut bytes = vec![1, 3, 0, 0, 0];
    bytes.extend((rings.len() as u32).to_le_bytes());
    for ring in rings.iter().map(|ring| ring.as_array().unwrap()) {
        bytes.extend((ring.len() as u32).to_le_bytes());
        for number in ring.iter().flat_map(|point| point.as_array().unwrap()) {
            bytes.extend(number.as_f64().unwrap().to_le_bytes());
        }
    }
    bytes
}

/// The bundled footprints as a GeoPackage at `path`, and as SQL that makes the same table in `PostGIS`.
fn delft_as_geopackage(path: &Path) -> String {
    let file = json_of(data("footprints.geojson"));
    let connection = rusqlite::Connection::open(path).unwrap();
    let columns =
        "fid INTEGER PRIMARY KEY, id TEXT, bgt_id TEXT, level INTEGER, height DOUBLE PRECISION, inspected DATE";
    connection
        .execute_batch(&format!(
            "CREATE TABLE gpkg_contents (table_name TEXT, data_type TEXT, srs_id INTEGER);
             CREATE TABLE gpkg_geometry_columns (table_name TEXT, column_name TEXT, geometry_type_name TEXT, srs_id INTEGER);
             CREATE TABLE gpkg_spatial_ref_sys
                 (srs_id INTEGER, organization TEXT, organization_coordsys_id INTEGER, definition TEXT);
             INSERT INTO gpkg_spatial_ref_sys VALUES (28992, 'EPSG', 28992, 'undefined');
             INSERT INTO gpkg_contents VALUES ('footprints', 'features', 28992);
             INSERT INTO gpkg_geometry_columns VALUES ('footprints', 'geom', 'POLYGON', 28992);
             CREATE TABLE footprints ({columns}, geom BLOB)"
        ))
        .unwrap();
    let mut sql = format!("CREATE TABLE footprints ({columns}, geom geometry(Polygon, 28992));");
    let features = file["features"].as_array().unwrap();
    // The table is filled from its end, so that only its key tells the order.
    for (fid, feature) in features.iter().enumerate().rev() {
        let text = |name: &str| feature["properties"][name].as_str().unwrap().to_owned();
        let (id, bgt, level) = (text("id"), text("bgt_id"), feature["properties"]["relatievehoogteligging"].as_i64());
        let height = fid as f64 * 0.1;
        let shape = wkb(&feature["geometry"]["coordinates"]);
        let hex: String = shape.iter().fold(String::new(), |mut text, byte| {
            write!(text, "{byte:02x}").unwrap();
            text
        });
        let values = format!("{fid}, '{id}', '{bgt}', {}, {height:?}, '2021-03-0{}'", level.unwrap(), fid % 9 + 1);
        write!(sql, "INSERT INTO footprints VALUES ({values}, ST_SetSRID('{hex}'::geometry, 28992));").unwrap();
        let blob = [&b"GP\0\x01"[..], &28992_i32.to_le_bytes(), &shape].concat();
        connection.execute(&format!("INSERT INTO footprints VALUES ({values}, ?)"), [blob]).unwrap();
    }
    sql
}

#[test]
fn the_model_is_that_of_the_same_footprints_in_a_geopackage() {
    let Some(server) = server() else { return };
    let folder = tempdir().unwrap();
    let file = folder.path().join("footprints.gpkg");
    server.database("footprints", &delft_as_geopackage(&file));
    server.sql("footprints", "CREATE INDEX ON footprints USING gist (geom); ANALYZE footprints");
    let tile = data("delft_ahn3.laz");
    let address = server.address("footprints");
    let query = ["--query", "SELECT * FROM footprints WHERE level > -99 ORDER BY fid -- all of them\n;"];
    let model = |name: &str, footprints: &Path, words: &[&str]| {
        let out = folder.path().join(name);
        let mut command = command(["reconstruct", "--field=height-field", "--ground-class=2", "-f"]);
        command.arg(footprints).arg("-o").arg(&out).arg(&tile).args(words);
        let run: Run = command.output().unwrap().into();
        assert!(run.code != 1, "{}", run.err);
        (std::fs::read(&out).unwrap(), report_of(&out))
    };
    let (expected, of_file) = model("file.city.json", &file, &[]);
    let (of_table, report) = model("table.city.json", address.as_ref(), &[]);
    assert!(of_table == expected, "the table gives another model");
    assert!(model("query.city.json", address.as_ref(), &query).0 == expected, "the query gives another model");
    let (of_table, of_file) = (&report["inputs"]["footprints"], &of_file["inputs"]["footprints"]);
    assert_eq!((&of_table["footprints"], &of_table["crs"]), (&json!(71), &of_file["crs"]));
    assert_eq!(
        of_table["file"],
        json!(format!("PG:host={} port={} user=postgres dbname=footprints", server.host, server.port))
    );
    // A folder gets a file that is named after the database.
    let run: Run = command(["info", "--json", &address, tile.to_str().unwrap()]).output().unwrap().into();
    let info: serde_json::Value = serde_json::from_str(&run.out).unwrap_or_else(|_| panic!("{}", run.err));
    assert_eq!(info["footprints"][0]["overlap"]["touching"], json!(71), "{}", run.out);
}

#[test]
fn attributes_of_all_usual_types_become_what_they_are() {
    let Some(server) = server() else { return };
    let types = ", true AS yes, 1::int2 AS small, 2::int4 AS whole, 9007199254740993::int8 AS large, 2.8::float4 AS single, \
        0.1::float8 AS double, 12.50::numeric AS price, 123456789012345678901::numeric AS digits, 'NaN'::numeric AS nan, \
        'é''\"x'::text AS note, 'ab'::varchar(9) AS short, 'ab'::char(5) AS padded, date '2021-03-04' AS day, \
        timestamp '2021-03-04 05:06:07.25' AS at, timestamptz '2021-03-04 05:06:07+02' AS moment, time '05:06' AS clock, \
        'a0eebc99-9c0b-4ef8-bb6d-6bb9bd380a11'::uuid AS code, '{\"a\": [1, null]}'::jsonb AS tree, ARRAY['a', 'b,\"c'] AS list, \
        ARRAY[1.5, 2] AS numbers, null::int AS nothing, '\\x00ff'::bytea AS bytes, interval '1 day' AS span, \
        ST_MakePoint(1, 2) AS door, '1.2.3.4'::inet AS host, 'two'::mood AS mood, 7::positive AS checked, \
        26::oid AS object, 'x'::name AS called, 1 AS \"q\"\"uoted Name\"";
    server
        .database("types", "CREATE TYPE mood AS ENUM ('one', 'two'); CREATE DOMAIN positive AS int CHECK (value > 0)");
    server.sql(
        "types",
        &format!("SET search_path = public; CREATE TABLE pand AS SELECT '007' AS id, {HOUSE} AS geom{types}"),
    );
    let ran = run_house(&server.address("types"), "--layer pand(geom)", &[]);
    let of = ran.attributes("007");
    let expected = json!({
        "yes": true, "small": 1, "whole": 2, "large": 9_007_199_254_740_993_u64, "single": 2.8, "double": 0.1, "price": 12.5,
        "digits": "123456789012345678901", "nan": null, "note": "é'\"x", "short": "ab", "padded": "ab", "day": "2021-03-04",
        "at": "2021-03-04T05:06:07.25", "moment": "2021-03-04T03:06:07Z", "clock": "05:06:00",
        "code": "a0eebc99-9c0b-4ef8-bb6d-6bb9bd380a11", "tree": {"a": [1, null]}, "list": "[\"a\",\"b,\\\"c\"]",
        "numbers": "[1.5,2]", "nothing": null, "span": "P1D", "host": "1.2.3.4/32", "mood": "two", "checked": 7,
        "object": 26, "called": "x", "q\"uoted Name": 1,
    });
    for (name, value) in expected.as_object().unwrap() {
        assert_eq!(&of[name], value, "{name}: {of:#}");
    }
    assert!(of.get("bytes").is_none() && of.get("door").is_none() && of.get("geom").is_none());
    let said = [
        "`span` is of type interval, which gable does not know: read as text",
        "`host` is of type inet",
        "`bytes` is binary and was left out",
        "`door` is geometry beside that of the layer",
    ];
    assert_says(&ran.run.err, &said);
    let told = ran.run.err.matches("which gable does not know").count();
    assert_eq!(told, 2, "{}", ran.run.err);
}

#[test]
fn only_what_lies_at_the_tiles_is_asked_for() {
    let Some(server) = server() else { return };
    server.house("far", "");
    let boxes = "INSERT INTO pand SELECT 'far-' || i, ST_SetSRID(ST_MakeEnvelope(100000 + 20 * i, 450000, 100010 + 20 * i, 450010), 28992) \
        FROM generate_series(1, 5000) i; INSERT INTO pand VALUES ('nowhere', NULL); \
        ALTER TABLE pand ADD PRIMARY KEY (id); CREATE INDEX by_place ON pand USING gist (geom); ANALYZE pand; \
        CREATE TABLE world AS SELECT id, ST_Transform(geom, 4326) AS place FROM pand; \
        CREATE TABLE round AS SELECT id, place::geography AS spot FROM world WHERE id IN ('007', 'far-1')";
    server.sql("far", boxes);
    for layer in ["pand", "world", "round"] {
        let ran = run_house(&server.address("far"), &format!("--layer {layer}"), &[]);
        // What has no geometry is nowhere, and told.
        let (code, rejected) = if layer == "round" { (0, 0) } else { (2, 1) };
        assert_eq!(ran.run.code, code, "{layer}: {}", ran.run.err);
        let footprints = &ran.report()["inputs"]["footprints"];
        assert_eq!((&footprints["footprints"], &footprints["rejected"]), (&json!(1), &json!(rejected)), "{layer}");
        assert_says(&ran.run.err, &["features beside the tiles are not asked for"]);
    }
    let ran = run_house(&server.address("far"), "", &["--query", "SELECT * FROM pand"]);
    assert_eq!(ran.report()["inputs"]["footprints"]["footprints"], json!(1));
    // Backends count for all to see when they end.
    let scans = "SELECT pg_stat_get_numscans('by_place'::regclass)";
    for _ in 0..50 {
        if server.sql("far", scans) != ["0"] {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(100));
    }
    assert_ne!(server.sql("far", scans), ["0"], "the index of the table is used");
    let nothing = run_house(&server.address("far"), "--layer round --footprint-crs EPSG:25831", &[]);
    nothing.refused(&["no feature at the tiles", "--footprint-crs"]);
}

#[test]
fn curves_are_straightened_and_views_read() {
    let Some(server) = server() else { return };
    let arcs = "CURVEPOLYGON(COMPOUNDCURVE((85000 447008, 85000 447000, 85010 447000, 85010 447008), \
        CIRCULARSTRING(85010 447008, 85005 447009, 85000 447008)))";
    server.database(
        "curves",
        &format!(
            "CREATE TABLE arcs (id text, geom geometry(CurvePolygon, 28992)); \
             INSERT INTO arcs VALUES ('007', ST_GeomFromText('{arcs}', 28992)); \
             CREATE SCHEMA \"Odd.Schema\"; CREATE VIEW \"Odd.Schema\".\"a \"\"view\" AS \
             SELECT id, ST_Collect(ARRAY[geom]) AS \"the Geom\" FROM arcs"
        ),
    );
    for layer in ["arcs", "Odd.Schema.a \"view"] {
        let ran = run_house(&server.address("curves"), "", &["--layer", layer]);
        let notes = ran.attributes("007")["gable_notes"].to_string();
        assert!(notes.contains("arcs"), "{layer}: {notes}");
    }
}

#[test]
fn an_srid_of_0_means_the_system_of_the_points_unless_one_is_given() {
    let Some(server) = server() else { return };
    server.database("bare", &format!("CREATE TABLE pand AS SELECT '007' AS id, ST_SetSRID({HOUSE}, 0) AS geom"));
    let ran = run_house(&server.address("bare"), "", &[]);
    ran.attributes("007");
    assert_says(&ran.run.err, &["does not say its reference system", "--footprint-crs"]);
    let ran = run_house(&server.address("bare"), "--footprint-crs EPSG:28992", &[]);
    ran.attributes("007");
    assert!(!ran.run.err.contains("reference system"), "{}", ran.run.err);
    // A column for any SRID: that of the first value counts, and others are told.
    server.sql(
        "bare",
        &format!(
            "CREATE TABLE mixed (id text, geom geometry); \
        INSERT INTO mixed VALUES ('007', {HOUSE}), ('b', ST_SetSRID({HOUSE}, 25831))"
        ),
    );
    let ran = run_house(&server.address("bare"), "--layer mixed", &[]);
    assert_ends(
        &ran.run,
        2,
        &["1 of 2 features have no usable polygon", "its SRID is 25831, and that of the first feature 28992"],
    );
    assert_eq!(ran.report()["inputs"]["footprints"]["crs"], json!("EPSG:28992"));
    server.sql(
        "bare",
        "INSERT INTO spatial_ref_sys VALUES (990001, 'me', 7, 'nonsense', ''); \
        CREATE TABLE own AS SELECT id, ST_SetSRID(geom, 990001) AS geom FROM pand",
    );
    let ran = run_house(&server.address("bare"), "--layer own", &[]);
    ran.refused(&["--footprint-crs"]);
}

#[test]
fn a_pipeline_reads_databases_too() {
    let Some(server) = server() else { return };
    server.house("piped", "");
    let folder = house_folder();
    let out = folder.path().join("out.city.json");
    let address = format!("{} password=hunter2", server.address("piped"));
    let pipeline = json!([folder.path().join("house.laz"), {
        "type": "writers.lod2", "filename": out, "crs": "EPSG:7415", "field": "height-field",
        "footprints": address, "query": "SELECT * FROM pand"
    }]);
    let (file, serialization) = (folder.path().join("p.json"), folder.path().join("s.json"));
    std::fs::write(&file, pipeline.to_string()).unwrap();
    let mut command = command(["pipeline"]);
    command.arg(&file).arg("--pipeline-serialization").arg(&serialization);
    let run: Run = command.output().unwrap().into();
    assert_eq!(run.code, 0, "{}", run.err);
    assert_eq!(report_of(&out)["inputs"]["footprints"]["footprints"], json!(1));
    let text = std::fs::read_to_string(&serialization).unwrap();
    assert!(text.contains("password=***") && !text.contains("hunter2"), "{text}");
}
