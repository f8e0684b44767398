//! Clouds that are no LAS files: PLY, and text with a point a line (XYZ, PTS, CSV).
//!
//! They have no tiles, no index and mostly no coordinate reference system; what they say beside places and classes is not
//! looked at. Programs write what they like into them, normals that point anywhere included. Readers are our own: the
//! crates that there are build the whole file in memory, and make room for as many points as a header claims. Here a file
//! is read from its beginning to its end, once to see how much there is and where, and once for every use.

pub(crate) mod lines;
mod ply;
mod ply_file;
mod ply_header;
mod text;

#[cfg(test)]
mod tests;

use super::spill;
use super::tile::Extent;
use crate::error::{Error, InputError, Result};
use crate::source::open::Place;
pub(crate) use ply_file::PlyFile;
use ply_header::PlyHeader;
pub(crate) use ply_header::Scalar;
use std::io::BufReader;
use std::ops::ControlFlow;
use std::path::Path;
use text::Columns;

/// What is said of a file that is neither.
pub(super) const WANTED: &str = "a LAS, LAZ, COPC, PLY or text (xyz, pts, txt, asc, csv) file";
/// The extensions of text with a point a line.
pub(super) const TEXT: [&str; 5] = ["xyz", "pts", "txt", "asc", "csv"];

/// Takes points, each with its class, until it has enough.
pub(super) type Visit<'a> = dyn FnMut([f64; 3], u8) -> ControlFlow<()> + 'a;

/// How the points of a cloud stand in its file.
#[derive(Debug, Clone)]
pub(super) enum Cloud {
    /// In a PLY file.
    Ply(PlyHeader),
    /// In text.
    Text(Columns),
}

/// What the first look at a cloud found.
#[derive(Debug)]
pub(super) struct Opened {
    /// How its points stand.
    pub cloud: Cloud,
    /// Where it is.
    pub place: Place,
    /// Points that could be read, those with absurd coordinates included.
    pub points: u64,
    /// Where they lie.
    pub extent: Extent,
    /// Size of the file in bytes.
    pub size: u64,
}

impl Cloud {
    /// The cloud at `path`, if its content or its extension says that it is one; read once from beginning to end.
    ///
    /// # Errors
    /// The file cannot be read, or is not what it says that it is; of text, any line that is no point.
    pub fn open(path: &Path) -> Result<Option<Opened>> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
        if ["las", "laz"].contains(&extension.as_str()) {
            return Ok(None);
        }
        let (place, size) = Place::of(path, WANTED)?;
        let mut file = BufReader::with_capacity(BUFFER, place.open()?);
        let cloud = match extension.as_str() {
            _ if ply_header::is_ply(&mut file).map_err(|e| Error::io(path, "read", e))? => {
                Self::Ply(ply_header::read(path, &mut file)?)
            }
            "ply" => {
                let found = if size == 0 { "an empty file (0 bytes)" } else { "another beginning" };
                let fault = InputError::new(path, found, "`ply` and the end of a line").at("line 1");
                return Err(fault.remedy("The file is damaged or not a PLY file: fetch or export it again").into());
            }
            text if TEXT.contains(&text) => Self::Text(text::columns(path, &mut file)?),
            _ => return Ok(None),
        };
        let (mut points, mut extent) = (0, Extent::EMPTY);
        let fault = cloud.read(path, &place, &mut |position, _| {
            points += 1;
            if spill::is_plausible(position) {
                extent.grow(position);
            }
            ControlFlow::Continue(())
        })?;
        match (&cloud, fault) {
            // What a header announces may be cut off, and the rest be used; text announces nothing.
            (Self::Ply(header), Some(fault)) if points == 0 && header.vertices() > 0 => Err(fault.into()),
            (Self::Text(_), Some(fault)) => Err(fault.into()),
            _ => Ok(Some(Opened { cloud, place, points, extent, size })),
        }
    }

    /// Hands out the points in the order of the file. Gives what stood in the way, if not all could be read.
    ///
    /// # Errors
    /// The file cannot be opened; an object cannot be read any more, or was changed.
    pub fn read(&self, path: &Path, place: &Place, visit: &mut Visit) -> Result<Option<InputError>> {
        let file = BufReader::with_capacity(BUFFER, place.open()?);
        let fault = match self {
            Self::Ply(header) => ply::read(header, path, file, visit),
            Self::Text(columns) => text::read(columns, path, file, visit),
        };
        place.verdict()?;
        Ok(fault)
    }

    /// Points that the file announces; `None` where it announces none.
    pub fn announced(&self) -> Option<u64> {
        match self {
            Self::Ply(header) => Some(header.vertices()),
            Self::Text(_) => None,
        }
    }

    /// Whether it says to which class points belong.
    pub fn has_classes(&self) -> bool {
        match self {
            Self::Ply(header) => header.has_classes(),
            Self::Text(columns) => columns.class.is_some(),
        }
    }

    /// What kind of file it is.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Ply(_) => "PLY",
            Self::Text(_) => "text",
        }
    }

    /// How it is written, for a person.
    pub fn describe(&self) -> String {
        match self {
            Self::Ply(header) => header.encoding.name().to_owned(),
            Self::Text(columns) => format!("x, y, z in columns {}", columns.places()),
        }
    }
}

/// Bytes that are read at once.
const BUFFER: usize = 1 << 18;

/// Whether a name is one that programs give to the class of a point.
fn is_class(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    let name = name.strip_prefix("scalar_").unwrap_or(&name);
    matches!(name, "classification" | "class")
}

/// The class that a number means; 0, never classified, where it is none.
fn class_of(value: f64) -> u8 {
    let rounded = value.round();
    if (0.0..=255.0).contains(&rounded) { rounded as u8 } else { 0 }
}
