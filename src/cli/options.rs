//! The options of `gable reconstruct`, `validate` and `evaluate` as JSON, for callers that have no command line.

use std::path::Path;

use clap::error::{ContextKind, ContextValue};
use clap::{ArgAction, Args, Command, FromArgMatches};
use serde_json::{Map, Value};

use super::{config, evaluate, reconstruct, validate};
use crate::audit;
use crate::error::{InputError, Result};
use crate::evaluate::Evaluation;
use crate::run::Job;
use crate::source::footprints::redacted;

pub use super::evaluate::Heard;

/// How messages call the options.
pub(super) const NAME: &str = "options";
/// How alike a name must be to be proposed for one that is unknown (Jaro-Winkler, 0 to 1).
const ALIKE: f64 = 0.75;

/// A command whose options have names.
pub(super) struct Grammar {
    name: &'static str,
    /// Options that are passed in another way, or mean something on a command line only.
    others: &'static [&'static str],
    /// What the command takes beside its options; `""` where that is passed in another way.
    arguments: &'static str,
}

pub(super) const RECONSTRUCT: Grammar = Grammar {
    name: "reconstruct",
    others: &["quiet", "verbose", "view", "config", "plan", "job", "parts"],
    arguments: "tiles",
};
/// As options of a configuration, which stands for a command line.
pub(super) const CONFIGURATION: Grammar =
    Grammar { name: "reconstruct", others: &["config", "plan", "job", "parts"], arguments: "tiles" };
const VALIDATE: Grammar = Grammar { name: "validate", others: &["strict", "list", "json"], arguments: "" };
const EVALUATE: Grammar = Grammar {
    name: "evaluate",
    // What is tried on scans needs no model, and is no measurement of one.
    others: &[
        "points",
        "json",
        "field",
        "generate",
        "limit",
        "columns",
        "seed",
        "jobs",
        "model",
        "onnxruntime",
        "hold-out",
        "density",
        "footprints",
        "crs",
        "footprint-crs",
    ],
    arguments: "",
};

/// The job that `text` describes: a JSON object whose members have the names of the options of `gable reconstruct`, without
/// dashes in front; `tiles` are its arguments. Flags are true or false, lists are arrays or text with commas, null is the
/// default. Unlike on the command line, nothing is required: without footprints there are none, and without an output
/// [`Job::output`] is empty.
///
/// ```
/// let job = gable::cli::options::job(r#"{"tiles": "a.laz", "building-class": [1, 6], "jobs": 2}"#)?;
/// assert_eq!((job.tiles, job.threads.map(usize::from)), (vec!["a.laz".to_owned()], Some(2)));
/// let fault = gable::cli::options::job(r#"{"bilding-class": 6}"#).unwrap_err();
/// assert!(fault.to_string().ends_with("Did you mean \"building-class\"?"));
/// # Ok::<(), gable::error::InputError>(())
/// ```
///
/// # Errors
/// It is no JSON object; an option that does not exist, with the nearest one that does; or a value that an option does
/// not take.
pub fn job(text: &str) -> Result<Job, InputError> {
    let mut options = config::with_preset(object(text)?)?;
    let tiles = options.shift_remove("tiles").map(|tiles| texts("tiles", &tiles)).transpose()?.unwrap_or_default();
    let is_given = |name: &str| options.get(name).is_some_and(|value| !value.is_null());
    let mut words = Vec::new();
    if !is_given("footprints") && !is_given("no-footprint") {
        words.push("--no-footprint");
    }
    // What the command line requires and a caller need not give.
    if !is_given("output") {
        words.push("--output=none.city.json");
    }
    words.extend(["--", "tiles"]);
    let mut job = parse::<reconstruct::Args>(&RECONSTRUCT, &options, &words)?.into_job()?;
    job.tiles = tiles;
    job.command = Vec::new();
    if !is_given("output") {
        job.output = std::path::PathBuf::new();
    }
    Ok(job)
}

/// How a file is to be checked: a JSON object with the options of `gable validate`, as in [`job`].
///
/// # Errors
/// As [`job`].
pub fn validation(text: &str) -> Result<audit::Options> {
    validate::options(&parse(&VALIDATE, &object(text)?, &["--", "model"])?)
}

