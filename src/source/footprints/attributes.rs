//! The attributes of features by their names.

use std::collections::HashSet;
use std::fmt;

use serde::de::{Deserialize, Deserializer, IgnoredAny, MapAccess, Visitor};
use serde::{Serialize, Serializer};
use serde_json::{Map, Value};

/// Values that are nested deeper are kept as their text: what reads them later reads no deeper than 128, and they lie deeper there.
const DEEPEST: usize = 32;

/// The attributes of a feature, in their order.
///
/// There are as many as footprints, and few of them are looked at, so they are kept as the text of a JSON object: that takes a
/// quarter of the memory of a map. Numbers come back to the last bit.
#[derive(Clone, PartialEq, Eq)]
pub struct Attributes(Box<str>);

impl Attributes {
    /// All of them.
    pub fn to_map(&self) -> Map<String, Value> {
        // What was written by `From` is read.
        serde_json::from_str(&self.0).unwrap_or_default()
    }

    /// The value of an attribute by its name.
    pub fn get(&self, name: &str) -> Option<Value> {
        self.find(name).exact
    }

    /// The value of an attribute by its name; by its name without regard to case where there is no such.
    pub fn meant(&self, name: &str) -> Option<Value> {
        let Found { exact, alike, .. } = self.find(name);
        exact.or(alike)
    }

    fn find(&self, name: &str) -> Found {
        let mut text = serde_json::Deserializer::from_str(&self.0);
        text.deserialize_map(Find(name)).unwrap_or_default()
    }
}

impl From<Map<String, Value>> for Attributes {
    fn from(mut attributes: Map<String, Value>) -> Self {
        for value in attributes.values_mut().filter(|value| is_deeper(value, DEEPEST)) {
            *value = Value::String(value.to_string());
        }
        Self(Value::Object(attributes).to_string().into_boxed_str())
    }
}

impl Default for Attributes {
    fn default() -> Self {
        Self::from(Map::new())
    }
}

impl fmt::Debug for Attributes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

/// As the text.
impl Serialize for Attributes {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&self.0)
    }
}

impl<'de> Deserialize<'de> for Attributes {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        String::deserialize(deserializer).map(|text| Self(text.into_boxed_str()))
    }
}

fn is_deeper(value: &Value, levels: usize) -> bool {
    let Some(levels) = levels.checked_sub(1) else { return value.is_array() || value.is_object() };
    match value {
        Value::Array(values) => values.iter().any(|value| is_deeper(value, levels)),
        Value::Object(values) => values.values().any(|value| is_deeper(value, levels)),
        _ => false,
    }
}

/// What is found of a name.
#[derive(Default)]
struct Found {
    exact: Option<Value>,
    /// The first whose name differs in case alone.
    alike: Option<Value>,
}

/// Looks for a name, and skips the values of all others.
struct Find<'a>(&'a str);

impl<'de> Visitor<'de> for Find<'_> {
    type Value = Found;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("attributes")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Found, A::Error> {
        let mut found = Found::default();
        while let Some(name) = map.next_key::<String>()? {
            if name == self.0 {
                found.exact = Some(map.next_value()?);
            } else if found.alike.is_none() && name.eq_ignore_ascii_case(self.0) {
                found.alike = Some(map.next_value()?);
            } else {
                map.next_value::<IgnoredAny>()?;
            }
        }
        Ok(found)
    }
}

/// The names of attributes in the order in which they first occur.
#[derive(Default)]
pub(super) struct Columns {
    pub names: Vec<String>,
    seen: HashSet<String>,
}

impl Columns {
    pub fn extend<'a>(&mut self, names: impl IntoIterator<Item = &'a String>) {
        for name in names {
            if !self.seen.contains(name) {
                self.seen.insert(name.clone());
                self.names.push(name.clone());
            }
        }
    }
}

