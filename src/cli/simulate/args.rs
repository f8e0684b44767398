//! What `gable simulate` takes.

use std::num::NonZeroUsize;
use std::path::PathBuf;
use std::str::FromStr;

use clap::{ArgMatches, Command, FromArgMatches};

use super::super::flags::Flags;
use crate::pipeline::options::Tunable;
use crate::segment::{BuildingClasses, SegmentOptions};
use crate::simulate::ScanOptions;
use crate::simulate::shards::Interface;

/// The most threads that may be asked for.
const MOST_THREADS: usize = 1024;

const EXAMPLES: &str = "\
Examples:
  Training data from city models and 2 000 generated buildings, four scans of each:
    gable simulate models/*.city.json --generate 2000 --variants 4 -o shards/
  The same for the network of the paper:
    gable simulate models/*.city.json -o shards/ --interface points2surf
  Training data from real scans; one of the tiles is kept for validation:
    gable simulate --real ahn/1.laz ahn/2.laz --hold-back ahn/3.laz -f pand.gpkg --variants 8 -o real/
  Validation data under one condition, everything else going well:
    gable simulate city.city.json -o shards/ --split 0,1,0 --clean --density 5 --noise 0.01
  Buildings that are known exactly, as a tile, and what becomes of them:
    gable simulate --generate 100 --clean --density 8 --scans town/
    gable reconstruct town/points.laz -f town/footprints.geojson -o town/model.city.json
    gable evaluate town/model.city.json --reference town/reference.city.json

Models that are open or invalid are left out and counted. Of the training data, a scan without
a partition is left out and counted in manifest.json, which also tells which tile is of which
split: a file is a tile, a file of more than 600 models is divided into blocks of 250 m, and
generated buildings are tiles of 50.

Real scans are thinned, cropped and given holes; what is asked about them is answered by all
their points: above the top ones it is free, below them inside, and where nothing was scanned
unknown, which training does not count. A building that lies in tiles of several splits is
only of the last of them.

Of a value such as --density 1..60 every scan draws its own; --density 10 is the same for all.
The same files, options and seed give the same bytes, whatever the number of threads.

Exit codes:
  0  done
  1  nothing could be done, or bad usage
  2  interrupted: what is there is whole, but not all that was asked for; or models that
     could not be scanned for --scans";

/// What `gable simulate` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
#[command(group = clap::ArgGroup::new("placed").args(["scans", "real", "hold_back"]).multiple(true))]
pub struct Args {
    /// LoD 2 models: CityJSON (1.0 to 2.0) or CityJSONSeq files, folders of .city.json and .city.jsonl, or glob patterns
    #[arg(value_name = "FILES", required_unless_present_any = ["generate", "real", "hold_back"])]
    pub(super) files: Vec<PathBuf>,

    /// Also scan so many generated buildings
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(super) generate: usize,

    /// Scans of each model
    #[arg(long, value_name = "N", default_value = "1")]
    pub(super) variants: NonZeroUsize,

    /// Folder for training data: shards and a manifest
    #[arg(short, long, value_name = "FOLDER", required_unless_present_any = ["scans", "statistics"])]
    pub(super) output: Option<PathBuf>,

    /// Folder for one scan of each model as a tile, with footprints and the models as reference
    #[arg(long, value_name = "FOLDER")]
    pub(super) scans: Option<PathBuf>,

    /// File for what the scans look like: figures of the virtual and of the real ones side by side (Markdown)
    #[arg(long, value_name = "FILE")]
    pub(super) statistics: Option<PathBuf>,

    /// CRS of models that do not name theirs, such as EPSG:31256 (for --scans), or of the real tiles
    #[arg(long, value_name = "CRS", requires = "placed")]
    pub(super) crs: Option<String>,

    /// Replace files that are there
    #[arg(long)]
    pub(super) overwrite: bool,

    /// For which network the data are
    #[arg(long, value_name = "NAME", default_value = "field", value_parser = interface())]
    pub(super) interface: Interface,

    /// Shares of training, validation and test; tiles are never divided
    #[arg(long, value_name = "SHARES", default_value = "0.9,0.1,0")]
    pub(super) split: Shares,

    /// What everything random follows from
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub(super) seed: u64,

    /// No more models than this from each source
    #[arg(long, value_name = "N")]
    pub(super) limit: Option<NonZeroUsize>,

    /// Level of detail of the models [default: the highest of LoD 2]
    #[arg(long, value_name = "LOD")]
    pub(super) lod: Option<String>,

    /// Scan the models as they stand instead of mirrored, turned and scaled
    #[arg(long)]
    pub(super) no_augmentation: bool,

    /// Number of threads [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    pub(super) jobs: Option<NonZeroUsize>,

    /// Say nothing but errors
    #[arg(short, long)]
    pub(super) quiet: bool,

    #[command(flatten)]
    pub(super) real: RealArgs,

    #[command(flatten)]
    pub(super) sizes: SizeArgs,

    #[command(flatten)]
    pub(super) conditions: ScanArgs,
}

/// Real scans to learn from.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Real scans")]
pub(super) struct RealArgs {
    /// Also learn from the buildings of these tiles: LAS, LAZ or COPC files, folders or glob patterns
    #[arg(long, num_args = 1.., value_name = "TILES", requires = "footprints")]
    pub(super) real: Vec<String>,

    /// Tiles of real scans that are kept for validation, whatever the shares are
    #[arg(long, num_args = 1.., value_name = "TILES", requires = "footprints")]
    pub(super) hold_back: Vec<String>,

    /// Where the buildings of the real scans stand: footprints in any form that `gable reconstruct` reads
    #[arg(short, long, value_name = "FILE", requires = "placed")]
    pub(super) footprints: Option<PathBuf>,

    /// CRS of the footprints; goes before what the file says
    #[arg(long, value_name = "CRS", requires = "footprints")]
    pub(super) footprint_crs: Option<String>,

    /// Classes of building points, such as 1,6; "any" for clouds that are not classified
    #[arg(long, value_name = "CLASSES", default_value_t = SegmentOptions::default().building_classes)]
    pub(super) building_class: BuildingClasses,
}

/// Sizes of the training data.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Training data")]
pub(super) struct SizeArgs {
    /// Queries near the surface, for each scan
    #[arg(long, value_name = "N", default_value_t = 64)]
    pub(super) near: usize,

    /// Queries anywhere in the box
    #[arg(long, value_name = "N", default_value_t = 48)]
    pub(super) uniform: usize,

    /// Cells of the partition that are asked about
    #[arg(long, value_name = "N", default_value_t = 18)]
    pub(super) cells: usize,

    /// Queries in each cell
    #[arg(long, value_name = "N", default_value = "8")]
    pub(super) samples_per_cell: NonZeroUsize,

    /// Points of a patch [default: 16, points2surf: 300]
    #[arg(long, value_name = "N")]
    pub(super) patch_points: Option<NonZeroUsize>,

    /// Rows and columns of the raster (field)
    #[arg(long, value_name = "N", default_value = "32")]
    pub(super) grid: NonZeroUsize,

    /// Scans of a shard
    #[arg(long, value_name = "N", default_value = "512")]
    pub(super) shard: NonZeroUsize,
}

/// How scans are made: `--clean` and what is set beside.
#[derive(Debug, Clone)]
pub(super) struct ScanArgs(pub(super) ScanOptions);

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
pub(super) struct Shares(pub(super) [f64; 3]);

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
        assert_eq!(parse(&[]).unwrap().conditions.0, ScanOptions::training());
        let set = parse(&["--density", "5", "--setup", "airborne", "--noise", "0..0.01"]).unwrap().conditions.0;
        let expected = ScanOptions {
            density: Span::fixed(5.0),
            setup: SetupChoice::Airborne,
            noise: Span::new(0.0, 0.01),
            ..ScanOptions::training()
        };
        assert_eq!(set, expected);
        // What stands on the command line goes before what is clean, even where it is as in training.
        let set = parse(&["--clean", "--density", "1..60", "--dropped", "0.1"]).unwrap().conditions.0;
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
