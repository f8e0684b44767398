//! GeoPackage (OGC 12-128r19) and SpatiaLite, both in `SQLite`; also `SQLite` files in which GDAL keeps plain WKB.

use std::collections::HashMap;
use std::path::Path;

use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags, OptionalExtension, Row};
use serde_json::{Map, Number, Value};

use super::reference_system::crs_of_listing;
use super::sqlite_bounds::{Allowance, bound, is_without_end};
use super::{FootprintOptions, LayerInfo, RawFeature, Sink, names, wkb};
use crate::error::{Error, InputError, Result};
use crate::source::crs::Crs;

/// Lists the layers of a GeoPackage: table, geometry column, type, SRID.
const GEOPACKAGE_LAYERS: &str = "SELECT c.table_name, g.column_name, g.geometry_type_name, g.srs_id \
    FROM gpkg_geometry_columns g JOIN gpkg_contents c ON lower(c.table_name) = lower(g.table_name) \
    ORDER BY c.table_name";
/// Lists the layers of a SpatiaLite file in the same columns.
const SPATIALITE_LAYERS: &str =
    "SELECT f_table_name, f_geometry_column, %TYPE%, srid FROM geometry_columns ORDER BY f_table_name";
/// Geometry types that can hold polygons, by name and by number (modulo 1000).
const POLYGON_TYPES: [&str; 12] = [
    "GEOMETRY",
    "POLYGON",
    "MULTIPOLYGON",
    "GEOMETRYCOLLECTION",
    "SURFACE",
    "MULTISURFACE",
    "CURVEPOLYGON",
    "0",
    "3",
    "6",
    "7",
    "12",
];

/// A table with geometry.
struct Layer {
    table: String,
    column: String,
    can_hold_polygons: bool,
    srid: Option<i64>,
}

/// Reads a GeoPackage or SpatiaLite file.
pub(super) fn read(path: &Path, options: &FootprintOptions, sink: Sink<'_>) -> Result<LayerInfo> {
    let fault = |error: rusqlite::Error| {
        if is_without_end(&error) {
            let found = format!("tables or views without end ({error})");
            return InputError::new(path, found, "features that come to an end").remedy(
                "A view can be a program that never ends: write what is wanted of it into a table, and read that",
            );
        }
        InputError::new(path, error.to_string(), "a readable SQLite database")
    };
    let size = std::fs::metadata(path).map_err(|e| Error::io(path, "open", e))?.len();
    let connection = open(path).map_err(fault)?;
    let mut allowance = bound(&connection, size).map_err(fault)?;
    let is_geopackage = has_table(&connection, "gpkg_contents").map_err(fault)?;
    if !is_geopackage && !has_table(&connection, "geometry_columns").map_err(fault)? {
        return Err(
            InputError::new(path, "an SQLite database without layers", "a GeoPackage or SpatiaLite file").into()
        );
    }
    let layers = layers(&connection, is_geopackage).map_err(fault)?;
    let layer = choose(path, &layers, options)?;
    let mut info = LayerInfo { layer: layer.table.clone(), ..LayerInfo::default() };
    info.crs = crs_of(path, &connection, layer, is_geopackage, options)?;
    let mut blobs = HashMap::new();
    features(&connection, layer, sink, &mut info.columns, &mut blobs, &mut allowance).map_err(fault)?;
    let mut blobs: Vec<_> = blobs.into_iter().collect();
    blobs.sort_unstable();
    info.warnings.extend(
        blobs
            .into_iter()
            .map(|(column, count)| format!("attribute `{column}` is binary in {count} features and was left out")),
    );
    Ok(info)
}

/// Opens read-only. A database in write-ahead mode in a folder that cannot be written needs `immutable`.
fn open(path: &Path) -> rusqlite::Result<Connection> {
    let probe = |connection: Connection| {
        connection.query_row("SELECT count(*) FROM sqlite_master", [], |_| Ok(()))?;
        Ok(connection)
    };
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    Connection::open_with_flags(path, flags).and_then(probe).or_else(|error| {
        let escaped: String = path
            .to_string_lossy()
            .chars()
            .map(|c| match c {
                '%' => "%25".to_string(),
                '?' => "%3f".to_string(),
                '#' => "%23".to_string(),
                c => c.to_string(),
            })
            .collect();
        Connection::open_with_flags(format!("file:{escaped}?immutable=1"), flags | OpenFlags::SQLITE_OPEN_URI)
            .and_then(probe)
            .map_err(|_| error)
    })
}

fn has_table(connection: &Connection, name: &str) -> rusqlite::Result<bool> {
    connection.query_row("SELECT count(*) > 0 FROM sqlite_master WHERE lower(name) = ?1", [name], |row| row.get(0))
}

/// The names and declared types of the columns of a table.
fn columns(connection: &Connection, table: &str) -> rusqlite::Result<Vec<(String, String)>> {
    connection
        .prepare("SELECT name, type FROM pragma_table_info(?1)")?
        .query_map([table], |row| Ok((row.get(0)?, row.get(1)?)))?
        .collect()
}

fn layers(connection: &Connection, is_geopackage: bool) -> rusqlite::Result<Vec<Layer>> {
    let sql = if is_geopackage {
        GEOPACKAGE_LAYERS.to_string()
    } else {
        // The column of the type has changed its name between versions.
        let columns = columns(connection, "geometry_columns")?;
        let kind = columns.iter().find(|(name, _)| name == "geometry_type" || name == "type");
        SPATIALITE_LAYERS.replace("%TYPE%", kind.map_or("0", |(name, _)| name))
    };
    connection
        .prepare(&sql)?
        .query_map([], |row| {
            let kind = match row.get_ref(2)? {
                ValueRef::Integer(number) => (number % 1000).to_string(),
                ValueRef::Text(name) => String::from_utf8_lossy(name).to_uppercase(),
                _ => "GEOMETRY".into(),
            };
            Ok(Layer {
                table: row.get(0)?,
                column: row.get(1)?,
                can_hold_polygons: POLYGON_TYPES.contains(&kind.as_str()),
                srid: row.get(3)?,
            })
        })?
        .collect()
}

