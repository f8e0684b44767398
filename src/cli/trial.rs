//! `gable evaluate --field …`: what fields are worth on virtual scans.

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use clap::ValueEnum;
use clap::builder::PossibleValue;
use indicatif::{ProgressBar, ProgressStyle};
use rayon::{ThreadPool, ThreadPoolBuilder};
use serde::Serialize;

use super::Outcome;
use super::making::threads;
use super::output::{duration, print, say};
use crate::error::{Error, InputError, Result};
use crate::network::{Field, FieldOptions, NetworkFile};
use crate::reconstruct::Parameters;
use crate::reconstruct::occupancy::network::Interface;
use crate::simulate::{self, Source};
use crate::sink::write_json;
use crate::source::cityjson;
use crate::trial::{Column, ColumnFindings, Contender, Figures, Step, Trial, choose, overhanging};

/// What `gable evaluate --field` takes beside models.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Trial of fields on virtual scans of the models")]
pub struct TrialArgs {
    /// Try these fields: each decides about the same scans of closed LoD 2 models, which are the truth
    #[arg(long = "field", id = "fields", value_enum, value_delimiter = ',', value_name = "FIELD,…")]
    fields: Vec<Contestant>,

    /// Also try them on this many generated buildings
    #[arg(long, value_name = "N", requires = "fields", default_value_t = 0)]
    generate: usize,

    /// Take at most this many models of each file, chosen by the seed [default: all]
    #[arg(long, value_name = "N", requires = "fields")]
    limit: Option<NonZeroUsize>,

    /// Conditions of the scans [default: all; those with overhangs need --generate]
    #[arg(long, value_enum, value_delimiter = ',', value_name = "COLUMN,…", requires = "fields")]
    columns: Vec<Column>,

    /// Seed of the choice of models, of generated buildings, of scans and of the points held out
    #[arg(long, value_name = "SEED", requires = "fields", default_value_t = 1)]
    seed: u64,

    /// Number of threads [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = threads, allow_negative_numbers = true, requires = "fields")]
    jobs: Option<NonZeroUsize>,

    /// Use this network instead of the embedded one of the same interface
    #[arg(long, value_name = "FILE", requires = "fields")]
    model: Option<PathBuf>,

    /// Run networks with this library of ONNX Runtime (libonnxruntime.so) instead of the embedded runtime
    #[arg(long, value_name = "LIBRARY", requires = "fields")]
    onnxruntime: Option<PathBuf>,
}

impl TrialArgs {
    /// Whether there are fields to try.
    pub fn is_given(&self) -> bool {
        !self.fields.is_empty()
    }

    /// The fields, ready to be asked.
    ///
    /// # Errors
    /// A network cannot be read, or is for none of the fields.
    pub(super) fn contenders(&self) -> Result<Vec<Contender>> {
        contenders(self)
    }

    /// The seed of all that is drawn.
    pub(super) fn seed(&self) -> u64 {
        self.seed
    }

    /// The number of threads, if it was given.
    pub(super) fn threads(&self) -> Option<NonZeroUsize> {
        self.jobs
    }

    /// The network in place of the embedded one, for the report.
    pub(super) fn network(&self) -> Option<String> {
        self.model.as_ref().map(|path| path.display().to_string())
    }

    /// The threads that do the work.
    ///
    /// # Errors
    /// The system does not give that many.
    pub(super) fn pool(&self) -> Result<ThreadPool> {
        let jobs = self.jobs.map_or(0, NonZeroUsize::get);
        ThreadPoolBuilder::new()
            .num_threads(jobs)
            .build()
            .map_err(|e| Error::io(format!("{jobs} threads"), "start", std::io::Error::other(e)))
    }
}

/// A field that can be tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Contestant {
    Oracle,
    Field(Field),
}

impl Contestant {
    fn name(self) -> &'static str {
        match self {
            Self::Oracle => "oracle",
            Self::Field(field) => field.name(),
        }
    }
}

impl ValueEnum for Contestant {
    fn value_variants<'a>() -> &'a [Self] {
        const ALL: [Contestant; 4] = [
            Contestant::Oracle,
            Contestant::Field(Field::HeightField),
            Contestant::Field(Field::Neural),
            Contestant::Field(Field::Points2Surf),
        ];
        &ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        match self {
            Self::Oracle => Some(PossibleValue::new("oracle").help("the truth itself: what cells and cut cost alone")),
            Self::Field(field) => field.to_possible_value(),
        }
    }
}

impl ValueEnum for Column {
    fn value_variants<'a>() -> &'a [Self] {
        &Self::ALL
    }

    fn to_possible_value(&self) -> Option<PossibleValue> {
        Some(PossibleValue::new(self.name()))
    }
}

/// The trial as data.
#[derive(Debug, Serialize)]
struct Report<'a> {
    gable: &'static str,
    seed: u64,
    network: Option<String>,
    parameters: &'a Parameters,
    sources: &'a [SourceReport],
    columns: &'a [ColumnFindings],
}

