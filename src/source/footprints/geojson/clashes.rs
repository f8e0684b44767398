//! What stands twice under one name in GeoJSON, of which only one can be kept.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fmt;

use serde::de::{DeserializeSeed, Deserializer, Error, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Number, Value};

/// What was seen twice so far.
#[derive(Default)]
pub(super) struct Clashes {
    /// How often a name was repeated within its object.
    repeated: RefCell<BTreeMap<String, u64>>,
    /// How many features have an `id` and another one among their properties.
    ids: RefCell<u64>,
}

impl Clashes {
    /// Notes a feature with two ids.
    pub(super) fn two_ids(&self) {
        *self.ids.borrow_mut() += 1;
    }

    /// What is to be told, one sentence each.
    pub(super) fn warnings(self) -> Vec<String> {
        let repeated = self.repeated.into_inner().into_iter();
        let mut told: Vec<String> = repeated
            .map(|(name, n)| format!("`{name}` stands more than once in one object ({n} times): the last value counts"))
            .collect();
        let ids = self.ids.into_inner();
        if ids > 0 {
            told.push(format!(
                "{ids} features have an `id` of their own and another among their properties, which counts"
            ));
        }
        told
    }
}

/// Reads any JSON as `serde_json` does, and notes names that are repeated.
#[derive(Clone, Copy)]
pub(super) struct Noting<'a>(pub &'a Clashes);

impl<'de> DeserializeSeed<'de> for Noting<'_> {
    type Value = Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Value, D::Error> {
        deserializer.deserialize_any(self)
    }
}

impl<'de> Visitor<'de> for Noting<'_> {
    type Value = Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("JSON")
    }

    fn visit_bool<E: Error>(self, value: bool) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_i64<E: Error>(self, value: i64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Value, E> {
        Ok(Number::from_f64(value).map_or(Value::Null, Value::Number))
    }

    fn visit_str<E: Error>(self, value: &str) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_string<E: Error>(self, value: String) -> Result<Value, E> {
        Ok(value.into())
    }

    fn visit_unit<E: Error>(self) -> Result<Value, E> {
        Ok(Value::Null)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut elements: A) -> Result<Value, A::Error> {
        let mut array = Vec::new();
        while let Some(element) = elements.next_element_seed(self)? {
            array.push(element);
        }
        Ok(array.into())
    }

    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<Value, A::Error> {
        let mut object = Map::new();
        while let Some(name) = members.next_key::<String>()? {
            let value = members.next_value_seed(self)?;
            if object.contains_key(&name) {
                *self.0.repeated.borrow_mut().entry(name.clone()).or_default() += 1;
            }
            object.insert(name, value);
        }
        Ok(object.into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_is_read_as_it_is_and_what_stands_twice_is_told() {
        let text = r#"{"a": [1, -2, 0.1, 18446744073709551615, "é\n", null, true, {}], "b": {"x": 1, "x": 2}, "a\"": "", "b": 3}"#;
        let clashes = Clashes::default();
        let mut json = serde_json::Deserializer::from_str(text);
        let value = Noting(&clashes).deserialize(&mut json).unwrap();
        assert_eq!(value, serde_json::from_str::<Value>(text).unwrap());
        clashes.two_ids();
        let told = clashes.warnings();
        assert_eq!(told.len(), 3, "{told:?}");
        assert!(told[0].starts_with("`b` stands") && told[1].starts_with("`x` stands"), "{told:?}");
    }
}
