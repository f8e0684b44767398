//! `gable plan`: a run divided into jobs.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use super::making::MakingArgs;
use super::output::{counted, print, thousands};
use super::progress::{Progress, Verbosity};
use super::written::{ModelArgs, OUTPUT};
use super::{Outcome, interrupt};
use crate::error::InputError;
use crate::run::Job;
use crate::run::jobs::{self, JobPlan, PlanFolder, Split};

const EXAMPLES: &str = "\
Examples:
  A country in 500 jobs of about the same cost:
    gable plan 'ahn/*.laz' -f pand.gpkg --jobs 500 -o plan/
  Jobs of about 2000 footprints, with the options of a configuration:
    gable plan --config country.toml --job-size 2000 -o plan/
  Then each job, anywhere and in any order, and the model of all:
    gable reconstruct --plan plan/ --job 0
    gable merge --plan plan/ -o country.city.jsonl

The plan:
  A folder. plan.json holds all options, the tiles and the jobs; jobs/K.jsonl the footprints of
  job K, with those beside them that it must know; parts/ what the jobs make. Headers and
  footprints are read, and no points but a few that show whether a header is right. Tiles are named by their
  absolute paths, which must be the same where the jobs run. Jobs need neither the footprints
  nor each other, and are the work of whatever starts processes: Dask, Ray, Slurm, Kubernetes.
  The model is that of one run, byte for byte, whatever the number of jobs.

Exit codes:
  0  the plan is written
  1  it is not, or bad usage";

/// What `gable plan` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    #[command(flatten)]
    making: MakingArgs,

    /// The folder of the plan
    #[arg(short, long, value_name = "PLAN", help_heading = OUTPUT)]
    output: PathBuf,

    /// Number of jobs
    #[arg(short, long, value_name = "N", conflicts_with = "job_size", help_heading = OUTPUT)]
    jobs: Option<NonZeroUsize>,

    /// About so many footprints for each job [default: 1000]
    #[arg(long, value_name = "N", help_heading = OUTPUT)]
    job_size: Option<NonZeroUsize>,

    /// Replace a plan that exists, with the parts of its jobs
    #[arg(long, help_heading = OUTPUT)]
    overwrite: bool,

    #[command(flatten)]
    model: ModelArgs,

    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

/// Makes the plan and says what is in it.
///
/// # Errors
/// As [`jobs::make`].
pub fn main(args: Args) -> Outcome {
    interrupt::listen();
    let verbosity = if args.quiet { Verbosity::Quiet } else { Verbosity::Normal };
    let folder = PlanFolder::new(&args.output);
    let (split, overwrite) = (args.split(), args.overwrite);
    let job = args.into_job()?;
    let plan = jobs::make(&job, split, &folder, overwrite, &Progress::new(verbosity))?;
    if verbosity > Verbosity::Quiet {
        print(&text(&plan, &folder))?;
    }
    Ok(0)
}

impl Args {
    fn split(&self) -> Split {
        match (self.jobs, self.job_size) {
            (Some(jobs), _) => Split::Jobs(jobs),
            (None, Some(each)) => Split::Footprints(each),
            (None, None) => Split::DEFAULT,
        }
    }

    /// # Errors
    /// A CRS that is none, or options that contradict each other.
    fn into_job(self) -> Result<Job, InputError> {
        let job = self.model.into_job(self.making)?;
        job.refuse_contradictions()?;
        Ok(job)
    }
}

/// What is in a plan, for a person.
fn text(plan: &JobPlan, folder: &PlanFolder) -> String {
    let (least, most) = plan.sizes();
    let jobs = counted(plan.jobs.len() as u64, "job");
    let footprints = counted(plan.footprints as u64, "footprint");
    let tiles = counted(plan.tiles.len() as u64, "tile");
    format!(
        "{}: {jobs} of {} to {} footprints; {footprints}, {tiles}, of which each point is read {:.1} times\n",
        folder.path().display(),
        thousands(least as u64),
        thousands(most as u64),
        plan.readings()
    )
}
