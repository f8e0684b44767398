//! The columns of a table of attributes: names and types, which are known when the last feature has been seen.

use std::collections::HashMap;

use serde_json::{Map, Value};

use super::Feature;

/// The type of a column: the narrowest that holds all its values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// True and false.
    Boolean,
    /// Whole numbers from `min` to `max`.
    Integer { min: i64, max: i64 },
    /// Any numbers.
    Real,
    /// Text; what is none is its JSON.
    Text,
}

impl Kind {
    /// The type of a value; `None` for null.
    fn of(value: &Value) -> Option<Self> {
        Some(match value {
            Value::Null => return None,
            Value::Bool(_) => Self::Boolean,
            Value::Number(number) => match number.as_i64() {
                Some(n) => Self::Integer { min: n, max: n },
                None if number.is_u64() => Self::Text,
                None => Self::Real,
            },
            _ => Self::Text,
        })
    }

    /// The narrowest type that holds the values of both.
    fn with(self, other: Self) -> Self {
        match (self, other) {
            (Self::Boolean, Self::Boolean) => Self::Boolean,
            (Self::Integer { min: a, max: b }, Self::Integer { min: c, max: d }) => {
                Self::Integer { min: a.min(c), max: b.max(d) }
            }
            (Self::Integer { .. } | Self::Real, Self::Integer { .. } | Self::Real) => Self::Real,
            _ => Self::Text,
        }
    }
}

/// A column.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Column {
    /// The name of the attribute.
    pub attribute: String,
    /// Its name in the table: that of the attribute unless it is taken there.
    pub name: String,
    /// Its type; `None` while all its values are null.
    pub kind: Option<Kind>,
    /// How many rows have a value.
    pub values: usize,
}

/// The columns of a table in the order in which they were first seen.
#[derive(Debug, Clone, Default)]
pub(super) struct Columns {
    list: Vec<Column>,
    index: HashMap<String, usize>,
    /// Names that the format has columns of, in lower case.
    reserved: Vec<String>,
    /// Names that attributes have, in lower case.
    taken: HashMap<String, usize>,
    rows: usize,
}

impl Columns {
    /// No columns; these names are taken by columns that every table of the format has.
    pub(super) fn new(reserved: &[&str]) -> Self {
        Self { reserved: reserved.iter().map(|name| name.to_lowercase()).collect(), ..Self::default() }
    }

    /// Takes the attributes of another row into account.
    pub(super) fn see(&mut self, attributes: &Map<String, Value>) {
        self.rows += 1;
        for (attribute, value) in attributes {
            let i = match self.index.get(attribute) {
                Some(&i) => i,
                None => self.add(attribute),
            };
            let (Some(kind), Some(column)) = (Kind::of(value), self.list.get_mut(i)) else { continue };
            column.values += 1;
            column.kind = Some(column.kind.map_or(kind, |known| known.with(kind)));
        }
    }

    fn add(&mut self, attribute: &str) -> usize {
        // As elsewhere, what the source says under a name that is another's is of the source.
        let of_format = self.reserved.contains(&attribute.to_lowercase());
        let own = if of_format { format!("source_{attribute}") } else { attribute.to_owned() };
        let mut name = own.clone();
        // Names that differ in case alone are one name in SQL.
        while let Some(count) = self.taken.get_mut(&name.to_lowercase()) {
            *count += 1;
            name = format!("{own}_{count}");
        }
        self.taken.insert(name.to_lowercase(), 1);
        self.list.push(Column { attribute: attribute.to_owned(), name, kind: None, values: 0 });
        self.index.insert(attribute.to_owned(), self.list.len() - 1);
        self.list.len() - 1
    }

    /// The columns.
    pub(super) fn list(&self) -> &[Column] {
        &self.list
    }

    /// What is to be told of attributes whose columns have other names, because theirs are taken by another in some case of
    /// letters, or by the format; `but` are those of which nothing need be told. `None` where there are none.
    pub(super) fn renamed(&self, but: &[&str]) -> Option<String> {
        let told = self.list.iter().filter(|column| column.name != column.attribute && column.kind.is_some());
        let told = told.filter(|column| !but.contains(&column.attribute.as_str()));
        let told: Vec<String> = told.map(|column| format!("{:?} is {:?}", column.attribute, column.name)).collect();
        (!told.is_empty()).then(|| {
            format!("the names of these attributes are taken, they are written under others: {}", told.join(", "))
        })
    }

    /// How many rows there are.
    pub(super) fn rows(&self) -> usize {
        self.rows
    }
}

/// A value as text: text as it is, anything else as JSON.
pub(super) fn text_of(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// The attributes of a feature as one row: those of the top-level object and, where it has but one child, that one's which
/// it lacks itself. The second is how many children have attributes that the row leaves out.
pub(super) fn row_of(feature: &Feature) -> (Map<String, Value>, usize) {
    let mut row = feature.root().map(|root| root.attributes.clone()).unwrap_or_default();
    let children = feature.objects.get(1..).unwrap_or_default();
    if let [child] = children {
        for (name, value) in &child.attributes {
            row.entry(name).or_insert_with(|| value.clone());
        }
    }
    let is_told = |child: &&crate::source::cityjson::CityObject| {
        child.attributes.iter().any(|(name, value)| row.get(name) != Some(value))
    };
    let left_out = children.iter().filter(is_told).count();
    (row, left_out)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn columns(rows: &[Value]) -> Vec<(String, Option<Kind>, usize)> {
        let mut columns = Columns::new(&["ID"]);
        for row in rows {
            columns.see(row.as_object().unwrap());
        }
        columns.list().iter().map(|c| (c.name.clone(), c.kind, c.values)).collect()
    }

    #[test]
    fn a_column_is_as_narrow_as_its_values_allow() {
        let rows = [
            json!({"a": 1, "b": true, "c": null, "d": 1, "e": "x"}),
            json!({"a": -5, "b": false, "d": 2.5, "e": 1, "f": [1]}),
            json!({"b": 1, "g": u64::MAX}),
        ];
        let text = Some(Kind::Text);
        let expected = [
            ("a", Some(Kind::Integer { min: -5, max: 1 }), 2),
            ("b", text, 3),
            ("c", None, 0),
            ("d", Some(Kind::Real), 2),
            ("e", text, 2),
            ("f", text, 1),
            ("g", text, 1),
        ];
        assert_eq!(columns(&rows), expected.map(|(name, kind, values)| (name.to_owned(), kind, values)));
    }

    #[test]
    fn names_that_differ_in_case_alone_become_different() {
        let names: Vec<String> =
            columns(&[json!({"id": 1, "Id": 2, "source_id": 3, "x": 4, "X": 5})]).into_iter().map(|c| c.0).collect();
        assert_eq!(names, ["source_id", "source_Id_2", "source_id_3", "x", "X_2"]);
    }
}
