//! Which layers a database has, and which of them is meant.

use std::path::Path;

use tokio_postgres::Transaction;

use super::session::Waiting;
use crate::error::{InputError, Result};
use crate::source::footprints::names;

/// Where the extension is, whose functions may not be on the search path.
const EXTENSION: &str = "SELECT n.nspname::text FROM pg_catalog.pg_extension e \
    JOIN pg_catalog.pg_namespace n ON n.oid = e.extnamespace WHERE e.extname = 'postgis'";
/// All columns of geometry that may be read. `%` is the schema of the extension.
const LAYERS: &str = "SELECT l.s::text, l.t::text, l.c::text, l.srid::int4, upper(l.kind)::text, \
        c.relkind::text, pg_catalog.pg_table_is_visible(c.oid) \
    FROM (SELECT f_table_schema s, f_table_name t, f_geometry_column c, srid, type kind FROM %.geometry_columns \
        UNION ALL SELECT f_table_schema, f_table_name, f_geography_column, srid, type FROM %.geography_columns) l \
    JOIN pg_catalog.pg_namespace n ON n.nspname = l.s \
    JOIN pg_catalog.pg_class c ON c.relnamespace = n.oid AND c.relname = l.t ORDER BY 1, 2, 3";
/// Tables of a name, and whether they may be read.
const TABLES: &str = "SELECT n.nspname::text, c.relname::text, \
        pg_catalog.has_schema_privilege(n.oid, 'USAGE') AND pg_catalog.has_table_privilege(c.oid, 'SELECT'), \
        ARRAY(SELECT a.attname::text FROM pg_catalog.pg_attribute a \
            WHERE a.attrelid = c.oid AND a.attnum > 0 AND NOT a.attisdropped ORDER BY a.attnum) \
    FROM pg_catalog.pg_class c JOIN pg_catalog.pg_namespace n ON n.oid = c.relnamespace \
    WHERE c.relkind IN ('r', 'v', 'm', 'f', 'p') AND $1::text IN (c.relname::text, n.nspname || '.' || c.relname) ORDER BY 1, 2";
/// The columns of the primary key of a table, in their order.
const KEY: &str = "SELECT a.attname::text FROM pg_catalog.pg_index i \
    JOIN pg_catalog.pg_class c ON c.oid = i.indrelid JOIN pg_catalog.pg_namespace n ON n.oid = c.relnamespace \
    CROSS JOIN LATERAL unnest(i.indkey::int2[]) WITH ORDINALITY k (number, place) \
    JOIN pg_catalog.pg_attribute a ON a.attrelid = c.oid AND a.attnum = k.number \
    WHERE i.indisprimary AND n.nspname = $1 AND c.relname = $2 ORDER BY k.place";
/// The types that can hold polygons.
const POLYGON_TYPES: [&str; 7] =
    ["GEOMETRY", "POLYGON", "MULTIPOLYGON", "GEOMETRYCOLLECTION", "SURFACE", "MULTISURFACE", "CURVEPOLYGON"];
/// The kind of an ordinary table, whose rows have places on disk.
const ORDINARY: &str = "r";

/// A column of geometry.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layer {
    pub schema: String,
    pub table: String,
    pub column: String,
    /// The SRID that all its values must have; 0 where they may have any.
    pub srid: i32,
    kind: String,
    /// Whether it is an ordinary table: not a view, partitioned or foreign.
    is_ordinary: bool,
    /// Whether its table is found without its schema.
    is_visible: bool,
}

/// An identifier as SQL wants it.
pub(super) fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\""))
}

/// The schema of `PostGIS`, quoted.
///
/// # Errors
/// The database does not have it.
pub(super) fn extension(waiting: &Waiting<'_>, transaction: &Transaction<'_>) -> Result<String> {
    let row = waiting.answer(transaction.query_opt(EXTENSION, &[]))?;
    match row {
        Some(row) => waiting.answer(std::future::ready(row.try_get::<_, String>(0))).map(|name| quoted(&name)),
        None => Err(InputError::new(&waiting.label, "a database without PostGIS", "one with the extension `postgis`")
            .remedy("Is dbname right? Its owner adds it with: CREATE EXTENSION postgis")
            .into()),
    }
}

