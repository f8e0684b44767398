//! What an option accepts.

use serde_json::{Map, Value, json};

/// What an option accepts.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// One of these names, each with its documentation.
    Choice(Vec<(String, String)>),
    /// A number, whole or not, from the first to the last limit.
    Number {
        /// Whether only whole numbers will do.
        whole: bool,
        /// The smallest and the largest number.
        limits: [f64; 2],
    },
    /// A number, or `auto`.
    NumberOrAuto,
    /// `true` or `false`.
    Boolean,
    /// Text.
    Text,
    /// The name of a file.
    File,
    /// Names parted by commas, or an array of them.
    Names,
    /// A text, or an array of texts that each stand for themselves.
    Texts,
    /// Any JSON, carried along.
    Anything,
}

impl Kind {
    /// Any number.
    pub fn number() -> Self {
        Self::Number { whole: false, limits: [f64::NEG_INFINITY, f64::INFINITY] }
    }

    /// A number of at least `low`.
    pub fn at_least(low: f64) -> Self {
        Self::Number { whole: false, limits: [low, f64::INFINITY] }
    }

    /// A whole number from `low` to `high`.
    pub fn whole(low: u32, high: u32) -> Self {
        Self::Number { whole: true, limits: [low.into(), high.into()] }
    }

    /// A whole number of at least 0.
    pub fn count() -> Self {
        Self::Number { whole: true, limits: [0.0, f64::INFINITY] }
    }

    /// One of these names, each with what it means.
    pub fn choice(names: &[(&str, &str)]) -> Self {
        Self::Choice(names.iter().map(|(name, help)| ((*name).to_owned(), (*help).to_owned())).collect())
    }

    /// What a schema without references accepts.
    pub fn of_schema(schema: &Value) -> Self {
        let variants = |key: &str| schema.get(key).and_then(Value::as_array);
        if let Some(names) = variants("enum") {
            let names = names.iter().filter_map(Value::as_str).map(|name| (name.to_owned(), String::new()));
            return Self::Choice(names.collect());
        }
        if let Some(variants) = variants("oneOf") {
            let named = variants
                .iter()
                .filter_map(|variant| Some((variant.get("const")?.as_str()?.to_owned(), description(variant))));
            return Self::Choice(named.collect());
        }
        // The first alternative that is not null: an optional value is one that may be left out.
        if let Some(some) = variants("anyOf").and_then(|all| all.iter().find(|s| type_of(s) != Some("null"))) {
            return Self::of_schema(some);
        }
        match type_of(schema) {
            Some("boolean") => Self::Boolean,
            Some(kind @ ("number" | "integer")) => {
                let limit = |key: &str, none: f64| schema.get(key).and_then(Value::as_f64).unwrap_or(none);
                let limits = [limit("minimum", f64::NEG_INFINITY), limit("maximum", f64::INFINITY)];
                Self::Number { whole: kind == "integer", limits }
            }
            _ => Self::Text,
        }
    }

    /// A word for it, in capitals.
    pub fn placeholder(&self) -> &'static str {
        match self {
            Self::Choice(_) => "NAME",
            Self::Number { .. } | Self::NumberOrAuto => "NUMBER",
            Self::Boolean => "BOOL",
            Self::Text | Self::Texts => "TEXT",
            Self::File => "FILE",
            Self::Names => "NAMES",
            Self::Anything => "JSON",
        }
    }

    /// What is expected, in words.
    pub fn expected(&self) -> String {
        match self {
            Self::Choice(names) => {
                let names: Vec<&str> = names.iter().map(|(name, _)| name.as_str()).collect();
                format!("one of {}", names.join(", "))
            }
            &Self::Number { whole, limits: [low, high] } => {
                let kind = if whole { "a whole number" } else { "a number" };
                match (low.is_finite(), high.is_finite()) {
                    (true, true) => format!("{kind} from {low} to {high}"),
                    (true, false) => format!("{kind} of at least {low}"),
                    (false, true) => format!("{kind} of at most {high}"),
                    (false, false) => kind.to_owned(),
                }
            }
            Self::NumberOrAuto => "a number or \"auto\"".to_owned(),
            Self::Boolean => "true or false".to_owned(),
            Self::Text => "a text".to_owned(),
            Self::File => "the name of a file".to_owned(),
            Self::Names => "names parted by commas, or an array of names".to_owned(),
            Self::Texts => "a text or an array of texts".to_owned(),
            Self::Anything => "JSON".to_owned(),
        }
    }

    /// The value in the form that the rest of the program reads: numbers and booleans may come as text, and lists as one
    /// text or as an array. `None` when it is not accepted.
    pub fn accept(&self, value: &Value) -> Option<Value> {
        match self {
            Self::Choice(names) => {
                let text = value.as_str()?.trim();
                let exact = names.iter().find(|(name, _)| name == text);
                let name = exact.or_else(|| names.iter().find(|(name, _)| name.eq_ignore_ascii_case(text)))?;
                Some(Value::String(name.0.clone()))
            }
            Self::Number { whole, limits: [low, high] } => {
                let number = number(value)?;
                let is_whole = number.is_i64() || number.is_u64();
                let size = number.as_f64()?;
                ((is_whole || !whole) && (*low..=*high).contains(&size)).then_some(number)
            }
            Self::NumberOrAuto => match value.as_str() {
                Some(text) if text.trim().eq_ignore_ascii_case("auto") => Some(json!("auto")),
                _ => number(value),
            },
            Self::Boolean => match value {
                Value::Bool(_) => Some(value.clone()),
                Value::String(text) => match text.trim().to_ascii_lowercase().as_str() {
                    "true" | "1" => Some(Value::Bool(true)),
                    "false" | "0" => Some(Value::Bool(false)),
                    _ => None,
                },
                _ => None,
            },
            Self::Text | Self::File => match value {
                Value::String(_) => Some(value.clone()),
                Value::Number(number) => Some(Value::String(number.to_string())),
                _ => None,
            },
            Self::Names => {
                let texts = texts(value)?;
                let names =
                    texts.iter().flat_map(|text| text.split(',')).map(str::trim).filter(|name| !name.is_empty());
                Some(names.map(|name| Value::String(name.to_owned())).collect())
            }
            Self::Texts => Some(texts(value)?.into_iter().map(Value::String).collect()),
            Self::Anything => Some(value.clone()),
        }
    }

    /// What it accepts, as JSON Schema.
    pub fn schema(&self) -> Map<String, Value> {
        // PDAL takes numbers and booleans as text as well, and so do we; editors need not offer it.
        let schema = match self {
            Self::Choice(names) => {
                let variants: Vec<Value> = names
                    .iter()
                    .map(|(name, help)| match help.as_str() {
                        "" => json!({ "const": name }),
                        help => json!({ "const": name, "description": help }),
                    })
                    .collect();
                json!({ "oneOf": variants })
            }
            &Self::Number { whole, limits: [low, high] } => {
                let mut schema = json!({ "type": if whole { "integer" } else { "number" } });
                if low.is_finite() {
                    schema["minimum"] = exact(low);
                }
                if high.is_finite() {
                    schema["maximum"] = exact(high);
                }
                json!({ "anyOf": [schema, { "type": "string" }] })
            }
            Self::NumberOrAuto => json!({ "anyOf": [{ "type": "number" }, { "const": "auto" }, { "type": "string" }] }),
            Self::Boolean => json!({ "anyOf": [{ "type": "boolean" }, { "enum": ["true", "false"] }] }),
            Self::Text | Self::File => json!({ "type": "string" }),
            Self::Names | Self::Texts => {
                json!({ "anyOf": [{ "type": "string" }, { "type": "array", "items": { "type": ["string", "number"] } }] })
            }
            Self::Anything => json!({}),
        };
        match schema {
            Value::Object(map) => map,
            _ => Map::new(),
        }
    }
}

