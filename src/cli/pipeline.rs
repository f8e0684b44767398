//! `gable pipeline`: runs a pipeline in PDAL's grammar.

use std::ffi::OsString;
use std::io::{IsTerminal, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};

use super::output::{print, say};
use super::progress::{Progress, Verbosity};
use super::{FAILURE, Outcome, interrupt, summary};
use crate::error::{Error, InputError, Result};
use crate::pipeline::{Context, Observer, Override, Plan, Prepared, validate};
use crate::run;
use crate::sink::write_json;

const EXAMPLES: &str = "\
Examples:
  Run a pipeline:
    gable pipeline pipelines/quickstart.json
  With other options than the file's: for all stages of a type, or for the one of a tag
    gable pipeline city.json --readers.las.count=100000 --stage.model.filename=out/small.city.json
  Can it be run, and does it stream?
    gable pipeline city.json --validate
  From another program, with what the stages have to tell:
    make-pipeline | gable pipeline --stdin --metadata metadata.json
  The stages and their options:
    gable stages
    gable stages filters.crop

The grammar is PDAL's: an array of stages, or an object with the array as \"pipeline\", in
which comments are allowed. Names of files are relative to the working folder. A stage that
PDAL has and gable has not: run the file in PDAL up to there (`pdal pipeline FILE`), let
writers.las write the points, and hand that file to gable.

Exit codes:
  0  done
  1  nothing could be done, or bad usage; also of --validate when the pipeline is not valid
  2  finished, but some points could not be read or writers.lod2 lacks buildings";

/// What `gable pipeline` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES, group(clap::ArgGroup::new("source").required(true).args(["file", "stdin"])))]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own on the command line")]
pub struct Args {
    /// The pipeline, a JSON file
    #[arg(value_name = "FILE")]
    file: Option<PathBuf>,

    /// Read the pipeline from standard input
    #[arg(long)]
    stdin: bool,

    /// Say whether the pipeline can be run and whether it streams, as JSON, and do not run it
    #[arg(long)]
    validate: bool,

    /// Write what the stages have to tell to this file, as JSON
    #[arg(long, value_name = "FILE")]
    metadata: Option<PathBuf>,

    /// Write the pipeline with all types, tags, inputs and files written out to this file
    #[arg(long, value_name = "FILE")]
    pipeline_serialization: Option<PathBuf>,

    /// Write a line to this file or pipe, which exists, whenever a file is begun or complete (READYFILE, DONEFILE)
    #[arg(long, value_name = "FILE")]
    progress: Option<PathBuf>,

    /// Set an option of all stages of a type (readers.las.count=5) or of one (stage.TAG.count=5); the same as
    /// --readers.las.count=5 and --stage.TAG.count=5
    #[arg(long = "set", value_name = "STAGE.OPTION=VALUE")]
    overrides: Vec<String>,

    /// Say nothing but errors
    #[arg(short, long, conflicts_with = "verbose")]
    quiet: bool,

    /// Say what became of every building
    #[arg(short, long)]
    verbose: bool,
}

/// The arguments with `--readers.las.count=5` and `--readers.las.count 5`, which are no options of their own, as `--set`.
pub fn spell_out(arguments: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let mut arguments = arguments.peekable();
    let mut out: Vec<OsString> = arguments.next().into_iter().collect();
    let is_ours = arguments.peek().is_some_and(|command| command == "pipeline");
    while let Some(argument) = arguments.next() {
        let prefixes = ["--readers.", "--filters.", "--writers.", "--stage."];
        let text = argument.to_str().filter(|text| is_ours && prefixes.iter().any(|prefix| text.starts_with(prefix)));
        let Some(text) = text.map(|text| text.trim_start_matches('-').to_owned()) else {
            out.push(argument);
            continue;
        };
        let mut set = OsString::from(text.as_str());
        if !text.contains('=') {
            // Without a value the grammar of the option says what is wrong.
            set.push("=");
            set.push(arguments.next().unwrap_or_default());
        }
        out.extend([OsString::from("--set"), set]);
    }
    out
}

