//! The CRS of a LAS file in GeoTIFF keys (LAS 1.4, section 2.5.3.2; OGC 19-008r4).

use std::collections::BTreeMap;
use std::rc::Rc;

use super::proj_ffi::{Context, Object};
use super::{Crs, definition};

/// The keys that are read, by their number in the standard.
mod key {
    pub const CITATION: u16 = 1026;
    pub const GEODETIC_CRS: u16 = 2048;
    pub const GEODETIC_DATUM: u16 = 2050;
    pub const ELLIPSOID_SEMI_MAJOR_AXIS: u16 = 2057;
    pub const ELLIPSOID_SEMI_MINOR_AXIS: u16 = 2058;
    pub const ELLIPSOID_INVERSE_FLATTENING: u16 = 2059;
    pub const PROJECTED_CRS: u16 = 3072;
    pub const PROJECTED_CITATION: u16 = 3073;
    pub const PROJECTION: u16 = 3074;
    pub const METHOD: u16 = 3075;
    pub const LINEAR_UNITS: u16 = 3076;
    pub const LINEAR_UNIT_SIZE: u16 = 3077;
    pub const STANDARD_PARALLEL_1: u16 = 3078;
    pub const STANDARD_PARALLEL_2: u16 = 3079;
    pub const NATURAL_ORIGIN_LONGITUDE: u16 = 3080;
    pub const NATURAL_ORIGIN_LATITUDE: u16 = 3081;
    pub const FALSE_EASTING: u16 = 3082;
    pub const FALSE_NORTHING: u16 = 3083;
    pub const FALSE_ORIGIN_LONGITUDE: u16 = 3084;
    pub const FALSE_ORIGIN_LATITUDE: u16 = 3085;
    pub const FALSE_ORIGIN_EASTING: u16 = 3086;
    pub const FALSE_ORIGIN_NORTHING: u16 = 3087;
    pub const CENTRE_LONGITUDE: u16 = 3088;
    pub const CENTRE_LATITUDE: u16 = 3089;
    pub const SCALE_AT_NATURAL_ORIGIN: u16 = 3092;
    pub const VERTICAL_CRS: u16 = 4096;
    pub const VERTICAL_UNITS: u16 = 4099;
}

/// The record that holds the keys.
const DIRECTORY: u16 = 34735;
/// The record that holds those of their values that are numbers.
const DOUBLES: u16 = 34736;
/// The record that holds those of their values that are text.
const ASCII: u16 = 34737;
/// The value of a key that says: see the other keys.
const USER_DEFINED: u16 = 32767;
/// Codes that EPSG assigns to systems; below are legacy codes, above private ones.
const EPSG_CODES: std::ops::RangeInclusive<u16> = 1024..=32766;
/// Projection codes of UTM, north and south (16001 is zone 1 north).
const UTM: [(std::ops::RangeInclusive<u16>, f64); 2] = [(16001..=16060, 0.0), (16101..=16160, 1e7)];

/// A value of a key.
#[derive(Debug, Clone, PartialEq)]
enum Value {
    Short(u16),
    Double(f64),
    Text(String),
}

/// The keys of a file, by number.
struct Keys(BTreeMap<u16, Value>);

impl Keys {
    /// Reads the directory; entries that point outside their record are left out.
    fn read(directory: &[u8], doubles: &[u8], ascii: &[u8]) -> Self {
        let shorts: Vec<u16> = directory.as_chunks::<2>().0.iter().map(|bytes| u16::from_le_bytes(*bytes)).collect();
        let doubles: Vec<f64> = doubles.as_chunks::<8>().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        let count = shorts.get(3).copied().unwrap_or(0);
        let entries = shorts.get(4..).unwrap_or_default().as_chunks::<4>().0;
        let value = |&[key, location, count, offset]: &[u16; 4]| {
            let start = usize::from(offset);
            let value = match location {
                0 => Value::Short(offset),
                DIRECTORY => Value::Short(*shorts.get(start)?),
                DOUBLES => Value::Double(*doubles.get(start)?),
                ASCII => {
                    let text = ascii.get(start..)?;
                    let text = &text[..text.len().min(usize::from(count))];
                    Value::Text(String::from_utf8_lossy(text).trim_end_matches(['|', '\0', ' ']).to_string())
                }
                _ => return None,
            };
            (key != 0).then_some((key, value))
        };
        Self(entries.iter().take(usize::from(count)).filter_map(value).collect())
    }

    fn short(&self, key: u16) -> Option<u16> {
        match self.0.get(&key)? {
            Value::Short(value) if *value != 0 => Some(*value),
            _ => None,
        }
    }

    fn text(&self, key: u16) -> Option<&str> {
        match self.0.get(&key)? {
            Value::Text(text) => Some(text),
            _ => None,
        }
    }

    fn number(&self, keys: &[u16]) -> Option<f64> {
        keys.iter().find_map(|key| match self.0.get(key)? {
            Value::Double(value) => Some(*value),
            Value::Short(value) => Some(f64::from(*value)),
            Value::Text(_) => None,
        })
    }

