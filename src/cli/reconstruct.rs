//! `gable reconstruct`: points and footprints in, a city model out.

use std::path::PathBuf;

use super::making::{MakingArgs, RUN, ThreadArgs};
use super::output::{print, say};
use super::planned::{self, PlannedArgs};
use super::progress::{Progress, Verbosity};
use super::written::{OUTPUT, WrittenArgs};
use super::{Outcome, interrupt, summary, view};
use crate::error::{InputError, Result};
use crate::run::{Job, run};
use crate::sink::is_stream;

const EXAMPLES: &str = "\
Examples:
  The tiles of a folder and footprints in any CRS, one CityJSON file:
    gable reconstruct tiles/ --footprints buildings.gpkg -o city.city.json
  One building a line (CityJSONSeq), tiles that do not name their CRS:
    gable reconstruct 'ahn/*.laz' --footprints pand.sqlite --crs EPSG:7415 -o city.city.jsonl
  A cloud that is not classified, some of the footprints only:
    gable reconstruct a.laz b.laz -f houses.shp --filter \"height > 3\" \\
      --building-class any -o out/
  Footprints of a database; its password is in PGPASSWORD or ~/.pgpass:
    gable reconstruct tiles/ -f \"PG:host=db dbname=city user=me\" --layer bag.pand -o a.city.json
    gable reconstruct tiles/ -f postgresql://me@db/city -o a.city.json \\
      --query \"SELECT id, geom FROM bag.pand WHERE status = 'in use'\"
  Tiles in object storage or on the web, the model too; credentials as usual (AWS_ACCESS_KEY_ID, …):
    gable reconstruct s3://city/tiles/ -f s3://city/buildings.parquet -o s3://city/a.city.jsonl
  Those tiles of an index (STAC, pdal tindex) that touch the footprints:
    gable reconstruct https://host/items.json -f buildings.gpkg -o city.city.json
  A single object without a footprint, and one from photographs in feet, with y upwards:
    gable reconstruct church.laz --no-footprint -o church.city.json
    gable reconstruct church.ply --no-footprint --unit ft --up-axis y -o church.city.json
  The options of a file (TOML, the same names: `footprints = \"buildings.gpkg\"`), but for one:
    gable reconstruct --config city.toml --lambda 0.2
  With the terrain that the buildings stand in, to 10 cm:
    gable reconstruct tiles/ -f buildings.gpkg -o city.city.json --terrain --terrain-error 0.1
  And a page to look at it in: city.html
    gable reconstruct tiles/ -f buildings.gpkg -o city.city.json --view
  A part of a city, a file for each tile, with attributes called `b_height_ridge`:
    gable reconstruct tiles/ -f buildings.gpkg --box 84900,447400,85100,447600 \\
      --attribute-prefix b_ -o 'out/{tile}.city.json'
  One job of a plan that `gable plan` made, on this machine:
    gable reconstruct --plan plan/ --job 7