/// Where the buildings come from.
#[derive(Debug, Serialize)]
struct SourceReport {
    name: String,
    /// Its closed and valid models.
    closed: usize,
    /// Those of them that were scanned.
    used: usize,
    /// How many solids were left out, for each reason.
    left_out: BTreeMap<String, usize>,
}

/// Runs the trial.
///
/// # Errors
/// A file cannot be read or written, a network cannot be run, or there is no building to scan.
pub fn main(models: &[PathBuf], args: &TrialArgs, json: Option<&Path>) -> Outcome {
    let columns = columns(args)?;
    let contenders = contenders(args)?;
    let pool = args.pool()?;
    let limit = args.limit.map_or(usize::MAX, NonZeroUsize::get);
    let mut truths = Vec::new();
    let mut reports = Vec::new();
    let mut take = |source: Source, limit: usize| {
        let Source { name, mut models, left_out, .. } = source;
        let closed = models.len();
        choose(&mut models, limit, args.seed);
        let unfit: usize = left_out.values().sum();
        say(&format!("{name}: {} of {closed} models, {unfit} left out", models.len()));
        reports.push(SourceReport { name, closed, used: models.len(), left_out });
        truths.extend(models);
    };
    for path in &cityjson::expand(models)? {
        take(pool.install(|| simulate::read(path, None))?, limit);
    }
    if args.generate > 0 {
        take(pool.install(|| simulate::generate(args.generate, args.seed)), usize::MAX);
    }
    let needs_overhangs = columns.iter().any(|c| c.needs_overhangs());
    let overhanging = pool.install(|| overhanging(if needs_overhangs { args.generate } else { 0 }, args.seed));
    if truths.is_empty() && overhanging.is_empty() {
        return Err(InputError::new("MODEL", "no closed and valid LoD 2 building", "at least one")
            .remedy("Name files with LoD 2 solids, or --generate buildings")
            .into());
    }
    let trial =
        Trial { contenders, columns, models: truths, overhanging, parameters: Parameters::default(), seed: args.seed };
    let progress = Progress::new(&trial);
    let found = pool.install(|| trial.run(&|step| progress.step(step)));
    drop(progress);
    if let Some(path) = json {
        let report = Report {
            gable: env!("CARGO_PKG_VERSION"),
            seed: args.seed,
            network: args.network(),
            parameters: &trial.parameters,
            sources: &reports,
            columns: &found,
        };
        write_json(path, &report)?;
    }
    print(&text(&found))?;
    Ok(0)
}

fn columns(args: &TrialArgs) -> Result<Vec<Column>> {
    if args.columns.is_empty() {
        return Ok(Column::ALL.into_iter().filter(|c| args.generate > 0 || !c.needs_overhangs()).collect());
    }
    match args.columns.iter().find(|column| column.needs_overhangs() && args.generate == 0) {
        None => Ok(args.columns.clone()),
        Some(column) => {
            Err(InputError::new("--columns", column.name(), "a condition that models can be scanned under")
                .remedy("Generate buildings with overhangs by --generate")
                .into())
        }
    }
}

/// The fields, ready to be asked.
fn contenders(args: &TrialArgs) -> Result<Vec<Contender>> {
    let interface = args.model.as_deref().map(NetworkFile::open).transpose()?.map(|file| file.interface);
    let of_model = interface.map(|interface| match interface {
        Interface::Field { .. } => Field::Neural,
        Interface::Points2Surf { .. } => Field::Points2Surf,
    });
    if let (Some(path), Some(field)) = (&args.model, of_model)
        && !args.fields.contains(&Contestant::Field(field))
    {
        let found = format!("a network for --field {}", field.name());
        return Err(InputError::new(path, found, "one for a field that is tried").into());
    }
    let load = |contestant: &Contestant| {
        let field = match *contestant {
            Contestant::Oracle => None,
            Contestant::Field(field) => {
                let network = field != Field::HeightField;
                let options = FieldOptions {
                    field,
                    model: args.model.clone().filter(|_| of_model == Some(field)),
                    onnxruntime: args.onnxruntime.clone().filter(|_| network),
                    ..FieldOptions::default()
                };
                Some(options.load()?)
            }
        };
        Ok(Contender { name: contestant.name().to_owned(), field })
    };
    args.fields.iter().map(load).collect()
}

