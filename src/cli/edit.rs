//! `gable edit`: a page in which a person mends the last buildings.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde_json::Value;

use super::making::{MakingArgs, RUN, ThreadArgs};
use super::output::{counted, print, say};
use super::progress::{Progress, Verbosity};
use super::written::{OUTPUT, WrittenArgs};
use super::{Outcome, interrupt, summary};
use crate::edit::server::Server;
use crate::edit::{Desk, Opening, export};
use crate::error::InputError;
use crate::run::Job;
use crate::run::output::{prepare, report_path};
use crate::source::{cityjson, objects};

const EXAMPLES: &str = "\
Examples:
  Mend the model of a run; tiles, footprints and options are those of the run, as its report
  (OUT.report.json) tells them:
    gable edit city.city.json
  Where the files are elsewhere now, or there is no report:
    gable edit city.city.json --points tiles/ -f buildings.gpkg
  On a machine without a browser; open the address that is printed, over ssh -L 8000:127.0.0.1:8000:
    gable edit city.city.json --port 8000 --no-browser
  Say who decides:
    gable edit city.city.json --author jan
  The model with what was accepted, without a page; the same as
  `gable reconstruct … --edits edits.json`:
    gable edit city.city.json --export mended.city.json

The page:
  It is served to this machine alone, at an address with a secret in it; nothing leaves the machine.
  Its list begins with the buildings that need a person most. Each edit is followed at once by the
  method, so that what comes out is valid, and is written to edits.json beside the model (--edits
  names another file): a restart goes on from there. Ctrl-C ends it.
  It holds the points of all buildings in memory. Of a large city edit a part: --box, --filter
  and --limit-area choose it.

Exit codes:
  0  ended, or the model is written
  1  it could not begin, or bad usage
  2  with --export: written, but some buildings lack a model or some tiles could not be read";

/// The heading of the options of the page.
const PAGE: &str = "Page";

/// What `gable edit` takes.
#[derive(Debug, clap::Args)]
#[command(
    after_help = EXAMPLES,
    mut_arg("tiles", |tiles| tiles
        .long("points")
        .num_args(1..)
        .value_name("TILE")
        .help("The tiles that the model was made from: files, folders, glob patterns or an index [default: those of the run]")),
    mut_arg("footprints", |footprints| footprints.help(
        "The footprints that the model was made from: a file or a PostGIS database [default: those of the run]")),
    mut_arg("edits", |edits| edits.help(
        "The file that all decisions go to, and that is gone on from [default: that of the run, or edits.json beside MODEL]")),
)]
pub struct Args {
    /// The model: CityJSON or CityJSONSeq that gable made
    #[arg(value_name = "MODEL")]
    model: PathBuf,

    #[command(flatten)]
    making: MakingArgs,

    #[command(flatten)]
    written: WrittenArgs,

    #[command(flatten)]
    threads: ThreadArgs,

    /// Port of this machine that the page is served on [default: any that is free]
    #[arg(long, value_name = "PORT", default_value_t = 0, hide_default_value = true, help_heading = PAGE)]
    port: u16,

    /// Open no browser: only print the address
    #[arg(long, help_heading = PAGE)]
    no_browser: bool,

    /// Who edits: stands beside each edit in the file
    #[arg(long, value_name = "NAME", help_heading = PAGE)]
    author: Option<String>,

    /// Write the model with what was accepted, and serve no page: a file of any format that `gable reconstruct` writes
    #[arg(long, value_name = "OUT", conflicts_with_all = ["port", "no_browser", "author"], help_heading = OUTPUT)]
    export: Option<PathBuf>,

    /// Replace the file of --export if it exists
    #[arg(long, requires = "export", help_heading = OUTPUT)]
    overwrite: bool,

    /// Say nothing but errors and the address
    #[arg(short, long, help_heading = RUN)]
    quiet: bool,
}

/// Serves the page until it is interrupted, or writes the model.
///
/// # Errors
/// The model, a tile, the footprints or the file of edits cannot be read; the port is taken; the model cannot be written.
pub fn main(args: Args) -> Outcome {
    let Args { model, making, written, threads, port, no_browser, author, export: output, overwrite, quiet } = args;
    let verbosity = if quiet { Verbosity::Quiet } else { Verbosity::Normal };
    let model = cityjson::only(&model)?;
    let job = written.into_job(making).map_err(|fault| with_model(fault, &model))?;
    let job = Job { threads: threads.jobs, ..job };
    job.refuse_contradictions()?;
    let edits = job.edits.clone().unwrap_or_else(|| model.with_file_name("edits.json"));
    if let Some(elsewhere) =
        [&model, &edits].into_iter().find(|path| objects::is_object(path) || path.as_os_str() == "-")
    {
        let fault = InputError::new(elsewhere, "no file", "a file of this machine");
        return Err(fault.remedy("Copy the model here: what is decided is written beside it, edit by edit").into());
    }
    if verbosity > Verbosity::Quiet {
        for difference in differences(&job, &report_path(&model)) {
            say(&format!("warning: {difference}"));
        }
    }
    if let Some(output) = output {
        interrupt::listen();
        return write(Job { overwrite, ..job }, &edits, &output, verbosity);
    }
    interrupt::listen_quietly();
    let server = Server::bind(port)?;
    prepare(&edits, true)?;
    let export = beside(&model);
    let opening = Opening { model, edits, author, export };
    let desk = Desk::open(job, opening, &Progress::new(verbosity))?;
    if verbosity > Verbosity::Quiet {
        desk.notes().iter().for_each(|note| say(&format!("warning: {note}")));
        let (all, urgent) = desk.counts();
        say(&format!("{}, {} of them for a person to look at", counted(all as u64, "building"), urgent));
    }
    let address = server.address();
    print(&format!("{address}\n"))?;
    if !no_browser && let Err(fault) = open::that_detached(&address) {
        say(&format!("warning: no browser could be opened ({fault}): open the address above in one"));
    }
    interrupt::wait_quietly();
    server.serve(Arc::new(desk), &interrupt::pressed)?;
    Ok(0)
}

