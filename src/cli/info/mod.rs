//! `gable info`: what is in tiles, footprint files and city models, and whether tiles and footprints go together.

mod describe;
mod model;
mod table;

use std::path::{Path, PathBuf};

use super::Outcome;
use super::output::{print, say};
use crate::error::Error;
use crate::source::cityjson;
use crate::source::crs::Crs;
use crate::source::footprints::{self, FootprintOptions};
use crate::source::points::{self, Placement, Unit, UpAxis};

const EXAMPLES: &str = "\
Examples:
  What is in a tile?
    gable info tile.laz
  Do these footprints lie on these tiles?
    gable info tiles/ buildings.gpkg
  What is in a city model?
    gable info city.city.json
  For a script:
    gable info --json tile.laz";

/// What `gable info` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// Tiles (LAS, LAZ, COPC, PLY, text, folders, glob patterns), footprint files or a PostGIS database, and city models; in object
    /// storage and on the web too
    #[arg(required = true, value_name = "FILES")]
    files: Vec<String>,

    /// CRS of the tiles; goes before what they say
    #[arg(long, value_name = "CRS")]
    crs: Option<String>,

    /// Unit of the coordinates of points without a CRS [default: m]
    #[arg(long, value_name = "UNIT", conflicts_with = "crs")]
    unit: Option<Unit>,

    /// Axis that points up in points without a CRS [default: z]
    #[arg(long, value_name = "AXIS", conflicts_with = "crs")]
    up_axis: Option<UpAxis>,

    /// CRS of the footprints; goes before what the file says
    #[arg(long, value_name = "CRS")]
    footprint_crs: Option<String>,

    /// Layer or table of the footprints, if there are several
    #[arg(long, value_name = "NAME")]
    layer: Option<String>,

    /// SELECT that gives the footprints of a database, instead of a layer
    #[arg(long, value_name = "SQL", conflicts_with = "layer")]
    query: Option<String>,

    /// Print JSON instead of tables
    #[arg(long)]
    json: bool,
}

/// Describes the files.
///
/// Exit code 2 says that some of the files could not be read, or not wholly.
///
/// # Errors
/// None of the files can be read, or a CRS that was given is none.
pub fn main(args: &Args) -> Outcome {
    let options = FootprintOptions {
        layer: args.layer.clone(),
        query: args.query.clone(),
        crs: args.footprint_crs.as_deref().map(Crs::parse).transpose()?,
        ..FootprintOptions::default()
    };
    let placement = Placement::given(args.unit, args.up_axis);
    let named = spread(&args.files);
    let (models, files): (Vec<&String>, Vec<&String>) = named.iter().partition(|file| model::is_model(file.as_ref()));
    let (tiles, footprints) = sort(&files);
    let (mut info, mut faults) = describe::describe(&tiles, &footprints, args.crs.as_deref(), &options, placement)?;
    for path in models {
        match model::describe(path.as_ref()) {
            Ok(model) => info.models.push(model),
            Err(fault) => faults.push(fault),
        }
    }
    let nothing = info.tiles.is_empty() && info.footprints.is_empty() && info.models.is_empty();
    if let Some(fault) = faults.pop_if(|_| nothing) {
        return Err(fault);
    }
    for fault in &faults {
        say(&format!("error: {fault}"));
    }
    if args.json {
        let json = serde_json::to_string_pretty(&info).map_err(|e| Error::io("standard output", "write", e.into()))?;
        print(&(json + "\n"))?;
    } else {
        print(&table::table_of(&info))?;
    }
    Ok(if faults.is_empty() && info.is_whole() { 0 } else { 2 })
}

/// The arguments with the models in folders and patterns by their own names; a folder of tiles, or of nothing that is known,
/// stays.
fn spread(files: &[String]) -> Vec<String> {
    let of_one = |file: &String| {
        let is_several = Path::new(file).is_dir() || (!Path::new(file).exists() && file.contains(['*', '?', '[']));
        let models = if is_several { cityjson::expand(&[file.into()]).unwrap_or_default() } else { Vec::new() };
        let has_tiles = models.is_empty() || points::expand(std::slice::from_ref(file)).is_ok();
        let models = models.into_iter().map(|model| model.to_string_lossy().into_owned());
        models.chain(has_tiles.then(|| file.clone())).collect::<Vec<String>>()
    };
    files.iter().flat_map(of_one).collect()
}

/// Parts footprint files, told by their extension, and databases from tiles.
fn sort(files: &[&String]) -> (Vec<String>, Vec<PathBuf>) {
    const FOOTPRINTS: [&str; 12] = [
        "gpkg",
        "geojson",
        "json",
        "shp",
        "fgb",
        "sqlite",
        "db",
        "geojsonl",
        "geojsons",
        "ndjson",
        "parquet",
        "geoparquet",
    ];
    let (mut tiles, mut outlines) = (Vec::new(), Vec::new());
    for file in files {
        let path = PathBuf::from(file);
        let shown = footprints::label(&path);
        let extension = shown.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        if FOOTPRINTS.contains(&extension.as_str()) || footprints::is_database(&path) {
            outlines.push(path);
        } else {
            tiles.push((*file).clone());
        }
    }
    (tiles, outlines)
}
