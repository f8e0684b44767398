//! The tables that every GeoPackage has (OGC 12-128r17), and the extensions that ours has.

use rusqlite::{Connection, Result, params};

use crate::source::crs::Crs;

/// `GPKG` and version 1.3.0 (clause 1.1.1): nothing here needs a later one, and GDAL before 3.7 warns of it.
const APPLICATION_ID: i64 = 0x4750_4B47;
const USER_VERSION: i64 = 10_300;
/// The time of last change, which the format demands and which must not differ from run to run.
pub(super) const NO_TIME: &str = "1970-01-01T00:00:00.000Z";
/// The `srs_id` of plane coordinates of an unknown system (clause 1.1.2.1.2).
const UNDEFINED: i32 = -1;
/// Where ids of systems without a code of EPSG begin.
const OWN: i32 = 100_000;

const TABLES: &str = "
CREATE TABLE gpkg_spatial_ref_sys (
  srs_name TEXT NOT NULL, srs_id INTEGER PRIMARY KEY, organization TEXT NOT NULL,
  organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT,
  definition_12_063 TEXT NOT NULL DEFAULT 'undefined');
CREATE TABLE gpkg_contents (
  table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT UNIQUE, description TEXT DEFAULT '',
  last_change DATETIME NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')),
  min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER,
  CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id));
CREATE TABLE gpkg_geometry_columns (
  table_name TEXT NOT NULL, column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL, srs_id INTEGER NOT NULL,
  z TINYINT NOT NULL, m TINYINT NOT NULL,
  CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name), CONSTRAINT uk_gc_table_name UNIQUE (table_name),
  CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name),
  CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys (srs_id));
CREATE TABLE gpkg_extensions (
  table_name TEXT, column_name TEXT, extension_name TEXT NOT NULL, definition TEXT NOT NULL, scope TEXT NOT NULL,
  CONSTRAINT ge_tce UNIQUE (table_name, column_name, extension_name));
CREATE TABLE layer_styles (
  id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, f_table_catalog TEXT, f_table_schema TEXT, f_table_name TEXT,
  f_geometry_column TEXT, styleName TEXT, styleQML TEXT, styleSLD TEXT, useAsDefault BOOLEAN, description TEXT,
  owner TEXT, ui TEXT, update_time DATETIME);
INSERT INTO gpkg_spatial_ref_sys VALUES
  ('Undefined Cartesian SRS', -1, 'NONE', -1, 'undefined', 'undefined Cartesian coordinate reference system',
   'undefined'),
  ('Undefined geographic SRS', 0, 'NONE', 0, 'undefined', 'undefined geographic coordinate reference system',
   'undefined');
INSERT INTO gpkg_extensions VALUES
  ('gpkg_spatial_ref_sys', 'definition_12_063', 'gpkg_crs_wkt', 'http://www.geopackage.org/spec/#extension_crs_wkt',
   'read-write');
";

/// Settings for a file that nobody sees before it is whole: no journal, no waiting for the disk. Little memory, whatever its
/// size.
const SETTINGS: &str = "PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; PRAGMA locking_mode = EXCLUSIVE;
PRAGMA cache_size = -8192; PRAGMA page_size = 4096;";

/// Makes the tables of an empty GeoPackage; returns the id of the CRS.
pub(super) fn create(connection: &Connection, crs: Option<&Crs>) -> Result<i32> {
    connection.execute_batch(SETTINGS)?;
    connection.execute_batch(&format!(
        "PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = {USER_VERSION}; BEGIN; {TABLES}"
    ))?;
    // A reader that knows WGS 84 alone must find it.
    let wgs84 = Crs::parse("EPSG:4326").ok();
    let known = [crs, wgs84.as_ref()];
    let mut id = UNDEFINED;
    for (i, system) in known.into_iter().enumerate() {
        let Some(system) = system else { continue };
        let code = system.code.as_deref().and_then(|code| code.split_once(':'));
        let own = code.and_then(|(authority, code)| Some((authority, code.parse::<i32>().ok()?)));
        let (organization, code) = own.unwrap_or(("NONE", OWN));
        let srs_id = if organization == "EPSG" { code } else { OWN };
        connection.execute(
            "INSERT OR IGNORE INTO gpkg_spatial_ref_sys VALUES (?, ?, ?, ?, ?, ?, ?)",
            params![
                system.name,
                srs_id,
                organization,
                code,
                system.wkt1().as_deref().unwrap_or("undefined"),
                Option::<&str>::None,
                system.wkt
            ],
        )?;
        if i == 0 {
            id = srs_id;
        }
    }
    Ok(id)
}