/// Measures a model, as `gable evaluate` does: `points` are tiles, folders and glob patterns whose points it is compared with,
/// `text` is a JSON object with the other options of that command, as in [`job`].
///
/// # Errors
/// As [`job`]; a file cannot be read, or the model, the tiles and the reference are not in one CRS.
pub fn evaluation(model: &Path, points: &[String], text: &str, heard: &mut dyn FnMut(Heard<'_>)) -> Result<Evaluation> {
    let mut args: evaluate::Args = parse(&EVALUATE, &object(text)?, &["--", "model"])?;
    args.compare_with(points);
    evaluate::evaluation(model, &args, heard)
}

/// The members of a JSON object.
fn object(text: &str) -> Result<Map<String, Value>, InputError> {
    if text.trim().is_empty() {
        return Ok(Map::new());
    }
    serde_json::from_str(text).map_err(|e| {
        InputError::new(NAME, "no JSON object", "an object such as {\"building-class\": \"6\"}")
            .at(format!("line {}, column {}", e.line(), e.column()))
            .remedy(e.to_string())
    })
}

/// What a command makes of its options and of some words behind them.
fn parse<A: Args + FromArgMatches>(
    grammar: &Grammar,
    options: &Map<String, Value>,
    others: &[&str],
) -> Result<A, InputError> {
    let command = A::augment_args(Command::new("gable").no_binary_name(true));
    let words = options.iter().map(|(name, value)| word(grammar, &command, name, value));
    let mut words: Vec<String> = words.collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect();
    words.extend(others.iter().map(|&word| word.to_owned()));
    let args = command.try_get_matches_from(words).and_then(|matches| A::from_arg_matches(&matches));
    args.map_err(|fault| explain(grammar, &fault))
}

/// An option as the command line has it: one word, or none for one that is left at its default, or one for each value of
/// an option that may be given again.
pub(super) fn word(grammar: &Grammar, command: &Command, name: &str, value: &Value) -> Result<Vec<String>, InputError> {
    let fault = |found: String, expected: &str| InputError::new(NAME, found, expected).at(format!("\"{name}\""));
    let known = || {
        let options = command.get_arguments().filter_map(clap::Arg::get_long);
        let arguments = Some(grammar.arguments).filter(|name| !name.is_empty());
        options.filter(|option| !grammar.others.contains(option)).chain(arguments)
    };
    if name == "crs" && grammar.name == RECONSTRUCT.name {
        let fault = fault("a CRS among the options".to_owned(), "it beside them");
        return Err(fault.remedy("The CRS of the points has an argument of its own"));
    }
    let argument = command.get_arguments().find(|argument| argument.get_long() == Some(name));
    let Some(argument) = argument.filter(|_| !grammar.others.contains(&name)) else {
        let plain = name.trim_start_matches('-').replace('_', "-");
        let likeness = |option: &str| strsim::jaro_winkler(&plain, option);
        let nearest = known().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
        let remedy = match nearest.filter(|option| likeness(option) >= ALIKE) {
            Some(option) => format!("Did you mean \"{option}\"?"),
            None => format!("There are {}", known().collect::<Vec<_>>().join(", ")),
        };
        return Err(fault("an unknown option".to_owned(), &format!("one of `gable {}`", grammar.name)).remedy(remedy));
    };
    if matches!(argument.get_action(), ArgAction::SetTrue) {
        return match value {
            Value::Bool(true) => Ok(vec![format!("--{name}")]),
            Value::Bool(false) | Value::Null => Ok(Vec::new()),
            other => Err(fault(redacted(&other.to_string()), "true or false")),
        };
    }
    if value.is_null() {
        return Ok(Vec::new());
    }
    let texts = texts(name, value)?;
    let may_be_given_again = matches!(argument.get_action(), ArgAction::Append);
    if may_be_given_again && argument.get_value_delimiter().is_none() {
        return Ok(texts.into_iter().map(|text| format!("--{name}={text}")).collect());
    }
    Ok(vec![format!("--{name}={}", texts.join(","))])
}

/// A value, or several of them, as text.
pub(super) fn texts(name: &str, value: &Value) -> Result<Vec<String>, InputError> {
    match value {
        Value::String(text) => Ok(vec![text.clone()]),
        Value::Number(_) | Value::Bool(_) => Ok(vec![value.to_string()]),
        Value::Null => Ok(Vec::new()),
        Value::Array(values) if !values.iter().any(|value| value.is_array() || value.is_object()) => {
            Ok(values.iter().map(|value| texts(name, value)).collect::<Result<Vec<_>, _>>()?.concat())
        }
        other => Err(InputError::new(
            NAME,
            redacted(&other.to_string()),
            "a text, a number, true, false or an array of them",
        )
        .at(format!("\"{name}\""))),
    }
}

/// What the command line says of an option, without its words on usage.
fn explain(grammar: &Grammar, fault: &clap::Error) -> InputError {
    let text = |kind| match fault.get(kind) {
        Some(ContextValue::String(text)) => Some(text.clone()),
        Some(ContextValue::Strings(texts)) => Some(texts.join(", ")),
        _ => None,
    };
    let argument = text(ContextKind::InvalidArg).unwrap_or_default();
    let name = argument.trim_start_matches('-').split([' ', '=']).next().unwrap_or_default().to_owned();
    let said = fault.to_string();
    let said = said.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned();
    let reason = std::error::Error::source(fault).map(ToString::to_string);
    let expected = match (reason, text(ContextKind::ValidValue)) {
        (Some(reason), _) => reason,
        (None, Some(values)) => format!("one of {values}"),
        (None, None) => format!("what `gable {} --help` says", grammar.name),
    };
    let found = text(ContextKind::InvalidValue).filter(|_| !name.is_empty()).unwrap_or(said);
    InputError::new(NAME, redacted(&found), expected).at(format!("\"{name}\""))
}

#[cfg(test)]
mod tests {
    use super::{job, validation};
    use crate::network::Field;
    use crate::segment::BuildingClasses;

    #[test]
    fn options_are_those_of_the_command_line() {
        let job = job(r#"{"footprints": "f.gpkg", "layer": "houses", "output": "a.city.jsonl", "overwrite": true,
            "resume": false, "building-class": [1, 6], "ground-class": "2,8", "field": "height-field", "lambda": 2.5,
            "jobs": 3, "report": null, "point-cloud-date": "2014-03", "tiles": ["a.laz", "b.laz"]}"#)
        .unwrap();
        let source = job.footprints.unwrap();
        assert_eq!((source.path.to_str(), source.options.layer.as_deref()), (Some("f.gpkg"), Some("houses")));
        assert_eq!((job.output.to_str(), job.overwrite, job.resume), (Some("a.city.jsonl"), true, false));
        assert_eq!(job.segmentation.building_classes, BuildingClasses::Listed(vec![1, 6]));
        assert_eq!(job.segmentation.ground_classes, [2, 8]);
        assert_eq!((job.field.field, job.parameters.labelling.lambda), (Field::HeightField, 2.5));
        assert_eq!((job.threads.map(usize::from), job.report), (Some(3), None));
        assert_eq!((job.tiles, job.command), (vec!["a.laz".to_owned(), "b.laz".to_owned()], Vec::new()));
        let bare = super::job("{}").unwrap();
        assert!(bare.tiles.is_empty() && bare.footprints.is_none() && bare.output.as_os_str().is_empty());
    }

    #[test]
    fn what_is_wrong_is_said() {
        let cases = [
            ("[1]", &["options, line 1", "no JSON object"][..]),
            ("{\"lambda\": 1", &["options, line 1, column 12"]),
            (r#"{"lamda": 1}"#, &["\"lamda\"", "unknown option", "Did you mean \"lambda\"?"]),
            (r#"{"building_class": 6}"#, &["Did you mean \"building-class\"?"]),
            (r#"{"quiet": true}"#, &["unknown option"]),
            (r#"{"crs": "EPSG:7415"}"#, &["argument of its own"]),
            (r#"{"lambda": "much"}"#, &["\"lambda\"", "found much", "a number from 0 to 1000"]),
            (r#"{"lambda": -1}"#, &["found -1", "a number from 0 to 1000"]),
            (r#"{"field": "neutral"}"#, &["\"field\"", "found neutral", "height-field"]),
            (r#"{"overwrite": "yes"}"#, &["\"overwrite\"", "true or false"]),
            (r#"{"lambda": {"a": 1}}"#, &["\"lambda\"", "a text, a number"]),
            (r#"{"building-class": 2}"#, &["class 2 as building and as ground"]),
            (r#"{"footprints": "a.gpkg", "no-footprint": true}"#, &["cannot be used with"]),
            (r#"{"filter": "a > 1"}"#, &["filter"]),
            (r#"{"detector": "PG:user=me password=hunter2"}"#, &["found PG:user=me password=***,"]),
            (r#"{"detector": ["PG:password=hunter2", 1]}"#, &["found PG:password=***"]),
            (r#"{"detector": {"a": "PG:password=hunter2"}}"#, &["password=***"]),
            (r#"{"overwrite": "postgres://me:hunter2@h"}"#, &["found \"postgres://me:***@h\""]),
        ];
        for (options, parts) in cases {
            let message = job(options).unwrap_err().to_string();
            assert!(!message.contains("hunter2"), "{message}");
            for part in parts {
                assert!(message.contains(part), "{options}: {message}");
            }
        }
    }

    #[test]
    fn other_commands_have_options_of_their_own() {
        let options = validation(r#"{"planarity": 0.01, "no-rounding": true, "no-schema": true}"#).unwrap();
        assert_eq!((options.tolerances.planarity, options.tolerances.rounding, options.schema), (0.01, false, false));
        let message = validation(r#"{"planarty": 0.01}"#).unwrap_err().to_string();
        assert!(message.contains("one of `gable validate`. Did you mean \"planarity\"?"), "{message}");
        assert!(validation(r#"{"json": "report.json"}"#).unwrap_err().to_string().contains("unknown option"));
        assert!(validation(r#"{"snap": 7}"#).unwrap_err().to_string().contains("a number from 0 to 1"));
    }
}
