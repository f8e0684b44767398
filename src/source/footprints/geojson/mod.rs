//! GeoJSON (RFC 7946, and the older form with a `crs` member): feature collections, features, geometries; sequences of
//! them, one a line or as RFC 8142 has them.
//!
//! A collection is read feature by feature and every feature is judged by itself, so that neither the size of a file
//! nor one bad feature matters.

mod clashes;
mod strict;

use std::fmt;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

use ::geojson::{Geometry, GeometryValue, Position};
use geo::Coord;
use serde::de::{DeserializeSeed, Deserializer, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

use clashes::{Clashes, Noting};
use strict::Strict;

pub(super) use strict::RECORD_SEPARATOR;

use super::format::stem;
use super::outline::{Outline, Ring};
use super::reference_system::crs_of_file;
use super::{FootprintOptions, LayerInfo, RawFeature, Sink};
use crate::error::{Error, InputError, Result};
use crate::source::crs::Crs;

/// Reads a GeoJSON file.
pub(super) fn read(path: &Path, options: &FootprintOptions, sink: Sink<'_>) -> Result<LayerInfo> {
    let mut file = BufReader::new(File::open(path).map_err(|e| Error::io(path, "open", e))?);
    skip_byte_order_mark(&mut file).map_err(|e| Error::io(path, "read", e))?;
    let (mut bounds, clashes) = (Bounds::default(), Clashes::default());
    let mut json = serde_json::Deserializer::from_reader(BufReader::new(Strict::new(file)));
    let mut take = |feature: RawFeature| {
        if let Ok(outline) = &feature.outline {
            bounds.extend(outline);
        }
        sink(feature);
    };
    let mut info = LayerInfo { layer: stem(path), ..LayerInfo::default() };
    // A file is one document, or a sequence of them: one a line, or one after each record separator.
    let (mut first, mut is_sequence): (Option<Document>, bool) = (None, false);
    loop {
        let mut document = Document::default();
        let read = Root { document: &mut document, sink: &mut take, clashes: &clashes }.deserialize(&mut json);
        match read {
            Ok(()) => {}
            Err(error) if error.is_eof() && first.is_some() => {
                info.missing = 1;
                info.warnings.push(format!("it is cut off in its last feature, which is missing ({error})"));
                break;
            }
            Err(error) => {
                let remedy = if error.is_eof() { "The file is cut off; get it anew" } else { "" };
                return Err(InputError::new(path, error.to_string(), "GeoJSON").remedy(remedy).into());
            }
        }
        if !document.has_features || document.kind.as_deref() != Some("FeatureCollection") {
            take(feature_of_document(path, &document, &clashes)?);
        }
        // What stands for the whole may be said in the first of a sequence, or in a later one.
        let first = first.get_or_insert_with(Document::default);
        for name in ["crs", "name"] {
            if let (Some(value), false) = (document.members.shift_remove(name), first.members.contains_key(name)) {
                first.members.insert(name.to_owned(), value);
            }
        }
        if json.end().is_ok() {
            break;
        }
        is_sequence = true;
    }
    info.warnings.extend(clashes.warnings());
    let document = first.unwrap_or_default();
    if let Some(Value::String(name)) = document.members.get("name").filter(|_| !is_sequence) {
        info.layer.clone_from(name);
    }
    if options.crs.is_none() {
        let (crs, warnings) = crs_of(path, &document, &bounds, options)?;
        info.crs = crs;
        info.warnings.extend(warnings);
    }
    Ok(info)
}

/// The feature that a document without `features` is.
fn feature_of_document(path: &Path, document: &Document, clashes: &Clashes) -> Result<RawFeature> {
    match document.kind.as_deref() {
        Some("FeatureCollection") => {
            Err(InputError::new(path, "a FeatureCollection without `features`", "GeoJSON").into())
        }
        Some("Feature") => Ok(feature_of(Value::Object(document.members.clone()), clashes)),
        Some(_) if document.members.contains_key("coordinates") || document.members.contains_key("geometries") => {
            let outline = outline_of(Value::Object(document.members.clone()));
            Ok(RawFeature { attributes: Map::new(), outline })
        }
        kind => {
            let found = kind.map_or("JSON without a `type`".to_string(), |kind| format!("JSON of type `{kind}`"));
            Err(InputError::new(path, found, "a FeatureCollection, a Feature or a geometry").into())
        }
    }
}

fn skip_byte_order_mark(file: &mut BufReader<File>) -> std::io::Result<()> {
    use std::io::BufRead;
    if file.fill_buf()?.starts_with(b"\xEF\xBB\xBF") {
        file.read_exact(&mut [0; 3])?;
    }
    Ok(())
}

/// The CRS by the `crs` member, else WGS 84 unless the coordinates cannot be degrees.
fn crs_of(
    path: &Path,
    document: &Document,
    bounds: &Bounds,
    options: &FootprintOptions,
) -> Result<(Option<Crs>, Vec<String>)> {
    let member = document.members.get("crs");
    let properties = member.and_then(|crs| crs.get("properties"));
    let name = properties.and_then(|p| p.get("name")).and_then(Value::as_str).map(str::to_string);
    let code =
        properties.and_then(|p| p.get("code")).map(|code| format!("EPSG:{}", code.to_string().trim_matches('"')));
    if let Some(definition) = name.or(code) {
        return Ok((crs_of_file(path, &definition, options)?, Vec::new()));
    }
    match member {
        Some(Value::Null) => Ok((None, vec!["its `crs` is null: the reference system is unknown".into()])),
        Some(other) => {
            let found = format!("`crs`: {other}");
            Err(InputError::new(path, found, "a `crs` by name, such as urn:ogc:def:crs:EPSG::28992")
                .remedy("Say with --footprint-crs which reference system it is")
                .into())
        }
        None if bounds.are_degrees() => Ok((Some(Crs::wgs84()?), Vec::new())),
        None => Ok((
            None,
            vec!["it names no reference system, and its coordinates are no degrees as the standard wants them".into()],
        )),
    }
}

/// The members of the document besides `features`.
#[derive(Default)]
struct Document {
    kind: Option<String>,
    members: Map<String, Value>,
    has_features: bool,
}

/// The bounds of all coordinates.
struct Bounds([f64; 4]);

impl Default for Bounds {
    fn default() -> Self {
        Self([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY])
    }
}

impl Bounds {
    fn extend(&mut self, outline: &Outline) {
        for c in outline.polygons.iter().flatten().flatten() {
            let [x0, y0, x1, y1] = self.0;
            self.0 = [x0.min(c.x), y0.min(c.y), x1.max(c.x), y1.max(c.y)];
        }
    }

    fn are_degrees(&self) -> bool {
        let [x0, y0, x1, y1] = self.0;
        x0 >= -180.0 && x1 <= 180.0 && y0 >= -90.0 && y1 <= 90.0
    }
}

/// Reads the root object: features are handed over one by one, all else is kept.
struct Root<'a> {
    document: &'a mut Document,
    sink: Sink<'a>,
    clashes: &'a Clashes,
}