/// A figure of the table: its title, where it stands, and how it is written.
type Figure = (&'static str, fn(&Figures) -> Option<f64>, fn(f64) -> String);

const FIGURES: [Figure; 17] = [
    ("Cell accuracy, %", |f| f.cell_accuracy, percent),
    ("Cell IoU by volume, %", |f| f.cell_iou, percent),
    ("Cell IoU by volume after the cut, %", |f| f.cell_iou_after_cut, percent),
    ("Expected calibration error of cells, %", |f| f.calibration_error, percent),
    ("All outside, % of buildings", |f| f.all_outside, percent),
    ("Sign near the surface, % right", |f| f.sign_near, percent),
    ("Sign anywhere in the box, % right", |f| f.sign_uniform, percent),
    ("Volume IoU of the model, %, mean", |f| f.volume_iou, percent),
    ("Hausdorff distance, % of R, median", |f| f.hausdorff, percent),
    ("Symmetric mean Hausdorff distance, % of R, median", |f| f.symmetric_mean, percent),
    ("Roof RMSE (model to true roof, per building), m, median", |f| f.roof_rmse, |value| format!("{value:.3}")),
    ("Faces, mean", |f| f.faces_mean, |value| format!("{value:.1}")),
    ("Faces, median", |f| f.faces_median, |value| format!("{value:.1}")),
    ("Closed and valid LoD 2.2, % of buildings", |f| f.lod22, percent),
    ("Decided by the vote, % of buildings", |f| f.fallback, percent),
    ("Buildings", |f| Some(f.buildings as f64), |value| value.to_string()),
    ("Buildings with cells", |f| Some(f.with_cells as f64), |value| value.to_string()),
];

fn percent(share: f64) -> String {
    format!("{:.2}", 100.0 * share)
}

/// A Markdown table per figure, fields by conditions, and what was not seen.
fn text(columns: &[ColumnFindings]) -> String {
    let tables = FIGURES.map(|(title, figure, write)| {
        let mut rows = vec![vec![title.to_owned()]];
        rows.extend(columns.first().into_iter().flat_map(|c| c.fields.iter().map(|f| vec![f.field.clone()])));
        for column in columns {
            let values = column.fields.iter().map(|f| figure(&f.figures).map_or_else(|| "–".to_owned(), write));
            for (row, cell) in rows.iter_mut().zip(std::iter::once(column.column.name().to_owned()).chain(values)) {
                row.push(cell);
            }
        }
        markdown(&rows)
    });
    let unseen = columns.iter().filter(|column| !column.unseen.is_empty());
    let unseen = unseen.map(|c| format!("{}: nothing was seen of {}\n", c.column.name(), c.unseen.join(", ")));
    tables.join("\n") + &unseen.collect::<String>()
}

/// A Markdown table, also readable as it is: the first column to the left, the others to the right.
pub(super) fn markdown(rows: &[Vec<String>]) -> String {
    let count = rows.iter().map(Vec::len).max().unwrap_or(0);
    let width = |i: usize| rows.iter().filter_map(|row| row.get(i)).map(|cell| cell.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..count).map(|i| width(i).max(2)).collect();
    let cell = |(i, (text, &width)): (usize, (&String, &usize))| match i {
        0 => format!("| {text:<width$} |"),
        _ => format!(" {text:>width$} |"),
    };
    let rule = |(i, &width): (usize, &usize)| match i {
        0 => format!("| {} |", "-".repeat(width)),
        _ => format!(" {}: |", "-".repeat(width - 1)),
    };
    let mut lines: Vec<String> =
        rows.iter().map(|row| row.iter().zip(&widths).enumerate().map(cell).collect()).collect();
    lines.insert(lines.len().min(1), widths.iter().enumerate().map(rule).collect());
    lines.join("\n") + "\n"
}

/// How far the trial is: a bar on a terminal, and a line with the cost of every column.
struct Progress {
    names: Vec<String>,
    bar: Mutex<Option<ProgressBar>>,
}

impl Progress {
    fn new(trial: &Trial) -> Self {
        Self { names: trial.contenders.iter().map(|c| c.name.clone()).collect(), bar: Mutex::new(None) }
    }

    fn step(&self, step: Step<'_>) {
        let mut bar = self.bar.lock().unwrap_or_else(PoisonError::into_inner);
        match step {
            Step::Started { column, buildings } if std::io::stderr().is_terminal() => {
                let template = "{msg} {wide_bar} {pos} of {len} buildings, {eta} left";
                let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
                *bar = Some(ProgressBar::new(buildings as u64).with_style(style).with_message(column.name()));
            }
            Step::Started { .. } => {}
            Step::Building => {
                if let Some(bar) = &*bar {
                    bar.inc(1);
                }
            }
            Step::Finished { column, scans, fields } => {
                if let Some(bar) = bar.take() {
                    bar.finish_and_clear();
                }
                let costs =
                    self.names.iter().zip(fields).map(|(name, &seconds)| format!("{name} {}", duration(seconds)));
                say(&format!("{}: scans {}, {}", column.name(), duration(scans), costs.collect::<Vec<_>>().join(", ")));
            }
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        if let Some(bar) = self.bar.lock().unwrap_or_else(PoisonError::into_inner).take() {
            bar.finish_and_clear();
        }
    }
}
