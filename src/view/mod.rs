//! One HTML file to look at a city model in: the model in 3D, what it is worth, and where it is at fault.
//!
//! [`build`] reads a CityJSON or CityJSONSeq file of any maker, checks it as [`audit()`] does, and puts it into
//! the page of `src/view/page`, which needs no network: the model travels in it as compressed columns. What is shown is what
//! the file holds; gable's own attributes ([`ATTRIBUTES`](crate::sink::ATTRIBUTES)) open more colourings, and those of other
//! makers can be coloured by too.
//!
//! - `payload` is what the page is given, `packed` how it is packed.
//! - `feature` turns a top-level object into faces, triangles and edges; `faults` says which of them are at fault.
//! - `cloud` picks the points around the buildings.
//! - `record` reads the report of the run that made the model.
//! - `page` puts all of it into the page.

pub(crate) mod cloud;
mod faults;
mod feature;
pub(crate) mod packed;
pub(crate) mod page;
mod payload;
mod record;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use crate::audit::{self, audit};
use crate::error::{Error, InputError, Result};
use crate::sink::prefix_in;
use crate::site::Frame;
use crate::source::cityjson::{self, CityObject};
use crate::source::crs::Crs;
use crate::source::open::refuse_pipe;
use crate::source::points::TileProblem;
use payload::Payload;

pub use page::path_for;

/// What is shown beside the model.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Options {
    /// Tiles whose points are shown around the buildings; none without.
    pub tiles: Vec<PathBuf>,
    /// At most so many points: where the tiles have more around the buildings, an even random sample of them.
    pub most_points: usize,
    /// Whether the tiles are in the CRS of the model whatever they say, because a run that made the model took them to be.
    pub trust_tiles: bool,
    /// The report of the run that made the model, if any.
    pub report: Option<PathBuf>,
}

impl Options {
    /// As many points as a page still loads quickly with: about 3 MB.
    pub const MOST_POINTS: usize = 500_000;
}

impl Default for Options {
    fn default() -> Self {
        Self { tiles: Vec::new(), most_points: Self::MOST_POINTS, trust_tiles: false, report: None }
    }
}

/// A page that is ready to be written.
#[derive(Debug, Clone)]
pub struct Page {
    /// The whole file.
    pub html: Vec<u8>,
    /// What is in it.
    pub contents: Contents,
    /// What is wrong with tiles whose other points are shown.
    pub problems: Vec<TileProblem>,
}

/// What is in a page.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Contents {
    /// Number of top-level buildings.
    pub buildings: usize,
    /// Number of other top-level objects.
    pub others: usize,
    /// The highest level of detail of the geometry of a building, and how many buildings have it; highest first. Empty
    /// text for buildings without geometry.
    pub lods: Vec<(String, usize)>,
    /// Number of top-level objects that are invalid.
    pub invalid: usize,
    /// Number of features of the file that could not be read, and are not shown.
    pub unreadable: usize,
    /// Number of triangles, all levels of detail together.
    pub triangles: usize,
    /// Number of points that are shown, and that the tiles have around the buildings.
    pub points: [usize; 2],
}

/// Makes the page of a model. While it is checked, `progress` is told the number of features so far and the number of bytes
/// that were read since it was last told.
///
/// # Errors
/// The model cannot be read or is no CityJSON 1.0 to 2.0, its CRS is geographic (there is no 3D space to show it in), it has
/// no object; a tile cannot be opened or says that it is in another CRS; the report is none of gable's.
pub fn build(model: &Path, options: &Options, progress: &mut dyn FnMut(usize, u64)) -> Result<Page> {
    let report = options.report.as_deref().map(record::read).transpose()?;
    refuse_pipe(model)?;
    let pieces = cityjson::features(model)?;
    let crs = pieces.head().crs_code().and_then(|code| Crs::parse(&code).ok());
    if let Some(crs) = crs.as_ref().filter(|crs| crs.is_geographic) {
        return Err(InputError::new(
            model,
            format!("the geographic CRS {}", crs.name),
            "coordinates in metres or feet",
        )
        .at("metadata.referenceSystem")
        .remedy("Reproject the model before it is shown")
        .into());
    }
    let found = audit(model, &audit::Options { schema: false, ..audit::Options::default() }, progress)?;
    let name = model.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let prefix = prefix_in(pieces.head()).to_owned();
    let metres_per_unit = crs.as_ref().map_or([1.0; 3], |crs| crs.metres_per_unit);
    let mut payload: Option<Payload> = None;
    let mut checked = found.features.iter();
    for piece in pieces {
        let piece = match piece {
            Ok(piece) => piece,
            // A feature that cannot be read is one of the findings on the file.
            Err(Error::Input(_)) => continue,
            Err(other) => return Err(other),
        };
        let payload = payload.get_or_insert_with(|| {
            let first = piece.vertices.first().copied().unwrap_or_default();
            Payload::new(Frame { origin: first.map(f64::floor), metres_per_unit }, &prefix)
        });
        for group in piece.groups() {
            let group: Vec<&CityObject> = group.into_iter().filter_map(|i| piece.objects.get(i)).collect();
            payload.add(&piece, &group, checked.next());
        }
    }
    let Some(mut payload) = payload.filter(|payload| !payload.is_empty()) else {
        return Err(InputError::new(model, "no CityObject that can be read", "a city model with at least one")
            .remedy("`gable validate` tells what is wrong with the file")
            .into());
    };
    payload.describe(&name, crs.as_ref(), &found);
    let problems = payload.add_points(options, crs.as_ref().filter(|_| !options.trust_tiles))?;
    payload.add_report(report);
    let contents = payload.contents();
    Ok(Page { html: page::fill(page::TEMPLATE, &name, &payload.pack()?), contents, problems })
}
