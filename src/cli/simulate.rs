//! `gable simulate`: from models to training data, and to tiles that look like those of a flight.

use std::fmt::Write as _;
use std::io::IsTerminal;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use clap::{ArgMatches, Command, FromArgMatches};
use indicatif::{ProgressBar, ProgressStyle};

use super::flags::{Flags, Tunable};
use super::output::{counted, duration, print, say, table, thousands};
use super::{Outcome, interrupt};
use crate::error::{Error, InputError, Result};
use crate::simulate::shards::{Interface, Job, Manifest, Observer, Sizes, run};
use crate::simulate::{ScanOptions, Source, Split, generate, read};

/// The exit code when it was interrupted, or some scans gave nothing.
const INCOMPLETE: u8 = 2;
/// How often a plain line says how far it is.
const PLAIN_INTERVAL: Duration = Duration::from_secs(10);
/// The most threads that may be asked for.
const MOST_THREADS: usize = 1024;

const EXAMPLES: &str = "\
Examples:
  Training data from city models and 2 000 generated buildings, four scans of each:
    gable simulate models/*.city.json --generate 2000 --variants 4 -o shards/
  The same for the network of the paper:
    gable simulate models/*.city.json -o shards/ --interface points2surf
  Validation data under one condition, everything else going well:
    gable simulate city.city.json -o shards/ --split 0,1,0 --clean --density 5 --noise 0.01

Of a value such as --density 1..60 every scan draws its own; --density 10 is the same for all.
The same files, options and seed give the same bytes, whatever the number of threads.

Exit codes:
  0  done
  1  nothing could be done, or bad usage
  2  finished, but some scans gave nothing, or it was interrupted: the manifest says which and why";

/// What `gable simulate` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// LoD 2 models: CityJSON (1.0 to 2.0) or CityJSONSeq files
    #[arg(value_name = "FILES", required_unless_present = "generate")]
    files: Vec<PathBuf>,

    /// Also scan so many generated buildings
    #[arg(long, value_name = "N", default_value_t = 0)]
    generate: usize,

    /// Scans of each model
    #[arg(long, value_name = "N", default_value = "1")]
    variants: NonZeroUsize,

    /// Folder for the training data: shards and a manifest
    #[arg(short, long, value_name = "FOLDER")]
    output: PathBuf,

    /// Replace training data that are there
    #[arg(long)]
    overwrite: bool,

    /// For which network the data are
    #[arg(long, value_name = "NAME", default_value = "field", value_parser = interface())]
    interface: Interface,

    /// Shares of training, validation and test; tiles are never divided
    #[arg(long, value_name = "SHARES", default_value = "0.9,0.1,0")]
    split: Shares,

    /// What everything random follows from
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,

    /// No more models than this from each source
    #[arg(long, value_name = "N")]
    limit: Option<NonZeroUsize>,

    /// Level of detail of the models [default: the highest of LoD 2]
    #[arg(long, value_name = "LOD")]
    lod: Option<String>,

    /// Scan the models as they stand instead of mirrored, turned and scaled
    #[arg(long)]
    no_augmentation: bool,

    /// Number of threads [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    jobs: Option<NonZeroUsize>,

    /// Say nothing but errors
    #[arg(short, long)]
    quiet: bool,

    #[command(flatten)]
    sizes: SizeArgs,

    #[command(flatten)]
    scans: ScanArgs,
}

/// Sizes of the training data.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Training data")]
struct SizeArgs {
    /// Queries near the surface, for each scan
    #[arg(long, value_name = "N", default_value_t = 64)]
    near: usize,

    /// Queries anywhere in the box
    #[arg(long, value_name = "N", default_value_t = 48)]
    uniform: usize,

    /// Cells of the partition that are asked about
    #[arg(long, value_name = "N", default_value_t = 18)]
    cells: usize,

    /// Queries in each cell
    #[arg(long, value_name = "N", default_value = "8")]
    samples_per_cell: NonZeroUsize,

    /// Points of a patch [default: 16, points2surf: 300]
    #[arg(long, value_name = "N")]
    patch_points: Option<NonZeroUsize>,

    /// Rows and columns of the raster (field)
    #[arg(long, value_name = "N", default_value = "32")]
    grid: NonZeroUsize,

    /// Scans of a shard
    #[arg(long, value_name = "N", default_value = "512")]
    shard: NonZeroUsize,
}

/// How scans are made: `--clean` and what is set beside.
#[derive(Debug, Clone)]
struct ScanArgs(ScanOptions);

impl Tunable for ScanOptions {
    const HEADING: &'static str = "Scans";
    const ELSEWHERE: &'static [&'static str] = &[];
    const LIMITS: &'static [(&'static str, [f64; 2])] = &[];
}

impl clap::Args for ScanArgs {
    fn augment_args(command: Command) -> Command {
        let clean = clap::Arg::new("clean")
            .long("clean")
            .action(clap::ArgAction::SetTrue)
            .help_heading(ScanOptions::HEADING)
            .help("Start from scans in which nothing goes wrong (airborne, 10 pulses per m²), not from those for training");
        Flags::<ScanOptions>::augment_args(command.arg(clean))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for ScanArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut scans = Self(ScanOptions::training());
        scans.update_from_arg_matches(matches)?;
        Ok(scans)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        let start = if matches.get_flag("clean") { ScanOptions::clean() } else { self.0.clone() };
        let mut flags = Flags(start);
        flags.update_from_arg_matches(matches)?;
        self.0 = flags.0;
        Ok(())
    }
}

/// Shares of training, validation and test.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Shares([f64; 3]);

impl FromStr for Shares {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let shares: Vec<f64> = text.split(',').filter_map(|share| share.trim().parse().ok()).collect();
        match <[f64; 3]>::try_from(shares) {
            Ok(shares) if shares.iter().all(|s| (0.0..=1e9).contains(s)) && shares.iter().sum::<f64>() > 0.0 => {
                Ok(Self(shares))
            }
            _ => Err("three shares are expected, such as 0.9,0.1,0: training, validation, test".to_owned()),
        }
    }
}

fn interface() -> impl clap::builder::TypedValueParser<Value = Interface> {
    use clap::builder::{PossibleValuesParser, TypedValueParser};
    let all = [Interface::Field, Interface::Points2surf];
    PossibleValuesParser::new(all.map(Interface::name))
        .map(move |name| all.into_iter().find(|one| one.name() == name).unwrap_or(Interface::Field))
}

/// A number of threads.
fn threads(text: &str) -> Result<NonZeroUsize, String> {
    let threads = text.trim().parse().ok().filter(|threads: &NonZeroUsize| threads.get() <= MOST_THREADS);
    threads.ok_or_else(|| format!("a whole number from 1 to {MOST_THREADS} is expected"))
}

/// Runs the command.
///
/// # Errors
/// No source gives a model, a file cannot be read, or the output cannot be written.
pub fn main(args: &Args) -> Outcome {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.jobs.map_or(0, NonZeroUsize::get)).build();
    let pool = pool.map_err(|fault| {
        InputError::new("--jobs", format!("threads that the system does not give: {fault}"), "fewer of them")
    })?;
    pool.install(|| simulate(args))
}

fn simulate(args: &Args) -> Outcome {
    prepare(&args.output, args.overwrite)?;
    let sources = sources(args)?;
    let sizes = sizes(args);
    let scans = sources.iter().map(|source| source.models.len()).sum::<usize>() * args.variants.get();
    let job = Job {
        sources,
        variants: args.variants.get(),
        options: args.scans.0.clone(),
        augment: !args.no_augmentation,
        interface: args.interface,
        sizes,
        shares: args.split.0,
        seed: args.seed,
        shard: args.sizes.shard.get(),
        output: args.output.clone(),
    };
    interrupt::listen();
    interrupt::something_to_save();
    let progress = Progress::new(scans as u64, args.quiet);
    let manifest = run(&job, &progress)?;
    let elapsed = progress.finish();
    if !args.quiet {
        print(&summary(&manifest, elapsed))?;
    }
    Ok(if manifest.interrupted || !manifest.failed.is_empty() { INCOMPLETE } else { 0 })
}

/// Makes the folder; refuses one that holds training data.
fn prepare(folder: &Path, overwrite: bool) -> Result<()> {
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "create", e))?;
    let entries = std::fs::read_dir(folder).map_err(|e| Error::io(folder, "read", e))?;
    for entry in entries {
        let path = entry.map_err(|e| Error::io(folder, "read", e))?.path();
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let is_shard = name.ends_with(".safetensors") && Split::ALL.iter().any(|split| name.starts_with(split.name()));
        if !is_shard && name != "manifest.json" {
            continue;
        }
        if !overwrite {
            return Err(InputError::new(folder, format!("training data ({name})"), "a folder without any")
                .remedy("Give --overwrite to replace them, or another folder")
                .into());
        }
        // What is left of more shards than there will be must not be taken for part of the new data.
        std::fs::remove_file(&path).map_err(|e| Error::io(&path, "remove", e))?;
    }
    Ok(())
}

fn sources(args: &Args) -> Result<Vec<Source>> {
    let mut sources = Vec::new();
    for path in &args.files {
        let mut source = read(path, args.lod.as_deref())?;
        // Two files of one name in different folders are two tiles.
        let double = sources.iter().filter(|other: &&Source| other.name == source.name).count();
        if double > 0 {
            for model in &mut source.models {
                model.tile = format!("{} ({})", model.tile, double + 1).into();
            }
        }
        sources.push(source);
    }
    if args.generate > 0 {
        sources.push(generate(args.generate, args.seed));
    }
    for source in &mut sources {
        source.models.truncate(args.limit.map_or(usize::MAX, NonZeroUsize::get));
    }
    if sources.iter().all(|source| source.models.is_empty()) {
        let reasons: Vec<String> =
            sources.iter().flat_map(|s| &s.left_out).map(|(reason, count)| format!("{count} × {reason}")).collect();
        let named = args.files.first().map_or_else(|| PathBuf::from("--generate"), Clone::clone);
        return Err(InputError::new(named, format!("no model that could be scanned ({})", reasons.join(", ")), "some")
            .remedy("`gable validate` tells what is wrong with a file, solid by solid")
            .into());
    }
    Ok(sources)
}

fn sizes(args: &Args) -> Sizes {
    let given = &args.sizes;
    let usual = Sizes::of(args.interface);
    Sizes {
        grid: if usual.grid == 0 { 0 } else { given.grid.get() },
        neighbours: given.patch_points.map_or(usual.neighbours, NonZeroUsize::get),
        near: given.near,
        uniform: given.uniform,
        cells: given.cells,
        samples_per_cell: given.samples_per_cell.get(),
        ..usual
    }
}

/// What was made, for a person.
fn summary(manifest: &Manifest, elapsed: f64) -> String {
    let row = |name: String, value: String| vec![name, value];
    let mut rows = Vec::new();
    for source in &manifest.sources {
        rows.push(row(source.name.clone(), counted(source.models as u64, "model")));
        for (reason, &count) in &source.left_out {
            rows.push(row(format!("  left out: {reason}"), thousands(count as u64)));
        }
    }
    for split in Split::ALL {
        let tiles = manifest.tiles.values().filter(|of| **of == split).count();
        let scans = manifest.scans.get(&split).copied().unwrap_or(0);
        if tiles > 0 {
            rows.push(row(
                format!("{} ({})", split.name(), counted(tiles as u64, "tile")),
                counted(scans as u64, "scan"),
            ));
        }
    }
    for (reason, &count) in &manifest.failed {
        rows.push(row(format!("  gave nothing: {reason}"), thousands(count as u64)));
    }
    let mut text = table(&rows, "");
    let scans: usize = manifest.scans.values().sum();
    let ended = if manifest.interrupted { "interrupted after" } else { "in" };
    let _ = writeln!(
        text,
        "{} in {}, {ended} {}",
        counted(scans as u64, "scan"),
        counted(manifest.shards.len() as u64, "shard"),
        duration(elapsed)
    );
    text
}

/// How far it is: a bar on a terminal, a plain line now and then otherwise.
struct Progress {
    bar: Option<ProgressBar>,
    quiet: bool,
    total: u64,
    done: AtomicU64,
    started: Instant,
    last_line: Mutex<Instant>,
}

impl Progress {
    fn new(total: u64, quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let template = "simulating {wide_bar} {human_pos} of {human_len} scans, {per_sec}, {eta} left";
            let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
            let bar = ProgressBar::new(total).with_style(style);
            bar.enable_steady_tick(Duration::from_millis(200));
            bar
        });
        let now = Instant::now();
        Self { bar, quiet, total, done: AtomicU64::new(0), started: now, last_line: Mutex::new(now) }
    }

    /// Clears the bar; returns the seconds that it took.
    fn finish(&self) -> f64 {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
        self.started.elapsed().as_secs_f64()
    }
}

impl Observer for Progress {
    fn advanced(&self, by: u64) {
        let done = self.done.fetch_add(by, Ordering::Relaxed) + by;
        if let Some(bar) = &self.bar {
            bar.inc(by);
        } else if !self.quiet {
            let mut last = self.last_line.lock().unwrap_or_else(PoisonError::into_inner);
            if last.elapsed() >= PLAIN_INTERVAL {
                *last = Instant::now();
                let left = self.total.saturating_sub(done) as f64 / done.max(1) as f64;
                let left = duration(left * self.started.elapsed().as_secs_f64());
                say(&format!("simulating: {} of {}, about {left} left", thousands(done), counted(self.total, "scan")));
            }
        }
    }

    fn interrupted(&self) -> bool {
        interrupt::pressed()
    }
}

/// Clears the bar of a simulation that failed.
impl Drop for Progress {
    fn drop(&mut self) {
        self.finish();
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::simulate::{SetupChoice, Span};

    #[derive(Debug, Parser)]
    struct Cli {
        #[command(flatten)]
        args: Args,
    }

    fn parse(arguments: &[&str]) -> Result<Args, clap::Error> {
        let all = ["simulate", "a.json", "-o", "out"].iter().chain(arguments);
        Cli::try_parse_from(all).map(|cli| cli.args)
    }

    #[test]
    fn scans_are_those_for_training_unless_they_are_clean() {
        assert_eq!(parse(&[]).unwrap().scans.0, ScanOptions::training());
        let set = parse(&["--density", "5", "--setup", "airborne", "--noise", "0..0.01"]).unwrap().scans.0;
        let expected = ScanOptions {
            density: Span::fixed(5.0),
            setup: SetupChoice::Airborne,
            noise: Span::new(0.0, 0.01),
            ..ScanOptions::training()
        };
        assert_eq!(set, expected);
        // What stands on the command line goes before what is clean, even where it is as in training.
        let set = parse(&["--clean", "--density", "1..60", "--dropped", "0.1"]).unwrap().scans.0;
        let expected = ScanOptions { density: Span::new(1.0, 60.0), dropped: Span::fixed(0.1), ..ScanOptions::clean() };
        assert_eq!(set, expected);
    }

    #[test]
    fn slips_are_refused() {
        for slip in [
            ["--density", "60..1"],
            ["--split", "0.9,0.1"],
            ["--split", "0,0,0"],
            ["--interface", "pointnet"],
            ["--tree-chance", "2"],
            ["--setup", "satellite"],
            ["--variants", "0"],
        ] {
            assert!(parse(&slip).is_err(), "{slip:?}");
        }
        assert!(Cli::try_parse_from(["simulate", "-o", "out"]).is_err(), "a source is needed");
    }
}