/// Runs a pipeline.
///
/// # Errors
/// As [`Plan::read`], [`Prepared::new`] and [`Prepared::run`].
pub fn main(args: &Args) -> Outcome {
    let (text, name) = args.read()?;
    let overrides = args.overrides.iter().map(|text| Override::parse(text)).collect::<Result<Vec<_>, _>>()?;
    let verbosity = match (args.quiet, args.verbose) {
        (true, _) => Verbosity::Quiet,
        (false, true) => Verbosity::Verbose,
        (false, false) => Verbosity::Normal,
    };
    let listener = Listener::new(verbosity, args.progress.as_deref())?;
    let plan = Plan::read(&text, &name, &overrides);
    if args.validate {
        let verdict = validate(plan, &listener);
        print(&format!("{verdict:#}\n"))?;
        return Ok(if verdict["valid"] == true { 0 } else { FAILURE });
    }
    let plan = plan?;
    if let Some(path) = &args.pipeline_serialization {
        write_json(path, &plan.to_json())?;
    }
    interrupt::listen();
    // Files under way are removed when stages end, not when the process does.
    interrupt::something_to_save();
    let command: Vec<String> = std::env::args_os().map(|arg| arg.to_string_lossy().into_owned()).collect();
    let context = Context { observer: &listener, command: &command };
    let outcome = Prepared::new(&plan, &context)?.run(&context)?;
    listener.clear();
    if let Some(path) = &args.metadata {
        write_json(path, &outcome.metadata)?;
    }
    for report in &outcome.reports {
        if verbosity > Verbosity::Quiet {
            print(&summary::summary(report))?;
        } else if let Some(text) = summary::shortfall(report) {
            say(&text);
        }
    }
    Ok(outcome.exit_code)
}

impl Args {
    /// The text of the pipeline, and what messages call it.
    fn read(&self) -> Result<(String, PathBuf)> {
        let name = self.file.clone().unwrap_or_else(|| PathBuf::from("standard input"));
        let bytes = if let Some(path) = &self.file {
            std::fs::read(path)
        } else {
            let mut bytes = Vec::new();
            std::io::stdin().lock().read_to_end(&mut bytes).map(|_| bytes)
        };
        let bytes = bytes.map_err(|e| Error::io(&name, "read", e))?;
        let text = String::from_utf8(bytes).map_err(|e| {
            let at = format!("byte {}", e.utf8_error().valid_up_to());
            InputError::new(&name, "bytes that are no UTF-8", "JSON in UTF-8").at(at)
        })?;
        Ok((text, name))
    }
}

/// Shows how far a pipeline is.
struct Listener {
    verbosity: Verbosity,
    reconstruction: Progress,
    bar: Mutex<Option<ProgressBar>>,
    /// Where PDAL's lines on files go.
    lines: Option<Mutex<std::fs::File>>,
}

impl Listener {
    /// `progress` exists, as in PDAL: it may be a pipe.
    ///
    /// # Errors
    /// It cannot be opened.
    fn new(verbosity: Verbosity, progress: Option<&Path>) -> Result<Self> {
        let open = |path: &Path| {
            std::fs::OpenOptions::new().append(true).open(path).map_err(|e| Error::io(path, "open", e)).map(Mutex::new)
        };
        let lines = progress.map(open).transpose()?;
        Ok(Self { verbosity, reconstruction: Progress::new(verbosity), bar: Mutex::default(), lines })
    }

    fn line(&self, what: &str, file: &Path) {
        if let Some(lines) = &self.lines {
            // Nobody need listen.
            let mut lines = lines.lock().unwrap_or_else(PoisonError::into_inner);
            let _ = lines.write_all(format!("{what}:{}\n", file.display()).as_bytes());
        }
    }

    fn clear(&self) {
        if let Some(bar) = self.bar.lock().unwrap_or_else(PoisonError::into_inner).take() {
            bar.finish_and_clear();
        }
    }
}

impl Drop for Listener {
    fn drop(&mut self) {
        self.clear();
    }
}

