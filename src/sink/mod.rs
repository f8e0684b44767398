//! Where models go: one file per format.
//!
//! A [`Sink`] takes [`Building`]s one by one, in the order in which they shall stand, and shows a file only when it is
//! whole. The bytes depend on the buildings and the [`Metadata`] alone: no time, no host, no thread.
//!
//! In CityJSON a building is a `Building` with the footprint (LoD 0), the attributes of the source and those of
//! [`ATTRIBUTES`], and its parts are `BuildingPart`s `<id>-0`, `<id>-1`, … with a Solid at LoD 1.2, at LoD 2.2 or both.
//! Semantic surfaces carry `slope` and `azimuth` (degrees; clockwise from north), `height_min` and `height_max`
//! (vertical unit of the CRS) and `confidence` (0 to 1, LoD 2.2) on a `RoofSurface`, and `on_footprint_edge` on a `WallSurface`.

mod attributes;
mod cityjson;
mod cityjsonseq;
mod header;
mod objects;
mod output;
mod sequence;
#[cfg(test)]
mod tests;
mod vertices;

pub use attributes::{ATTRIBUTES, Attribute};
pub use header::{Metadata, PointCloud, reference_system};
pub use objects::Ids;
pub use output::write_whole;
pub use sequence::Sequence;

use std::path::{Path, PathBuf};

use crate::building::Building;
use crate::error::{InputError, Result};

/// Takes buildings and writes them in one format.
///
/// Nothing is seen under the final name before [`Sink::finish`]; a sink that is dropped leaves nothing behind.
pub trait Sink: Send {
    /// Writes one building. Its id must differ from those of all others.
    ///
    /// # Errors
    /// [`crate::error::Error::Io`] when the system refuses to write, and an input error when the format cannot hold that
    /// much. The sink is of no use afterwards.
    fn write(&mut self, building: &Building) -> Result<()>;

    /// Completes the file and gives it its name.
    ///
    /// # Errors
    /// [`crate::error::Error::Io`] when the system refuses to write or to rename.
    fn finish(self: Box<Self>) -> Result<Written>;
}

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// The file; empty when there is none.
    pub path: PathBuf,
    /// Its format, if it is one of gable's.
    pub format: Option<Format>,
    /// Number of buildings, with those that have no geometry.
    pub buildings: usize,
    /// Number of `CityObject`s: buildings and their parts.
    pub objects: usize,
    /// Size of the file in bytes.
    pub bytes: u64,
}

/// A format that gable writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// CityJSON 2.0, one object.
    CityJson,
    /// CityJSON 2.0 text sequence, one building a line.
    CityJsonSeq,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 2] = [Self::CityJson, Self::CityJsonSeq];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::CityJson => "CityJSON",
            Self::CityJsonSeq => "CityJSONSeq",
        }
    }

    /// The file name extensions that ask for it, the usual one first.
    pub fn extensions(self) -> [&'static str; 2] {
        match self {
            Self::CityJson => [".city.json", ".json"],
            Self::CityJsonSeq => [".city.jsonl", ".jsonl"],
        }
    }

    /// The format that a file name asks for, in any case of letters.
    ///
    /// # Errors
    /// When the extension is none of those known; the error lists them.
    pub fn of(path: &Path) -> Result<Self, InputError> {
        let name = path.file_name().map(|n| n.to_string_lossy().to_lowercase()).unwrap_or_default();
        Self::ALL.into_iter().find(|f| f.extensions().iter().any(|e| name.ends_with(e))).ok_or_else(|| {
            let known: Vec<String> =
                Self::ALL.iter().map(|f| format!("{} ({})", f.extensions().join(" or "), f.name())).collect();
            InputError::new(path, "an unknown extension", known.join(", "))
                .remedy("The extension of the output chooses its format.")
        })
    }
}

/// Opens a sink for `path` in the format that its extension asks for. The file appears when the sink is finished.
///
/// # Errors
/// An unknown extension, an existing file without `overwrite`, a folder in the file's place, or a folder that cannot be
/// written to.
pub fn create(path: &Path, metadata: Metadata, overwrite: bool) -> Result<Box<dyn Sink>> {
    create_in(None, path, metadata, overwrite)
}

/// The same with the files that have no name yet in the folder `scratch`, on the file system of `path`. Without one they
/// stand beside `path`, where a process that is killed leaves them.
///
/// # Errors
/// As [`create`].
pub fn create_in(scratch: Option<&Path>, path: &Path, metadata: Metadata, overwrite: bool) -> Result<Box<dyn Sink>> {
    Ok(match Format::of(path)? {
        Format::CityJson => Box::new(cityjson::CityJson::create(path, metadata, overwrite, scratch)?),
        Format::CityJsonSeq => Box::new(cityjsonseq::CityJsonSeq::create(path, metadata, overwrite, scratch)?),
    })
}
