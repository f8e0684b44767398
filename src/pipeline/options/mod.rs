//! The options of stages: one table per stage, from which everything else follows.

mod kind;
mod tunable;

use std::collections::BTreeMap;
use std::path::PathBuf;

use serde_json::{Map, Value};

use super::expression::Misfit;
use super::nearest::nearest;
use crate::error::InputError;

pub use kind::Kind;
pub use tunable::{Tunable, Tuning, tuned, tunings};

/// An option of a stage.
#[derive(Debug, Clone)]
pub struct OptionSpec {
    /// Its name.
    pub name: String,
    /// Other names that mean the same.
    pub aliases: &'static [&'static str],
    /// What it accepts.
    pub kind: Kind,
    /// Its default, in the form that [`Kind::accept`] gives; null when it has none.
    pub default: Value,
    /// Whether the stage cannot do without it.
    pub required: bool,
    /// What it does, without a full stop at the end.
    pub help: String,
}

impl OptionSpec {
    /// An option that may be left out and has no default.
    pub fn new(name: impl Into<String>, kind: Kind, help: impl Into<String>) -> Self {
        Self { name: name.into(), aliases: &[], kind, default: Value::Null, required: false, help: help.into() }
    }

    /// The same with a default.
    #[must_use]
    pub fn or(mut self, default: impl Into<Value>) -> Self {
        self.default = default.into();
        self
    }

    /// The same, but the stage cannot do without it.
    #[must_use]
    pub fn required(mut self) -> Self {
        self.required = true;
        self
    }

    /// The same with other names that mean it.
    #[must_use]
    pub fn aliases(mut self, aliases: &'static [&'static str]) -> Self {
        self.aliases = aliases;
        self
    }

    /// Whether it goes by this name; dashes are underscores.
    pub fn is_called(&self, name: &str) -> bool {
        let same = |own: &str| {
            own.len() == name.len() && own.bytes().zip(name.bytes()).all(|(a, b)| a == b || (a, b) == (b'_', b'-'))
        };
        same(&self.name) || self.aliases.iter().any(|alias| same(alias))
    }
}

impl From<Tuning> for OptionSpec {
    fn from(tuning: Tuning) -> Self {
        Self::new(tuning.name, tuning.kind, tuning.help).or(tuning.default)
    }
}

/// Which stage of which pipeline, for messages.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Place {
    /// The pipeline.
    pub file: PathBuf,
    /// The stage: its number and type, and its tag when it has one.
    pub stage: String,
}

impl Place {
    /// A fault of the stage.
    pub fn fault(&self, found: impl Into<String>, expected: impl Into<String>) -> InputError {
        InputError::new(&self.file, found, expected).at(self.stage.clone())
    }

    /// The refusal of a point, by its number in the set that came, whose coordinates are not finite.
    pub fn not_finite(&self, point: usize) -> InputError {
        let found = format!("coordinates that are not finite at point {point}");
        self.fault(found, "finite coordinates").remedy("Drop such points with filters.range before")
    }
}

/// The options that a stage was given, checked against its table.
#[derive(Debug, Clone)]
pub struct Values {
    place: Place,
    table: Vec<OptionSpec>,
    given: BTreeMap<String, Value>,
}

impl Values {
    /// Checks options against the table of a stage. `elsewhere` are the options that PDAL's stage of that name has beyond
    /// ours.
    ///
    /// # Errors
    /// An option that the stage does not have, a value that it does not accept, or a required option that is missing.
    pub fn new(
        place: Place,
        table: Vec<OptionSpec>,
        elsewhere: &[&str],
        given: &Map<String, Value>,
    ) -> Result<Self, InputError> {
        let mut values = Self { place, table, given: BTreeMap::new() };
        for (name, value) in given {
            values.set(name, value, elsewhere)?;
        }
        let missing = values.table.iter().find(|spec| spec.required && !values.given.contains_key(&spec.name));
        if let Some(spec) = missing {
            let found = format!("no option `{}`", spec.name);
            return Err(values.place.fault(found, format!("`{}`: {}", spec.name, spec.help)));
        }
        Ok(values)
    }

    fn set(&mut self, name: &str, value: &Value, elsewhere: &[&str]) -> Result<(), InputError> {
        let Some(spec) = self.table.iter().find(|spec| spec.is_called(name)) else {
            return Err(self.unknown(name, elsewhere));
        };
        let Some(accepted) = spec.kind.accept(value) else {
            return Err(self.fault(&spec.name, &value.to_string(), spec.kind.expected()));
        };
        self.given.insert(spec.name.clone(), accepted);
        Ok(())
    }

    fn unknown(&self, name: &str, elsewhere: &[&str]) -> InputError {
        if elsewhere.contains(&name) {
            let found = format!("the option `{name}`, which PDAL has and gable has not");
            return self.place.fault(found, "options that gable has").remedy(
                "Leave it out, or run these stages in PDAL (`pdal pipeline FILE`), write their points with writers.las \
                 and read that file here",
            );
        }
        let names: Vec<&str> = self.table.iter().map(|spec| spec.name.as_str()).collect();
        let near = nearest(name, names.iter().copied()).map(|near| format!("`{near}`, or another of "));
        let fault = self.place.fault(
            format!("the option `{name}`, which this stage does not have"),
            format!("{}{}", near.unwrap_or_default(), names.join(", ")),
        );
        fault.remedy("`gable stages NAME` describes the options of a stage")
    }

    /// The stage, for messages.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// A fault of an option.
    pub fn fault(&self, option: &str, found: &str, expected: impl Into<String>) -> InputError {
        self.place.fault(format!("{found} as `{option}`"), expected)
    }

    /// A fault of an option.
    pub fn misfit(&self, option: &str, misfit: Misfit) -> InputError {
        self.fault(option, &misfit.found, misfit.expected)
    }

    /// Whether the option was given, and is not just its default.
    pub fn is_given(&self, name: &str) -> bool {
        self.given.contains_key(name)
    }

    /// The value that was given.
    pub fn given(&self, name: &str) -> Option<&Value> {
        self.given.get(name)
    }

    /// The value, or its default; `None` when there is neither.
    pub fn value(&self, name: &str) -> Option<&Value> {
        let default = || self.table.iter().find(|spec| spec.name == name).map(|spec| &spec.default);
        self.given.get(name).or_else(default).filter(|value| !value.is_null())
    }

    /// A text.
    pub fn text(&self, name: &str) -> Option<&str> {
        self.value(name).and_then(Value::as_str)
    }

    /// A number.
    pub fn number(&self, name: &str) -> Option<f64> {
        self.value(name).and_then(Value::as_f64)
    }

    /// A whole number that is not negative.
    pub fn whole(&self, name: &str) -> Option<u64> {
        self.value(name).and_then(Value::as_u64)
    }

    /// Whether it is on.
    pub fn is_on(&self, name: &str) -> bool {
        self.value(name).and_then(Value::as_bool).unwrap_or(false)
    }

    /// Several texts or names; none without a value.
    pub fn texts(&self, name: &str) -> Vec<&str> {
        match self.value(name) {
            Some(Value::Array(values)) => values.iter().filter_map(Value::as_str).collect(),
            Some(Value::String(text)) => vec![text],
            _ => Vec::new(),
        }
    }

    /// The options that were given, by their own names, in the order of the table.
    pub fn to_json(&self) -> Map<String, Value> {
        let given = |spec: &OptionSpec| Some((spec.name.clone(), self.given.get(&spec.name)?.clone()));
        self.table.iter().filter_map(given).collect()
    }
}