impl Observer for Listener {
    fn started(&self, points: Option<u64>) {
        self.clear();
        if self.verbosity == Verbosity::Quiet || !std::io::stderr().is_terminal() {
            return;
        }
        let template = "reading points {wide_bar} {human_pos} of {human_len}, {per_sec}, {eta} left";
        let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
        let bar = match points {
            Some(points) => ProgressBar::new(points).with_style(style),
            None => ProgressBar::new_spinner(),
        };
        bar.enable_steady_tick(Duration::from_millis(200));
        *self.bar.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar);
    }

    fn advanced(&self, points: u64) {
        if let Some(bar) = self.bar.lock().unwrap_or_else(PoisonError::into_inner).as_ref() {
            bar.inc(points);
        }
    }

    fn finished(&self) {
        self.clear();
    }

    fn ready(&self, file: &Path) {
        self.line("READYFILE", file);
    }

    fn done(&self, file: &Path) {
        self.line("DONEFILE", file);
        if self.verbosity > Verbosity::Quiet {
            self.clear();
            say(&format!("written {}", file.display()));
        }
    }

    fn warning(&self, text: &str) {
        if self.verbosity == Verbosity::Quiet {
            return;
        }
        let write = || say(&format!("warning: {text}"));
        match self.bar.lock().unwrap_or_else(PoisonError::into_inner).as_ref() {
            Some(bar) => bar.suspend(write),
            None => write(),
        }
    }

    fn interrupted(&self) -> bool {
        interrupt::pressed()
    }

    fn reconstruction(&self) -> &dyn run::Observer {
        &self.reconstruction
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::catalogue::STAGES;
    use clap::Args as _;

    #[test]
    fn options_of_stages_become_settings() {
        let spelled = |arguments: &str| {
            let out = spell_out(arguments.split(' ').map(OsString::from));
            out.into_iter().map(|a| a.into_string().unwrap()).collect::<Vec<_>>().join(" ")
        };
        assert_eq!(
            spelled("gable pipeline p.json --readers.las.count=5 --validate --stage.a.x 7"),
            "gable pipeline p.json --set readers.las.count=5 --validate --set stage.a.x=7"
        );
        assert_eq!(spelled("gable info --readers.las.count=5"), "gable info --readers.las.count=5");
    }

    /// `writers.lod2` has the options of `gable reconstruct`, no more and no less, with the same defaults.
    #[test]
    fn the_stage_has_the_options_of_the_command() {
        let kind = STAGES.iter().find(|kind| kind.name == "writers.lod2").unwrap();
        let table = kind.table();
        let command = super::super::reconstruct::Args::augment_args(clap::Command::new("reconstruct"));
        // What only a command line has, and what a stage has by being one.
        let of_the_command =
            ["tiles", "output", "quiet", "verbose", "view", "config", "preset", "plan", "job", "parts"];
        let of_stages = ["filename", "where", "user_data"];
        let mut names: Vec<String> = Vec::new();
        for argument in command.get_arguments() {
            let name = argument.get_id().as_str().replace('-', "_");
            if of_the_command.contains(&name.as_str()) {
                continue;
            }
            let spec = table.iter().find(|spec| spec.name == name);
            let spec = spec.unwrap_or_else(|| panic!("writers.lod2 has no option `{name}`"));
            let default: Vec<String> =
                argument.get_default_values().iter().map(|value| value.to_string_lossy().into_owned()).collect();
            let own = match &spec.default {
                // A flag that is off has no default on the command line.
                serde_json::Value::Null | serde_json::Value::Bool(false) => String::new(),
                serde_json::Value::String(text) => text.clone(),
                other => other.to_string(),
            };
            assert_eq!(own, default.join(","), "the default of `{name}`");
            names.push(name);
        }
        for spec in &table {
            let is_there = names.contains(&spec.name) || of_stages.contains(&spec.name.as_str());
            assert!(is_there, "`gable reconstruct` has no --{}", spec.name.replace('_', "-"));
        }
    }
}