/// A limit as it was written: whole numbers without a point.
fn exact(limit: f64) -> Value {
    if limit.fract() == 0.0 && limit.abs() < 1e15 { json!(limit as i64) } else { json!(limit) }
}

/// A number, or a text that holds one.
fn number(value: &Value) -> Option<Value> {
    match value {
        Value::Number(_) => Some(value.clone()),
        Value::String(text) => {
            let text = text.trim();
            let number = serde_json::from_str::<Value>(text).ok().filter(Value::is_number);
            // `.5`, `5.` and `+5` are numbers to PDAL but not to JSON.
            number.or_else(|| text.parse::<f64>().ok().filter(|n| n.is_finite()).map(|n| json!(n)))
        }
        _ => None,
    }
}

/// One text or several; numbers are texts too.
fn texts(value: &Value) -> Option<Vec<String>> {
    let text = |value: &Value| match value {
        Value::String(text) => Some(text.clone()),
        Value::Number(number) => Some(number.to_string()),
        _ => None,
    };
    match value {
        Value::Array(values) => values.iter().map(text).collect(),
        one => text(one).map(|text| vec![text]),
    }
}

/// The type of a schema; of several, the first that is not null.
fn type_of(schema: &Value) -> Option<&str> {
    match schema.get("type")? {
        Value::Array(types) => types.iter().filter_map(Value::as_str).find(|&t| t != "null"),
        one => one.as_str(),
    }
}

/// The documentation of a schema without the marks of rustdoc links.
pub(super) fn description(schema: &Value) -> String {
    let text = schema.get("description").and_then(Value::as_str).unwrap_or_default();
    text.replace("[`", "`").replace("`]", "`").replace('\n', " ").trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_follow_the_schema() {
        let parse = |schema: Value, text: &str| Kind::of_schema(&schema).accept(&json!(text));
        assert_eq!(parse(json!({"type": "number"}), "0.25"), Some(json!(0.25)));
        assert_eq!(parse(json!({"type": ["number", "null"]}), "x"), None);
        assert_eq!(parse(json!({"type": "number", "minimum": 0.0}), "-0.1"), None);
        assert_eq!(parse(json!({"type": "number", "maximum": 2}), "2.1"), None);
        assert_eq!(parse(json!({"type": "integer"}), "1.5"), None);
        assert_eq!(parse(json!({"type": "integer", "minimum": 3}), "3"), Some(json!(3)));
        assert_eq!(parse(json!({"type": "boolean"}), "true"), Some(json!(true)));
        assert_eq!(parse(json!({"enum": ["a", "b"]}), "b"), Some(json!("b")));
        assert_eq!(parse(json!({"anyOf": [{"oneOf": [{"const": "a"}]}, {"type": "null"}]}), "b"), None);
    }

    #[test]
    fn values_may_come_as_text() {
        assert_eq!(Kind::number().accept(&json!(" .5 ")), Some(json!(0.5)));
        assert_eq!(Kind::whole(1, 4).accept(&json!("5")), None);
        assert_eq!(Kind::NumberOrAuto.accept(&json!("Auto")), Some(json!("auto")));
        assert_eq!(Kind::Boolean.accept(&json!("False")), Some(json!(false)));
        assert_eq!(Kind::Names.accept(&json!("X, Y,Z")), Some(json!(["X", "Y", "Z"])));
        assert_eq!(Kind::Texts.accept(&json!("([0,1],[0,1])")), Some(json!(["([0,1],[0,1])"])));
        assert_eq!(Kind::Texts.accept(&json!({})), None);
        assert_eq!(Kind::Text.accept(&json!(28992)), Some(json!("28992")));
    }
}
