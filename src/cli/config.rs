//! Options of `gable reconstruct`, and of those of `gable explain`, `gable plan` and `gable edit`, from a file and from presets.
//!
//! A configuration is TOML with the names of the options. What is given on the command line goes before it, and it before
//! the preset; all become words of the command line, so that one grammar reads them.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use clap::parser::ValueSource;
use clap::{ArgMatches, Command, ValueEnum};
use serde_json::{Map, Value};

use super::options;
use crate::error::{Error, InputError};

/// The options that name a configuration and a preset.
#[derive(Debug, Clone, Default, clap::Args)]
#[command(next_help_heading = "Many options at once")]
pub struct ConfigArgs {
    /// TOML file of options by their names, such as `lambda = 0.2`; what is given here goes before it
    #[arg(long, value_name = "FILE")]
    config: Option<PathBuf>,

    /// Options for a purpose; what is given here and in a configuration goes before it
    #[arg(long, value_name = "NAME")]
    preset: Option<Preset>,
}

/// Options for a purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Preset {
    /// The height-field vote decides, not the network: half the time, no overhangs
    Fast,
    /// Smaller parts, steps and features are modelled, with more faces
    Quality,
}

impl Preset {
    /// The options that it stands for.
    fn options(self) -> Map<String, Value> {
        let options: Vec<(&str, Value)> = match self {
            Self::Fast => vec![("field", "height-field".into())],
            Self::Quality => vec![
                ("minimum-area", 0.5.into()),
                ("minimum-feature", 0.05.into()),
                ("step-height", 0.2.into()),
                ("step-length", 0.5.into()),
                ("footprint-tolerance", 0.03.into()),
            ],
        };
        options.into_iter().map(|(name, value)| (name.to_owned(), value)).collect()
    }
}

/// The commands that take a configuration: it is written for the first, and the others take of it what they have.
const COMMANDS: [&str; 4] = ["reconstruct", "explain", "plan", "edit"];
/// The one whose tiles are an option: its name.
const WITH_POINTS: &str = "edit";
/// What a configuration says of the model and of one process is not meant for a page nor for a plan.
const OF_MODEL: [&str; 3] = ["output", "overwrite", "jobs"];

/// The words of the command line with those of its configuration and its preset; `command` is the grammar.
///
/// # Errors
/// The configuration cannot be read, is no TOML, or has an option that does not exist.
pub(super) fn spell_out(mut words: Vec<OsString>, mut command: Command) -> Result<Vec<OsString>, Error> {
    let Some(command_name) = words.get(1).and_then(|name| COMMANDS.into_iter().find(|known| name == known)) else {
        return Ok(words);
    };
    let whole = command.find_subcommand_mut(COMMANDS[0]).map(|grammar| grammar.clone().no_binary_name(true));
    let Some((whole, grammar)) = whole.zip(command.find_subcommand_mut(command_name)) else { return Ok(words) };
    let grammar = grammar.clone().no_binary_name(true).ignore_errors(true);
    // What is wrong with the words is told when all of them are together.
    let Ok(given) = grammar.clone().try_get_matches_from(&words[2..]) else { return Ok(words) };
    let mut configured = Map::new();
    let mut preset = given.try_get_one::<Preset>("preset").ok().flatten().copied();
    if let Ok(Some(path)) = given.try_get_one::<PathBuf>("config") {
        configured = read(path)?;
        let named = take_preset(&mut configured).map_err(|fault| InputError { file: path.clone(), ..fault })?;
        preset = preset.or(named);
    }
    let mut options = preset.map(Preset::options).unwrap_or_default();
    options.extend(configured);
    let mut tiles = Vec::new();
    let mut others = Vec::new();
    for (name, value) in options {
        let fault = |fault: InputError| match given.get_one::<PathBuf>("config") {
            Some(path) => InputError { file: path.clone(), ..fault },
            None => fault,
        };
        if name == "tiles" {
            tiles = options::texts(&name, &value).map_err(fault)?;
        } else if !is_given(&given, &name) {
            let given = options::word(&options::CONFIGURATION, &whole, &name, &value).map_err(fault)?;
            let is_there = grammar.get_arguments().any(|argument| argument.get_long() == Some(name.as_str()));
            let is_meant = command_name == COMMANDS[0] || is_there && !OF_MODEL.contains(&name.as_str());
            others.extend(given.into_iter().filter(|_| is_meant).map(OsString::from));
        }
    }
    if is_given(&given, "tiles") {
        tiles.clear();
    }
    let tile = |tile: String| if command_name == WITH_POINTS { format!("--points={tile}") } else { tile };
    words.splice(2..2, others.into_iter().chain(tiles.into_iter().map(tile).map(OsString::from)));
    Ok(words)
}

/// The options with those that a preset among them stands for; what is given goes before it.
///
/// # Errors
/// There is no such preset.
pub(super) fn with_preset(mut options: Map<String, Value>) -> Result<Map<String, Value>, InputError> {
    let mut all = take_preset(&mut options)?.map(Preset::options).unwrap_or_default();
    all.extend(options);
    Ok(all)
}