impl<'de> DeserializeSeed<'de> for Root<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_map(self)
    }
}

impl<'de> Visitor<'de> for Root<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a GeoJSON object")
    }

    fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<(), A::Error> {
        while let Some(key) = map.next_key::<String>()? {
            // Other formats, CityJSON for one, hold large members that are nobody's business here.
            match key.as_str() {
                "features" => {
                    self.document.has_features = true;
                    map.next_value_seed(Features { sink: self.sink, clashes: self.clashes })?;
                }
                "type" => {
                    let kind = map.next_value::<Value>()?;
                    self.document.kind = kind.as_str().map(str::to_string);
                    self.document.members.insert(key, kind);
                }
                "crs" | "name" | "id" | "properties" | "geometry" | "coordinates" | "geometries" => {
                    let value = map.next_value_seed(Noting(self.clashes))?;
                    self.document.members.insert(key, value);
                }
                _ => {
                    map.next_value::<IgnoredAny>()?;
                }
            }
        }
        Ok(())
    }
}

struct Features<'a> {
    sink: Sink<'a>,
    clashes: &'a Clashes,
}

impl<'de> DeserializeSeed<'de> for Features<'_> {
    type Value = ();

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<(), D::Error> {
        deserializer.deserialize_seq(self)
    }
}

impl<'de> Visitor<'de> for Features<'_> {
    type Value = ();

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("an array of features")
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut features: A) -> Result<(), A::Error> {
        while let Some(feature) = features.next_element_seed(Noting(self.clashes))? {
            (self.sink)(feature_of(feature, self.clashes));
        }
        Ok(())
    }
}

/// A feature from its JSON. Its `id` member becomes the attribute `id` where there is none.
fn feature_of(feature: Value, clashes: &Clashes) -> RawFeature {
    let Value::Object(mut members) = feature else {
        return RawFeature { attributes: Map::new(), outline: Err("it is no GeoJSON feature".into()) };
    };
    let mut attributes = match members.remove("properties") {
        Some(Value::Object(properties)) => properties,
        _ => Map::new(),
    };
    if let Some(id) = members.remove("id") {
        match attributes.get("id") {
            None => drop(attributes.insert("id".into(), id)),
            Some(other) if *other != id => clashes.two_ids(),
            Some(_) => {}
        }
    }
    let outline = match members.remove("geometry") {
        None | Some(Value::Null) => Err("it has no geometry".into()),
        Some(geometry) => outline_of(geometry),
    };
    RawFeature { attributes, outline }
}

fn outline_of(geometry: Value) -> Result<Outline, String> {
    let geometry: Geometry =
        serde_json::from_value(geometry).map_err(|error| format!("its geometry cannot be understood: {error}"))?;
    let mut outline = Outline::default();
    let mut others = Vec::new();
    collect(geometry.value, &mut outline, &mut others)?;
    outline.beside(&others)
}

/// Takes the polygons of a geometry and the names of what else it holds.
fn collect(geometry: GeometryValue, outline: &mut Outline, others: &mut Vec<&'static str>) -> Result<(), String> {
    match geometry {
        GeometryValue::Polygon { coordinates } => outline.polygons.push(rings(&coordinates)?),
        GeometryValue::MultiPolygon { coordinates } => {
            for polygon in coordinates {
                outline.polygons.push(rings(&polygon)?);
            }
        }
        GeometryValue::GeometryCollection { geometries } => {
            for part in geometries {
                collect(part.value, outline, others)?;
            }
        }
        GeometryValue::Point { .. } => others.push("Point"),
        GeometryValue::MultiPoint { .. } => others.push("MultiPoint"),
        GeometryValue::LineString { .. } => others.push("LineString"),
        GeometryValue::MultiLineString { .. } => others.push("MultiLineString"),
    }
    Ok(())
}

fn rings(polygon: &[Vec<Position>]) -> Result<Vec<Ring>, String> {
    let coord = |position: &Position| match position.as_slice() {
        [x, y, ..] => Ok(Coord { x: *x, y: *y }),
        short => Err(format!("a position has {} number(s), not two", short.len())),
    };
    polygon.iter().map(|ring| ring.iter().map(coord).collect()).collect()
}
