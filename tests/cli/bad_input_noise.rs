//! Damage at random: whatever a file holds, the command ends by itself, with one of its exit codes and never with a
//! panic.

use std::path::Path;
use std::time::{Duration, Instant};

use crate::bad_input_footprints::write_shapefile;
use crate::bench::*;

/// How long a file is damaged, and how often; a slow machine does fewer rounds.
const TIME: Duration = Duration::from_secs(4);
const ROUNDS: u64 = 100;

/// A generator of which the numbers are those of every run (Steele, Lea and Flood, `SplitMix64`).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }
}

/// Flips one to eight bits, one in three of them among the first 600 bytes, where the headers are.
fn damage(content: &mut [u8], random: &mut Random) {
    for _ in 0..=random.below(8) {
        let reach = if random.below(3) == 0 { content.len().min(600) } else { content.len() };
        let at = random.below(reach);
        content[at] ^= 1 << random.below(8);
    }
}

/// Runs the command on damaged copies of these files of `folder`, and on the others as they are.
fn survives(folder: &Path, tile: &str, footprints: &str, damaged: &str, seed: u64) {
    let whole = std::fs::read(folder.join(damaged)).unwrap();
    let until = Instant::now() + TIME;
    let mut random = Random(seed);
    for round in 0..ROUNDS {
        if Instant::now() > until {
            println!("{damaged}: {round} rounds in the time that there is");
            break;
        }
        let mut content = whole.clone();
        damage(&mut content, &mut random);
        if random.below(8) == 0 {
            content.truncate(random.below(whole.len()));
        }
        std::fs::write(folder.join(damaged), &content).unwrap();
        let started = Instant::now();
        let run = run_in(folder, tile, footprints, "--overwrite --jobs 1");
        assert!(matches!(run.code, 0..=2), "round {round}: {}{}", run.out, run.err);
        assert!(!run.err.contains("panicked") && !run.err.contains("RUST_BACKTRACE"), "round {round}: {}", run.err);
        assert!(
            run.code != 1 || run.err.contains("error: ") || run.err.contains("warning: "),
            "round {round}: no word"
        );
        let named = [tile, footprints, damaged].iter().any(|name| run.err.contains(name));
        // What damage has left readable may still have no building point: that is no fault of a file.
        let empty = run.err.contains("no footprint holds a point");
        assert!(run.code != 1 || named || empty, "round {round}: no file is named: {}", run.err);
        assert!(started.elapsed() < Duration::from_mins(1), "round {round} took {:?}", started.elapsed());
        let left = names_in(folder);
        assert!(
            !left.iter().any(|name| name.ends_with("part") || name.ends_with("partial")),
            "round {round}: {left:?}"
        );
    }
}

#[test]
fn random_damage_to_the_bundled_tile() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::copy(data("delft_ahn3.laz"), folder.path().join("t.laz")).unwrap();
    // A few footprints, so that the time goes into the reading.
    let mut footprints = json_of(data("footprints.geojson"));
    footprints["features"].as_array_mut().unwrap().truncate(2);
    std::fs::write(folder.path().join("f.geojson"), footprints.to_string()).unwrap();
    survives(folder.path(), "t.laz", "f.geojson", "t.laz", 1);
}

#[test]
fn random_damage_to_a_small_tile() {
    let folder = house_folder();
    survives(folder.path(), "house.laz", "footprints.geojson", "house.laz", 2);
    write_house(&folder.path().join("house.las"), None, 6);
    survives(folder.path(), "house.las", "footprints.geojson", "house.las", 3);
}

#[test]
fn random_damage_to_a_shapefile() {
    let folder = house_folder();
    let ring = [[0.0, 0.0], [0.0, 8.0], [10.0, 8.0], [10.0, 0.0], [0.0, 0.0]];
    write_shapefile(&folder.path().join("f.shp"), &ring.map(|c| [c[0] + CORNER[0], c[1] + CORNER[1]]));
    for (part, seed) in [("f.shp", 5), ("f.dbf", 6)] {
        let whole = std::fs::read(folder.path().join(part)).unwrap();
        survives(folder.path(), "house.laz", "f.shp", part, seed);
        std::fs::write(folder.path().join(part), whole).unwrap();
    }
}

#[test]
fn random_damage_to_footprints() {
    let folder = house_folder();
    // The bundled footprints do not lie where the house is; its own come last.
    let mut bundled = json_of(data("footprints.geojson"));
    let own = json_of(folder.path().join("footprints.geojson"))["features"][0].clone();
    bundled["features"].as_array_mut().unwrap().push(own);
    std::fs::write(folder.path().join("f.geojson"), bundled.to_string()).unwrap();
    survives(folder.path(), "house.laz", "f.geojson", "f.geojson", 4);
}

/// The footprint of the house, thrice beside each other, as well-known binary.
fn outlines() -> [Vec<u8>; 3] {
    [0.0, 12.0, 24.0].map(|west| {
        let mut bytes = vec![1];
        for number in [3_u32, 1, 5] {
            bytes.extend(number.to_le_bytes());
        }
        for [x, y] in [[0.0, 0.0], [10.0, 0.0], [10.0, 8.0], [0.0, 8.0], [0.0, 0.0]] {
            bytes.extend([CORNER[0] + west + x, CORNER[1] + y].iter().flat_map(|c| f64::to_le_bytes(*c)));
        }
        bytes
    })
}

