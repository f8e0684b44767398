//! FlatGeobuf, version 3.
//!
//! The crate's own iterator trusts the sizes and offsets in the file; features are cut out, verified and decoded here,
//! so that a damaged one is reported instead of ending the run.

use std::fs::File;
use std::io::{BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use ::flatgeobuf::{ColumnType, Geometry, GeometryType, Header};
use geo::Coord;
use serde_json::{Map, Number, Value};

use super::arcs;
use super::attributes::distinct;
use super::format::stem;
use super::outline::{Outline, Ring};
use super::reference_system::crs_of_file;
use super::{FootprintOptions, LayerInfo, RawFeature, Sink};
use crate::error::{Error, InputError, Result};
use crate::source::crs::Crs;

/// Bytes before the header: magic and size.
const MAGIC: usize = 8;
/// No header is larger.
const LARGEST_HEADER: u64 = 10 << 20;
/// Bytes of a node of the spatial index.
const INDEX_NODE: u64 = 40;

/// A column of the table.
struct Column {
    name: String,
    kind: ColumnType,
}

/// Reads a FlatGeobuf file.
pub(super) fn read(path: &Path, options: &FootprintOptions, sink: Sink<'_>) -> Result<LayerInfo> {
    let fault = |found: &str| InputError::new(path, found, "a FlatGeobuf file");
    let file = File::open(path).map_err(|e| Error::io(path, "open", e))?;
    let length = file.metadata().map_err(|e| Error::io(path, "read", e))?.len();
    let mut file = BufReader::new(file);
    file.read_exact(&mut [0; MAGIC]).map_err(|_| fault("a file that is too short"))?;
    let bytes = sized(&mut file, length.min(LARGEST_HEADER)).ok_or_else(|| fault("a header that is cut off"))?;
    let header = ::flatgeobuf::size_prefixed_root_as_header(&bytes)
        .map_err(|error| fault("a damaged header").at(error.to_string()))?;
    let index = index_size(&header).filter(|size| *size < length).ok_or_else(|| fault("a damaged header"))?;
    file.seek(SeekFrom::Current(index.cast_signed())).map_err(|e| Error::io(path, "read", e))?;
    let stated = header.columns().iter().flatten().map(|column| (column.name().to_string(), column.type_())).collect();
    let (columns, clashes) = columns_of(stated);
    let mut info = LayerInfo {
        layer: header.name().map_or_else(|| stem(path), str::to_string),
        crs: crs_of(path, &header, options)?,
        columns: columns.iter().filter(|c| c.kind != ColumnType::Binary).map(|c| c.name.clone()).collect(),
        ..LayerInfo::default()
    };
    let binary = columns.iter().filter(|c| c.kind == ColumnType::Binary);
    info.warnings.extend(binary.map(|c| format!("attribute `{}` is binary and was left out", c.name)));
    info.warnings.extend(clashes);
    let mut count = 0_u64;
    let mut end = file.stream_position().map_err(|e| Error::io(path, "read", e))?;
    while let Some(bytes) = sized(&mut file, length) {
        count += 1;
        end += bytes.len() as u64;
        sink(feature_of(&bytes, &header, &columns));
    }
    match header.features_count() {
        // A writer that streams does not know how many there will be.
        0 if end < length => {
            info.missing = 1;
            info.warnings.push(format!("it is cut off in its feature {}: what follows is missing", count + 1));
        }
        stated if count < stated => {
            info.missing = stated - count;
            info.warnings.push(format!("it is cut off: {} of {stated} features are missing", stated - count));
        }
        _ => {}
    }
    Ok(info)
}

/// The columns of a table, and what is to be told of those of one name.
fn columns_of(stated: Vec<(String, ColumnType)>) -> (Vec<Column>, Vec<String>) {
    let (names, kinds): (Vec<String>, Vec<ColumnType>) = stated.into_iter().unzip();
    let (names, clashes) = distinct(names);
    (names.into_iter().zip(kinds).map(|(name, kind)| Column { name, kind }).collect(), clashes)
}

/// The next block with its size of four bytes in front; `None` at the end or when it would be larger than `limit`.
fn sized(file: &mut impl Read, limit: u64) -> Option<Vec<u8>> {
    let mut size = [0; 4];
    file.read_exact(&mut size).ok()?;
    let length = u32::from_le_bytes(size);
    if length < 8 || u64::from(length) > limit {
        return None;
    }
    let mut bytes = vec![0; 4 + length as usize];
    let (start, rest) = bytes.split_at_mut(4);
    start.copy_from_slice(&size);
    file.read_exact(rest).ok()?;
    Some(bytes)
}

/// Bytes of the packed R-tree before the features; `None` when the header makes no sense.
fn index_size(header: &Header<'_>) -> Option<u64> {
    let (mut level, node) = (header.features_count(), u64::from(header.index_node_size()));
    if node == 0 || level == 0 {
        return Some(0);
    }
    if node < 2 || level > u64::MAX / (4 * INDEX_NODE) {
        return None;
    }
    let mut nodes = level;
    loop {
        level = level.div_ceil(node);
        nodes += level;
        if level == 1 {
            return nodes.checked_mul(INDEX_NODE);
        }
    }
}

fn crs_of(path: &Path, header: &Header<'_>, options: &FootprintOptions) -> Result<Option<Crs>> {
    let Some(crs) = header.crs().filter(|_| options.crs.is_none()) else { return Ok(None) };
    let organisation = crs.org().unwrap_or("EPSG");
    let code = match (crs.code(), crs.code_string()) {
        (code, _) if code > 0 => Some(format!("{organisation}:{code}")),
        (_, Some(code)) => Some(format!("{organisation}:{code}")),
        _ => None,
    };
    if let Some(known) = code.as_deref().and_then(|code| Crs::parse(code).ok()) {
        return Ok(Some(known));
    }
    match crs.wkt().map(str::to_string).or(code) {
        Some(definition) => crs_of_file(path, &definition, options),
        None => Ok(None),
    }
}

fn feature_of(bytes: &[u8], header: &Header<'_>, columns: &[Column]) -> RawFeature {
    let feature = match ::flatgeobuf::size_prefixed_root_as_feature(bytes) {
        Ok(feature) => feature,
        Err(error) => {
            return RawFeature { attributes: Map::new(), outline: Err(format!("it is damaged: {error}")) };
        }
    };
    let own: Option<Vec<Column>> = feature.columns().map(|columns| {
        columns_of(columns.iter().map(|column| (column.name().to_string(), column.type_())).collect()).0
    });
    let properties: Vec<u8> = feature.properties().map(|p| p.bytes().to_vec()).unwrap_or_default();
    let columns = own.as_deref().unwrap_or(columns);
    let (attributes, is_whole) = attributes_of(&properties, columns);
    let mut outline = match feature.geometry() {
        None => Err("it has no geometry".to_string()),
        Some(geometry) => outline_of(&geometry, header.geometry_type()),
    };
    if let (Ok(outline), false) = (&mut outline, is_whole) {
        outline.notes.push("some of its attributes are damaged and were left out".into());
    }
    RawFeature { attributes, outline }
}

/// The attributes, and whether all of them could be read.
fn attributes_of(mut bytes: &[u8], columns: &[Column]) -> (Map<String, Value>, bool) {
    let mut attributes: Map<String, Value> = Map::new();
    while !bytes.is_empty() {
        let column = take(&mut bytes).and_then(|index| columns.get(usize::from(u16::from_le_bytes(index))));
        let Some(column) = column else { return (attributes, false) };
        match value_of(&mut bytes, column.kind) {
            Some(Property::Kept(value)) => {
                attributes.insert(column.name.clone(), value);
            }
            Some(Property::LeftOut) => {}
            None => return (attributes, false),
        }
    }
    (attributes, true)
}

/// What becomes of a value.
enum Property {
    Kept(Value),
    /// It is binary.
    LeftOut,
}

/// The next value; `None` when it is damaged.
fn value_of(bytes: &mut &[u8], kind: ColumnType) -> Option<Property> {
    let float = |number: f64| Number::from_f64(number).map_or(Value::Null, Value::Number);
    let mut text = || {
        let length = u32::from_le_bytes(take(bytes)?) as usize;
        let (text, rest) = bytes.split_at_checked(length)?;
        *bytes = rest;
        Some(text)
    };
    let value = match kind {
        ColumnType::String | ColumnType::DateTime => String::from_utf8_lossy(text()?).into_owned().into(),
        ColumnType::Json => {
            let text = text()?;
            serde_json::from_slice(text).unwrap_or_else(|_| String::from_utf8_lossy(text).into_owned().into())
        }
        ColumnType::Binary => {
            text()?;
            return Some(Property::LeftOut);
        }
        ColumnType::Byte => i8::from_le_bytes(take(bytes)?).into(),
        ColumnType::UByte => u8::from_le_bytes(take(bytes)?).into(),
        ColumnType::Bool => Value::Bool(u8::from_le_bytes(take(bytes)?) != 0),
        ColumnType::Short => i16::from_le_bytes(take(bytes)?).into(),
        ColumnType::UShort => u16::from_le_bytes(take(bytes)?).into(),
        ColumnType::Int => i32::from_le_bytes(take(bytes)?).into(),
        ColumnType::UInt => u32::from_le_bytes(take(bytes)?).into(),
        ColumnType::Long => i64::from_le_bytes(take(bytes)?).into(),
        ColumnType::ULong => u64::from_le_bytes(take(bytes)?).into(),
        ColumnType::Float => float(f64::from(f32::from_le_bytes(take(bytes)?))),
        ColumnType::Double => float(f64::from_le_bytes(take(bytes)?)),
        _ => return None,
    };
    Some(Property::Kept(value))
}

fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (first, rest) = bytes.split_first_chunk::<N>()?;
    *bytes = rest;
    Some(*first)
}

