//! `gable validate`: is a city model valid.

use std::collections::BTreeMap;
use std::path::PathBuf;

use super::Outcome;
use super::output::{print, say, table, thousands};
use super::reading::{ReadingProgress, file_size};
use crate::audit::{Finding, Options, Report, audit, refusal};
use crate::error::{InputError, Result};
use crate::sink::write_json;
use crate::source::cityjson;
use crate::validate::{Tolerances, codes};

/// The exit code when all files were checked and something in them is invalid.
const INVALID: u8 = 2;

const EXAMPLES: &str = "\
Examples:
  Is a model valid?
    gable validate city.city.json
  Every fault with its place, and a report in the shape of val3dity's:
    gable validate city.city.jsonl --list --json report.json
  By the rules of val3dity:
    gable validate city.city.json --planarity 0.01 --no-rounding --overlap 0 --first-level

The official schema of the version that a file states is checked as well (901), and the verdict says
whether schema or geometry failed. Codes 101 to 601 are those of val3dity. Codes 801 to 808 are about labels and attributes; they do not
make a file invalid unless --strict is given, nor do the warnings of the schema's makers: members of
the root that it does not know, vertices that repeat others or that no geometry uses.

Exit codes:
  0  everything is valid
  1  a file cannot be checked, or bad usage
  2  something is invalid";

/// What `gable validate` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own on the command line")]
pub struct Args {
    /// CityJSON (1.0 to 2.0) or CityJSONSeq files, folders of .city.json and .city.jsonl, or glob patterns; `-` for standard
    /// input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,

    /// Vertices no farther apart than this are one, metres; 0 leaves all as they are
    #[arg(long, value_name = "METRES", default_value_t = Tolerances::default().snap)]
    snap: f64,

    /// How far a vertex may be off the plane of its face, metres
    #[arg(long, value_name = "METRES", default_value_t = Tolerances::default().planarity)]
    planarity: f64,

    /// How far a part of a face may turn from its plane, degrees; what the rounding to the file's grid can turn is added
    #[arg(long, value_name = "DEGREES", default_value_t = Tolerances::default().normals)]
    normals: f64,

    /// Count also what the rounding to the file's grid explains of such a turn, as val3dity does
    #[arg(long)]
    no_rounding: bool,

    /// How far the parts of a building, and solids that form one, may overlap, metres; nothing is added, and 0 is exact
    #[arg(long, value_name = "METRES", default_value_t = Options::default().overlap)]
    overlap: f64,

    /// Of each geometry show only the first level that fails (rings, polygons, shells, …), as val3dity does
    #[arg(long)]
    first_level: bool,

    /// Do not check the official schema of the file's version
    #[arg(long)]
    no_schema: bool,

    /// Faults of labels and attributes, and warnings, make a file invalid too
    #[arg(long)]
    strict: bool,

    /// Print every fault with its place
    #[arg(long)]
    list: bool,

    /// Write a report in the shape of val3dity's to this JSON file; a list of reports for several files
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Checks the files; one that cannot be checked is told on standard error, and the others are.
///
/// # Errors
/// A tolerance is no length or angle, or the report cannot be written.
pub fn main(args: &Args) -> Outcome {
    let options = options(args)?;
    let mut reports = Vec::new();
    let mut refused = false;
    for path in &cityjson::expand(&args.files)? {
        let mut progress = ReadingProgress::new("validate", file_size(path));
        let found = audit(path, &options, &mut |features, bytes| progress.advance(features, bytes));
        drop(progress);
        match found {
            Ok(report) => {
                print(&text(&report, args.list, args.strict))?;
                reports.push(report);
            }
            Err(error) => {
                say(&format!("error (901 {}): {error}", codes::name(901)));
                reports.push(refusal(path, &options, &error));
                refused = true;
            }
        }
    }
    if let Some(path) = &args.json {
        // One report as it is; several as a list.
        match &reports[..] {
            [one] => write_json(path, one)?,
            several => write_json(path, &several)?,
        }
    }
    if refused {
        return Ok(super::FAILURE);
    }
    Ok(if reports.iter().any(|report| !invalid(report, args.strict).is_empty()) { INVALID } else { 0 })
}

/// How the files are to be checked.
///
/// # Errors
/// A tolerance is no length or angle.
pub(super) fn options(args: &Args) -> Result<Options> {
    let given = [
        ("--snap", args.snap, 1.0),
        ("--planarity", args.planarity, 1.0),
        ("--normals", args.normals, 180.0),
        ("--overlap", args.overlap, 1.0),
    ];
    for (name, value, most) in given {
        if !(0.0..=most).contains(&value) {
            return Err(InputError::new(name, value.to_string(), format!("a number from 0 to {most}")).into());
        }
    }
    let tolerances =
        Tolerances { snap: args.snap, planarity: args.planarity, normals: args.normals, rounding: !args.no_rounding };
    Ok(Options { tolerances, overlap: args.overlap, first_level: args.first_level, schema: !args.no_schema })
}

/// What counts against a file, in words; with `strict` also what is told and makes nothing invalid.
fn invalid(report: &Report, strict: bool) -> Vec<&'static str> {
    let told = if strict { report.told() } else { Vec::new() };
    report.invalid().into_iter().chain(told).collect()
}

