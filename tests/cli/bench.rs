//! The test bench: the built command, the bundled data, and small clouds made on the spot.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use las::{Builder, Point, Vlr, Writer};
use serde_json::{Value, json};

/// WKT of a system in degrees.
pub const WGS84: &str = r#"GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563,AUTHORITY["EPSG","7030"]],AUTHORITY["EPSG","6326"]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433],AUTHORITY["EPSG","4326"]]"#;

/// WKT of a system in metres that is not that of the Netherlands.
pub const UTM31: &str = r#"PROJCS["ETRS89 / UTM zone 31N",GEOGCS["ETRS89",DATUM["European_Terrestrial_Reference_System_1989",SPHEROID["GRS 1980",6378137,298.257222101]],PRIMEM["Greenwich",0],UNIT["degree",0.0174532925199433]],PROJECTION["Transverse_Mercator"],PARAMETER["latitude_of_origin",0],PARAMETER["central_meridian",3],PARAMETER["scale_factor",0.9996],PARAMETER["false_easting",500000],PARAMETER["false_northing",0],UNIT["metre",1],AUTHORITY["EPSG","25831"]]"#;

/// A file of the bundled data.
pub fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/data").join(name)
}

/// What a command left behind.
pub struct Run {
    /// Its exit code.
    pub code: i32,
    /// Its standard output.
    pub out: String,
    /// Its standard error.
    pub err: String,
}

impl From<Output> for Run {
    fn from(output: Output) -> Self {
        Self {
            code: output.status.code().expect("ended by a signal"),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }
}

/// The command with these arguments.
pub fn command<A: AsRef<std::ffi::OsStr>>(args: impl IntoIterator<Item = A>) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gable"));
    command.args(args);
    command
}

/// Runs it.
pub fn gable<A: AsRef<std::ffi::OsStr>>(args: impl IntoIterator<Item = A>) -> Run {
    command(args).output().unwrap().into()
}

/// `gable reconstruct TILES --footprints FILE -o OUT REST`, blanks in `rest` part its arguments.
pub fn reconstruct(tiles: &[&Path], footprints: &Path, out: &Path, rest: &str) -> Run {
    let mut command = command(["reconstruct"]);
    command.args(tiles).arg("--footprints").arg(footprints).arg("-o").arg(out).args(rest.split_whitespace());
    command.output().unwrap().into()
}

/// The quick start.
pub fn delft(out: &Path, rest: &str) -> Run {
    reconstruct(&[&data("delft_ahn3.laz")], &data("footprints.geojson"), out, rest)
}

/// A JSON file.
pub fn json_of(path: impl AsRef<Path>) -> Value {
    let path = path.as_ref();
    serde_json::from_slice(&std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))).unwrap()
}

/// A CityJSON file has neither an error nor a warning by its schema and by cjval's checks beyond it.
pub fn assert_valid(model: &Path) {
    let validator = cjval::CJValidator::from_str(&std::fs::read_to_string(model).unwrap());
    for (check, summary) in validator.validate() {
        assert!(summary.get_errors().is_empty(), "{check}: {:?}", summary.get_errors());
    }
}

/// The report next to a model; it satisfies the checked-in schema, and no model of it fits worse than its block.
pub fn report_of(model: &Path) -> Value {
    let report = json_of(format!("{}.report.json", model.display()));
    let schema = json_of(Path::new(env!("CARGO_MANIFEST_DIR")).join("schemas/report.schema.json"));
    let validator = jsonschema::validator_for(&schema).unwrap();
    let faults: Vec<String> = validator.iter_errors(&report).map(|e| format!("{}: {e}", e.instance_path())).collect();
    assert!(faults.is_empty(), "{faults:#?}");
    for building in report["buildings"].as_array().unwrap() {
        if let [Some(model), Some(block)] = ["rmse_lod22", "rmse_lod12"].map(|lod| building[lod].as_f64()) {
            assert!(model <= block + 0.021, "{building:#}");
        }
    }
    report
}

/// South-west corner of the made-up neighbourhood, in the Dutch system.
pub const CORNER: [f64; 2] = [85_000.0, 447_000.0];

/// A made-up tile with a flat roof of class `class` at 6 m over [0, 10] × [0, 8] and ground at 0 m around it, two
/// points per metre each way.
pub fn write_house(path: &Path, wkt: Option<&str>, class: u8) {
    write_house_at(0.0, path, wkt, class);
}

/// Two tiles beside each other, west.laz and east.laz, that do not name their CRS, with such a house each, 40 m apart.
pub fn write_two_houses(folder: &Path) {
    write_house_at(0.0, &folder.join("west.laz"), None, 6);
    write_house_at(40.0, &folder.join("east.laz"), None, 6);
}

/// The same so many metres to the east.
fn write_house_at(east: f64, path: &Path, wkt: Option<&str>, class: u8) {
    let mut points = Vec::new();
    for i in -20..40 {
        for j in -20..36 {
            let (x, y) = (f64::from(i) * 0.5 + 0.25, f64::from(j) * 0.5 + 0.25);
            let roof = (0.0..10.0).contains(&x) && (0.0..8.0).contains(&y);
            let (z, class) = if roof { (6.0, class) } else { (0.0, 2) };
            points.push((CORNER[0] + east + x, CORNER[1] + y, z, class));
        }
    }
    write_tile(path, wkt, &points);
}

