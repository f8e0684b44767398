//! `gable reconstruct --plan`: one job of a plan.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::parser::ValueSource;
use clap::{ArgMatches, CommandFactory};

use super::output::{print, say};
use super::progress::{Progress, Verbosity};
use super::{Cli, Outcome, summary};
use crate::run::jobs::{self, JobRun, PlanFolder};

/// What a job of a plan takes beside its plan: everything else stands in there.
const TAKEN: [&str; 7] = ["plan", "job", "parts", "jobs", "overwrite", "quiet", "verbose"];

/// Which job of which plan.
#[derive(Debug, Clone, clap::Args)]
#[command(next_help_heading = "One job of many")]
pub struct PlannedArgs {
    /// Do a job of this plan, a folder that `gable plan` made: tiles, footprints and all options are those of the plan
    #[arg(long, value_name = "PLAN", requires = "job")]
    plan: Option<PathBuf>,

    /// Which job of the plan, from 0
    #[arg(long, value_name = "K", requires = "plan")]
    job: Option<usize>,

    /// The folder that the part of the job goes to, and its report [default: PLAN/parts]
    #[arg(long, value_name = "FOLDER", requires = "plan")]
    parts: Option<PathBuf>,
}

impl PlannedArgs {
    /// The job that is asked for, if one is.
    pub(super) fn run(&self, threads: Option<NonZeroUsize>, overwrite: bool) -> Option<JobRun> {
        let (plan, job) = self.plan.clone().zip(self.job)?;
        let command = std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
        Some(JobRun { plan: PlanFolder::new(plan), job, parts: self.parts.clone(), threads, overwrite, command })
    }
}

/// Refuses options beside a plan that stand in it.
///
/// # Errors
/// Which one.
pub(super) fn refuse_others(matches: ArgMatches) -> Result<ArgMatches, clap::Error> {
    let Some(("reconstruct", given)) = matches.subcommand() else { return Ok(matches) };
    if !given.contains_id("plan") {
        return Ok(matches);
    }
    let is_given =
        |id: &str| given.try_contains_id(id).is_ok() && given.value_source(id) == Some(ValueSource::CommandLine);
    let mut command = Cli::command();
    command.build();
    let Some(grammar) = command.find_subcommand("reconstruct") else { return Ok(matches) };
    let other = grammar.get_arguments().find(|argument| {
        let id = argument.get_id().as_str();
        !TAKEN.contains(&id) && is_given(id)
    });
    let Some(other) = other.map(ToString::to_string) else { return Ok(matches) };
    let mut fault = clap::Error::new(ErrorKind::ArgumentConflict).with_cmd(grammar);
    fault.insert(ContextKind::InvalidArg, ContextValue::String(other));
    fault.insert(ContextKind::PriorArg, ContextValue::String("--plan <PLAN>".to_owned()));
    Err(fault)
}

/// Does the job and says what came of it.
///
/// # Errors
/// As [`jobs::do_job`].
pub(super) fn main(run: &JobRun, verbosity: Verbosity) -> Outcome {
    match jobs::do_job(run, &Progress::new(verbosity))? {
        jobs::Outcome::WasDone(part) => {
            if verbosity > Verbosity::Quiet {
                let said = format!("{}: job {} is done already; --overwrite does it again", part.display(), run.job);
                print(&(said + "\n"))?;
            }
        }
        jobs::Outcome::Done(report) if verbosity > Verbosity::Quiet => print(&summary::summary(&report))?,
        jobs::Outcome::Done(report) => {
            if let Some(text) = summary::shortfall(&report) {
                say(&text);
            }
        }
    }
    Ok(0)
}
