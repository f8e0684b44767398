//! What is asked of the server: the columns of a table or of a query, and the rows at the tiles.

use tokio_postgres::{Error as PgError, Statement, Transaction};

use super::catalogue::{Layer, quoted};
use super::columns::{Column, Use, use_of};
use super::faults;
use super::session::Waiting;
use crate::error::{InputError, Result};

/// The name of the layer that a query makes.
const OF_QUERY: &str = "query";

/// Where the rows come from.
pub(super) enum Origin {
    /// A column of geometry of a table.
    Layer(Layer),
    /// A query of the user's.
    Query(String),
}

/// What is selected.
pub(super) struct Selection {
    origin: Origin,
    /// The schema of `PostGIS`, quoted.
    extension: String,
    /// The column of geometry, in SQL.
    geometry: String,
    /// The attributes, in order.
    pub columns: Vec<Column>,
    /// What the rows are ordered by, in SQL.
    order: Vec<String>,
    /// What is not read as it stands, one sentence each.
    pub warnings: Vec<String>,
}

impl Selection {
    /// What is selected of a table or a query.
    ///
    /// # Errors
    /// The query is none, or it has no or several columns of geometry, or two of one name.
    pub fn of(origin: Origin, waiting: &Waiting<'_>, transaction: &Transaction<'_>, extension: &str) -> Result<Self> {
        let (statement, order) = match &origin {
            Origin::Layer(layer) => {
                let sql = format!("SELECT * FROM {}", layer.table_sql());
                (waiting.answer(transaction.prepare(&sql))?, layer.order(waiting, transaction)?)
            }
            // By itself first: what is not one whole statement does not get any farther.
            Origin::Query(query) => {
                let alone = transaction.prepare(query);
                let statement = waiting.explained(alone, |error| faults::of_query(&waiting.label, error, 0))?;
                refuse(&statement, waiting)?;
                (statement, Vec::new())
            }
        };
        let (mut columns, mut geometries, mut warnings) = (Vec::new(), Vec::new(), Vec::new());
        for column in statement.columns() {
            let (name, kind) = (column.name(), column.type_());
            match use_of(name, kind) {
                Use::Attribute(column) => columns.push(column),
                Use::AsText(column) => {
                    warnings.push(format!(
                        "attribute `{name}` is of type {}, which gable does not know: read as text",
                        kind.name()
                    ));
                    columns.push(column);
                }
                Use::Binary => warnings.push(format!("attribute `{name}` is binary and was left out")),
                Use::Geometry(is_geography) => geometries.push((name.to_owned(), is_geography)),
            }
        }
        let wanted = match &origin {
            Origin::Layer(layer) => Some(layer.column.as_str()),
            Origin::Query(_) => None,
        };
        let names = || geometries.iter().map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
        let chosen = geometries.iter().find(|(name, _)| wanted.is_none_or(|wanted| wanted == name));
        let fault = |found: &str| InputError::new(&waiting.label, found, "one column of geometry").at("--query");
        let (name, is_geography) = match chosen {
            Some(_) if wanted.is_none() && geometries.len() > 1 => {
                let found = format!("{} geometry columns: {}", geometries.len(), names());
                return Err(fault(&found).remedy("Select only the one that is the outline").into());
            }
            Some(chosen) => chosen,
            None => {
                let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
                let remedy = format!("Select it as well; its columns are: {}", names.join(", "));
                return Err(fault("no geometry column").remedy(remedy).into());
            }
        };
        let others = geometries.iter().filter(|(other, _)| other != name);
        warnings
            .extend(others.map(|(other, _)| {
                format!("attribute `{other}` is geometry beside that of the layer and was left out")
            }));
        let cast = if *is_geography { format!("::{extension}.geometry") } else { String::new() };
        let geometry = format!("f.{}{cast}", quoted(name));
        Ok(Self { origin, extension: extension.to_owned(), geometry, columns, order, warnings })
    }

    /// The name of the layer.
    pub fn name(&self) -> String {
        match &self.origin {
            Origin::Layer(layer) => layer.table.clone(),
            Origin::Query(_) => OF_QUERY.to_owned(),
        }
    }

    /// What stands behind FROM.
    fn from(&self) -> String {
        match &self.origin {
            Origin::Layer(layer) => format!("{} AS f", layer.table_sql()),
            // On lines of its own, so that a comment at its end ends there.
            Origin::Query(query) => format!("(\n{query}\n) AS f"),
        }
    }

