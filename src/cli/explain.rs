//! `gable explain`: a page that shows how one building is made.

use std::fmt::Write;
use std::path::PathBuf;

use super::making::{MakingArgs, ThreadArgs};
use super::output::{print, say, thousands};
use super::progress::{Progress, Verbosity};
use super::{Outcome, interrupt};
use crate::error::{InputError, Result};
use crate::explain::{Contents, explain};
use crate::run::output::prepare;
use crate::run::{Job, chosen};
use crate::sink::write_whole;

const EXAMPLES: &str = "\
Examples:
  How is this building of a run made? The options are those of the run:
    gable explain tiles/ --footprints buildings.gpkg --id NL.IMBAG.Pand.0503100000017310 \\
      -o building.html
  With other parameters:
    gable explain tiles/ -f buildings.gpkg --id b17 --lambda 0.3 --field height-field -o b17.html
  By the configuration of the run:
    gable explain --config city.toml --id b17 -o b17.html
  An object without a footprint; several are named NAME-1, NAME-2 and so on:
    gable explain church.ply --no-footprint --id church -o church.html

The page:
  It is one file and needs no network: open it in any browser. It shows the points by class,
  the planes as they were found and after refinement, the planes that nobody scanned, the
  cells, how likely each is inside, what the cut decided, the surface, and how well it fits;
  with the figures and parameters of each step. The building is the one that the run makes.

Exit codes:
  0  the page is written
  1  it is not, or bad usage
  2  it is written, but the building has no model in LoD 2.2: the page shows how far it got";

/// What `gable explain` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    #[command(flatten)]
    making: MakingArgs,

    #[command(flatten)]
    threads: ThreadArgs,

    /// The building: its id, as it stands in the footprints and in the model
    #[arg(long, value_name = "ID", allow_hyphen_values = true)]
    id: String,

    /// The page: PAGE.html
    #[arg(short, long, value_name = "PAGE")]
    output: PathBuf,

    /// Replace a file that exists
    #[arg(long)]
    overwrite: bool,

    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,
}

/// The exit code when the building fell short of LoD 2.2.
const INCOMPLETE: u8 = 2;

/// Makes the page and says what is in it.
///
/// # Errors
/// As [`chosen`] and [`explain`]; the page cannot be written, or its name is that of another kind of file.
pub fn main(args: Args) -> Outcome {
    interrupt::listen();
    let Args { making, threads, id, output, overwrite, quiet } = args;
    let verbosity = if quiet { Verbosity::Quiet } else { Verbosity::Normal };
    let is_page = output.extension().is_some_and(|e| e.eq_ignore_ascii_case("html") || e.eq_ignore_ascii_case("htm"));
    if !is_page && !output.is_dir() {
        let fault = InputError::new(&output, "another extension than that of a page", "PAGE.html");
        return Err(fault.remedy("Give the name of an HTML file with -o").into());
    }
    let job = Job { threads: threads.jobs, ..making.into_job()? };
    job.refuse_contradictions()?;
    prepare(&output, overwrite)?;
    let contents = write(&job, &id, &output, verbosity)?;
    if verbosity > Verbosity::Quiet {
        print(&text(&contents, &output.display().to_string()))?;
    }
    if let Some(failure) = &contents.failure {
        say(&format!("{id}: {failure}"));
    }
    Ok(if contents.failure.is_none() { 0 } else { INCOMPLETE })
}

fn write(job: &Job, id: &str, output: &std::path::Path, verbosity: Verbosity) -> Result<Contents> {
    let chosen = chosen(job, id, &Progress::new(verbosity))?;
    let (building, page) = explain(job, &chosen)?;
    if verbosity > Verbosity::Quiet {
        for problem in &page.problems {
            say(&format!("warning: {problem}"));
        }
        for note in &building.notes {
            say(&format!("{id}: {note}"));
        }
    }
    write_whole(output, &page.html)?;
    Ok(page.contents)
}

/// What is in a page, for a person.
fn text(contents: &Contents, path: &str) -> String {
    let number = |n: usize| thousands(n as u64);
    let [points, around] = contents.points;
    let [found, refined, all] = contents.planes;
    let [cells, inside] = contents.cells;
    let rows = [
        ("points", format!("{} of the building, {} shown around", number(points), number(around))),
        (
            "planes",
            format!("{} found, {} after refinement, {} with walls", number(found), number(refined), number(all)),
        ),
        ("cells", format!("{}, {} inside", number(cells), number(inside))),
        ("faces", number(contents.faces)),
        ("written", path.to_owned()),
    ];
    let mut out = String::new();
    for (name, text) in &rows {
        // Writing to memory does not fail.
        let _ = writeln!(out, "{name:<8}  {text}");
    }
    out
}
