//! Shapefiles (ESRI White Paper, July 1998): `.shp` with `.dbf`, `.prj` and `.cpg` beside it.

use std::io::{BufReader, Cursor, Read};
use std::path::Path;

use ::shapefile::{PolygonRing, ReadableShape, Shape};
use geo::{BoundingRect, Contains, Coord, LineString, Point, Polygon};

use super::dbf::Table;
use super::format::{stem, with_extension};
use super::outline::{Outline, Ring};
use super::reference_system::crs_of_file;
use super::{FootprintOptions, LayerInfo, RawFeature, Sink};
use crate::error::{InputError, Result};
use crate::source::open::{self, Input};

/// Bytes of the header of the file and of each record.
const FILE_HEADER: u64 = 100;
const RECORD_HEADER: usize = 8;
/// Bytes of an entry of the index.
const INDEX_ENTRY: u64 = 8;

/// Reads a shapefile. Record after record is cut out and judged by itself.
pub(super) fn read(path: &Path, options: &FootprintOptions, sink: Sink<'_>) -> Result<LayerInfo> {
    let mut info = LayerInfo { layer: stem(path), ..LayerInfo::default() };
    let text_beside = |extension: &str| {
        with_extension(path, extension)
            .and_then(|file| open::whole(&file, "text").ok())
            .map(|bytes| String::from_utf8_lossy(&bytes).trim_start_matches('\u{feff}').trim().to_string())
    };
    if let Some(definition) = text_beside("prj") {
        info.crs = crs_of_file(path, &definition, options)?;
    } else if options.crs.is_none() {
        info.warnings.push("there is no .prj beside it: the reference system is unknown".into());
    }
    let dbf = with_extension(path, "dbf");
    let mut table = dbf.map(|dbf| Table::open(&dbf, text_beside("cpg").as_deref())).transpose()?;
    let mut lacks = Vec::new();
    match &table {
        Some(table) => {
            info.columns.extend(table.columns().cloned());
            info.warnings.extend(table.clashes.iter().cloned());
            let binary = table.binary_columns();
            info.warnings.extend(binary.map(|name| format!("attribute `{name}` is binary and was left out")));
        }
        None => lacks.push("there is no .dbf beside it: features have no attributes".into()),
    }
    let (mut deleted, mut shapes, mut without_record) = (0_u64, 0_u64, 0_u64);
    let mut records = Records::open(path)?;
    while let Some(content) = records.next() {
        shapes += 1;
        let outline = content.and_then(|content| outline_of(&content));
        let record = table.as_mut().and_then(Table::next);
        without_record += u64::from(record.is_none());
        match record {
            Some(record) if record.is_deleted => deleted += 1,
            record => {
                sink(RawFeature { attributes: record.map(|record| record.attributes).unwrap_or_default(), outline });
            }
        }
    }
    let mut features = shapes;
    // What the table still has is missing from a file that is cut off.
    while let Some(record) = table.as_mut().and_then(Table::next) {
        features += 1;
        if record.is_deleted {
            deleted += 1;
        } else {
            sink(RawFeature {
                attributes: record.attributes,
                outline: Err("its shape is missing from the .shp file".into()),
            });
        }
    }
    info.warnings.extend(table.as_ref().and_then(Table::lie));
    if deleted > 0 {
        info.warnings.push(format!("{deleted} features are marked as deleted and were left out"));
    }
    if table.is_some() && without_record > 0 {
        lacks.push(format!("the .dbf beside it is cut off: {without_record} of {shapes} features have no attributes"));
    }
    let listed = listed(path).map_err(|lack| lacks.push(lack)).unwrap_or(shapes);
    info.missing = listed.saturating_sub(features);
    let of = listed.max(features);
    if records.whole < of {
        lacks.push(format!("it is cut off: {} of {of} shapes are missing", of - records.whole));
    } else if records.is_cut_off {
        lacks.push("it is shorter than it says: shapes may be missing".into());
    }
    info.is_damaged = !lacks.is_empty();
    info.warnings.extend(lacks);
    Ok(info)
}

/// How many shapes the index (`.shx`) lists that a shapefile must have; or what is wrong with it.
fn listed(path: &Path) -> Result<u64, String> {
    let index = with_extension(path, "shx").ok_or("there is no .shx beside it: some may have been lost unseen")?;
    let unreadable = |error: &dyn std::fmt::Display| format!("the .shx beside it cannot be read: {error}");
    let (mut file, length) = open::regular(&index, "the index of a shapefile").map_err(|e| unreadable(&e))?;
    let mut header = [0; FILE_HEADER as usize];
    file.read_exact(&mut header).map_err(|e| unreadable(&e))?;
    if stated_length(&header) > length {
        return Err("the .shx beside it is cut off".into());
    }
    Ok((stated_length(&header).saturating_sub(FILE_HEADER)) / INDEX_ENTRY)
}

/// The length of a file in bytes as its header states it.
fn stated_length(header: &[u8; FILE_HEADER as usize]) -> u64 {
    let words = header[24..].first_chunk().map_or(0, |bytes| u32::from_be_bytes(*bytes));
    2 * u64::from(words)
}

