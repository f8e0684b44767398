//! Parameters as flags, made from the structures that hold them.
//!
//! A new field of [`Parameters`] or [`SegmentOptions`] becomes a flag without a line here: its name is the flag, its
//! documentation the help, its default the default, its type and range decide what is accepted. Fields of nested
//! structures are flags like all others; that no two have the same name is tested.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser, ValueParser};
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Command, FromArgMatches};
use schemars::JsonSchema;
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::reconstruct::Parameters;
use crate::segment::SegmentOptions;

/// A structure whose fields are flags.
pub trait Tunable: Clone + Default + Serialize + DeserializeOwned + JsonSchema {
    /// Under which heading the help lists them.
    const HEADING: &'static str;
    /// Fields that have a flag of their own elsewhere.
    const ELSEWHERE: &'static [&'static str];
    /// The ranges of flags where the structure sets none or takes what lies outside for the nearest value inside: on the
    /// command line such a value is a slip, and is refused.
    const LIMITS: &'static [(&'static str, [f64; 2])];
}

impl Tunable for Parameters {
    const HEADING: &'static str = "Method";
    const ELSEWHERE: &'static [&'static str] = &[];
    const LIMITS: &'static [(&'static str, [f64; 2])] = &[
        ("noise-factor", [1.0, 100.0]),
        ("minimum-tolerance", [0.001, 10.0]),
        ("maximum-tolerance", [0.001, 10.0]),
        ("minimum-area", [0.0, 10_000.0]),
        ("minimum-inliers", [3.0, 100_000.0]),
        ("maximum-density", [1.0, 10_000.0]),
        ("merge-tolerance", [0.0, 10.0]),
        ("regularise-tolerance", [0.0, 10.0]),
        ("footprint-tolerance", [0.0, 10.0]),
        ("step-height", [0.0, 100.0]),
        ("step-length", [0.0, 100.0]),
        ("lambda", [0.0, 1000.0]),
        ("volume-exponent", [0.0, 1.0]),
        ("minimum-feature", [0.0, 10.0]),
    ];
}

impl Tunable for SegmentOptions {
    const HEADING: &'static str = "Which points belong to a building";
    const ELSEWHERE: &'static [&'static str] = &["building_classes", "ground_classes"];
    const LIMITS: &'static [(&'static str, [f64; 2])] = &[
        ("ring-width", [0.1, 1000.0]),
        ("ring-limit", [0.0, 1000.0]),
        ("ring-area", [0.0, 100_000.0]),
        ("ground-percentile", [0.0, 100.0]),
        ("least-height", [0.0, 1000.0]),
        ("flatness", [0.0, 1.0]),
        ("hover-gap", [0.01, 1000.0]),
        ("party-wall-band", [0.0, 100.0]),
        ("party-wall-rise", [0.01, 1000.0]),
    ];
}

/// The fields of a structure as flags.
#[derive(Debug, Clone, Default)]
pub struct Flags<T>(pub T);

/// One parameter.
struct Flag {
    /// The flag without its dashes.
    name: String,
    /// Where it stands in the JSON form of its structure, as a JSON pointer.
    pointer: String,
    /// What the documentation of the field says.
    help: String,
    /// What it accepts.
    kind: Kind,
    /// Its default; null when it has none.
    default: Value,
}

/// What a flag accepts.
#[derive(Clone)]
enum Kind {
    /// One of these names, each with its documentation.
    Choice(Vec<(String, String)>),
    /// A number, whole or not, from the first to the last limit.
    Number { whole: bool, limits: [f64; 2] },
    /// `true` or `false`.
    Boolean,
    /// Text.
    Text,
}