/// The layer of this name: `table`, `schema.table`, or either with the column behind it, as in `table(geom)`. Without a
/// name it is the only one with polygons.
///
/// # Errors
/// There is none, or there are several.
pub(super) fn layer(
    waiting: &Waiting<'_>,
    transaction: &Transaction<'_>,
    extension: &str,
    wanted: Option<&str>,
) -> Result<Layer> {
    let rows = waiting.answer(transaction.query(&LAYERS.replace('%', extension), &[]))?;
    let layer = |row: &tokio_postgres::Row| {
        Ok(Layer {
            schema: row.try_get(0)?,
            table: row.try_get(1)?,
            column: row.try_get(2)?,
            srid: row.try_get(3)?,
            kind: row.try_get(4)?,
            is_ordinary: row.try_get::<_, &str>(5)? == ORDINARY,
            is_visible: row.try_get(6)?,
        })
    };
    let layers: Vec<Layer> = waiting.answer(std::future::ready(rows.iter().map(layer).collect()))?;
    let found = choose(&waiting.label, &layers, wanted);
    // What is no layer may still be a table.
    let (Err(fault), Some(name)) = (&found, wanted) else { return found.map_err(Into::into) };
    if layers.iter().any(|layer| layer.is_called(name)) {
        return Err(fault.clone().into());
    }
    let tables = waiting.answer(transaction.query(TABLES, &[&name]))?;
    let Some(table) = tables.first() else { return Err(fault.clone().into()) };
    let read = || Ok((table.try_get(0)?, table.try_get(1)?, table.try_get(2)?, table.try_get(3)?));
    let (schema, table, may_read, columns): (String, String, bool, Vec<String>) =
        waiting.answer(std::future::ready(read()))?;
    let place = format!("table {schema}.{table}");
    let fault = if may_read {
        InputError::new(&waiting.label, "no geometry column", "a column of type geometry or geography")
            .at(place)
            .remedy(format!("Its columns are: {}", columns.join(", ")))
    } else {
        InputError::new(&waiting.label, "no right to read it", "a table that may be read")
            .at(place)
            .remedy("Ask its owner for it: GRANT SELECT, and GRANT USAGE on the schema")
    };
    Err(fault.into())
}

fn choose(label: &Path, layers: &[Layer], wanted: Option<&str>) -> Result<Layer, InputError> {
    let named = |some: &[&Layer]| some.iter().map(|layer| layer.name(layers)).collect::<Vec<_>>();
    let all = || named(&layers.iter().collect::<Vec<_>>());
    let list = |some: &[&Layer]| some.iter().map(|layer| layer.full_name()).collect::<Vec<_>>().join(", ");
    let Some(wanted) = wanted else {
        let candidates: Vec<&Layer> = layers.iter().filter(|layer| layer.can_hold_polygons()).collect();
        return match candidates[..] {
            [only] => Ok(only.clone()),
            [] => Err(InputError::new(label, "no table with polygons", "a table with polygons that may be read")
                .remedy(if layers.is_empty() { String::new() } else { format!("There are: {}", all().join(", ")) })),
            _ => Err(InputError::new(label, format!("{} layers", candidates.len()), "the name of the layer to read")
                .remedy(format!("Name one with --layer: {}", named(&candidates).join(", ")))),
        };
    };
    let matches = |is_same: fn(&str, &str) -> bool| -> Vec<&Layer> {
        let named = |layer: &&Layer| layer.names().iter().any(|name| is_same(name, wanted));
        layers.iter().filter(named).collect()
    };
    let mut found = matches(|name, wanted| name == wanted);
    if found.is_empty() {
        found = matches(str::eq_ignore_ascii_case);
    }
    // Of tables of one name the one that a query without a schema would find.
    if found.iter().any(|layer| layer.is_visible) {
        found.retain(|layer| layer.is_visible);
    }
    let is_one_table =
        found.windows(2).all(|pair| (&pair[0].schema, &pair[0].table) == (&pair[1].schema, &pair[1].table));
    if is_one_table && found.iter().filter(|layer| layer.can_hold_polygons()).count() == 1 {
        found.retain(|layer| layer.can_hold_polygons());
    }
    match found[..] {
        [only] => Ok(only.clone()),
        [] => {
            let names = all();
            Err(InputError::new(label, format!("no layer `{wanted}`"), "a table with geometry that may be read")
                .remedy(names::remedy(wanted, names.iter().map(String::as_str))))
        }
        _ if is_one_table => Err(InputError::new(label, format!("{} geometry columns", found.len()), "one of them")
            .at(format!("table {wanted}"))
            .remedy(format!("Name it with --layer: {}", list(&found)))),
        _ => Err(InputError::new(label, format!("{} tables `{wanted}`", found.len()), "one of them")
            .remedy(format!("Name it with --layer: {}", list(&found)))),
    }
}