fn outline_of(geometry: &Geometry<'_>, of_layer: GeometryType) -> Result<Outline, String> {
    let mut outline = Outline::default();
    let mut others = Vec::new();
    let kind = if of_layer == GeometryType::Unknown { geometry.type_() } else { of_layer };
    collect(geometry, kind, &mut outline, &mut others)?;
    outline.beside(&others)
}

/// Takes the polygons of a geometry and the names of what else it holds. The depth of the recursion is bounded by the
/// verification of the buffer.
fn collect(
    geometry: &Geometry<'_>,
    kind: GeometryType,
    outline: &mut Outline,
    others: &mut Vec<&'static str>,
) -> Result<(), String> {
    match kind {
        GeometryType::Polygon => outline.polygons.push(rings(geometry)?),
        // Parts of a MultiPolygon may leave their type out.
        GeometryType::MultiPolygon => {
            for part in geometry.parts().iter().flatten() {
                outline.polygons.push(rings(&part)?);
            }
        }
        GeometryType::GeometryCollection | GeometryType::MultiSurface => {
            for part in geometry.parts().iter().flatten() {
                collect(&part, part.type_(), outline, others)?;
            }
        }
        GeometryType::CurvePolygon => {
            let parts = geometry.parts();
            let curves = parts.iter().flatten().map(|part| {
                let (mut ring, mut has_arcs) = (Ring::new(), false);
                curve(&part, &mut ring, &mut has_arcs, 0)?;
                Ok((ring, has_arcs))
            });
            let (rings, arcs): (Vec<Ring>, Vec<bool>) = curves.collect::<Result<Vec<_>, String>>()?.into_iter().unzip();
            outline.polygons.push(rings);
            if arcs.contains(&true) {
                outline.notes.push(arcs::note());
            }
        }
        GeometryType::PolyhedralSurface | GeometryType::TIN | GeometryType::Triangle => {
            return Err("its geometry is a surface in space, not a polygon in the plane".into());
        }
        other => others.push(other.variant_name().unwrap_or("geometry of an unknown type")),
    }
    Ok(())
}