/// The records of a `.shp` file as bytes.
struct Records {
    file: BufReader<Input>,
    left: u64,
    /// How many were read that are whole.
    whole: u64,
    /// Whether the file is shorter than its header states, or ends within a record.
    is_cut_off: bool,
}

impl Records {
    fn open(path: &Path) -> Result<Self> {
        let (file, length) = open::regular(path, "a shapefile")?;
        let mut file = BufReader::new(file);
        let mut header = [0; FILE_HEADER as usize];
        file.read_exact(&mut header)
            .map_err(|_| InputError::new(path, "a file that is too short", "a shapefile with its header"))?;
        Ok(Self { file, left: length - FILE_HEADER, whole: 0, is_cut_off: stated_length(&header) > length })
    }

    /// The content of the next record, an error where the file ends within it, `None` at the end.
    fn next(&mut self) -> Option<Result<Vec<u8>, String>> {
        let mut header = [0; RECORD_HEADER];
        self.left = self.left.checked_sub(RECORD_HEADER as u64)?;
        self.file.read_exact(&mut header).ok()?;
        let [.., a, b, c, d] = header;
        let length = 2 * u64::from(u32::from_be_bytes([a, b, c, d]));
        let Some(left) = self.left.checked_sub(length) else {
            (self.left, self.is_cut_off) = (0, true);
            return Some(Err("the .shp file ends within its shape".into()));
        };
        self.left = left;
        self.whole += 1;
        let mut content = vec![0; usize::try_from(length).ok()?];
        Some(self.file.read_exact(&mut content).map(|()| content).map_err(|e| format!("its shape cannot be read: {e}")))
    }
}

fn outline_of(content: &[u8]) -> Result<Outline, String> {
    let length = i32::try_from(content.len()).map_err(|_| "its shape is too large".to_string())?;
    let shape = Shape::read_from(&mut Cursor::new(content), length)
        .map_err(|error| format!("its shape cannot be understood: {error}"))?;
    let rings = match shape {
        Shape::Polygon(polygon) => plane(polygon.rings(), |p| (p.x, p.y)),
        Shape::PolygonM(polygon) => plane(polygon.rings(), |p| (p.x, p.y)),
        Shape::PolygonZ(polygon) => plane(polygon.rings(), |p| (p.x, p.y)),
        Shape::NullShape => return Err("it has no geometry".into()),
        Shape::Point(_) | Shape::PointM(_) | Shape::PointZ(_) => return Err(no_polygon("Point")),
        Shape::Multipoint(_) | Shape::MultipointM(_) | Shape::MultipointZ(_) => return Err(no_polygon("MultiPoint")),
        Shape::Polyline(_) | Shape::PolylineM(_) | Shape::PolylineZ(_) => return Err(no_polygon("LineString")),
        Shape::Multipatch(_) => {
            return Err("its geometry is a surface in space, not a polygon in the plane".into());
        }
    };
    Ok(Outline { polygons: grouped(rings), notes: Vec::new() })
}

fn no_polygon(kind: &str) -> String {
    format!("its geometry is a {kind}, not a polygon")
}

/// Rings without z and m; `true` for those that run as holes do.
fn plane<P>(rings: &[PolygonRing<P>], xy: impl Fn(&P) -> (f64, f64)) -> Vec<(Ring, bool)> {
    rings
        .iter()
        .map(|ring| {
            let points = ring.points().iter().map(|p| Coord::from(xy(p))).collect();
            (points, matches!(ring, PolygonRing::Inner(_)))
        })
        .collect()
}

/// Exteriors with their holes. A shapefile does not say which hole belongs where: it is the smallest exterior around
/// it. A hole without one is an exterior that runs the wrong way.
fn grouped(rings: Vec<(Ring, bool)>) -> Vec<Vec<Ring>> {
    let (holes, exteriors): (Vec<_>, Vec<_>) = rings.into_iter().partition(|(_, is_hole)| *is_hole);
    let mut polygons: Vec<Vec<Ring>> = exteriors.into_iter().map(|(ring, _)| vec![ring]).collect();
    let mut without = Vec::new();
    for (hole, _) in holes {
        let around = polygons
            .iter_mut()
            .filter(|polygon| is_inside(&hole, &polygon[0]))
            .min_by(|a, b| area_of_box(&a[0]).total_cmp(&area_of_box(&b[0])));
        match around {
            Some(polygon) => polygon.push(hole),
            None => without.push(vec![hole]),
        }
    }
    polygons.extend(without);
    polygons
}

fn is_finite(ring: &Ring) -> bool {
    ring.iter().all(|c| c.x.is_finite() && c.y.is_finite())
}

/// Whether the middle of some edge of a ring lies inside another; vertices may touch it.
fn is_inside(ring: &Ring, exterior: &Ring) -> bool {
    if !is_finite(ring) || !is_finite(exterior) {
        return false;
    }
    let polygon = Polygon::new(LineString::new(exterior.clone()), Vec::new());
    let bounds = polygon.bounding_rect();
    ring.windows(2)
        .map(|edge| Point::from((edge[0] + edge[1]) / 2.0))
        .any(|middle| bounds.is_some_and(|b| b.contains(&middle)) && polygon.contains(&middle))
}

fn area_of_box(ring: &Ring) -> f64 {
    LineString::new(ring.clone()).bounding_rect().map_or(0.0, |b| b.width() * b.height())
}