/// Registers a table of geometries with its bounds.
pub(super) fn register(
    connection: &Connection,
    table: &str,
    description: &str,
    has_z: bool,
    srs: i32,
    bounds: Option<[f64; 4]>,
) -> Result<()> {
    let [x0, y0, x1, y1] = bounds.map_or([None; 4], |b| b.map(Some));
    connection.execute(
        "INSERT INTO gpkg_contents VALUES (?, 'features', ?, ?, ?, ?, ?, ?, ?, ?)",
        params![table, table, description, NO_TIME, x0, y0, x1, y1, srs],
    )?;
    connection.execute(
        "INSERT INTO gpkg_geometry_columns VALUES (?, 'geom', 'MULTIPOLYGON', ?, ?, 0)",
        params![table, srs, i32::from(has_z)],
    )?;
    connection.execute(
        "INSERT INTO gpkg_extensions VALUES (?, 'geom', 'gpkg_rtree_index', \
         'http://www.geopackage.org/spec/#extension_rtree', 'write-only')",
        params![table],
    )?;
    Ok(())
}

/// Keeps a style for QGIS.
pub(super) fn style(connection: &Connection, table: &str, qml: &str) -> Result<()> {
    connection.execute(
        "INSERT INTO layer_styles VALUES (NULL, '', '', ?, 'geom', 'gable', ?, NULL, 1, '', '', NULL, ?)",
        params![table, qml, NO_TIME],
    )?;
    Ok(())
}

/// Lists the table of styles, which is none of the standard's.
pub(super) fn register_styles(connection: &Connection) -> Result<()> {
    connection.execute(
        "INSERT INTO gpkg_contents (table_name, data_type, identifier, last_change) \
         VALUES ('layer_styles', 'attributes', 'layer_styles', ?)",
        params![NO_TIME],
    )?;
    Ok(())
}

/// The triggers that keep the spatial index right when someone edits the table (annex F.3).
pub(super) fn index_triggers(connection: &Connection, table: &str) -> Result<()> {
    let index = format!("rtree_{table}_geom");
    let box_of = "NEW.fid, ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom)";
    let is_there = "(NEW.geom NOTNULL AND NOT ST_IsEmpty(NEW.geom))";
    let is_gone = "(NEW.geom ISNULL OR ST_IsEmpty(NEW.geom))";
    let put = format!("INSERT OR REPLACE INTO {index} VALUES ({box_of})");
    let triggers = [
        ("insert", "INSERT", format!("WHEN {is_there} BEGIN {put};")),
        ("update1", "UPDATE OF geom", format!("WHEN OLD.fid = NEW.fid AND {is_there} BEGIN {put};")),
        (
            "update2",
            "UPDATE OF geom",
            format!("WHEN OLD.fid = NEW.fid AND {is_gone} BEGIN DELETE FROM {index} WHERE id = OLD.fid;"),
        ),
        (
            "update3",
            "UPDATE",
            format!("WHEN OLD.fid != NEW.fid AND {is_there} BEGIN DELETE FROM {index} WHERE id = OLD.fid; {put};"),
        ),
        (
            "update4",
            "UPDATE",
            format!("WHEN OLD.fid != NEW.fid AND {is_gone} BEGIN DELETE FROM {index} WHERE id IN (OLD.fid, NEW.fid);"),
        ),
        ("delete", "DELETE", format!("WHEN OLD.geom NOTNULL BEGIN DELETE FROM {index} WHERE id = OLD.fid;")),
    ];
    for (name, event, body) in triggers {
        connection.execute_batch(&format!("CREATE TRIGGER {index}_{name} AFTER {event} ON {table} {body} END;"))?;
    }
    Ok(())
}
