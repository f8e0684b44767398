//! Where models go: one file per format.
//!
//! A [`Sink`] takes [`Feature`]s one by one, in the order in which they shall stand, and shows a file only when it is
//! whole. A feature is a [reconstructed building](Encoder) or [anything from a CityJSON file](Feature::split). The bytes
//! depend on the features and the [`Metadata`] alone: no time, no host, no thread. What must wait for the last feature
//! waits on disk, so that a million features need no more memory than a thousand.
//!
//! In CityJSON a building is a `Building` with the footprint (LoD 0), the attributes of the source and those of
//! [`ATTRIBUTES`], and its parts are `BuildingPart`s `<id>-0`, `<id>-1`, … with a Solid at LoD 1.2, at LoD 2.2 or both.
//! Semantic surfaces carry `slope` and `azimuth` (degrees; clockwise from north), `height_min` and `height_max`
//! (vertical unit of the CRS) and `confidence` (0 to 1, LoD 2.2) on a `RoofSurface`, `on_footprint_edge` and
//! `floor_depth` (metres) on a `WallSurface`.
//!
//! There is no `FlatCityBuf`: its crate (`fcb_core` 0.7) brings a command-line parser, a table printer, a second
//! `CityJSON` model from a pre-release and two unmaintained crates, and wants to know all attributes before the first
//! feature. Its own tools make it from what [`Format::CityJsonSeq`] writes.

mod attributes;
mod cityjson;
mod cityjsonseq;
mod colour;
mod columns;
mod encoder;
mod faces;
mod feature;
mod folder;
mod geopackage;
mod header;
mod json;
mod obj;
mod output;
mod selection;
mod sequence;
mod stream;
#[cfg(test)]
mod tests;
mod tileset;
mod vertices;

pub use crate::record::PointCloud;
pub use attributes::{ATTRIBUTES, Attribute, own_names};
pub use encoder::{Encoder, Ids};
pub use feature::{Feature, Split};
pub use header::{Metadata, reference_system};
pub use output::{copy_whole, write_json, write_whole};
pub(crate) use output::{refuse_web, temporary};
pub use selection::{AttributeOptions, Name, Names, PREFIX, PREFIX_MEMBER, own, prefix, prefix_in};
pub use sequence::Sequence;
pub use stream::{is_standard_output, is_stream, stream};

use std::path::{Path, PathBuf};

use crate::error::{InputError, Result};

/// Takes features and writes them in one format.
///
/// Nothing is seen under the final name before [`Sink::finish`]; a sink that is dropped leaves nothing behind.
pub trait Sink: Send {
    /// Writes one feature. Its id and those of its objects must differ from those of all others.
    ///
    /// # Errors
    /// [`crate::error::Error::Io`] when the system refuses to write, and an input error when the format cannot hold that
    /// much. The sink is of no use afterwards.
    fn write(&mut self, feature: &Feature) -> Result<()>;

    /// Completes the file and gives it its name.
    ///
    /// # Errors
    /// [`crate::error::Error::Io`] when the system refuses to write or to rename.
    fn finish(self: Box<Self>) -> Result<Written>;
}

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// The file or folder; empty when there is none.
    pub path: PathBuf,
    /// Its format, if it is one of gable's.
    pub format: Option<Format>,
    /// Number of features, with those that have no geometry.
    pub features: usize,
    /// Number of `CityObject`s: features and their parts.
    pub objects: usize,
    /// Size in bytes, of all files together.
    pub bytes: u64,
    /// What the user should know: what the format cannot hold, and what is less exact than it might be.
    pub notes: Vec<String>,
}

/// A format that gable writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Format {
    /// CityJSON 2.0, one object.
    CityJson,
    /// CityJSON 2.0 text sequence, one feature a line.
    CityJsonSeq,
    /// 3D Tiles 1.1: a folder with `tileset.json` and binary glTF.
    Tileset,
    /// `GeoPackage` 1.3: footprints and faces.
    GeoPackage,
    /// Wavefront OBJ, with an MTL file beside it.
    Obj,
}

impl Format {
    /// All formats.
    pub const ALL: [Self; 5] = [Self::CityJson, Self::CityJsonSeq, Self::Tileset, Self::GeoPackage, Self::Obj];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::CityJson => "CityJSON",
            Self::CityJsonSeq => "CityJSONSeq",
            Self::Tileset => "3D Tiles, a folder",
            Self::GeoPackage => "GeoPackage",
            Self::Obj => "OBJ",
        }
    }

    /// The file name extensions that ask for it, the usual one first.
    pub fn extensions(self) -> &'static [&'static str] {
        match self {
            Self::CityJson => &[".city.json", ".json"],
            Self::CityJsonSeq => &[".city.jsonl", ".jsonl"],
            Self::Tileset => &[".3dtiles"],
            Self::GeoPackage => &[".gpkg"],
            Self::Obj => &[".obj"],
        }
    }

    /// Whether the output is a folder.
    pub fn is_folder(self) -> bool {
        self == Self::Tileset
    }

    /// The format that a file name asks for, in any case of letters.
    ///
    /// # Errors
    /// When the extension is none of those known; the error lists them. `tileset.json`, which would be taken for
    /// CityJSON.
    pub fn of(path: &Path) -> Result<Self, InputError> {
        let name = path.file_name().map(|n| n.to_string_lossy().to_lowercase()).unwrap_or_default();
        if name == "tileset.json" {
            return Err(InputError::new(path, "the name of a file of 3D Tiles", "the folder of all of them")
                .remedy("Give a folder whose name ends in .3dtiles; its tileset.json is what viewers open."));
        }
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
        Format::Tileset => Box::new(tileset::Tileset::create(path, metadata, overwrite, scratch)?),
        Format::GeoPackage => Box::new(geopackage::GeoPackage::create(path, metadata, overwrite, scratch)?),
        Format::Obj => Box::new(obj::Obj::create(path, &metadata, overwrite, scratch)?),
    })
}