/// A made-up tile: x, y, z and class of each point.
pub fn write_tile(path: &Path, wkt: Option<&str>, points: &[(f64, f64, f64, u8)]) {
    let mut builder = Builder::from((1, 4));
    builder.point_format = las::point::Format::new(6).unwrap();
    builder.point_format.is_compressed = path.extension().is_some_and(|e| e == "laz");
    let (offset_x, offset_y) = points.first().map_or((0.0, 0.0), |p| (p.0.floor(), p.1.floor()));
    builder.transforms = las::Vector {
        x: las::Transform { scale: 0.001, offset: offset_x },
        y: las::Transform { scale: 0.001, offset: offset_y },
        z: las::Transform { scale: 0.001, offset: 0.0 },
    };
    if let Some(wkt) = wkt {
        builder.has_wkt_crs = true;
        builder.vlrs.push(Vlr {
            user_id: "LASF_Projection".into(),
            record_id: 2112,
            description: "WKT".into(),
            data: wkt.as_bytes().to_vec(),
        });
    }
    let mut writer = Writer::from_path(path, builder.into_header().unwrap()).unwrap();
    for &(x, y, z, class) in points {
        let classification = las::point::Classification::new(class).unwrap();
        writer.write_point(Point { x, y, z, classification, gps_time: Some(0.0), ..Point::default() }).unwrap();
    }
    writer.close().unwrap();
}

/// Cuts a tile at its middle, west to east and south to north.
pub fn cut_into_four(tile: &Path, folder: &Path) -> Vec<PathBuf> {
    let mut reader = las::Reader::from_path(tile).unwrap();
    let header = reader.header().clone();
    let points = reader.read_all().unwrap();
    let bounds = header.bounds();
    let (x, y) = (bounds.min.x.midpoint(bounds.max.x), bounds.min.y.midpoint(bounds.max.y));
    let names = ["sw", "se", "nw", "ne"].map(|name| folder.join(format!("{name}.laz")));
    let mut writers = names.clone().map(|name| Writer::from_path(name, header.clone()).unwrap());
    for point in points.points().map(Result::unwrap) {
        let quarter = usize::from(point.x >= x) + 2 * usize::from(point.y >= y);
        writers[quarter].write_point(point).unwrap();
    }
    for mut writer in writers {
        writer.close().unwrap();
    }
    names.into()
}

/// A GeoJSON file in the Dutch system: features of an id and a geometry.
pub fn write_footprints(path: &Path, features: &[(&str, Value)]) {
    let features: Vec<Value> = features
        .iter()
        .map(|(id, geometry)| json!({"type": "Feature", "properties": {"id": id}, "geometry": geometry}))
        .collect();
    let crs = json!({"type": "name", "properties": {"name": "urn:ogc:def:crs:EPSG::28992"}});
    let file = json!({"type": "FeatureCollection", "crs": crs, "features": features});
    std::fs::write(path, file.to_string()).unwrap();
}

/// A rectangle in the made-up neighbourhood.
pub fn rectangle(west: f64, south: f64, east: f64, north: f64) -> Value {
    let ring = [[west, south], [east, south], [east, north], [west, north], [west, south]];
    let ring: Vec<_> = ring.iter().map(|c| [c[0] + CORNER[0], c[1] + CORNER[1]]).collect();
    json!({"type": "Polygon", "coordinates": [ring]})
}

/// A line in the made-up neighbourhood: no footprint.
pub fn line() -> Value {
    json!({"type": "LineString", "coordinates": [CORNER, [CORNER[0] + 5.0, CORNER[1]]]})
}

/// The folder of shared data that is not part of the repository; `None`, and a line that says so, where it is not there.
pub fn shared(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data").join(name);
    if !path.exists() {
        println!("skipped: shared data not found");
        return None;
    }
    Some(path)
}

/// A folder with a made-up house of building class 6, `house.laz`, and its footprint 007, `footprints.geojson`.
pub fn house_folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_house(&folder.path().join("house.laz"), None, 6);
    write_footprints(&folder.path().join("footprints.geojson"), &[("007", rectangle(0.0, 0.0, 10.0, 8.0))]);
    folder
}

/// Reconstructs these files of a folder, blanks part their names, to `out.city.json` in it.
pub fn run_in(folder: &Path, tiles: &str, footprints: &str, rest: &str) -> Run {
    let tiles: Vec<PathBuf> = tiles.split_whitespace().map(|tile| folder.join(tile)).collect();
    let tiles: Vec<&Path> = tiles.iter().map(PathBuf::as_path).collect();
    reconstruct(&tiles, &folder.join(footprints), &folder.join("out.city.json"), &format!("--crs EPSG:7415 {rest}"))
}

/// Asserts that a command ended with this exit code and said these things on standard error.
pub fn assert_ends(run: &Run, code: i32, says: &[&str]) {
    assert_eq!(run.code, code, "{}{}", run.out, run.err);
    assert_says(&run.err, says);
}

/// The names of all that is in a folder, sorted.
pub fn names_in(folder: &Path) -> Vec<String> {
    let names = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name());
    let mut names: Vec<String> = names.map(|name| name.to_string_lossy().into_owned()).collect();
    names.sort();
    names
}

/// Asserts that `text` contains each of `parts`.
pub fn assert_says(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{part:?} is not in:\n{text}");
    }
}