/// A database of small pages, so that much of it is not empty.
fn database(path: &Path, tables: &str, blobs: impl Iterator<Item = Vec<u8>>) {
    let database = rusqlite::Connection::open(path).unwrap();
    database.execute_batch(&format!("PRAGMA page_size = 512; {tables}")).unwrap();
    for (i, blob) in blobs.enumerate() {
        database.execute("INSERT INTO pand VALUES (?1, ?2, ?3)", (i, blob, format!("house {i}"))).unwrap();
    }
}

#[test]
fn random_damage_to_a_geopackage() {
    let folder = house_folder();
    let tables = "CREATE TABLE gpkg_contents (table_name TEXT, data_type TEXT, srs_id INTEGER);
        CREATE TABLE gpkg_geometry_columns (table_name TEXT, column_name TEXT, geometry_type_name TEXT, srs_id INTEGER);
        CREATE TABLE gpkg_spatial_ref_sys
            (srs_id INTEGER, organization TEXT, organization_coordsys_id INTEGER, definition TEXT);
        INSERT INTO gpkg_spatial_ref_sys VALUES (28992, 'EPSG', 28992, 'undefined');
        INSERT INTO gpkg_contents VALUES ('pand', 'features', 28992);
        INSERT INTO gpkg_geometry_columns VALUES ('pand', 'geom', 'POLYGON', 28992);
        CREATE TABLE pand (fid INTEGER PRIMARY KEY, geom BLOB, id TEXT);";
    let header = [b"GP\0\x01".as_slice(), &28992_i32.to_le_bytes()].concat();
    let blobs = outlines().map(|wkb| [header.as_slice(), &wkb].concat());
    database(&folder.path().join("f.gpkg"), tables, blobs.into_iter());
    assert!(run_in(folder.path(), "house.laz", "f.gpkg", "").code != 1);
    survives(folder.path(), "house.laz", "f.gpkg", "f.gpkg", 7);
}

#[test]
fn random_damage_to_a_spatialite_file() {
    let folder = house_folder();
    let tables = "CREATE TABLE geometry_columns (f_table_name TEXT, f_geometry_column TEXT, geometry_type INTEGER,
            coord_dimension INTEGER, srid INTEGER, spatial_index_enabled INTEGER);
        CREATE TABLE spatial_ref_sys
            (srid INTEGER, auth_name TEXT, auth_srid INTEGER, ref_sys_name TEXT, proj4text TEXT, srtext TEXT);
        INSERT INTO geometry_columns VALUES ('pand', 'geom', 3, 2, 28992, 0);
        INSERT INTO spatial_ref_sys VALUES (28992, 'epsg', 28992, '', '', '');
        CREATE TABLE pand (fid INTEGER PRIMARY KEY, geom BLOB, id TEXT);";
    let bounds: Vec<u8> = [CORNER[0], CORNER[1], CORNER[0] + 34.0, CORNER[1] + 8.0].map(f64::to_le_bytes).concat();
    let header = [[0, 1].as_slice(), &28992_i32.to_le_bytes(), &bounds, &[0x7C]].concat();
    let blobs = outlines().map(|wkb| [header.as_slice(), &wkb[1..], &[0xFE]].concat());
    database(&folder.path().join("f.sqlite"), tables, blobs.into_iter());
    assert!(run_in(folder.path(), "house.laz", "f.sqlite", "").code != 1);
    survives(folder.path(), "house.laz", "f.sqlite", "f.sqlite", 8);
}

#[test]
fn random_damage_to_a_flatgeobuf_file() {
    use flatgeobuf::{ColumnType, FgbCrs, FgbWriter, FgbWriterOptions, GeometryType};
    use geozero::{ColumnValue, PropertyProcessor};
    let folder = house_folder();
    let options =
        FgbWriterOptions { crs: FgbCrs { code: 28992, ..Default::default() }, write_index: true, ..Default::default() };
    let mut writer = FgbWriter::create_with_options("panden", GeometryType::Polygon, options).unwrap();
    writer.add_column("id", ColumnType::String, |_, _| {});
    for west in [0.0, 12.0, 24.0] {
        let (x, y) = (CORNER[0] + west, CORNER[1]);
        let shape = geo::Geometry::Polygon(geo::Rect::new((x, y), (x + 10.0, y + 8.0)).to_polygon());
        let id = format!("house {west}");
        writer
            .add_feature_geom(shape, |feature| {
                feature.property(0, "id", &ColumnValue::String(&id)).unwrap();
            })
            .unwrap();
    }
    let mut bytes = Vec::new();
    writer.write(&mut bytes).unwrap();
    std::fs::write(folder.path().join("f.fgb"), &bytes[..bytes.len() - 9]).unwrap();
    let cut_off = run_in(folder.path(), "house.laz", "f.fgb", "");
    assert_ends(&cut_off, 2, &["f.fgb: it is cut off: 1 of 3 features are missing"]);
    std::fs::write(folder.path().join("f.fgb"), bytes).unwrap();
    assert!(run_in(folder.path(), "house.laz", "f.fgb", "").code != 1);
    survives(folder.path(), "house.laz", "f.fgb", "f.fgb", 9);
}