impl Layer {
    fn can_hold_polygons(&self) -> bool {
        // M is part of the name of a type, as in POLYGONM.
        let kind = self.kind.strip_suffix('M').unwrap_or(&self.kind);
        POLYGON_TYPES.iter().any(|known| *known == kind || *known == self.kind)
    }

    fn full_name(&self) -> String {
        format!("{}.{}({})", self.schema, self.table, self.column)
    }

    /// All that it may be called.
    fn names(&self) -> [String; 4] {
        let Self { schema, table, column, .. } = self;
        [table.clone(), format!("{schema}.{table}"), format!("{table}({column})"), self.full_name()]
    }

    fn is_called(&self, name: &str) -> bool {
        self.names().iter().any(|own| own.eq_ignore_ascii_case(name))
    }

    /// The shortest that it can be called among others: one that is found without its schema goes before those that are not.
    fn name(&self, others: &[Self]) -> String {
        let names = self.names();
        let rivals = || others.iter().filter(|other| other.is_visible || !self.is_visible);
        let is_own = |name: &&String| rivals().filter(|other| other.names().contains(name)).count() == 1;
        names.iter().find(is_own).unwrap_or(&names[3]).clone()
    }

    /// The table in SQL.
    pub fn table_sql(&self) -> String {
        format!("{}.{}", quoted(&self.schema), quoted(&self.table))
    }

    /// What its rows are ordered by, in SQL, so that the same table gives the same model: its key, else their places on
    /// disk; nothing where it has neither.
    pub fn order(&self, waiting: &Waiting<'_>, transaction: &Transaction<'_>) -> Result<Vec<String>> {
        let rows = waiting.answer(transaction.query(KEY, &[&self.schema, &self.table]))?;
        let names = rows.iter().map(|row| row.try_get::<_, String>(0)).collect();
        let key: Vec<String> = waiting.answer(std::future::ready(names))?;
        if key.is_empty() && self.is_ordinary {
            return Ok(vec!["f.ctid".to_owned()]);
        }
        Ok(key.iter().map(|name| format!("f.{}", quoted(name))).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(schema: &str, table: &str, column: &str, kind: &str) -> Layer {
        let text = str::to_owned;
        Layer {
            schema: text(schema),
            table: text(table),
            column: text(column),
            srid: 0,
            kind: text(kind),
            is_ordinary: true,
            is_visible: schema == "public",
        }
    }

    #[test]
    fn layers_are_chosen_by_name_or_because_there_is_but_one() {
        let layers = [
            layer("bag", "pand", "geom", "MULTIPOLYGON"),
            layer("bag", "weg", "geom", "LINESTRING"),
            layer("public", "Pand.x", "geom", "POLYGONM"),
            layer("public", "pand", "dak", "POLYGON"),
            layer("public", "pand", "gevel", "GEOMETRY"),
            layer("public", "pand", "punt", "POINT"),
        ];
        let chosen = |wanted| choose(Path::new("PG:"), &layers, Some(wanted)).map(|layer| layer.full_name());
        assert_eq!(chosen("bag.pand").unwrap(), "bag.pand(geom)");
        assert_eq!(chosen("pand(gevel)").unwrap(), "public.pand(gevel)");
        assert_eq!(chosen("PAND.X").unwrap(), "public.Pand.x(geom)");
        assert_eq!(chosen("weg").unwrap(), "bag.weg(geom)");
        let message = |wanted| chosen(wanted).unwrap_err().to_string();
        assert!(message("pand").contains("3 geometry columns") && message("pand").contains("public.pand(dak)"));
        let injected = "pand\"; DROP TABLE pand; --";
        assert!(message(injected).contains(&format!("no layer `{injected}`")), "{}", message(injected));
        assert!(message("bag.pnad").contains("Did you mean `bag.pand`"), "{}", message("bag.pnad"));
        let only = |some: &[Layer]| choose(Path::new("PG:"), some, None).map(|layer| layer.full_name());
        assert_eq!(only(&layers[..2]).unwrap(), "bag.pand(geom)");
        let none = only(&layers[1..2]).unwrap_err().to_string();
        assert!(none.contains("no table with polygons") && none.contains("weg"), "{none}");
        let several = only(&layers).unwrap_err().to_string();
        assert!(several.contains("4 layers") && several.contains("pand(dak)"), "{several}");
        assert_eq!(quoted("a\"b"), "\"a\"\"b\"");
    }
}
