//! Attributes as property tables (`EXT_structural_metadata`): a column each, texts with offsets, absent values as `noData`.

use serde_json::{Map, Value, json};

use super::glb::Buffer;
use crate::sink::columns::{Column, Columns, Kind, text_of};

/// What stands for an absent number.
const NO_INTEGER: i32 = i32::MIN;
const NO_REAL: f64 = f64::MIN;
/// The largest whole number up to which every one is a 64-bit float.
const EXACT: i64 = 1 << 53;

/// How a property is written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Type {
    Boolean,
    Int32,
    Float64,
    Text,
}

/// A property of a class.
#[derive(Debug, Clone)]
struct Property {
    /// Its id: letters, digits and underscores.
    id: String,
    /// The attribute.
    name: String,
    kind: Type,
}

/// A class of the schema: what the rows of its tables have.
#[derive(Debug, Clone)]
pub(super) struct Class {
    id: &'static str,
    properties: Vec<Property>,
}

/// How a column of so many rows is written; `None` where it has no values.
fn type_of(column: &Column, rows: usize) -> Option<Type> {
    Some(match column.kind? {
        // A boolean has no value to spare for an absent one.
        Kind::Boolean if column.values == rows => Type::Boolean,
        Kind::Boolean | Kind::Text => Type::Text,
        Kind::Real => Type::Float64,
        Kind::Integer { min, max } => {
            if min > i64::from(NO_INTEGER) && max <= i64::from(i32::MAX) {
                Type::Int32
            } else if min >= -EXACT && max <= EXACT {
                Type::Float64
            } else {
                Type::Text
            }
        }
    })
}

impl Class {
    /// The class of all rows that `columns` has seen.
    pub(super) fn new(id: &'static str, columns: &Columns) -> Self {
        let mut properties: Vec<Property> = Vec::new();
        for column in columns.list() {
            let Some(kind) = type_of(column, columns.rows()) else { continue };
            let word: String = column.name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
            let is_name = word.starts_with(|c: char| !c.is_ascii_digit());
            let word = if is_name { word } else { format!("_{word}") };
            let mut id = word.clone();
            for n in 2.. {
                if !properties.iter().any(|property| property.id == id) {
                    break;
                }
                id = format!("{word}_{n}");
            }
            properties.push(Property { id, name: column.attribute.clone(), kind });
        }
        Self { id, properties }
    }

    /// The class as the schema has it.
    pub(super) fn schema(&self) -> Value {
        let property = |property: &Property| {
            let name = &property.name;
            let definition = match property.kind {
                Type::Boolean => json!({"name": name, "type": "BOOLEAN"}),
                Type::Int32 => {
                    json!({"name": name, "type": "SCALAR", "componentType": "INT32", "noData": NO_INTEGER})
                }
                Type::Float64 => {
                    json!({"name": name, "type": "SCALAR", "componentType": "FLOAT64", "noData": NO_REAL})
                }
                Type::Text => json!({"name": name, "type": "STRING", "noData": ""}),
            };
            (property.id.clone(), definition)
        };
        json!({"properties": self.properties.iter().map(property).collect::<Map<_, _>>()})
    }

    /// A table of rows; properties that no row has are left out.
    pub(super) fn table(&self, rows: &[Map<String, Value>], buffer: &mut Buffer) -> Value {
        let mut properties = Map::new();
        for property in &self.properties {
            let values = rows.iter().map(|row| row.get(&property.name).filter(|value| !value.is_null()));
            if values.clone().all(|value| value.is_none()) {
                continue;
            }
            let columns = match property.kind {
                Type::Boolean => json!({"values": buffer.view(&bits(values))}),
                Type::Int32 => {
                    let number = |value: Option<&Value>| value.and_then(Value::as_i64).map_or(NO_INTEGER, |n| n as i32);
                    json!({"values": buffer.view(&values.flat_map(|v| number(v).to_le_bytes()).collect::<Vec<u8>>())})
                }
                Type::Float64 => {
                    let number = |value: Option<&Value>| value.and_then(Value::as_f64).unwrap_or(NO_REAL);
                    json!({"values": buffer.view(&values.flat_map(|v| number(v).to_le_bytes()).collect::<Vec<u8>>())})
                }
                Type::Text => {
                    let (texts, offsets) = texts(values);
                    // A view of no bytes is no view.
                    let texts = if texts.is_empty() { vec![0] } else { texts };
                    json!({
                        "values": buffer.view(&texts), "stringOffsets": buffer.view(&offsets), "stringOffsetType": "UINT32",
                    })
                }
            };
            properties.insert(property.id.clone(), columns);
        }
        json!({"class": self.id, "count": rows.len(), "properties": properties})
    }
}

/// A bit for each value.
fn bits<'a>(values: impl Iterator<Item = Option<&'a Value>>) -> Vec<u8> {
    let mut out = Vec::new();
    for (i, value) in values.enumerate() {
        if i % 8 == 0 {
            out.push(0);
        }
        if let Some(byte) = out.last_mut().filter(|_| value == Some(&Value::Bool(true))) {
            *byte |= 1 << (i % 8);
        }
    }
    out
}

/// All texts one behind the other, and where each begins and the last one ends.
fn texts<'a>(values: impl Iterator<Item = Option<&'a Value>>) -> (Vec<u8>, Vec<u8>) {
    let (mut out, mut offsets) = (Vec::new(), 0u32.to_le_bytes().to_vec());
    for value in values {
        out.extend_from_slice(value.map(text_of).unwrap_or_default().as_bytes());
        offsets.extend_from_slice(&(out.len() as u32).to_le_bytes());
    }
    (out, offsets)
}