impl Kind {
    /// What a schema without references accepts.
    fn of(schema: &Value) -> Self {
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
            return Self::of(some);
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

    fn parser(&self) -> ValueParser {
        match self {
            Self::Choice(names) => {
                let values = names.iter().map(|(name, help)| PossibleValue::new(name.clone()).help(help.clone()));
                PossibleValuesParser::new(values).map(Value::String).into()
            }
            &Self::Number { whole, limits } => ValueParser::new(move |text: &str| number(text, whole, limits)),
            Self::Boolean => ValueParser::from(clap::builder::BoolValueParser::new().map(Value::Bool)),
            Self::Text => ValueParser::new(|text: &str| Ok::<_, String>(Value::String(text.to_owned()))),
        }
    }

    fn placeholder(&self) -> &'static str {
        match self {
            Self::Choice(_) => "NAME",
            Self::Number { .. } => "NUMBER",
            Self::Boolean => "BOOL",
            Self::Text => "TEXT",
        }
    }
}

/// Reads a number.
///
/// # Errors
/// What was expected instead.
fn number(text: &str, whole: bool, [low, high]: [f64; 2]) -> Result<Value, String> {
    let kind = if whole { "a whole number" } else { "a number" };
    let range = match (low.is_finite(), high.is_finite()) {
        (true, true) => format!(" from {low} to {high}"),
        (true, false) => format!(" of at least {low}"),
        (false, true) => format!(" of at most {high}"),
        (false, false) => String::new(),
    };
    let value: Value = serde_json::from_str(text.trim()).unwrap_or_default();
    let is_whole = value.is_i64() || value.is_u64();
    match value.as_f64() {
        Some(number) if (is_whole || !whole) && (low..=high).contains(&number) => Ok(value),
        _ => Err(format!("{kind}{range} is expected")),
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
fn description(schema: &Value) -> String {
    let text = schema.get("description").and_then(Value::as_str).unwrap_or_default();
    text.replace("[`", "`").replace("`]", "`").replace('\n', " ").trim_end_matches('.').to_owned()
}

/// One flag per field, in the order of the fields.
fn flags<T: Tunable>() -> Vec<Flag> {
    let settings = schemars::generate::SchemaSettings::draft2020_12().with(|s| s.inline_subschemas = true);
    let schema = settings.into_generator().into_root_schema_for::<T>().to_value();
    let default = serde_json::to_value(T::default()).unwrap_or_default();
    let mut flags = Vec::new();
    collect(&schema, &default, "", &mut flags);
    flags.retain(|flag| !T::ELSEWHERE.contains(&flag.pointer.trim_start_matches('/')));
    for flag in &mut flags {
        let known = T::LIMITS.iter().find(|(name, _)| *name == flag.name);
        if let (Some((_, [low, high])), Kind::Number { limits, .. }) = (known, &mut flag.kind) {
            *limits = [limits[0].max(*low), limits[1].min(*high)];
        }
    }
    flags
}

fn collect(schema: &Value, default: &Value, pointer: &str, flags: &mut Vec<Flag>) {
    let Some(properties) = schema.get("properties").and_then(Value::as_object) else { return };
    for (field, schema) in properties {
        let name = field.replace('_', "-");
        let pointer = format!("{pointer}/{field}");
        let default = default.get(field).unwrap_or(&Value::Null);
        if schema.get("properties").is_some() {
            collect(schema, default, &pointer, flags);
        } else {
            flags.push(Flag {
                name,
                pointer,
                help: description(schema),
                kind: Kind::of(schema),
                default: default.clone(),
            });
        }
    }
}

impl<T: Tunable> clap::Args for Flags<T> {
    fn augment_args(command: Command) -> Command {
        flags::<T>().into_iter().fold(command, |command, flag| {
            let mut arg = Arg::new(flag.name.clone())
                .long(flag.name)
                .help(flag.help)
                .help_heading(T::HEADING)
                .value_name(flag.kind.placeholder())
                // So that `--lambda -1` is told its range rather than taken for an option.
                .allow_negative_numbers(matches!(flag.kind, Kind::Number { .. }))
                .value_parser(flag.kind.parser());
            match flag.default {
                Value::Null => {}
                Value::String(text) => arg = arg.default_value(text),
                other => arg = arg.default_value(other.to_string()),
            }
            command.arg(arg)
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl<T: Tunable> FromArgMatches for Flags<T> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut method = Self::default();
        method.update_from_arg_matches(matches)?;
        Ok(method)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        let fault = |text: String| clap::Error::raw(ErrorKind::ValueValidation, text + "\n");
        let mut parameters = serde_json::to_value(&self.0).map_err(|e| fault(e.to_string()))?;
        for flag in flags::<T>() {
            if matches.value_source(&flag.name) != Some(ValueSource::CommandLine) {
                continue;
            }
            let (Some(value), Some(place)) =
                (matches.get_one::<Value>(&flag.name), parameters.pointer_mut(&flag.pointer))
            else {
                continue;
            };
            *place = value.clone();
            self.0 = serde_json::from_value(parameters.clone())
                .map_err(|e| fault(format!("invalid value '{value}' for '--{}': {e}", flag.name)))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;
    use serde_json::json;

    use super::*;
    use crate::reconstruct::primitives::Detector;

    #[derive(Debug, Parser)]
    struct Cli {
        #[command(flatten)]
        method: Flags<Parameters>,
        #[command(flatten)]
        points: Flags<SegmentOptions>,
    }

    fn check<T: Tunable>() -> Vec<String> {
        let fields = serde_json::to_value(T::default()).unwrap();
        let flags = flags::<T>();
        assert!(flags.len() + T::ELSEWHERE.len() >= fields.as_object().unwrap().len());
        for flag in &flags {
            assert!(!flag.help.is_empty(), "--{} has no help", flag.name);
            assert!(fields.pointer(&flag.pointer).is_some(), "{} is nowhere in the structure", flag.pointer);
        }
        for (name, _) in T::LIMITS {
            assert!(flags.iter().any(|flag| flag.name == *name), "a range for --{name}, which is no flag");
        }
        flags.into_iter().map(|flag| flag.name).collect()
    }

    #[test]
    fn every_parameter_is_a_flag_with_help() {
        let mut names = check::<Parameters>();
        names.extend(check::<SegmentOptions>());
        let count = names.len();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), count, "two flags of one name");
    }

    #[test]
    fn defaults_are_those_of_the_structures() {
        let cli = Cli::try_parse_from(["gable"]).unwrap();
        assert_eq!(cli.method.0, Parameters::default());
        assert_eq!(cli.points.0, SegmentOptions::default());
    }

    #[test]
    fn a_flag_sets_its_parameter_and_nothing_else() {
        let set = Cli::try_parse_from(["gable", "--detector", "ransac"]).unwrap().method.0;
        let mut expected = Parameters::default();
        expected.detection.detector = Detector::Ransac;
        assert_eq!(set, expected);
        let message = Cli::try_parse_from(["gable", "--detector", "ransack"]).unwrap_err().to_string();
        assert!(message.contains("region-growing") && message.contains("'ransac'"), "{message}");
        let set = Cli::try_parse_from(["gable", "--ring-width", "4.5"]).unwrap().points.0;
        assert_eq!(set, SegmentOptions { ring_width: 4.5, ..SegmentOptions::default() });
    }

    #[test]
    fn kinds_follow_the_schema() {
        let parse = |schema: Value, text: &str| {
            let command = Command::new("x").arg(Arg::new("v").long("v").value_parser(Kind::of(&schema).parser()));
            let matches = command.try_get_matches_from(["x".to_owned(), format!("--v={text}")]);
            matches.ok().and_then(|m| m.get_one::<Value>("v").cloned())
        };
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
    fn nested_parameters_keep_their_own_names() {
        let schema =
            json!({"properties": {"cut": {"properties": {"max_cells": {"type": "integer", "description": "d"}}}}});
        let mut flags = Vec::new();
        collect(&schema, &json!({"cut": {"max_cells": 3}}), "", &mut flags);
        assert_eq!((flags[0].name.as_str(), flags[0].pointer.as_str()), ("max-cells", "/cut/max_cells"));
        assert_eq!(flags[0].default, json!(3));
    }
}