/// The names of columns, each once: of several of one name, as in a dBASE table that shortens them, the later ones get a
/// number. The second is what is to be told of it, one sentence each.
pub(super) fn distinct(names: impl IntoIterator<Item = String>) -> (Vec<String>, Vec<String>) {
    let names: Vec<String> = names.into_iter().collect();
    let mut taken: HashSet<String> = names.iter().cloned().collect();
    let mut seen = HashSet::new();
    let mut told = Vec::new();
    let mut name = |name: &String| {
        if seen.insert(name.clone()) {
            return name.clone();
        }
        let mut number = 2;
        let mut free = format!("{name}_{number}");
        while !taken.insert(free.clone()) {
            number += 1;
            free = format!("{name}_{number}");
        }
        told.push(format!("another attribute is called `{name}` as well: it is read as `{free}`"));
        free
    };
    let distinct = names.iter().map(&mut name).collect();
    (distinct, told)
}

/// The one of some names that is meant: the same, or the same but for case.
///
/// # Errors
/// Those that are meant as well.
pub(super) fn meant<'a>(wanted: &str, names: &'a [String]) -> Result<Option<&'a String>, Vec<&'a str>> {
    if let Some(exact) = names.iter().find(|name| *name == wanted) {
        return Ok(Some(exact));
    }
    let alike: Vec<&String> = names.iter().filter(|name| name.eq_ignore_ascii_case(wanted)).collect();
    match alike[..] {
        [] => Ok(None),
        [only] => Ok(Some(only)),
        _ => Err(alike.iter().map(|name| name.as_str()).collect()),
    }
}

/// The value of an attribute by its name; by its name without regard to case where there is no such.
pub fn attribute<'a>(attributes: &'a Map<String, Value>, name: &str) -> Option<&'a Value> {
    attributes
        .get(name)
        .or_else(|| attributes.iter().find(|(key, _)| key.eq_ignore_ascii_case(name)).map(|(_, value)| value))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_come_back_in_their_order_to_the_last_bit() {
        let map = serde_json::json!({
            "b": 0.1 + 0.2, "a": "é\n\"", "Name": 1, "name": null, "big": u64::MAX, "list": [1, {"x": [-0.0]}]
        });
        let map = map.as_object().unwrap();
        let attributes = Attributes::from(map.clone());
        assert_eq!(Value::Object(attributes.to_map()).to_string(), Value::Object(map.clone()).to_string());
        for (name, value) in map {
            assert_eq!(attributes.get(name).as_ref(), Some(value));
        }
        assert_eq!((attributes.get("NAME"), attributes.meant("NAME")), (None, Some(Value::from(1))));
        assert_eq!(attributes.meant("name"), Some(Value::Null));
        assert_eq!(attributes.meant("nothing"), None);
        assert_eq!(Attributes::default().to_map(), Map::new());
        let written = serde_json::to_string(&attributes).unwrap();
        assert_eq!(serde_json::from_str::<Attributes>(&written).unwrap(), attributes);
    }

    #[test]
    fn what_is_nested_too_deep_to_be_read_again_becomes_text() {
        for (levels, is_text) in [(1, false), (DEEPEST, false), (DEEPEST + 1, true), (120, true)] {
            let deep = (0..levels).fold(Value::Null, |inner, level| match level % 2 {
                0 => Value::Array(vec![inner]),
                _ => serde_json::json!({ "in": inner }),
            });
            let text = deep.to_string();
            let attributes = Attributes::from(Map::from_iter([("deep".to_owned(), deep.clone())]));
            let expected = if is_text { Value::String(text) } else { deep };
            assert_eq!(attributes.get("deep"), Some(expected), "{levels}");
        }
    }

    #[test]
    fn names_become_distinct_and_are_found_whatever_their_case() {
        let names = |list: &[&str]| list.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
        let (distinct, told) = distinct(names(&["building_i", "id", "building_i", "building_i_2", "building_i", "ID"]));
        assert_eq!(distinct, names(&["building_i", "id", "building_i_3", "building_i_2", "building_i_4", "ID"]));
        assert!(
            told.len() == 2 && told[0].ends_with("called `building_i` as well: it is read as `building_i_3`"),
            "{told:?}"
        );
        let columns = names(&["Id", "ID", "height"]);
        assert_eq!(meant("ID", &columns), Ok(Some(&columns[1])));
        assert_eq!(meant("HEIGHT", &columns), Ok(Some(&columns[2])));
        assert_eq!(meant("id", &columns), Err(vec!["Id", "ID"]));
        assert_eq!(meant("width", &columns), Ok(None));
    }
}
