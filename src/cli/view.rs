//! `gable view`: a page to look at a city model in.

use std::path::{Path, PathBuf};

use super::Outcome;
use super::output::{counted, print, say, table, thousands};
use super::progress::Verbosity;
use super::reading::{ReadingProgress, file_size};
use crate::error::{InputError, Result};
use crate::report::Report;
use crate::run::output::{model_path, prepare};
use crate::run::{FootprintSource, Job};
use crate::sink::{Format, write_whole};
use crate::source::{cityjson, points};
use crate::view::{Contents, Options, Page, build, path_for};

const EXAMPLES: &str = "\
Examples:
  A page beside the model, city.html:
    gable view city.city.json
  With the points that it was made from and the report of the run:
    gable view city.city.json --points tiles/*.laz --report city.city.json.report.json
  Under another name:
    gable view 3dbag.city.jsonl -o pages/3dbag.html

The page is one file and needs no network: open it in any browser. It colours the model by
semantics, fit, confidence, roof type, ladder step, validity or any attribute, lists what is at
fault, and shows the attributes of what is clicked. Faults are those of `gable validate`.

Exit codes:
  0  the page is written
  1  it is not, or bad usage
  2  it is written, but some features of the model or points of the tiles could not be read";

/// What `gable view` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// CityJSON (1.0 to 2.0) or CityJSONSeq file, of any maker, or a folder or pattern with one in it; `-` for standard
    /// input
    #[arg(value_name = "MODEL")]
    model: PathBuf,

    /// The page [default: beside the model, with .html for its extension]
    #[arg(short, long, value_name = "PAGE")]
    output: Option<PathBuf>,

    /// Replace the file of -o if it exists; a page beside the model always is
    #[arg(long, requires = "output")]
    overwrite: bool,

    /// Tiles whose points are shown around the buildings: files, folders or glob patterns
    #[arg(long, num_args = 1.., value_name = "TILE")]
    points: Vec<String>,

    /// Show at most so many points; of more an even random sample
    #[arg(long, value_name = "N", default_value_t = Options::MOST_POINTS, requires = "points")]
    max_points: usize,

    /// The report of the run that made the model: the page tells of the run too
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
}

/// The exit code when the page lacks something that its inputs should have had.
const INCOMPLETE: u8 = 2;

/// Makes the page and says what is in it.
///
/// # Errors
/// As [`build`]; the page cannot be written, or its name is that of another kind of file.
pub fn main(args: &Args) -> Outcome {
    let model = cityjson::only(&args.model)?;
    let path = args.output.clone().unwrap_or_else(|| path_for(&model));
    let is_page = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("html") || e.eq_ignore_ascii_case("htm"));
    if !is_page && !path.is_dir() {
        let fault = InputError::new(&path, "another extension than that of a page", "PAGE.html");
        return Err(fault.remedy("Give the name of an HTML file with -o").into());
    }
    prepare(&path, args.overwrite || args.output.is_none())?;
    let tiles = if args.points.is_empty() { Vec::new() } else { points::expand(&args.points)? };
    let options = Options { tiles, most_points: args.max_points, trust_tiles: false, report: args.report.clone() };
    let page = make(&model, &path, &options, true)?;
    print(&text(&page.contents, &path))?;
    let is_whole = page.contents.unreadable == 0 && page.problems.is_empty();
    Ok(if is_whole { 0 } else { INCOMPLETE })
}

/// Makes and writes a page; what is wrong with the inputs goes to standard error.
fn make(model: &Path, path: &Path, options: &Options, tells: bool) -> Result<Page> {
    let mut progress = tells.then(|| ReadingProgress::new("check", file_size(model)));
    let page = build(model, options, &mut |features, bytes| {
        if let Some(progress) = &mut progress {
            progress.advance(features, bytes);
        }
    });
    drop(progress);
    let page = page?;
    for problem in &page.problems {
        say(&format!("warning: {problem}"));
    }
    if page.contents.unreadable > 0 {
        let features = counted(page.contents.unreadable as u64, "feature");
        say(&format!("warning: {}: {features} could not be read; the page lists them", model.display()));
    }
    write_whole(path, &page.html)?;
    Ok(page)
}

/// Refuses a run whose page could not be made, before it is run.
///
/// # Errors
/// The model will not be CityJSON, or the page cannot be written.
pub fn prepare_for(job: &Job) -> Result<()> {
    if job.goes_to_many_files()? {
        let fault = InputError::new(&job.output, "a page of a model in several files", "a model in one file");
        return Err(fault.remedy("Leave --view out, and `gable view` one of them afterwards").into());
    }
    let footprints = job.footprints.as_ref().map(FootprintSource::name);
    let model = model_path(&job.output, &points::expand(&job.all_tiles())?, footprints.as_deref());
    let format = Format::of(&model)?;
    if !matches!(format, Format::CityJson | Format::CityJsonSeq) {
        let fault = InputError::new(&model, format!("{} with --view", format.name()), "a model in CityJSON");
        return Err(fault.remedy("Write CityJSON and turn it into other formats afterwards").into());
    }
    prepare(&path_for(&model), true)
}

/// The page of a run that is done, next to its model.
///
/// # Errors
/// As [`build`], or the page cannot be written.
pub fn of_run(report: &Report, job: &Job, verbosity: Verbosity) -> Result<()> {
    let mut outputs = report.outputs.iter().map(PathBuf::from);
    let Some(model) = outputs.next() else { return Ok(()) };
    let could_be_read = |path: &PathBuf| {
        let name = path.display().to_string();
        report.inputs.tiles.iter().all(|tile| tile.file != name || !tile.left_out)
    };
    let tiles = points::expand(&job.all_tiles())?.into_iter().filter(could_be_read).collect();
    let options = Options { tiles, most_points: Options::MOST_POINTS, trust_tiles: true, report: outputs.next() };
    let path = path_for(&model);
    make(&model, &path, &options, verbosity > Verbosity::Quiet)?;
    if verbosity > Verbosity::Quiet {
        print(&format!("A page to look at it in: {}\n", path.display()))?;
    }
    Ok(())
}

/// What is in a page, for a person.
fn text(contents: &Contents, path: &Path) -> String {
    let number = |n: usize| thousands(n as u64);
    let mut rows = vec![vec!["buildings".to_owned(), number(contents.buildings)]];
    rows.extend(contents.lods.iter().map(|(lod, count)| {
        let name = if lod.is_empty() { "  without geometry".to_owned() } else { format!("  up to LoD {lod}") };
        vec![name, number(*count)]
    }));
    if contents.others > 0 {
        rows.push(vec!["other objects".to_owned(), number(contents.others)]);
    }
    rows.push(vec!["invalid".to_owned(), number(contents.invalid)]);
    rows.push(vec!["triangles".to_owned(), number(contents.triangles)]);
    let [shown, around] = contents.points;
    if around > 0 {
        rows.push(vec!["points".to_owned(), format!("{} of {}", number(shown), number(around))]);
    }
    rows.push(vec!["written".to_owned(), path.display().to_string()]);
    table(&rows, "")
}