/// Writes the model with what was accepted.
fn write(job: Job, edits: &Path, output: &Path, verbosity: Verbosity) -> Outcome {
    if !edits.exists() && verbosity > Verbosity::Quiet {
        say(&format!("warning: {} is not there: the model is written without edits", edits.display()));
    }
    let report = export(job, edits, output, &Progress::new(verbosity))?;
    if verbosity > Verbosity::Quiet {
        print(&summary::summary(&report))?;
    } else if let Some(text) = summary::shortfall(&report) {
        say(&text);
    }
    Ok(report.exit_code)
}

/// Where the page writes the model with what was accepted: beside it, with `.edited` before its extension.
fn beside(model: &Path) -> PathBuf {
    let name = model.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let lower = name.to_lowercase();
    let known = [".city.jsonl", ".city.json", ".jsonl", ".json"].into_iter().find(|end| lower.ends_with(end));
    let end = known.map_or(name.len(), |end| name.len() - end.len());
    let (stem, extension) = name.split_at_checked(end).unwrap_or((&name, ""));
    let extension = if extension.is_empty() { ".city.json" } else { extension };
    model.with_file_name(format!("{stem}.edited{extension}"))
}

/// That no footprints are given, and that the report of the run, which tells them, is not there either.
fn with_model(fault: InputError, model: &Path) -> InputError {
    if fault.file != Path::new("--footprints") {
        return fault;
    }
    let remedy = format!(
        "Give --points and --footprints: {}, the report of the run that made the model, does not tell them. {}",
        report_path(model).display(),
        fault.remedy
    );
    InputError { remedy, ..fault }
}

/// In what a job differs from the run that made the model, by its report: what is made here may differ then, edits or not.
fn differences(job: &Job, report: &Path) -> Vec<String> {
    let read = std::fs::read(report).ok().and_then(|bytes| serde_json::from_slice::<Value>(&bytes).ok());
    let Some(report) = read else { return Vec::new() };
    let own = [
        ("parameters", serde_json::to_value(&job.parameters)),
        ("field", serde_json::to_value(&job.field)),
        ("segmentation", serde_json::to_value(&job.segmentation)),
    ];
    let mut found = Vec::new();
    for (part, own) in own {
        if let (Ok(own), Some(then)) = (own, report.get(part)) {
            compare(part, &own, then, &mut found);
        }
    }
    found
}

fn compare(name: &str, own: &Value, then: &Value, found: &mut Vec<String>) {
    match (own, then) {
        (Value::Object(own), Value::Object(then)) => {
            for (key, own) in own {
                compare(&key.replace('_', "-"), own, then.get(key).unwrap_or(&Value::Null), found);
            }
        }
        (own, then) if own != then => found.push(format!("{name} is {own} here, and the model was made with {then}")),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_export_stands_beside_the_model() {
        for (model, expected) in [
            ("a/city.city.json", "a/city.edited.city.json"),
            ("City.CITY.JSONL", "City.edited.CITY.JSONL"),
            ("b.json", "b.edited.json"),
            ("c.txt", "c.txt.edited.city.json"),
        ] {
            assert_eq!(beside(Path::new(model)), Path::new(expected));
        }
    }

    #[test]
    fn what_differs_from_the_run_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let report = folder.path().join("r.json");
        let job = Job::default();
        let mut then = serde_json::json!({
            "parameters": job.parameters, "field": job.field, "segmentation": job.segmentation,
        });
        let told = |then: &Value| {
            std::fs::write(&report, then.to_string()).unwrap();
            differences(&job, &report)
        };
        assert_eq!(told(&then), Vec::<String>::new());
        then["parameters"]["labelling"]["lambda"] = 0.77.into();
        let found = told(&then);
        assert!(found.len() == 1 && found[0].starts_with("lambda is ") && found[0].ends_with("0.77"), "{found:?}");
    }
}