    fn epsg(&self, key: u16) -> Option<u16> {
        self.short(key).filter(|code| EPSG_CODES.contains(code))
    }
}

/// The CRS in the GeoTIFF keys of a file whose records `record` finds; `None` when it has no such keys or they say
/// nothing.
pub(super) fn read<'a>(record: impl Fn(u16) -> Option<&'a [u8]>) -> Result<Option<Crs>, String> {
    let Some(directory) = record(DIRECTORY) else { return Ok(None) };
    of_keys(directory, record(DOUBLES).unwrap_or_default(), record(ASCII).unwrap_or_default())
}

/// The CRS in such keys: their directory, and those of their values that are numbers and text, little-endian.
pub(super) fn of_keys(directory: &[u8], doubles: &[u8], ascii: &[u8]) -> Result<Option<Crs>, String> {
    let keys = Keys::read(directory, doubles, ascii);
    let context = Context::new()?;
    let Some(horizontal) =
        horizontal(&context, &keys).map_err(|e| format!("its GeoTIFF keys cannot be understood: {e}"))?
    else {
        return Ok(None);
    };
    let vertical = vertical(&context, &keys);
    let crs = match vertical.as_ref().and_then(|vertical| Object::compound(&horizontal, vertical)) {
        Some(compound) => definition::from_object(compound)?,
        None => definition::from_object(horizontal)?,
    };
    // A vertical unit may stand alone, without a vertical system.
    let z = keys.short(key::VERTICAL_UNITS).and_then(|code| context.length_unit(code)).filter(|_| vertical.is_none());
    Ok(Some(match z {
        Some(unit) => Crs { metres_per_unit: [crs.metres_per_unit[0], crs.metres_per_unit[1], unit.metres], ..crs },
        None => crs,
    }))
}

fn horizontal(context: &Rc<Context>, keys: &Keys) -> Result<Option<Object>, String> {
    let epsg = |code: u16| Object::parse(context, &format!("EPSG:{code}")).map_err(|e| format!("EPSG:{code}: {e}"));
    if let Some(code) = keys.epsg(key::PROJECTED_CRS) {
        return Ok(Some(in_file_units(context, keys, epsg(code)?)));
    }
    // ESRI software and some others put the whole WKT into a citation.
    for citation in [key::PROJECTED_CITATION, key::CITATION] {
        let wkt = keys.text(citation).and_then(|text| Some(&text[text.find("PROJCS[")?..]));
        if let Some(object) = wkt.and_then(|wkt| Object::from_wkt(context, wkt).ok()) {
            return Ok(Some(object));
        }
    }
    if keys.short(key::PROJECTED_CRS) == Some(USER_DEFINED) {
        return Object::from_wkt(context, &user_defined(context, keys)?).map(Some);
    }
    keys.epsg(key::GEODETIC_CRS).map(epsg).transpose()
}

/// The system with the unit of length that the file says its coordinates are in.
fn in_file_units(context: &Context, keys: &Keys, crs: Object) -> Object {
    let unit = keys.short(key::LINEAR_UNITS).and_then(|code| context.length_unit(code));
    let Some(unit) = unit else { return crs };
    let is_same = crs.axis_units().first().is_none_or(|own| (own / unit.metres - 1.0).abs() < 1e-9);
    if is_same { crs } else { crs.with_length_unit(&unit).unwrap_or(crs) }
}

/// The vertical system; `None` for legacy codes (those of ellipsoidal heights, below 5600) and unknown ones.
fn vertical(context: &Rc<Context>, keys: &Keys) -> Option<Object> {
    let code = keys.epsg(key::VERTICAL_CRS)?;
    let object = Object::parse(context, &format!("EPSG:{code}")).ok()?;
    if object.kind() != super::proj_ffi::Kind::Vertical {
        return None;
    }
    let unit = keys.short(key::VERTICAL_UNITS).and_then(|code| context.length_unit(code));
    match unit {
        Some(unit) if object.axis_units().first().is_some_and(|own| (own / unit.metres - 1.0).abs() > 1e-9) => {
            object.with_length_unit(&unit).or(Some(object))
        }
        _ => Some(object),
    }
}

/// WKT 1 of a projected system that the keys define by its parameters.
fn user_defined(context: &Rc<Context>, keys: &Keys) -> Result<String, String> {
    let base = geographic_wkt(context, keys)?;
    let (unit, metres) = match keys.short(key::LINEAR_UNITS) {
        Some(code) if code != USER_DEFINED => {
            let unit = context.length_unit(code).ok_or_else(|| format!("unknown unit of length EPSG:{code}"))?;
            (unit.name, unit.metres)
        }
        _ => ("unit".to_string(), keys.number(&[key::LINEAR_UNIT_SIZE]).unwrap_or(1.0)),
    };
    let (method, parameters) = projection(keys, metres)?;
    let mut elements = vec!["\"user-defined\"".to_string(), base, format!("PROJECTION[\"{method}\"]")];
    elements.extend(parameters.iter().map(|(name, value)| format!("PARAMETER[\"{name}\",{value}]")));
    elements.push(format!("UNIT[\"{unit}\",{metres}]"));
    Ok(format!("PROJCS[{}]", elements.join(",")))
}