/// Appends a curve to a ring: straight, of arcs, or of parts of either kind.
fn curve(geometry: &Geometry<'_>, ring: &mut Ring, has_arcs: &mut bool, depth: u8) -> Result<(), String> {
    let numbers: Vec<f64> = geometry.xy().iter().flatten().collect();
    let points: Ring = numbers.as_chunks::<2>().0.iter().map(|&[x, y]| Coord { x, y }).collect();
    match geometry.type_() {
        GeometryType::CircularString => {
            *has_arcs = true;
            arcs::linearise(&points, ring)?;
        }
        GeometryType::CompoundCurve if depth == 0 => {
            geometry.parts().iter().flatten().try_for_each(|part| curve(&part, ring, has_arcs, depth + 1))?;
        }
        GeometryType::LineString | GeometryType::Unknown => {
            // A part begins where the one before it ends.
            let skipped = usize::from(!points.is_empty() && points.first() == ring.last());
            ring.extend(&points[skipped..]);
        }
        _ => return Err("its rings are of an unknown kind".into()),
    }
    Ok(())
}

fn rings(polygon: &Geometry<'_>) -> Result<Vec<Ring>, String> {
    let numbers: Vec<f64> = polygon.xy().iter().flatten().collect();
    let points: Ring = numbers.as_chunks::<2>().0.iter().map(|&[x, y]| Coord { x, y }).collect();
    if points.is_empty() {
        return Ok(Vec::new());
    }
    let ends: Vec<usize> = polygon.ends().iter().flatten().map(|end| end as usize).collect();
    let ends = if ends.is_empty() { vec![points.len()] } else { ends };
    let mut start = 0;
    ends.into_iter()
        .map(|end| {
            let ring = points.get(start..end).ok_or("its rings are damaged")?.to_vec();
            start = end;
            Ok(ring)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use ::flatgeobuf::GeometryArgs;
    use flatbuffers::{FlatBufferBuilder, WIPOffset};
    use geo::Area;

    use super::*;

    type Part<'a> = WIPOffset<Geometry<'a>>;

    fn curve<'a>(buffer: &mut FlatBufferBuilder<'a>, type_: GeometryType, points: &[[f64; 2]]) -> Part<'a> {
        let xy = Some(buffer.create_vector(points.as_flattened()));
        Geometry::create(buffer, &GeometryArgs { type_, xy, ..GeometryArgs::default() })
    }

    fn of_parts<'a>(buffer: &mut FlatBufferBuilder<'a>, type_: GeometryType, parts: &[Part<'a>]) -> Part<'a> {
        let parts = Some(buffer.create_vector(parts));
        Geometry::create(buffer, &GeometryArgs { type_, parts, ..GeometryArgs::default() })
    }

    #[test]
    fn curves_are_straightened() {
        let mut buffer = FlatBufferBuilder::new();
        let sides = [[0.0, 10.0], [0.0, 0.0], [10.0, 0.0], [10.0, 10.0]];
        let sides = curve(&mut buffer, GeometryType::LineString, &sides);
        let arc = curve(&mut buffer, GeometryType::CircularString, &[[10.0, 10.0], [5.0, 15.0], [0.0, 10.0]]);
        let outer = of_parts(&mut buffer, GeometryType::CompoundCurve, &[sides, arc]);
        let hole = curve(&mut buffer, GeometryType::CircularString, &[[2.0, 5.0], [8.0, 5.0], [2.0, 5.0]]);
        let whole = of_parts(&mut buffer, GeometryType::CurvePolygon, &[outer, hole]);
        buffer.finish_minimal(whole);
        let geometry = flatbuffers::root::<Geometry<'_>>(buffer.finished_data()).unwrap();
        let outline = outline_of(&geometry, GeometryType::CurvePolygon).unwrap();
        let (polygon, notes) = outline.into_valid().unwrap();
        let area = 100.0 + 12.5 * std::f64::consts::PI - 9.0 * std::f64::consts::PI;
        assert!((polygon.unsigned_area() - area).abs() < 0.2, "{}", polygon.unsigned_area());
        assert!(notes.len() == 1 && notes[0].contains("arcs"), "{notes:?}");
    }
}
