//! `gable convert`: city models from format to format.

use std::path::PathBuf;

use super::Outcome;
use super::output::{counted, print, say};
use super::reading::{ReadingProgress, file_size};
use crate::convert::{Conversion, Pass, convert};
use crate::sink::is_stream;
use crate::source::cityjson;

const EXAMPLES: &str = "\
Examples:
  For a web map (3D Tiles 1.1; open city.3dtiles/tileset.json in CesiumJS):
    gable convert city.city.json -o city.3dtiles
  For QGIS, from anybody's CityJSON:
    gable convert lod2.city.jsonl -o city.gpkg
  One object to one feature a line, and back:
    gable convert city.city.json -o city.city.jsonl
  Only LoD 1.2, for a modelling program:
    gable convert city.city.json --lod 1.2 -o blocks.obj

The output:
  The extension chooses the format: .city.json, .city.jsonl, .3dtiles (a folder), .gpkg or .obj.
  `-` is standard input and standard output, which gets CityJSONSeq; pipes do, too.
  A sequence (.city.jsonl) is read feature by feature, whatever its size; a CityJSON object is
  held in memory as a whole. Appearances, geometry templates, points and lines are left out
  and told. Several files become one model as in `gable merge`.

Exit codes:
  0  done
  1  nothing could be done, or bad usage";

/// What `gable convert` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// CityJSON (1.0 to 2.0) or CityJSONSeq files, folders of .city.json and .city.jsonl, or glob patterns; `-` for standard
    /// input
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,

    #[command(flatten)]
    target: Target,
}

/// Where it goes, and what of it.
#[derive(Debug, clap::Args)]
pub(super) struct Target {
    /// The output: .city.json, .city.jsonl, .3dtiles (a folder), .gpkg or .obj; `-` for CityJSONSeq to standard output
    #[arg(short, long, value_name = "OUT")]
    pub(super) output: PathBuf,

    /// Replace what exists
    #[arg(long)]
    pub(super) overwrite: bool,

    /// CRS of the files, such as EPSG:7415; goes before what they say
    #[arg(long, value_name = "CRS")]
    pub(super) crs: Option<String>,

    /// Only these levels of detail, such as 2.2 or 0,1.2
    #[arg(long, value_name = "LOD", value_delimiter = ',')]
    pub(super) lod: Vec<String>,
}

/// Converts files.
///
/// # Errors
/// See [`convert`].
pub fn main(args: Args) -> Outcome {
    run("convert", cityjson::expand(&args.files)?, args.target)
}

/// Reads `inputs` and writes them as one model; `label` is what the progress calls it.
///
/// # Errors
/// See [`convert`].
pub(super) fn run(label: &'static str, inputs: Vec<PathBuf>, target: Target) -> Outcome {
    // They are read once for their ids and once to be written.
    let size = inputs.iter().map(|path| file_size(path)).sum::<u64>() * 2;
    let Target { output, overwrite, crs, lod } = target;
    let to_stream = is_stream(&output);
    let conversion = Conversion { inputs, output, overwrite, crs, lods: lod };
    let mut progress = ReadingProgress::new(label, size);
    let converted = convert(&conversion, &mut |at| {
        // The comparison of a few features is no part of the bar.
        if at.pass != Pass::Compare {
            progress.advance(at.features, at.bytes);
        }
    });
    drop(progress);
    let converted = converted?;
    for warning in &converted.warnings {
        say(&format!("warning: {warning}"));
    }
    let written = &converted.written;
    let (features, objects) = (counted(written.features as u64, "feature"), counted(written.objects as u64, "object"));
    let format = written.format.map_or_else(String::new, |format| format!("{}, ", format.name()));
    let megabytes = written.bytes as f64 / 1e6;
    let said = format!("{}: {format}{features}, {objects}, {megabytes:.1} MB", written.path.display());
    if to_stream {
        say(&said);
    } else {
        print(&(said + "\n"))?;
    }
    Ok(0)
}