/// A report for a person.
fn text(report: &Report, list: bool, strict: bool) -> String {
    let number = |n: usize| thousands(n as u64);
    let invalid = invalid(report, strict);
    let verdict = if invalid.is_empty() { "valid".to_owned() } else { format!("INVALID ({})", invalid.join(", ")) };
    let crs = report.crs.as_deref().unwrap_or("no CRS, lengths are taken for metres");
    let grid = match report.grid_step {
        None => String::new(),
        Some([x, _, z]) if x == z => format!(", checked on a grid of {x} m"),
        Some([x, _, z]) => format!(", checked on a grid of {x} m, upwards {z} m"),
    };
    let mut out = format!("{}: {verdict}\n  {}, {crs}{grid}\n", report.input_file, report.input_file_type);
    let mut rows = vec![["", "all", "valid"].map(str::to_owned).to_vec()];
    for row in report.features_overview.iter().chain(&report.primitives_overview) {
        rows.push(vec![row.kind.clone(), number(row.total), number(row.valid)]);
    }
    out += &table(&rows, "  ");
    let findings = || report.features.iter().map(|f| (&f.errors, &f.semantic_errors));
    let unread = std::iter::once(&report.dataset_errors);
    out += &by_code("schema", std::iter::once(&report.schema_errors));
    out += &by_code("faults", unread.chain(findings().map(|(errors, _)| errors)));
    out += &by_code("labels and attributes", findings().map(|(_, semantic)| semantic));
    if let (Some(first), false) = (report.schema_errors.first(), list) {
        out.extend(["  the first of the schema: ", &first.info, "\n"]);
    }
    out.extend(report.schema_warnings.iter().flat_map(|warning| ["  warning: ", warning, "\n"]));
    out.extend(report.notes.iter().flat_map(|note| ["  note: ", note, "\n"]));
    if list {
        let all = report.features.iter().flat_map(|f| f.errors.iter().chain(&f.semantic_errors));
        for finding in report.dataset_errors.iter().chain(&report.schema_errors).chain(all) {
            let Finding { code, description, id, info } = finding;
            out.extend(["  ", &code.to_string(), " ", description, " ", id, ": ", info, "\n"]);
        }
    }
    out
}

/// The number of faults of each code, and of the features that have it.
fn by_code<'a>(title: &str, findings: impl Iterator<Item = &'a Vec<Finding>>) -> String {
    let mut counts: BTreeMap<u16, [u64; 2]> = BTreeMap::new();
    for of_feature in findings {
        let mut of_code: BTreeMap<u16, u64> = BTreeMap::new();
        for finding in of_feature {
            *of_code.entry(finding.code).or_default() += 1;
        }
        for (code, count) in of_code {
            let [faults, features] = counts.entry(code).or_default();
            *faults += count;
            *features += 1;
        }
    }
    if counts.is_empty() {
        return String::new();
    }
    let mut rows = vec![[title, "faults", "features"].map(str::to_owned).to_vec()];
    rows.extend(counts.iter().map(|(&code, [faults, features])| {
        vec![format!("{code} {}", codes::name(code)), thousands(*faults), thousands(*features)]
    }));
    table(&rows, "  ")
}
