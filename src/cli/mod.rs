//! The command line: one file per subcommand.
//!
//! | exit code | meaning |
//! |---|---|
//! | 0 | done; every footprint that holds points has a model |
//! | 1 | nothing could be done, or bad usage |
//! | 2 | finished, but some buildings lack a model or some tiles could not be read |

mod attributes;
mod config;
mod convert;
#[cfg(feature = "edit")]
mod edit;
mod evaluate;
mod explain;
mod field;
mod flags;
mod held_out;
mod info;
mod interrupt;
mod making;
mod merge;
pub mod options;
mod outlines;
mod output;
#[cfg(feature = "pipelines")]
mod pipeline;
mod placement;
mod plan;
mod planned;
mod progress;
mod reading;
#[cfg(feature = "edit")]
mod recalled;
mod reconstruct;
mod shell;
mod simulate;
#[cfg(feature = "pipelines")]
mod stages;
pub mod summary;
mod trial;
mod usage;
mod validate;
mod version;
mod view;
mod written;

use std::io::ErrorKind;
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::error::Error;

/// What a successful command leaves as its exit code, and an unsuccessful one as its error.
type Outcome = crate::error::Result<u8>;

/// The exit code when nothing could be done, or of bad usage.
const FAILURE: u8 = 1;

const EXAMPLES: &str = "\
Examples:
  What is in these files?
    gable info tiles/ footprints.gpkg
  A city model of the buildings in these footprints:
    gable reconstruct tiles/*.laz --footprints footprints.gpkg -o city.city.json
  How well does it fit the points?
    gable evaluate city.city.json --points tiles/*.laz
  PDAL's pipelines, with gable in them:
    gable pipeline pipelines/quickstart.json
  Is it valid, or any other city model?
    gable validate city.city.json
  For a web map, for QGIS:
    gable convert city.city.json -o city.3dtiles
    gable convert city.city.json -o city.gpkg
  What does it look like, and where is it at fault?
    gable view city.city.json --points tiles/*.laz
  A whole country, job by job on many machines:
    gable plan tiles/ -f footprints.gpkg --jobs 500 -o plan/
    gable reconstruct --plan plan/ --job 0
    gable merge --plan plan/ -o country.city.jsonl
  How was this building made?
    gable explain tiles/*.laz --footprints footprints.gpkg --id b17 -o b17.html
  Mend the last buildings by hand:
    gable edit city.city.json

Exit codes:
  0  done; every footprint that holds points has a model
  1  nothing could be done, or bad usage
  2  finished, but some buildings lack a model or some tiles could not be read: the summary
     and the report say which and why";

#[derive(Debug, Parser)]
#[command(
    name = "gable",
    version,
    about = "Airborne laser tiles and building footprints in, valid LoD 2 city models out",
    after_help = EXAMPLES,
    long_version = version::long(),
    arg_required_else_help = true
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Reconstruct the buildings of footprints from airborne points
    Reconstruct(Box<reconstruct::Args>),
    /// Divide a run into jobs for many machines
    Plan(Box<plan::Args>),
    /// Run a pipeline in PDAL's grammar
    #[cfg(feature = "pipelines")]
    Pipeline(pipeline::Args),
    /// List the stages of pipelines, or the options of one
    #[cfg(feature = "pipelines")]
    Stages(stages::Args),
    /// Say what is in tiles and footprint files
    Info(info::Args),
    /// Measure a city model: its faces and faults, its distance to points and to a reference model; or fields, on scans
    /// of models
    Evaluate(Box<evaluate::Args>),
    /// Check whether city models are valid, fault by fault
    Validate(validate::Args),
    /// Write a city model in another format: CityJSON, CityJSONSeq, 3D Tiles, GeoPackage or OBJ
    Convert(convert::Args),
    /// Join the city models of several tiles, or the parts of the jobs of a plan, into one
    Merge(merge::Args),
    /// Write a page to look at a city model in: one HTML file, with the points and the faults
    View(view::Args),
    /// Write a page that shows how one building is made, step by step
    Explain(Box<explain::Args>),
    /// Mend buildings by hand, in a page that is served to this machine alone
    #[cfg(feature = "edit")]
    Edit(Box<edit::Args>),
    /// Scan city models virtually, for training and testing
    Simulate(Box<simulate::Args>),
    /// Write what a shell needs to complete commands and options
    Completions(shell::CompletionsArgs),
    /// Write manual pages
    Man(shell::ManArgs),
}

/// Runs the command line of this process and returns its exit code.
pub fn main() -> ExitCode {
    interrupt::outlive_file_limits();
    let words = std::env::args_os();
    #[cfg(feature = "pipelines")]
    let words = pipeline::spell_out(words).into_iter();
    let spelt = config::spell_out(words.collect(), Cli::command());
    #[cfg(feature = "edit")]
    let spelt = spelt.and_then(|words| recalled::spell_out(words, &Cli::command()));
    let words = match spelt {
        Ok(words) => words,
        Err(error) => {
            output::say(&format!("error: {error}"));
            return ExitCode::from(FAILURE);
        }
    };
    let matches = Cli::command().try_get_matches_from(&words).and_then(planned::refuse_others);
    let cli = match matches.and_then(|matches| Cli::from_arg_matches(&matches)) {
        Ok(cli) => cli,
        Err(message) => return usage::tell(&words, &message),
    };
    let outcome = match cli.command {
        Command::Reconstruct(args) => reconstruct::main(*args),
        Command::Plan(args) => plan::main(*args),
        #[cfg(feature = "pipelines")]
        Command::Pipeline(args) => pipeline::main(&args),
        #[cfg(feature = "pipelines")]
        Command::Stages(args) => stages::main(&args),
        Command::Info(args) => info::main(&args),
        Command::Evaluate(args) => evaluate::main(&args),
        Command::Validate(args) => validate::main(&args),
        Command::Convert(args) => convert::main(args),
        Command::Merge(args) => merge::main(args),
        Command::View(args) => view::main(&args),
        Command::Explain(args) => explain::main(*args),
        #[cfg(feature = "edit")]
        Command::Edit(args) => edit::main(*args),
        Command::Simulate(args) => simulate::main(&args),
        Command::Completions(args) => shell::completions(&args),
        Command::Man(args) => shell::man(&args),
    };
    match outcome {
        Ok(code) => ExitCode::from(code),
        // Whoever reads our stream has heard enough.
        Err(Error::Io { source, .. }) if source.kind() == ErrorKind::BrokenPipe => ExitCode::SUCCESS,
        Err(error) => {
            output::say(&format!("error: {error}"));
            ExitCode::from(FAILURE)
        }
    }
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    #[test]
    fn the_grammar_is_sound() {
        super::Cli::command().debug_assert();
    }

    #[test]
    fn every_option_has_help() {
        for command in super::Cli::command().get_subcommands() {
            assert!(command.get_about().is_some(), "{}", command.get_name());
            assert!(command.get_after_help().is_some(), "{} has no examples", command.get_name());
            for argument in command.get_arguments() {
                assert!(argument.get_help().is_some(), "{} {}", command.get_name(), argument.get_id());
            }
        }
    }
}
