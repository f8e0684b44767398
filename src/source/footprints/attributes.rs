//! The attributes of features by their names.

use std::collections::HashSet;

use serde_json::{Map, Value};

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