The output:
  The extension chooses the format: .city.json (CityJSON), .city.jsonl (CityJSONSeq),
  .3dtiles (3D Tiles, a folder), .gpkg (GeoPackage) or .obj (OBJ).
  A folder, or a name without an extension, gets a .city.json that is named after the tile
  if there is one, else after the footprints. In a name {tile} stands for the tile that a
  building lies in, {id} for its id: 'out/{tile}.city.json', 'out/{id}.obj'; their report is
  gable.report.json in the folder that all are in. `-`, and a pipe, get CityJSONSeq building by
  building, without a report unless --report names one. The report goes to OUT.report.json. Ctrl-C
  writes what is done; nothing appears under its name before it is whole. A run that was
  killed leaves what it has done in OUT.partial: the same command with --resume goes on. An
  object (s3://, az://, gs://) appears when it is whole; its OUT.partial is a folder here.
  A job of a plan leaves its part in PLAN/parts; `gable merge --plan` joins them. Done again it
  does nothing; killed, the same command goes on.

Exit codes:
  0  every footprint that holds points has a model
  1  nothing could be done, or bad usage
  2  finished, but some buildings lack a model or some tiles could not be read
  With --plan 0 once the part is there, whatever became of its buildings, else 1";

/// What `gable reconstruct` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES, mut_arg("tiles", |tiles| tiles.required_unless_present("plan")))]
#[expect(clippy::struct_excessive_bools, reason = "each is a flag of its own on the command line")]
pub struct Args {
    #[command(flatten)]
    making: MakingArgs,

    #[command(flatten)]
    threads: ThreadArgs,

    #[command(flatten)]
    planned: PlannedArgs,

    /// The model: a file (.city.json, .city.jsonl, .gpkg, .obj), a tileset (.3dtiles), a folder, or `-` for CityJSONSeq to
    /// standard output; with {tile} or {id} in its name a file for each tile or building
    #[arg(short, long, value_name = "OUT", required_unless_present = "plan", help_heading = OUTPUT)]
    output: Option<PathBuf>,

    /// Replace files that exist
    #[arg(long, help_heading = OUTPUT)]
    overwrite: bool,

    /// Go on from what a run that was killed has left in OUT.partial
    #[arg(long, help_heading = OUTPUT)]
    resume: bool,

    /// Write the points of each building, and those up to --ring-width around it, to a LAZ file of its own in the folder OUT,
    /// with all of them in OUT/index.gpkg, instead of models
    #[arg(long, conflicts_with_all = ["resume", "view", "no_footprint"], help_heading = OUTPUT)]
    crop_only: bool,

    /// Where the report goes [default: OUT.report.json]
    #[arg(long, value_name = "FILE", help_heading = OUTPUT)]
    report: Option<PathBuf>,

    /// Write a page to look at the model in, next to it: OUT.html
    #[arg(long, help_heading = OUTPUT)]
    view: bool,

    /// Say nothing but errors
    #[arg(short, long, conflicts_with = "verbose", help_heading = RUN)]
    quiet: bool,

    /// Say what became of every building
    #[arg(short, long, help_heading = RUN)]
    verbose: bool,

    #[command(flatten)]
    written: WrittenArgs,
}

/// Reconstructs and says what came out.
///
/// # Errors
/// As [`run`].
pub fn main(args: Args) -> Outcome {
    let verbosity = match (args.quiet, args.verbose) {
        (true, _) => Verbosity::Quiet,
        (false, true) => Verbosity::Verbose,
        (false, false) => Verbosity::Normal,
    };
    interrupt::listen();
    if let Some(run) = args.planned.run(args.threads.jobs, args.overwrite) {
        return planned::main(&run, verbosity);
    }
    let with_page = args.view;
    let crops = args.crop_only;
    let job = args.into_job()?;
    let to_stream = is_stream(&job.output);
    if with_page && to_stream {
        let fault = InputError::new("--view", "a page beside a stream", "a file as output, beside which it can stand");
        return Err(fault.remedy("Write the stream to a file, and `gable view` that").into());
    }
    if with_page {
        view::prepare_for(&job)?;
    }
    let report = run(&job, &Progress::new(verbosity))?;
    if verbosity > Verbosity::Quiet {
        let text = if crops { summary::cropped(&report) } else { summary::summary(&report) };
        if to_stream {
            say(text.trim_end());
        } else {
            print(&text)?;
        }
    } else if let Some(text) = summary::shortfall(&report) {
        say(&text);
    }
    if with_page {
        view::of_run(&report, &job, verbosity)?;
    }
    Ok(report.exit_code)
}

impl Args {
    /// # Errors
    /// A CRS that is none, or options that contradict each other.
    pub(super) fn into_job(self) -> Result<Job, InputError> {
        let job = self.written.into_job(self.making)?;
        let job = Job {
            output: self.output.unwrap_or_default(),
            threads: self.threads.jobs,
            crop_only: self.crop_only,
            overwrite: self.overwrite,
            resume: self.resume,
            report: self.report,
            ..job
        };
        job.refuse_contradictions()?;
        Ok(job)
    }
}