/// Takes the preset out of some options.
fn take_preset(options: &mut Map<String, Value>) -> Result<Option<Preset>, InputError> {
    let Some(name) = options.shift_remove("preset").filter(|name| !name.is_null()) else { return Ok(None) };
    let named = name.as_str().and_then(|name| Preset::from_str(name, false).ok());
    named.map(Some).ok_or_else(|| {
        let names: Vec<_> = Preset::value_variants().iter().filter_map(Preset::to_possible_value).collect();
        let names: Vec<&str> = names.iter().map(clap::builder::PossibleValue::get_name).collect();
        InputError::new(options::NAME, name.to_string(), format!("one of {}", names.join(", "))).at("\"preset\"")
    })
}

/// Whether an option is on the command line; unknown ones are not.
fn is_given(given: &ArgMatches, name: &str) -> bool {
    let id = name.replace('-', "_");
    let named =
        |id: &str| given.ids().any(|known| known == id) && given.value_source(id) == Some(ValueSource::CommandLine);
    named(&id) || named(name)
}

/// The options of a configuration.
fn read(path: &Path) -> Result<Map<String, Value>, Error> {
    const EXPECTED: &str = "options by their names, such as `footprints = \"buildings.gpkg\"`";
    let text = fs::read_to_string(path).map_err(|source| Error::io(path, "read", source))?;
    let table: toml::Table = text.parse().map_err(|error: toml::de::Error| {
        let line = error.span().map_or(1, |span| 1 + text.bytes().take(span.start).filter(|b| *b == b'\n').count());
        InputError::new(path, error.message(), EXPECTED).at(format!("line {line}"))
    })?;
    let options = serde_json::to_value(table).map_err(|error| InputError::new(path, error.to_string(), EXPECTED))?;
    let Value::Object(options) = options else { return Ok(Map::new()) };
    Ok(options.into_iter().map(|(name, value)| (name.replace('_', "-"), value)).collect())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::super::Cli;
    use super::*;

    fn spelt(words: &[&str]) -> Result<Vec<String>, String> {
        let words = ["gable"].iter().chain(words).map(OsString::from).collect();
        let words = spell_out(words, Cli::command()).map_err(|error| error.to_string())?;
        Ok(words.into_iter().map(|word| word.into_string().unwrap()).collect())
    }

    #[test]
    fn a_configuration_fills_in_what_the_command_line_leaves_out() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("city.toml");
        let config = path.to_str().unwrap();
        fs::write(
            &path,
            "tiles = ['a.laz', 'b.laz']\nfootprints = 'f.gpkg'\nlambda = 0.2\nground_class = [2, 8]\nview = true\n",
        )
        .unwrap();
        let words = spelt(&["reconstruct", "-o", "x.city.json", "--config", config]).unwrap();
        assert_eq!(
            words[2..7],
            ["--footprints=f.gpkg", "--ground-class=2,8", "--lambda=0.2", "--view", "a.laz"].map(str::to_owned)
        );
        // What is given goes before, and before a preset the configuration.
        let given = ["reconstruct", "c.laz", "-f", "g.gpkg", "--lambda=1", "--config", config, "--preset", "fast"];
        let words = spelt(&given).unwrap();
        assert_eq!(words[2..5], ["--field=height-field", "--ground-class=2,8", "--view"].map(str::to_owned));
        assert_eq!(
            words[5..],
            ["c.laz", "-f", "g.gpkg", "--lambda=1", "--config", config, "--preset", "fast"].map(str::to_owned)
        );
        let parsed = <Cli as clap::Parser>::try_parse_from(words.iter().chain([&"-o=x.city.json".to_owned()]));
        assert!(parsed.is_ok(), "{:?}", parsed.err());
        fs::write(&path, "preset = 'fast'\nlambda = 0.2\n").unwrap();
        let words = spelt(&["reconstruct", "c.laz", "--config", config]).unwrap();
        assert_eq!(words[2..4], ["--field=height-field", "--lambda=0.2"].map(str::to_owned));
        // Other commands have no configuration.
        assert_eq!(spelt(&["info", "--config", config]).unwrap(), ["gable", "info", "--config", config]);
    }

    #[test]
    fn a_bad_configuration_is_told_with_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("city.toml");
        let told = |text: &str| {
            fs::write(&path, text).unwrap();
            spelt(&["reconstruct", "--config", path.to_str().unwrap()]).unwrap_err()
        };
        let unknown = told("lamda = 1");
        assert!(unknown.contains("city.toml") && unknown.contains("Did you mean \"lambda\"?"), "{unknown}");
        let malformed = told("lambda = 1\nfield = \n");
        assert!(malformed.contains("line 2"), "{malformed}");
        assert!(told("preset = 'slow'").contains("one of fast, quality"));
        assert!(told("[method]\nlambda = 1").contains("unknown option"));
        fs::remove_file(&path).unwrap();
        assert!(spelt(&["reconstruct", "--config", path.to_str().unwrap()]).unwrap_err().contains("city.toml"));
    }
}
