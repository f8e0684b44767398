//! The points of one building as a LAZ file.

use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use las::point::Format;
use las::{Builder, Color, Header, Point, PointDataBuilder, Transform, Vector, Version, Vlr, Writer};

use crate::error::{Error, Result};
use crate::sink::temporary;
use crate::source::crs::Crs;
use crate::source::points::ScanPoint;

/// What points of other files than LAS and LAZ are whole multiples of, CRS units.
const SCALE: f64 = 0.0001;
/// The point format of these.
const PLAIN: u8 = 6;

/// Records of one building from one tile, as they stand there.
pub(super) struct Records {
    format: Format,
    transforms: Vector<Transform>,
    /// What else the file of a building takes from the tile.
    time: las::GpsTimeType,
    extra: Vec<Vlr>,
    bytes: Vec<u8>,
}

impl Records {
    /// None yet, of a LAS or LAZ file.
    pub(super) fn of_las(header: &Header) -> Self {
        let format = Format { is_compressed: true, ..*header.point_format() };
        let describes_extra = |vlr: &&Vlr| vlr.user_id == "LASF_Spec" && vlr.record_id == 4;
        Self {
            format,
            transforms: *header.transforms(),
            time: header.gps_time_type(),
            extra: header.vlrs().iter().filter(describes_extra).cloned().collect(),
            bytes: Vec::new(),
        }
    }

    /// None yet, of points of another kind near a place, CRS units.
    ///
    /// # Errors
    /// Never in practice: the format exists.
    pub(super) fn plain(near: [f64; 3]) -> las::Result<Self> {
        let mut format = Format::new(PLAIN)?;
        format.is_compressed = true;
        let [x, y, z] = near.map(|offset| Transform { scale: SCALE, offset: offset.floor() });
        let time = las::GpsTimeType::Week;
        Ok(Self { format, transforms: Vector { x, y, z }, time, extra: Vec::new(), bytes: Vec::new() })
    }

    /// Takes a record as it stands in the tile.
    pub(super) fn push(&mut self, record: &[u8]) {
        self.bytes.extend_from_slice(record);
    }

    /// Takes a point of a file of another kind.
    ///
    /// # Errors
    /// It lies too far from the others.
    pub(super) fn push_plain(&mut self, point: &ScanPoint) -> las::Result<()> {
        let [x, y, z] = point.position;
        let point = Point {
            x,
            y,
            z,
            return_number: point.return_number.min(15),
            number_of_returns: point.return_number.min(15),
            classification: las::point::Classification::new(point.class)?,
            is_synthetic: point.synthetic,
            is_withheld: point.withheld,
            is_overlap: point.overlap,
            gps_time: Some(0.0),
            ..Point::default()
        };
        point.into_raw(&self.transforms)?.write_to(&mut self.bytes, &self.format)
    }

    /// How many records there are.
    pub(super) fn len(&self) -> u64 {
        (self.bytes.len() / usize::from(self.format.len()).max(1)) as u64
    }

    fn header(&self, crs: &Crs) -> las::Result<Header> {
        let mut builder = Builder::from(Version::new(1, 4));
        builder.point_format = Format { has_waveform: false, ..self.format };
        builder.transforms = self.transforms;
        builder.gps_time_type = self.time;
        // The same input gives the same file on any day.
        builder.date = None;
        "gable crop".clone_into(&mut builder.system_identifier);
        builder.generating_software = format!("gable {}", env!("CARGO_PKG_VERSION"));
        builder.has_wkt_crs = true;
        let wkt = crs.wkt1().unwrap_or_else(|| crs.wkt.clone());
        builder.vlrs.push(Vlr {
            user_id: "LASF_Projection".to_owned(),
            record_id: 2112,
            description: "OGC WKT".to_owned(),
            data: wkt.bytes().chain([0]).collect(),
        });
        builder.vlrs.extend(self.extra.iter().cloned());
        builder.into_header()
    }

    /// Whether its records can stand behind those of a file as they are.
    fn is_like(&self, header: &Header) -> bool {
        self.format == *header.point_format() && self.transforms == *header.transforms()
    }
}

/// Writes the records of a building; the file appears under its name when it is whole. The first of `parts`, which are not
/// empty, says in which point format and with which scale.
///
/// # Errors
/// The system refuses, a file is there and shall not be replaced, or a point lies too far from the others.
pub(super) fn write(path: &Path, parts: Vec<Records>, crs: &Crs, overwrite: bool) -> Result<()> {
    let fault = |e: las::Error| Error::io(path, "write", std::io::Error::other(e));
    let Some(first) = parts.first() else { return Ok(()) };
    let folder = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or_else(|| Path::new("."));
    let file = temporary(0o666).suffix(".laz").tempfile_in(folder).map_err(|e| Error::io(path, "create", e))?;
    let handle: File = file.reopen().map_err(|e| Error::io(path, "create", e))?;
    let mut writer = Writer::new(BufWriter::new(handle), first.header(crs).map_err(fault)?).map_err(fault)?;
    for part in parts {
        let is_like = part.is_like(writer.header());
        let data = PointDataBuilder::new().with_format(part.format).with_transforms(part.transforms);
        let data = data.build_from_bytes(part.bytes).map_err(fault)?;
        if is_like {
            writer.write_points(&data).map_err(fault)?;
            continue;
        }
        let format = *writer.header().point_format();
        for point in data.points() {
            writer.write_point(fitted(point.map_err(fault)?, format)).map_err(fault)?;
        }
    }
    writer.close().map_err(fault)?;
    drop(writer);
    file.as_file().sync_all().map_err(|e| Error::io(path, "write", e))?;
    let renamed = if overwrite { file.persist(path) } else { file.persist_noclobber(path) };
    renamed.map_err(|e| Error::io(path, "rename the finished file to", e.error))?;
    Ok(())
}

/// A point with the fields of a point format: what it lacks is 0, what the format lacks is left out.
fn fitted(point: Point, format: Format) -> Point {
    let mut extra_bytes = point.extra_bytes;
    extra_bytes.resize(usize::from(format.extra_bytes), 0);
    Point {
        gps_time: format.has_gps_time.then(|| point.gps_time.unwrap_or_default()),
        color: format.has_color.then(|| point.color.unwrap_or(Color::new(0, 0, 0))),
        nir: format.has_nir.then(|| point.nir.unwrap_or_default()),
        waveform: None,
        extra_bytes,
        ..point
    }
}
