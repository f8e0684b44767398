//! A PLY file with all that its vertices have, for who wants more than places and classes.

use super::ply::{self, VisitValues};
use super::ply_header::{self, PlyHeader, Scalar};
use super::{BUFFER, WANTED};
use crate::error::{Error, InputError, Result};
use crate::source::open::Place;
use std::io::BufReader;
use std::path::{Path, PathBuf};

/// A PLY file whose header has been read.
#[derive(Debug, Clone)]
pub(crate) struct PlyFile {
    path: PathBuf,
    place: Place,
    header: PlyHeader,
}

impl PlyFile {
    /// Reads the header of the file at `path`.
    ///
    /// # Errors
    /// The file cannot be read, or is no PLY file with points.
    pub fn open(path: &Path) -> Result<Self> {
        let (place, size) = Place::of(path, WANTED)?;
        let mut file = BufReader::with_capacity(BUFFER, place.open()?);
        if !ply_header::is_ply(&mut file).map_err(|e| Error::io(path, "read", e))? {
            let found = if size == 0 { "an empty file (0 bytes)" } else { "another beginning" };
            let fault = InputError::new(path, found, "`ply` and the end of a line").at("line 1");
            return Err(fault.remedy("The file is damaged or not a PLY file: fetch or export it again").into());
        }
        Ok(Self { path: path.to_path_buf(), place, header: ply_header::read(path, &mut file)? })
    }

    /// The numbers that a vertex has, without lists: name and type.
    pub fn properties(&self) -> impl Iterator<Item = (&str, Scalar)> {
        self.header.vertex.singles().map(|property| (property.name.as_str(), property.kind))
    }

    /// How the numbers are written, for a person.
    pub fn encoding(&self) -> &'static str {
        self.header.encoding.name()
    }

    /// Number of vertices that the header announces.
    pub fn vertices(&self) -> u64 {
        self.header.vertices()
    }

    /// Hands out the vertices in the order of the file, each as the numbers of [`Self::properties`]. Gives what stood in the
    /// way, if not all could be read.
    ///
    /// # Errors
    /// The file cannot be opened.
    pub fn read(&self, visit: &mut VisitValues) -> Result<Option<InputError>> {
        let file = BufReader::with_capacity(BUFFER, self.place.open()?);
        let fault = ply::read_values(&self.header, &self.path, file, visit);
        self.place.verdict()?;
        Ok(fault)
    }
}
