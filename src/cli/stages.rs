//! `gable stages`: the stages of pipelines and their options.

use super::Outcome;
use super::output::print;
use crate::pipeline::catalogue;
use crate::pipeline::describe;
use crate::pipeline::options::Place;

const EXAMPLES: &str = "\
Examples:
  All stages:
    gable stages
  The options of one:
    gable stages writers.lod2";

/// What `gable stages` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// The stage whose options are listed, such as filters.crop; all stages when it is not given
    #[arg(value_name = "NAME")]
    name: Option<String>,
}

/// Lists stages, or the options of one.
///
/// # Errors
/// A stage that there is not.
pub fn main(args: &Args) -> Outcome {
    let text = match &args.name {
        None => describe::list() + "\n`gable stages NAME` lists the options of a stage.\n",
        Some(name) => {
            let place = Place { file: "gable stages".into(), stage: String::new() };
            describe::stage(catalogue::find(name, &place)?)
        }
    };
    print(&text)?;
    Ok(0)
}
