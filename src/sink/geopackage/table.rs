//! A table of attributes with a geometry, whose columns become known with its rows.

use std::collections::BTreeSet;

use rusqlite::types::Value as Cell;
use rusqlite::{Connection, Result, params_from_iter};
use serde_json::{Map, Value};

use super::blob::{Polygons, bounds, multipolygon};
use crate::sink::columns::{Column, Columns, Kind, text_of};

/// The most columns that `SQLite` holds in a table, less those that a reader may want to add.
const MOST_COLUMNS: usize = 1990;

/// A table that is being filled.
pub(super) struct Table {
    name: &'static str,
    /// Its text columns that every row has.
    fixed: &'static [&'static str],
    columns: Columns,
    /// The fixed columns from which an attribute of the same name differs in some row.
    differing: BTreeSet<&'static str>,
    /// How many of the columns the table has.
    made: usize,
    bounds: Option<[f64; 4]>,
    rows: i64,
}

/// The type of a column in SQL (OGC 12-128r19, table 1).
fn sql_type(kind: Option<Kind>) -> &'static str {
    match kind {
        Some(Kind::Boolean) => "BOOLEAN",
        Some(Kind::Integer { .. }) => "INTEGER",
        Some(Kind::Real) => "REAL",
        Some(Kind::Text) | None => "TEXT",
    }
}

/// A name as SQL wants it.
fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\"").replace('\0', ""))
}

/// A value as `SQLite` keeps it.
fn cell(value: &Value) -> Cell {
    match value {
        Value::Null => Cell::Null,
        Value::Bool(b) => Cell::Integer(i64::from(*b)),
        Value::Number(n) => match (n.as_i64(), n.as_f64()) {
            (Some(n), _) => Cell::Integer(n),
            (None, Some(real)) if !n.is_u64() => Cell::Real(real),
            _ => Cell::Text(n.to_string()),
        },
        other => Cell::Text(text_of(other)),
    }
}

impl Table {
    /// Makes the table with the columns that every row has, all of them text, and its spatial index.
    pub(super) fn create(connection: &Connection, name: &'static str, fixed: &'static [&'static str]) -> Result<Self> {
        connection.execute_batch(&format!(
            "CREATE TABLE {name} ({}); CREATE VIRTUAL TABLE rtree_{name}_geom USING rtree(id, minx, maxx, miny, maxy);",
            definition(fixed, &[])
        ))?;
        let reserved: Vec<&str> = ["fid", "geom"].iter().chain(fixed).copied().collect();
        let columns = Columns::new(&reserved);
        Ok(Self { name, fixed, columns, differing: BTreeSet::new(), made: 0, bounds: None, rows: 0 })
    }

    pub(super) fn bounds(&self) -> Option<[f64; 4]> {
        self.bounds
    }

    /// What is to be told of attributes whose columns have other names. An attribute that says what a column of the format
    /// says as well is not told.
    pub(super) fn renamed(&self) -> Option<String> {
        let same: Vec<&str> = self.fixed.iter().filter(|name| !self.differing.contains(*name)).copied().collect();
        self.columns.renamed(&same).map(|told| format!("{}: {told}", self.name))
    }

    /// Adds a row. `Ok(false)` when its attributes would need more columns than a table can have.
    pub(super) fn insert<const D: usize>(
        &mut self,
        connection: &Connection,
        fixed: &[&str],
        attributes: &Map<String, Value>,
        polygons: &Polygons<D>,
        srs: i32,
    ) -> Result<bool> {
        self.columns.see(attributes);
        for (name, own) in self.fixed.iter().zip(fixed) {
            if attributes.get(*name).is_some_and(|value| !value.is_null() && text_of(value) != *own) {
                self.differing.insert(name);
            }
        }
        if self.columns.list().len() + self.fixed.len() > MOST_COLUMNS {
            return Ok(false);
        }
        for column in self.columns.list().iter().skip(self.made) {
            // Without a type as yet, so that SQLite keeps every value as it is: a whole number stays one, and "007" a text.
            connection.execute_batch(&format!("ALTER TABLE {} ADD COLUMN {}", self.name, quoted(&column.name)))?;
        }
        self.made = self.columns.list().len();
        self.rows += 1;
        let bounds = bounds(polygons);
        let geometry = bounds.map(|bounds| multipolygon(polygons, bounds, srs));
        let mut cells = vec![Cell::Integer(self.rows), geometry.map_or(Cell::Null, Cell::Blob)];
        cells.extend(fixed.iter().map(|text| Cell::Text((*text).to_owned())));
        let value = |column: &Column| attributes.get(&column.attribute).map_or(Cell::Null, cell);
        cells.extend(self.columns.list().iter().map(value));
        let places = vec!["?"; cells.len()].join(",");
        connection
            .prepare_cached(&format!("INSERT INTO {} VALUES ({places})", self.name))?
            .execute(params_from_iter(cells))?;
        if let Some([x0, y0, x1, y1]) = bounds {
            let index = format!("INSERT INTO rtree_{}_geom VALUES (?, ?, ?, ?, ?)", self.name);
            connection.prepare_cached(&index)?.execute((self.rows, x0, x1, y0, y1))?;
            let [a, b, c, d] = self.bounds.unwrap_or([x0, y0, x1, y1]);
            self.bounds = Some([a.min(x0), b.min(y0), c.max(x1), d.max(y1)]);
        }
        Ok(true)
    }

    /// Gives every column the type that holds all its values.
    pub(super) fn finish(&mut self, connection: &Connection) -> Result<()> {
        let (name, columns) = (self.name, self.columns.list());
        for column in columns.iter().filter(|column| matches!(column.kind, Some(Kind::Text) | None)) {
            let column = quoted(&column.name);
            connection.execute_batch(&format!(
                "UPDATE {name} SET {column} = CAST({column} AS TEXT) WHERE typeof({column}) IN ('integer', 'real')"
            ))?;
        }
        // The declared types change nothing of what is stored: SQLite documents this way to change them ("ALTER TABLE",
        // section 7), which spares a copy of the whole table.
        let sql = format!("CREATE TABLE {name} ({})", definition(self.fixed, columns));
        let version: i64 = connection.pragma_query_value(None, "schema_version", |row| row.get(0))?;
        connection.execute_batch("PRAGMA writable_schema = ON")?;
        connection.execute("UPDATE sqlite_schema SET sql = ? WHERE type = 'table' AND name = ?", (sql, name))?;
        connection.execute_batch(&format!("PRAGMA schema_version = {}; PRAGMA writable_schema = OFF", version + 1))
    }
}

/// The columns of a table in SQL.
fn definition(fixed: &[&str], columns: &[Column]) -> String {
    let own = ["fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL", "geom MULTIPOLYGON"].map(str::to_owned);
    let fixed = fixed.iter().map(|name| format!("{name} TEXT"));
    let columns = columns.iter().map(|column| format!("{} {}", quoted(&column.name), sql_type(column.kind)));
    own.into_iter().chain(fixed).chain(columns).collect::<Vec<_>>().join(", ")
}
