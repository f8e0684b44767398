//! `gable merge`: several city models into one, or the parts of the jobs of a plan.

use std::path::PathBuf;

use super::convert::{self, Target};
use super::output::{print, say};
use super::progress::{Progress, Verbosity};
use super::{Outcome, interrupt, summary};
use crate::error::InputError;
use crate::run::jobs::{self, Merge, PlanFolder};
use crate::sink::is_stream;
use crate::source::cityjson;

const EXAMPLES: &str = "\
Examples:
  The tiles of a city into one file:
    gable merge out/*.city.jsonl -o city.city.jsonl
  Straight to 3D Tiles:
    gable merge west.city.json east.city.json -o city.3dtiles
  The parts of the jobs of a plan, into any format:
    gable merge --plan plan/ -o country.city.jsonl
    gable merge --plan plan/ -o 'out/{tile}.city.json'
  Which jobs of a plan have not left a part yet, as `sbatch --array` takes them:
    gable merge --plan plan/ --missing

Ids stay unique. Two features of one id whose boxes overlap are the same building, on the border of
two tiles say: the better one is kept, which is the one with the higher level of detail, then with the
larger gable_coverage, then with more gable_points, then the first. If the boxes do not overlap they
are different buildings: both are kept, and the later one gets another id. All files must be in one CRS.

The parts of a plan are joined without a choice: every footprint is in exactly one of them, and what
is missing or there twice is listed. The model has the bytes that one run would have written, and its
report goes to OUT.report.json.

Exit codes:
  0  done; of a plan, every footprint that holds points has a model
  1  nothing could be done, or bad usage; with --missing, there are some
  2  of a plan: done, but some buildings lack a model or some tiles could not be read";

/// What `gable merge` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// CityJSON (1.0 to 2.0) or CityJSONSeq files, folders of .city.json and .city.jsonl, or glob patterns; `-` for standard
    /// input
    #[arg(required_unless_present = "plan", num_args = 1.., value_name = "FILE", conflicts_with = "plan")]
    files: Vec<PathBuf>,

    /// Join the parts of the jobs of this plan; OUT may have {tile} or {id} in its name, as that of `gable reconstruct`
    #[arg(long, value_name = "PLAN", conflicts_with_all = ["crs", "lod"])]
    plan: Option<PathBuf>,

    /// The folder of the parts, where it is not that of the plan; may be given again
    #[arg(long, value_name = "FOLDER", requires = "plan")]
    parts: Vec<PathBuf>,

    /// Where the report goes [default: OUT.report.json]
    #[arg(long, value_name = "FILE", requires = "plan")]
    report: Option<PathBuf>,

    /// Write no model: say which jobs have no part
    #[arg(long, requires = "plan")]
    missing: bool,

    /// The output: .city.json, .city.jsonl, .3dtiles (a folder), .gpkg or .obj; `-` for CityJSONSeq to standard output
    #[arg(short, long, value_name = "OUT", required_unless_present = "missing", conflicts_with = "missing")]
    output: Option<PathBuf>,

    /// Replace what exists
    #[arg(long)]
    overwrite: bool,

    /// CRS of the files, such as EPSG:7415; goes before what they say
    #[arg(long, value_name = "CRS")]
    crs: Option<String>,

    /// Only these levels of detail, such as 2.2 or 0,1.2
    #[arg(long, value_name = "LOD", value_delimiter = ',')]
    lod: Vec<String>,
}

/// Joins files, or the parts of a plan.
///
/// # Errors
/// See [`crate::convert::convert`] and [`jobs::merge`].
pub fn main(args: Args) -> Outcome {
    let Args { files, plan, parts, report, missing, output, overwrite, crs, lod } = args;
    let output = output.unwrap_or_default();
    if let Some(plan) = plan.map(PlanFolder::new) {
        if missing {
            return list_missing(&plan, &parts);
        }
        let command = std::env::args_os().map(|word| word.to_string_lossy().into_owned()).collect();
        return join(&Merge { plan, parts, output, report, overwrite, command });
    }
    let files = cityjson::expand(&files)?;
    if let [one] = &files[..] {
        let fault = InputError::new(one, "one city model", "two or more");
        return Err(fault.remedy("`gable convert` writes one in another format").into());
    }
    convert::run("merge", files, Target { output, overwrite, crs, lod })
}

/// Says which jobs have no part: nothing else goes to standard output, so that a scheduler can take it.
fn list_missing(plan: &PlanFolder, parts: &[PathBuf]) -> Outcome {
    let read = plan.read()?;
    let missing = jobs::missing(&read, plan, parts)?;
    say(&format!("{} of {} jobs have no part", missing.len(), read.jobs.len()));
    if missing.is_empty() {
        return Ok(0);
    }
    print(&format!("{}\n", jobs::ranges(&missing)))?;
    Ok(1)
}

/// Joins the parts of a plan and says what came out.
fn join(merge: &Merge) -> Outcome {
    interrupt::listen();
    let report = jobs::merge(merge, &Progress::new(Verbosity::Normal))?;
    let text = summary::summary(&report);
    if is_stream(&merge.output) {
        say(text.trim_end());
    } else {
        print(&text)?;
    }
    Ok(report.exit_code)
}
