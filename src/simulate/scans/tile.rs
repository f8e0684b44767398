//! The points as a laser tile.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use las::point::{Classification, Format};
use las::{Builder, Point, Transform, Vector, Version, Vlr, Writer};
use nalgebra::Point3;
use tempfile::NamedTempFile;

use super::Scanned;
use crate::error::{Error, InputError, Result};
use crate::sink::temporary;
use crate::site::Frame;
use crate::source::crs::Crs;

/// The classes of the ASPRS.
const GROUND: u8 = 2;
/// The same for buildings.
const BUILDING: u8 = 6;
/// Coordinates are whole multiples of this, in units of the CRS.
const SCALE: f64 = 0.001;
/// How far from its offset a coordinate may be: 32 bits.
const REACH: f64 = SCALE * i32::MAX as f64;

/// A LAZ file being written; it appears under its name when it is complete.
pub(super) struct TileFile {
    writer: Writer<BufWriter<File>>,
    file: NamedTempFile,
    path: PathBuf,
    offset: [f64; 3],
    overwrite: bool,
    points: [u64; 2],
}

impl TileFile {
    /// Opens a file for points near `offset`, whole CRS units.
    pub fn create(path: &Path, crs: &Crs, offset: [f64; 3], overwrite: bool) -> Result<Self> {
        if !overwrite && path.exists() {
            return Err(InputError::new(path, "an existing file", "a new file name")
                .remedy("Give --overwrite to replace it")
                .into());
        }
        let fault = |e: las::Error| Error::io(path, "write", std::io::Error::other(e));
        let mut builder = Builder::from(Version::new(1, 4));
        builder.point_format = Format::new(6).map_err(fault)?;
        builder.point_format.is_compressed = true;
        // The same scans shall give the same bytes on any day.
        builder.date = None;
        "simulation".clone_into(&mut builder.system_identifier);
        builder.generating_software = format!("gable {}", env!("CARGO_PKG_VERSION"));
        builder.has_wkt_crs = true;
        builder.vlrs.push(Vlr {
            user_id: "LASF_Projection".to_owned(),
            record_id: 2112,
            description: "OGC WKT".to_owned(),
            data: crs.wkt.bytes().chain([0]).collect(),
        });
        let [x, y, z] = offset.map(|offset| Transform { scale: SCALE, offset });
        builder.transforms = Vector { x, y, z };
        let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."));
        let file = temporary(0o666).suffix(".laz").tempfile_in(folder).map_err(|e| Error::io(path, "create", e))?;
        let handle = file.reopen().map_err(|e| Error::io(path, "create", e))?;
        let header = builder.into_header().map_err(fault)?;
        let writer = Writer::new(BufWriter::new(handle), header).map_err(fault)?;
        Ok(Self { writer, file, path: path.to_path_buf(), offset, overwrite, points: [0; 2] })
    }

    /// Adds the points of a scan.
    pub fn add(&mut self, scanned: &Scanned) -> Result<()> {
        let scan = &scanned.scan;
        self.points[0] += scan.points.len() as u64;
        self.points[1] += scan.ground_points.len() as u64;
        self.write(&scan.points, &scan.frame, BUILDING)?;
        self.write(&scan.ground_points, &scan.frame, GROUND)
    }

    fn write(&mut self, points: &[Point3<f64>], frame: &Frame, class: u8) -> Result<()> {
        let fault = |e: las::Error| Error::io(&self.path, "write", std::io::Error::other(e));
        let classification = Classification::new(class).map_err(fault)?;
        for p in points {
            let place = frame.to_crs(p);
            if let Some(axis) = (0..3).find(|&i| (place[i] - self.offset[i]).abs() >= REACH) {
                let found = format!("points {:.0} units from each other", (place[axis] - self.offset[axis]).abs());
                return Err(InputError::new(&self.path, found, format!("no more than {REACH:.0} in one tile"))
                    .remedy("Scan models that are far from each other one by one")
                    .into());
            }
            let [x, y, z] = place;
            let point = Point {
                x,
                y,
                z,
                return_number: 1,
                number_of_returns: 1,
                classification,
                gps_time: Some(0.0),
                ..Point::default()
            };
            self.writer.write_point(point).map_err(fault)?;
        }
        Ok(())
    }

    /// Completes the file; returns the numbers of building and of ground points.
    pub fn finish(mut self) -> Result<[u64; 2]> {
        let path = &self.path;
        self.writer.close().map_err(|e| Error::io(path, "write", std::io::Error::other(e)))?;
        self.file.as_file().sync_all().map_err(|e| Error::io(path, "write", e))?;
        let renamed = if self.overwrite { self.file.persist(path) } else { self.file.persist_noclobber(path) };
        renamed.map_err(|e| Error::io(path, "rename the finished file to", e.error))?;
        Ok(self.points)
    }
}
