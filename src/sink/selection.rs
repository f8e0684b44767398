//! Which attributes are written, and what the names of gable's own begin with.

use std::fmt;
use std::str::FromStr;

use glob::{MatchOptions, Pattern};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::source::cityjson::CityModel;

/// What the names of gable's own attributes begin with unless another prefix is asked for.
pub const PREFIX: &str = "gable_";
/// The member of a model's metadata that tells the prefix, where it is another.
pub const PREFIX_MEMBER: &str = "gable_attribute_prefix";
/// Characters of a prefix, at most.
const LONGEST: usize = 32;

/// Which attributes are written.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct AttributeOptions {
    /// Which of gable's own, by their names with or without a prefix.
    pub own: Names,
    /// What the names of gable's own begin with; see [`prefix`].
    pub prefix: String,
    /// Which of the footprint's.
    pub source: Names,
}

impl Default for AttributeOptions {
    /// All of both; gable's own begin with [`PREFIX`].
    fn default() -> Self {
        Self { own: Names::All, prefix: PREFIX.to_owned(), source: Names::All }
    }
}

/// Some names: all, or those of a list such as `roof_type,height_*`, in any case of letters. `*` stands for any characters,
/// `?` for one; `none` is a list without any.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(try_from = "String", into = "String")]
#[schemars(with = "String")]
pub enum Names {
    /// All.
    #[default]
    All,
    /// Those that one of these stands for.
    Listed(Vec<Name>),
}

/// A name, or a pattern for several.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Name {
    text: String,
    pattern: Option<Pattern>,
}

impl Name {
    fn stands_for(&self, name: &str) -> bool {
        const ANY_CASE: MatchOptions = MatchOptions {
            case_sensitive: false,
            require_literal_separator: false,
            require_literal_leading_dot: false,
        };
        // A name may hold what would be a pattern.
        self.text.eq_ignore_ascii_case(name)
            || self.pattern.as_ref().is_some_and(|pattern| pattern.matches_with(name, ANY_CASE))
    }
}

impl fmt::Display for Name {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Names {
    /// Whether this name is among them.
    pub fn have(&self, name: &str) -> bool {
        match self {
            Self::All => true,
            Self::Listed(names) => names.iter().any(|one| one.stands_for(name)),
        }
    }

    /// The first of the list that stands for none of `known`.
    pub fn unknown(&self, known: &[&str]) -> Option<&Name> {
        let Self::Listed(names) = self else { return None };
        names.iter().find(|name| !known.iter().any(|one| name.stands_for(one)))
    }
}

impl From<Names> for String {
    /// The list as it is read.
    fn from(names: Names) -> Self {
        match names {
            Names::All => "all".to_owned(),
            Names::Listed(names) if names.is_empty() => "none".to_owned(),
            Names::Listed(names) => names.iter().map(ToString::to_string).collect::<Vec<_>>().join(","),
        }
    }
}

impl TryFrom<String> for Names {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl FromStr for Names {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.trim() {
            "all" => return Ok(Self::All),
            "none" => return Ok(Self::Listed(Vec::new())),
            _ => {}
        }
        let name = |text: &str| {
            let is_pattern = text.contains(['*', '?', '[']);
            Name { text: text.to_owned(), pattern: Pattern::new(text).ok().filter(|_| is_pattern) }
        };
        let names: Vec<&str> = text.split(',').map(str::trim).collect();
        if names.contains(&"") {
            return Err("names parted by commas are expected, such as roof_type,height_*; or all, or none".to_owned());
        }
        Ok(Self::Listed(names.into_iter().map(name).collect()))
    }
}

/// A prefix of attributes: at most 32 letters, digits and `_ - . :`, or nothing.
///
/// # Errors
/// What was expected. A `+` at the beginning would ask for an Extension of CityJSON.
pub fn prefix(text: &str) -> Result<String, String> {
    let is_plain = text.chars().all(|c| c.is_alphanumeric() || "_-.:".contains(c));
    if is_plain && text.chars().count() <= LONGEST {
        return Ok(text.to_owned());
    }
    Err(format!("at most {LONGEST} letters, digits and _ - . : are expected"))
}

/// What the names of gable's own attributes in a model begin with; `head` is the head of its file.
pub fn prefix_in(head: &CityModel) -> &str {
    head.metadata.get(PREFIX_MEMBER).and_then(Value::as_str).unwrap_or(PREFIX)
}

/// One of gable's own attributes, by its name after the prefix, in a model with this prefix.
pub fn own<'a>(attributes: &'a Map<String, Value>, prefix: &str, bare: &str) -> Option<&'a Value> {
    attributes.get(&format!("{prefix}{bare}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_listed_as_they_are_or_by_patterns() {
        let names: Names = "Roof_Type, height_*,a[b]".parse().unwrap();
        let had = |name: &str| names.have(name);
        assert!(had("roof_type") && had("HEIGHT_ridge") && had("a[b]"));
        assert!(!had("height") && !had("type") && !had("roof_type_2"));
        assert_eq!(names.unknown(&["roof_type", "height_x"]).unwrap().to_string(), "a[b]");
        assert_eq!("all".parse(), Ok(Names::All));
        assert_eq!(String::from(names), "Roof_Type,height_*,a[b]");
        let none: Names = "none".parse().unwrap();
        assert!(!none.have("none") && none.unknown(&[]).is_none());
        assert!("a,,b".parse::<Names>().is_err() && "".parse::<Names>().is_err());
    }

    #[test]
    fn a_prefix_is_plain() {
        for good in ["", "b_", "bag:", "größe-"] {
            assert_eq!(prefix(good).as_deref(), Ok(good));
        }
        for bad in ["+x", "a b", "x\n", &"x".repeat(33)] {
            assert!(prefix(bad).is_err(), "{bad}");
        }
    }
}
