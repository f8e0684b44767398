//! `gable edit`: the options of the run that made a model, from its report.
//!
//! They become words of the command line, as those of a [configuration](super::config) do; what is given there goes before
//! them.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command};
use serde_json::Value;

use super::config;
use crate::error::Error;
use crate::run::output::report_path;

/// The command that makes models, and the one that takes up what it made.
const MADE_BY: &str = "reconstruct";
const TAKEN_UP_BY: &str = "edit";
/// What a run says of its own process and files, and of the way to its options, which are spelt out.
const OF_RUN: [&str; 4] = ["overwrite", "jobs", "quiet", "config"];
/// What is said of footprints, and nothing where there are none.
const OF_FOOTPRINTS: [&str; 11] = [
    "footprints",
    "roofprint",
    "footprint_crs",
    "layer",
    "query",
    "filter",
    "id_attribute",
    "box",
    "limit_area",
    "footprint_attributes",
    "preset",
];

/// The words of the command line with the options of the run that made its model, where the report of that tells them;
/// `command` is the grammar.
///
/// # Errors
/// The configuration of that run can no longer be read.
pub(super) fn spell_out(mut words: Vec<OsString>, command: &Command) -> Result<Vec<OsString>, Error> {
    if words.get(1).is_none_or(|name| name != TAKEN_UP_BY) {
        return Ok(words);
    }
    let grammar = |name: &str| {
        let mut own = command.find_subcommand(name)?.clone().no_binary_name(true).ignore_errors(true);
        own.build();
        Some(own)
    };
    let (Some(own), Some(of_run)) = (grammar(TAKEN_UP_BY), grammar(MADE_BY)) else { return Ok(words) };
    // What is wrong with the words is told when all of them are together.
    let Ok(given) = own.clone().try_get_matches_from(&words[2..]) else { return Ok(words) };
    let Some(model) = given.try_get_one::<PathBuf>("model").ok().flatten() else { return Ok(words) };
    let Some(run) = command_of(&report_path(model)) else { return Ok(words) };
    if run.get(1).is_none_or(|name| name != MADE_BY) {
        return Ok(words);
    }
    let run = config::spell_out(run, command.clone())?;
    let Ok(run) = of_run.clone().try_get_matches_from(&run[2..]) else { return Ok(words) };
    let recalled =
        own.get_arguments().filter(|argument| is_meant(argument, &given) && is_given(&run, argument.get_id().as_str()));
    let recalled: Vec<OsString> = recalled.flat_map(|argument| said(argument, &run)).collect();
    words.splice(2..2, recalled);
    Ok(words)
}

/// The command that a report says it is of.
fn command_of(report: &Path) -> Option<Vec<OsString>> {
    let report: Value = serde_json::from_slice(&std::fs::read(report).ok()?).ok()?;
    let words = report.get("command")?.as_array()?;
    words.iter().map(|word| word.as_str().map(OsString::from)).collect()
}

fn is_given(matches: &ArgMatches, id: &str) -> bool {
    matches.ids().any(|known| known == id) && matches.value_source(id) == Some(ValueSource::CommandLine)
}

/// Whether an option of the run holds here: it is not given, nor anything that it would contradict.
fn is_meant(argument: &Arg, given: &ArgMatches) -> bool {
    let id = argument.get_id().as_str();
    let contradicts = match id {
        "no_footprint" => is_given(given, "footprints"),
        id if OF_FOOTPRINTS.contains(&id) => is_given(given, "no_footprint"),
        _ => false,
    };
    !OF_RUN.contains(&id) && argument.get_long().is_some() && !is_given(given, id) && !contradicts
}

/// What the run said of an option, as words.
fn said(argument: &Arg, run: &ArgMatches) -> Vec<OsString> {
    let id = argument.get_id().as_str();
    let Some(name) = argument.get_long() else { return Vec::new() };
    if matches!(argument.get_action(), ArgAction::SetTrue) {
        return if run.get_flag(id) { vec![format!("--{name}").into()] } else { Vec::new() };
    }
    let word = |value: &std::ffi::OsStr| {
        let mut word = OsString::from(format!("--{name}="));
        word.push(value);
        word
    };
    run.get_raw(id).into_iter().flatten().map(word).collect()
}

#[cfg(test)]
mod tests {
    use clap::{CommandFactory, Parser};

    use super::super::Cli;
    use super::*;

    #[test]
    fn the_options_of_the_run_hold_but_for_those_that_are_given() {
        let folder = tempfile::tempdir().unwrap();
        let model = folder.path().join("city.city.json");
        let config = folder.path().join("city.toml");
        std::fs::write(&config, "field = 'height-field'\nlambda = 0.3\n").unwrap();
        let spelt = |words: &[&str]| -> Vec<String> {
            let words = ["gable", "edit", model.to_str().unwrap()].iter().chain(words).map(OsString::from).collect();
            let words = spell_out(words, &Cli::command()).unwrap();
            assert!(Cli::try_parse_from(&words).is_ok(), "{words:?}: {:?}", Cli::try_parse_from(&words).err());
            words.into_iter().map(|word| word.into_string().unwrap()).collect()
        };
        let report = |command: &[&str]| {
            let report = serde_json::json!({ "command": command });
            std::fs::write(report_path(&model), report.to_string()).unwrap();
        };
        let given = ["--points", "x.laz", "-f", "x.gpkg", "--lambda", "0.5"];
        // Without a report nothing is known.
        assert_eq!(spelt(&given).len(), 9);
        report(&[
            "gable",
            "reconstruct",
            "a.laz",
            "b.laz",
            "-f",
            "f.gpkg",
            "-o",
            "city.city.json",
            "--overwrite",
            "-j",
            "2",
            "--config",
            config.to_str().unwrap(),
            "--ground-class",
            "2,9",
            "--terrain",
            "--filter",
            "h > 3",
            "--view",
        ]);
        let words = spelt(&[]);
        for word in [
            "--points=a.laz",
            "--points=b.laz",
            "--footprints=f.gpkg",
            "--lambda=0.3",
            "--field=height-field",
            "--ground-class=2",
            "--ground-class=9",
            "--terrain",
            "--filter=h > 3",
        ] {
            assert!(words.iter().any(|own| own == word), "{word}: {words:?}");
        }
        let others = ["overwrite", "jobs", "view", "output", "config"];
        assert!(!words.iter().any(|word| others.iter().any(|other| word.contains(other))), "{words:?}");
        let words = spelt(&given);
        for word in ["--points=a.laz", "--footprints=f.gpkg", "--lambda=0.3"] {
            assert!(!words.iter().any(|own| own == word), "{word}: {words:?}");
        }
        let words = spelt(&["--no-footprint"]);
        assert!(!words.iter().any(|word| word.contains("filter") || word.contains("footprints=")), "{words:?}");
        // A model of a pipeline: its command says nothing.
        report(&["gable", "pipeline", "city.json"]);
        assert_eq!(spelt(&given).len(), 9);
    }
}
