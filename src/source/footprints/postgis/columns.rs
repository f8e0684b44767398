//! The columns of a layer: how each is asked for, and what its values become.

use serde_json::{Number, Value};
use tokio_postgres::types::{Kind, Type};
use tokio_postgres::{Error as PgError, Row};

use super::catalogue::quoted;

/// How a value comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Boolean,
    Int2,
    Int4,
    Int8,
    Float4,
    Float8,
    Text,
    /// A number in digits.
    Digits,
    Json,
    /// A date or a time by ISO 8601.
    Time,
}

/// A column that is asked for.
#[derive(Debug)]
pub(super) struct Column {
    pub name: String,
    /// What is selected, in SQL.
    pub sql: String,
    form: Form,
}

/// What becomes of a column.
#[derive(Debug)]
pub(super) enum Use {
    /// An attribute.
    Attribute(Column),
    /// An attribute of a type that gable does not know, as the server writes it.
    AsText(Column),
    /// Bytes, which are no attribute.
    Binary,
    /// Geometry; the second says whether it is `geography`.
    Geometry(bool),
}

/// What becomes of the column `name` of this type.
pub(super) fn use_of(name: &str, of: &Type) -> Use {
    let own = format!("f.{}", quoted(name));
    let text = format!("{own}::pg_catalog.text");
    let attribute = |sql: &str, form| Use::Attribute(Column { name: name.to_owned(), sql: sql.to_owned(), form });
    match of.kind() {
        Kind::Domain(base) => return use_of(name, base),
        Kind::Enum(_) => return attribute(&text, Form::Text),
        // As JSON writes it: quotes and dates are the same everywhere.
        Kind::Array(_) => return attribute(&format!("pg_catalog.to_json({own})::pg_catalog.text"), Form::Text),
        _ => {}
    }
    match *of {
        Type::BOOL => attribute(&own, Form::Boolean),
        Type::INT2 => attribute(&own, Form::Int2),
        Type::INT4 => attribute(&own, Form::Int4),
        Type::INT8 => attribute(&own, Form::Int8),
        Type::OID => attribute(&format!("{own}::pg_catalog.int8"), Form::Int8),
        Type::FLOAT4 => attribute(&own, Form::Float4),
        Type::FLOAT8 => attribute(&own, Form::Float8),
        Type::NUMERIC => attribute(&text, Form::Digits),
        Type::JSON | Type::JSONB => attribute(&text, Form::Json),
        Type::DATE | Type::TIMESTAMP | Type::TIMESTAMPTZ => {
            attribute(&format!("pg_catalog.to_json({own}) OPERATOR(pg_catalog.#>>) '{{}}'"), Form::Time)
        }
        // Blanks up to the length of char(n) are no part of the value.
        Type::TEXT
        | Type::VARCHAR
        | Type::BPCHAR
        | Type::NAME
        | Type::CHAR
        | Type::UUID
        | Type::TIME
        | Type::TIMETZ => attribute(&text, Form::Text),
        Type::BYTEA => Use::Binary,
        _ if of.name() == "geometry" => Use::Geometry(false),
        _ if of.name() == "geography" => Use::Geometry(true),
        _ if of.name() == "citext" => attribute(&text, Form::Text),
        _ => Use::AsText(Column { name: name.to_owned(), sql: text, form: Form::Text }),
    }
}

impl Column {
    /// Its value in place `i` of a row.
    ///
    /// # Errors
    /// It is not of the type that was asked for.
    pub fn value(&self, row: &Row, i: usize) -> Result<Value, PgError> {
        Ok(match self.form {
            Form::Boolean => row.try_get::<_, Option<bool>>(i)?.into(),
            Form::Int2 => row.try_get::<_, Option<i16>>(i)?.into(),
            Form::Int4 => row.try_get::<_, Option<i32>>(i)?.into(),
            Form::Int8 => row.try_get::<_, Option<i64>>(i)?.into(),
            // As it is written down, not as its nearest double: 2.8, not 2.799999952316284.
            Form::Float4 => row
                .try_get::<_, Option<f32>>(i)?
                .map_or(Value::Null, |value| value.to_string().parse().map_or(Value::Null, float)),
            Form::Float8 => row.try_get::<_, Option<f64>>(i)?.map_or(Value::Null, float),
            Form::Text => row.try_get::<_, Option<String>>(i)?.into(),
            Form::Digits => row.try_get::<_, Option<&str>>(i)?.map_or(Value::Null, digits),
            Form::Json => row.try_get::<_, Option<&str>>(i)?.map_or(Value::Null, json),
            Form::Time => row.try_get::<_, Option<&str>>(i)?.map_or(Value::Null, time),
        })
    }
}

fn float(value: f64) -> Value {
    Number::from_f64(value).map_or(Value::Null, Value::Number)
}

/// A number in digits; one with more of them than a JSON number keeps stays text, for it may be an id.
fn digits(text: &str) -> Value {
    const KEPT: usize = 15;
    if !text.bytes().any(|byte| byte.is_ascii_digit()) {
        return Value::Null;
    }
    let is_whole = !text.contains(['.', 'e', 'E']);
    if is_whole {
        let number = text.parse::<i64>().map(Number::from).or_else(|_| text.parse::<u64>().map(Number::from));
        if let Ok(number) = number {
            return Value::Number(number);
        }
        if text.bytes().filter(u8::is_ascii_digit).count() > KEPT {
            return text.into();
        }
    }
    text.parse().map_or(Value::Null, float)
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|_| text.into())
}

/// A time in UTC ends in Z, as in other formats.
fn time(text: &str) -> Value {
    text.strip_suffix("+00:00").map_or_else(|| text.into(), |bare| format!("{bare}Z").into())
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn numbers_keep_all_their_digits() {
        let cases = [
            ("12", json!(12)),
            ("-7", json!(-7)),
            ("18446744073709551615", json!(u64::MAX)),
            ("99999999999999999999999", json!("99999999999999999999999")),
            ("2.80", json!(2.8)),
            ("2.8", json!(2.8)),
            ("1e20", json!(1e20)),
            ("NaN", Value::Null),
            ("inf", Value::Null),
            ("Infinity", Value::Null),
        ];
        for (text, expected) in cases {
            assert_eq!(digits(text), expected, "{text}");
        }
        assert_eq!(time("2020-01-02T03:04:05+00:00"), json!("2020-01-02T03:04:05Z"));
        assert_eq!(time("2020-01-02"), json!("2020-01-02"));
    }

    #[test]
    fn types_are_asked_for_as_what_they_become() {
        let sql = |of: Type| match use_of("a\"b", &of) {
            Use::Attribute(column) => column.sql,
            Use::AsText(column) => format!("told: {}", column.sql),
            other => format!("{other:?}"),
        };
        assert_eq!(sql(Type::INT4), "f.\"a\"\"b\"");
        assert_eq!(sql(Type::NUMERIC), "f.\"a\"\"b\"::pg_catalog.text");
        assert_eq!(sql(Type::INTERVAL), "told: f.\"a\"\"b\"::pg_catalog.text");
        assert_eq!(sql(Type::TEXT_ARRAY), "pg_catalog.to_json(f.\"a\"\"b\")::pg_catalog.text");
        assert_eq!(sql(Type::BYTEA), "Binary");
    }
}