/// The layer asked for; else the only one; else the only one that can hold polygons.
fn choose<'a>(path: &Path, layers: &'a [Layer], options: &FootprintOptions) -> Result<&'a Layer> {
    let all = || layers.iter().map(|layer| layer.table.as_str()).collect::<Vec<_>>().join(", ");
    if let Some(wanted) = &options.layer {
        let exact = layers.iter().find(|layer| layer.table == *wanted);
        return exact.or_else(|| layers.iter().find(|layer| layer.table.eq_ignore_ascii_case(wanted))).ok_or_else(
            || {
                InputError::new(path, format!("no layer `{wanted}`"), "a layer of the file")
                    .remedy(names::remedy(wanted, layers.iter().map(|layer| layer.table.as_str())))
                    .into()
            },
        );
    }
    let mut candidates = layers.iter().filter(|layer| layer.can_hold_polygons || layers.len() == 1);
    match (candidates.next(), candidates.next()) {
        (Some(only), None) => Ok(only),
        (None, _) => Err(InputError::new(path, "no layer with polygons", "a layer with polygons")
            .remedy(if layers.is_empty() { String::new() } else { format!("There are: {}", all()) })
            .into()),
        (Some(_), Some(_)) => {
            Err(InputError::new(path, format!("{} layers", layers.len()), "the name of the layer to read")
                .remedy(format!("Name one of: {}", all()))
                .into())
        }
    }
}

fn crs_of(
    path: &Path,
    connection: &Connection,
    layer: &Layer,
    is_geopackage: bool,
    options: &FootprintOptions,
) -> Result<Option<Crs>> {
    // 0 and −1 mean: undefined (GeoPackage, section 1.1.2.1.2; SpatiaLite likewise).
    let Some(srid) = layer.srid.filter(|srid| *srid > 0 && options.crs.is_none()) else { return Ok(None) };
    let sql = if is_geopackage {
        "SELECT organization || ':' || organization_coordsys_id, definition FROM gpkg_spatial_ref_sys WHERE srs_id = ?1"
    } else {
        "SELECT auth_name || ':' || auth_srid, srtext FROM spatial_ref_sys WHERE srid = ?1"
    };
    let row = |row: &Row<'_>| Ok((row.get::<_, Option<String>>(0)?, row.get::<_, Option<String>>(1).unwrap_or(None)));
    // SpatiaLite has kept the definition in columns of several names; the code is always there.
    let found = connection
        .query_row(sql, [srid], row)
        .optional()
        .or_else(|_| {
            let sql = "SELECT auth_name || ':' || auth_srid, NULL FROM spatial_ref_sys WHERE srid = ?1";
            connection.query_row(sql, [srid], row).optional()
        })
        .map_err(|error| InputError::new(path, error.to_string(), "a list of reference systems"))?;
    let (code, definition) = found.unwrap_or((None, None));
    crs_of_listing(path, srid, code, definition, options)
}

fn features(
    connection: &Connection,
    layer: &Layer,
    sink: Sink<'_>,
    names: &mut Vec<String>,
    blobs: &mut HashMap<String, usize>,
    allowance: &mut Allowance,
) -> rusqlite::Result<()> {
    let types: HashMap<String, String> =
        columns(connection, &layer.table)?.into_iter().map(|(name, kind)| (name, kind.to_uppercase())).collect();
    let mut statement = connection.prepare(&format!("SELECT * FROM \"{}\"", layer.table.replace('"', "\"\"")))?;
    let all: Vec<String> = statement.column_names().into_iter().map(str::to_string).collect();
    let geometry = all.iter().position(|name| name.eq_ignore_ascii_case(&layer.column));
    let is_boolean: Vec<bool> =
        all.iter().map(|name| types.get(name).is_some_and(|kind| kind.contains("BOOL"))).collect();
    names.extend(all.iter().enumerate().filter(|(i, _)| Some(*i) != geometry).map(|(_, name)| name.clone()));
    let mut rows = statement.query([])?;
    while let Some(row) = rows.next()? {
        let mut attributes = Map::new();
        let mut outline = Err("it has no geometry".to_string());
        for (i, name) in all.iter().enumerate() {
            let value = row.get_ref(i)?;
            allowance.take(name, value)?;
            if Some(i) == geometry {
                outline = match value {
                    ValueRef::Null => Err("it has no geometry".into()),
                    ValueRef::Blob(blob) => wkb::outline(blob),
                    _ => Err("its geometry is text or a number, not a blob".into()),
                };
                continue;
            }
            let value = match value {
                ValueRef::Blob(_) => {
                    *blobs.entry(name.clone()).or_default() += 1;
                    continue;
                }
                ValueRef::Integer(number @ (0 | 1)) if is_boolean[i] => Value::Bool(number == 1),
                ValueRef::Integer(number) => number.into(),
                ValueRef::Real(number) => Number::from_f64(number).map_or(Value::Null, Value::Number),
                ValueRef::Text(text) => String::from_utf8_lossy(text).into_owned().into(),
                ValueRef::Null => Value::Null,
            };
            attributes.insert(name.clone(), value);
        }
        sink(RawFeature { attributes, outline });
    }
    Ok(())
}
