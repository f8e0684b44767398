//! A table of attributes with a geometry, whose columns become known with its rows.

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
    /// Attributes that have said what a fixed column of their name says, as often as they were there.
    echoes: Vec<Echo>,
    /// The columns that the table has, beside the fixed ones: indices into [`Columns::list`].
    made: Vec<usize>,
    bounds: Option<[f64; 4]>,
    rows: i64,
}

/// An attribute of the name of a fixed column that says the same: the id of a building, most often. It needs no column of its
/// own.
struct Echo {
    attribute: String,
    /// The fixed column.
    column: &'static str,
    /// The rows in which it was there, from and to.
    rows: Vec<[i64; 2]>,
}

impl Echo {
    fn hear(&mut self, row: i64) {
        match self.rows.last_mut() {
            Some([_, last]) if *last + 1 == row => *last = row,
            _ => self.rows.push([row, row]),
        }
    }
}

/// The type of a column in SQL (OGC 12-128r17, table 1).
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
            definition(fixed, std::iter::empty())
        ))?;
        let reserved: Vec<&str> = ["fid", "geom"].iter().chain(fixed).copied().collect();
        let columns = Columns::new(&reserved);
        Ok(Self { name, fixed, columns, echoes: Vec::new(), made: Vec::new(), bounds: None, rows: 0 })
    }

    pub(super) fn bounds(&self) -> Option<[f64; 4]> {
        self.bounds
    }

    /// What is to be told of attributes whose columns have other names. An attribute that says what a column of the format
    /// says has none, and is not told.
    pub(super) fn renamed(&self) -> Option<String> {
        let same: Vec<&str> = self.echoes.iter().map(|echo| echo.attribute.as_str()).collect();
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
        self.rows += 1;
        let left = self.listen(fixed, attributes);
        self.columns.see(attributes);
        if self.columns.list().len() + self.fixed.len() > MOST_COLUMNS {
            return Ok(false);
        }
        self.add_columns(connection)?;
        for echo in left {
            self.part(connection, &echo)?;
        }
        let bounds = bounds(polygons);
        let geometry = bounds.map(|bounds| multipolygon(polygons, bounds, srs));
        let mut cells = vec![Cell::Integer(self.rows), geometry.map_or(Cell::Null, Cell::Blob)];
        cells.extend(fixed.iter().map(|text| Cell::Text((*text).to_owned())));
        let value = |column: &Column| attributes.get(&column.attribute).map_or(Cell::Null, cell);
        cells.extend(self.own_columns().map(value));
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

    /// The columns that are in the table beside the fixed ones, in its order.
    fn own_columns(&self) -> impl Iterator<Item = &Column> {
        self.made.iter().filter_map(|&i| self.columns.list().get(i))
    }

    /// Notes which attributes of a row say what a fixed column of their name says; gives those that no longer do.
    fn listen(&mut self, fixed: &[&str], attributes: &Map<String, Value>) -> Vec<Echo> {
        let is_known = |attribute: &str| self.columns.list().iter().any(|column| column.attribute == attribute);
        let mut met: Vec<Echo> = Vec::new();
        for (name, said) in self.fixed.iter().zip(fixed) {
            for (attribute, value) in attributes.iter().filter(|(own, _)| own.eq_ignore_ascii_case(name)) {
                let says_so = value.is_null() || text_of(value) == *said;
                match self.echoes.iter().position(|echo| echo.attribute == *attribute) {
                    Some(i) if !says_so => met.push(self.echoes.swap_remove(i)),
                    Some(i) => {
                        if let Some(echo) = self.echoes.get_mut(i).filter(|_| !value.is_null()) {
                            echo.hear(self.rows);
                        }
                    }
                    None if says_so && !is_known(attribute) => {
                        let mut echo = Echo { attribute: attribute.clone(), column: name, rows: Vec::new() };
                        if !value.is_null() {
                            echo.hear(self.rows);
                        }
                        self.echoes.push(echo);
                    }
                    None => {}
                }
            }
        }
        met
    }

    /// Adds the columns of attributes that are seen for the first time.
    fn add_columns(&mut self, connection: &Connection) -> Result<()> {
        if self.made.len() + self.echoes.len() == self.columns.list().len() {
            return Ok(());
        }
        for (column, i) in self.columns.list().iter().zip(0..) {
            if self.made.contains(&i) || self.echoes.iter().any(|echo| echo.attribute == column.attribute) {
                continue;
            }
            // Without a type as yet, so that SQLite keeps every value as it is: a whole number stays one, and "007" a text.
            connection.execute_batch(&format!("ALTER TABLE {} ADD COLUMN {}", self.name, quoted(&column.name)))?;
            self.made.push(i);
        }
        Ok(())
    }

    /// Gives an attribute that no longer says the same the values that it had in the rows so far.
    fn part(&self, connection: &Connection, echo: &Echo) -> Result<()> {
        let Some(column) = self.columns.list().iter().find(|column| column.attribute == echo.attribute) else {
            return Ok(());
        };
        let value = match column.kind {
            Some(Kind::Boolean) => format!("{} = 'true'", echo.column),
            Some(kind @ (Kind::Integer { .. } | Kind::Real)) => {
                format!("CAST({} AS {})", echo.column, sql_type(Some(kind)))
            }
            Some(Kind::Text) | None => echo.column.to_owned(),
        };
        let update = format!("UPDATE {} SET {} = {value} WHERE fid BETWEEN ? AND ?", self.name, quoted(&column.name));
        echo.rows.iter().try_for_each(|rows| connection.execute(&update, *rows).map(drop))
    }

    /// Gives every column the type that holds all its values.
    pub(super) fn finish(&mut self, connection: &Connection) -> Result<()> {
        let name = self.name;
        for column in self.own_columns().filter(|column| matches!(column.kind, Some(Kind::Text) | None)) {
            let column = quoted(&column.name);
            connection.execute_batch(&format!(
                "UPDATE {name} SET {column} = CAST({column} AS TEXT) WHERE typeof({column}) IN ('integer', 'real')"
            ))?;
        }
        // The declared types change nothing of what is stored: SQLite documents this way to change them ("ALTER TABLE",
        // section 7), which spares a copy of the whole table.
        let sql = format!("CREATE TABLE {name} ({})", definition(self.fixed, self.own_columns()));
        let version: i64 = connection.pragma_query_value(None, "schema_version", |row| row.get(0))?;
        connection.execute_batch("PRAGMA writable_schema = ON")?;
        connection.execute("UPDATE sqlite_schema SET sql = ? WHERE type = 'table' AND name = ?", (sql, name))?;
        connection.execute_batch(&format!("PRAGMA schema_version = {}; PRAGMA writable_schema = OFF", version + 1))
    }
}

/// The columns of a table in SQL.
fn definition<'a>(fixed: &[&str], columns: impl Iterator<Item = &'a Column>) -> String {
    let own = ["fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL", "geom MULTIPOLYGON"].map(str::to_owned);
    let fixed = fixed.iter().map(|name| format!("{name} TEXT"));
    let columns = columns.map(|column| format!("{} {}", quoted(&column.name), sql_type(column.kind)));
    own.into_iter().chain(fixed).chain(columns).collect::<Vec<_>>().join(", ")
}