    /// The SRID of the geometry: that of the column, else of the first value; 0 without any.
    ///
    /// # Errors
    /// The server does not answer, or the query cannot be part of another.
    pub fn srid(&self, waiting: &Waiting<'_>, transaction: &Transaction<'_>) -> Result<i32> {
        if let Origin::Layer(layer) = &self.origin
            && layer.srid > 0
        {
            return Ok(layer.srid);
        }
        let Self { extension, geometry, .. } = self;
        let sql =
            format!("SELECT {extension}.ST_SRID({geometry}) FROM {} WHERE {geometry} IS NOT NULL LIMIT 1", self.from());
        let row = waiting.explained(transaction.query_opt(&sql, &[]), |error| self.fault(waiting, error, &sql))?;
        row.map_or(Ok(0), |row| waiting.answer(std::future::ready(row.try_get(0))))
    }

    /// The condition that a box touches the one of the parameters 1 to 4, in the system of parameter 5.
    fn at_tiles(&self) -> String {
        let Self { extension, geometry, .. } = self;
        format!(
            "{geometry} OPERATOR({extension}.&&) {extension}.ST_MakeEnvelope($1::pg_catalog.float8, \
             $2::pg_catalog.float8, $3::pg_catalog.float8, $4::pg_catalog.float8, $5::pg_catalog.int4)"
        )
    }

    /// The statement; `at_tiles` has the parameters of a box. What has no geometry lies nowhere, and is told.
    pub fn sql(&self, at_tiles: bool) -> String {
        let Self { extension, geometry, columns, order, .. } = self;
        let selected: String = columns.iter().flat_map(|column| [", ", &column.sql]).collect();
        let condition =
            if at_tiles { format!(" WHERE {} OR {geometry} IS NULL", self.at_tiles()) } else { String::new() };
        let order = if order.is_empty() { String::new() } else { format!(" ORDER BY {}", order.join(", ")) };
        format!("SELECT {extension}.ST_AsEWKB({geometry}){selected} FROM {}{condition}{order}", self.from())
    }

    /// Whether there are features that do not touch the box. Of a query that would take another run of it: then there may be.
    ///
    /// # Errors
    /// The server does not answer.
    pub fn leaves_out(
        &self,
        waiting: &Waiting<'_>,
        transaction: &Transaction<'_>,
        bounds: &[f64; 4],
        srid: i32,
    ) -> Result<bool> {
        if matches!(self.origin, Origin::Query(_)) {
            return Ok(true);
        }
        let sql = format!("SELECT EXISTS (SELECT FROM {} WHERE NOT ({}))", self.from(), self.at_tiles());
        let [x0, y0, x1, y1] = bounds;
        let row = waiting.answer(transaction.query_one(&sql, &[x0, y0, x1, y1, &srid]))?;
        waiting.answer(std::future::ready(row.try_get(0)))
    }

    /// A refusal of a statement that holds the query.
    pub fn fault(&self, waiting: &Waiting<'_>, error: &PgError, sql: &str) -> InputError {
        match &self.origin {
            Origin::Layer(_) => faults::asking(&waiting.label, error),
            Origin::Query(query) => {
                let before =
                    sql.find(query.as_str()).and_then(|at| sql.get(..at)).map_or(0, |text| text.chars().count());
                faults::of_query(&waiting.label, error, u32::try_from(before).unwrap_or(0))
            }
        }
    }
}

/// Refuses a query with parameters, without rows, or with two columns of one name.
fn refuse(statement: &Statement, waiting: &Waiting<'_>) -> Result<()> {
    let fault = |found: String, expected: &str| InputError::new(&waiting.label, found, expected).at("--query");
    if let Some(count) = Some(statement.params().len()).filter(|count| *count > 0) {
        return Err(fault(format!("{count} parameters ($1, …)"), "a query that is whole").into());
    }
    if statement.columns().is_empty() {
        return Err(fault("a statement that gives no rows".to_owned(), "a SELECT").into());
    }
    let names: Vec<&str> = statement.columns().iter().map(tokio_postgres::Column::name).collect();
    if let Some((_, twice)) = names.iter().enumerate().find(|(i, name)| names[..*i].contains(name)) {
        return Err(fault(format!("two columns `{twice}`"), "a name for each column")
            .remedy("Name one of them otherwise: … AS another")
            .into());
    }
    Ok(())
}