/// WKT 1 of the geographic system beneath a projected one.
fn geographic_wkt(context: &Rc<Context>, keys: &Keys) -> Result<String, String> {
    // In the old list of codes that of a datum is that of its geographic system plus 2000.
    let of_datum = keys.epsg(key::GEODETIC_DATUM).filter(|code| (6001..=6999).contains(code)).map(|code| code - 2000);
    if let Some(code) = keys.epsg(key::GEODETIC_CRS).or(of_datum)
        && let Some(wkt) = Object::parse(context, &format!("EPSG:{code}")).ok().and_then(|object| object.wkt1())
    {
        return Ok(wkt);
    }
    let major = keys.number(&[key::ELLIPSOID_SEMI_MAJOR_AXIS]).ok_or("it names neither datum nor ellipsoid")?;
    let inverse_flattening = keys.number(&[key::ELLIPSOID_INVERSE_FLATTENING]).or_else(|| {
        let minor = keys.number(&[key::ELLIPSOID_SEMI_MINOR_AXIS])?;
        Some(if minor == major { 0.0 } else { major / (major - minor) })
    });
    let inverse_flattening = inverse_flattening.ok_or("its ellipsoid has no flattening")?;
    Ok(format!(
        "GEOGCS[\"unknown\",DATUM[\"unknown\",SPHEROID[\"unknown\",{major},{inverse_flattening}]],\
         PRIMEM[\"Greenwich\",0],UNIT[\"degree\",0.0174532925199433]]"
    ))
}

/// A name in WKT 1 and what belongs to it.
type Named<T> = (&'static str, T);

/// Method of projection and its parameters.
fn projection(keys: &Keys, metres: f64) -> Result<Named<Vec<Named<f64>>>, String> {
    if let Some(code) = keys.short(key::PROJECTION).filter(|code| *code != USER_DEFINED) {
        let Some((zone, northing)) = UTM
            .iter()
            .find(|(zones, _)| zones.contains(&code))
            .map(|(zones, northing)| (code - zones.start() + 1, northing))
        else {
            return Err(format!("projection code {code} is not supported"));
        };
        return Ok((
            "Transverse_Mercator",
            vec![
                ("latitude_of_origin", 0.0),
                ("central_meridian", f64::from(zone) * 6.0 - 183.0),
                ("scale_factor", 0.9996),
                ("false_easting", 5e5 / metres),
                ("false_northing", northing / metres),
            ],
        ));
    }
    let longitude = keys
        .number(&[key::NATURAL_ORIGIN_LONGITUDE, key::FALSE_ORIGIN_LONGITUDE, key::CENTRE_LONGITUDE])
        .unwrap_or(0.0);
    let latitude =
        keys.number(&[key::NATURAL_ORIGIN_LATITUDE, key::FALSE_ORIGIN_LATITUDE, key::CENTRE_LATITUDE]).unwrap_or(0.0);
    let parallels = [
        ("standard_parallel_1", keys.number(&[key::STANDARD_PARALLEL_1]).unwrap_or(latitude)),
        ("standard_parallel_2", keys.number(&[key::STANDARD_PARALLEL_2]).unwrap_or(latitude)),
    ];
    let scale = [("scale_factor", keys.number(&[key::SCALE_AT_NATURAL_ORIGIN]).unwrap_or(1.0))];
    let origin = [("latitude_of_origin", latitude), ("central_meridian", longitude)];
    let centre = [("latitude_of_center", latitude), ("longitude_of_center", longitude)];
    let shift = [
        ("false_easting", keys.number(&[key::FALSE_EASTING, key::FALSE_ORIGIN_EASTING]).unwrap_or(0.0)),
        ("false_northing", keys.number(&[key::FALSE_NORTHING, key::FALSE_ORIGIN_NORTHING]).unwrap_or(0.0)),
    ];
    // Codes of the methods: GeoTIFF 1.0, section 6.3.3.3.
    match keys.short(key::METHOD) {
        Some(1) => Ok(("Transverse_Mercator", [&origin[..], &scale, &shift].concat())),
        Some(7) => Ok(("Mercator_1SP", [&origin[1..], &scale, &shift].concat())),
        Some(8) => Ok(("Lambert_Conformal_Conic_2SP", [&origin[..], &parallels, &shift].concat())),
        Some(9) => Ok(("Lambert_Conformal_Conic_1SP", [&origin[..], &scale, &shift].concat())),
        Some(11) => Ok(("Albers_Conic_Equal_Area", [&centre[..], &parallels, &shift].concat())),
        Some(16) => Ok(("Oblique_Stereographic", [&origin[..], &scale, &shift].concat())),
        Some(method) => Err(format!("projection method {method} is not supported")),
        None => Err("it has no code and no projection method".into()),
    }
}
