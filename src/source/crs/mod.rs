//! Coordinate reference systems: where they come from, what their units are, and how to go from one to another.
//!
//! A [`Crs`] is plain data and goes from thread to thread; PROJ, which understands it, is asked anew each time and
//! with the database that is linked into the binary, whatever `PROJ_DATA` says.

mod definition;
mod geocentric;
mod geotiff;
mod proj_ffi;
mod scale;
mod spatial;
mod transform;

#[cfg(test)]
mod tests;

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::InputError;

pub use geocentric::Geocentric;
pub use spatial::SpatialTransformer;
pub use transform::Transformer;

/// The user id of the records of a LAS header that hold a CRS (LAS 1.4, section 2.5.3).
const LAS_PROJECTION: &str = "LASF_Projection";
/// The records that hold OGC WKT, by user id and number, the usual one first: WKT 1 (LAS 1.4, section 2.5.3.1), WKT 2 as
/// later drafts number it, and those of the library that wrote WKT before there was a number for it.
const LAS_WKT_RECORDS: [(&str, u16); 4] =
    [(LAS_PROJECTION, 2112), (LAS_PROJECTION, 4224), ("liblas", 2112), ("liblas", 4224)];
/// The name of the system of an object without one.
const LOCAL_NAME: &str = "local coordinates in metres, heights along z";
/// Its definition (OGC 18-010r11, engineering systems).
const LOCAL_WKT: &str = r#"ENGCRS["local coordinates in metres, heights along z",EDATUM["unknown engineering datum"],CS[Cartesian,3],AXIS["(x)",unspecified,ORDER[1]],AXIS["(y)",unspecified,ORDER[2]],AXIS["(z)",up,ORDER[3]],LENGTHUNIT["metre",1]]"#;
/// What to write where a CRS is expected.
const EXAMPLES: &str = "Give it as a code such as EPSG:7415, as a pair such as EPSG:2154+5720, or as WKT";

/// The version of PROJ that is linked into the binary.
pub fn proj_version() -> String {
    use proj_sys::{PROJ_VERSION_MAJOR, PROJ_VERSION_MINOR, PROJ_VERSION_PATCH};
    format!("{PROJ_VERSION_MAJOR}.{PROJ_VERSION_MINOR}.{PROJ_VERSION_PATCH}")
}

/// A coordinate reference system.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Crs {
    /// WKT2 of the whole system (compound systems whole), as PROJ writes it.
    pub wkt: String,
    /// Authority and code of the whole system, such as `EPSG:7415`; for a compound system that has no code of its own
    /// but whose parts have, `EPSG:2154+5720`; where nobody knows its vertical part ([`Self::unknown_heights`]), that of
    /// its horizontal part; `None` when there is none.
    pub code: Option<String>,
    /// Its name.
    pub name: String,
    /// Metres per unit along x, y and z (z takes the horizontal unit when the system has no vertical part). For
    /// geographic systems x and y are those of a degree (or other angle) along the equator.
    pub metres_per_unit: [f64; 3],
    /// Whether it is geographic: its horizontal unit is an angle.
    pub is_geographic: bool,
}

impl Crs {
    /// The CRS of a LAS header: WKT VLR or EVLR (whether or not the header's WKT bit is set), else GeoTIFF keys; `None`
    /// when it has neither.
    ///
    /// # Errors
    /// What is wrong with a CRS that is there but cannot be understood.
    pub fn from_header(header: &las::Header) -> Result<Option<Self>, String> {
        let of_user = |user: &str, id: u16| {
            header
                .all_vlrs()
                .find(|vlr| vlr.record_id == id && vlr.user_id.eq_ignore_ascii_case(user))
                .map(|vlr| vlr.data.as_slice())
        };
        let record = |id: u16| of_user(LAS_PROJECTION, id);
        let mut from_wkt = None;
        for bytes in LAS_WKT_RECORDS.into_iter().filter_map(|(user, id)| of_user(user, id)) {
            let end = bytes.iter().position(|&b| b == 0).unwrap_or(bytes.len());
            let text = String::from_utf8_lossy(&bytes[..end]);
            if text.trim().is_empty() {
                continue;
            }
            match definition::from_wkt(text.trim()) {
                Ok(crs) => return Ok(Some(crs)),
                Err(e) => from_wkt = from_wkt.or(Some(format!("its WKT cannot be understood: {e}"))),
            }
        }
        match (geotiff::read(record), from_wkt) {
            (Ok(Some(crs)), _) => Ok(Some(crs)),
            (_, Some(e)) | (Err(e), _) => Err(e),
            (Ok(None), _) => Ok(None),
        }
    }

    /// The CRS in the GeoTIFF keys of a raster: the directory, and those of its values that are numbers and text; `None` when
    /// they say nothing.
    ///
    /// # Errors
    /// What is wrong with keys that cannot be understood.
    pub(crate) fn from_geotiff_keys(directory: &[u16], doubles: &[f64], ascii: &str) -> Result<Option<Self>, String> {
        let directory: Vec<u8> = directory.iter().flat_map(|value| value.to_le_bytes()).collect();
        let doubles: Vec<u8> = doubles.iter().flat_map(|value| value.to_le_bytes()).collect();
        geotiff::of_keys(&directory, &doubles, ascii.as_bytes())
    }

    /// A CRS as a user or a file names it: `EPSG:7415`, `28992` (EPSG is meant), `EPSG:2154+5720`, URN, URI, WKT of any
    /// dialect, PROJJSON, PROJ string, or the exact name of a system in the EPSG database.
    ///
    /// # Errors
    /// What could not be understood, with examples of what can.
    pub fn parse(text: &str) -> Result<Self, InputError> {
        definition::parse(text).map_err(|reason| {
            let shown: String = text.trim().chars().take(80).collect();
            // What PROJ says of an authority or a code that it does not have.
            let reason = if reason.contains("Unknown error") { "PROJ knows no such system".to_owned() } else { reason };
            InputError::new(
                "coordinate reference system",
                format!("`{shown}`: {reason}"),
                "a horizontal or compound reference system",
            )
            .remedy(EXAMPLES)
        })
    }

    /// The system of a single object that stands nowhere on the Earth: metres, heights along z.
    pub fn local() -> Self {
        Self {
            wkt: LOCAL_WKT.to_owned(),
            code: None,
            name: LOCAL_NAME.to_owned(),
            metres_per_unit: [1.0; 3],
            is_geographic: false,
        }
    }

    /// Whether it is [`Self::local`].
    pub fn is_local(&self) -> bool {
        self.code.is_none() && self.name == LOCAL_NAME
    }

    /// WGS 84 with longitude first, which GeoJSON means when it names no CRS (RFC 7946, section 4).
    ///
    /// # Errors
    /// When PROJ cannot be used at all.
    pub fn wgs84() -> Result<Self, InputError> {
        Self::parse("OGC:CRS84")
    }

    /// The form that CityJSON wants for `metadata.referenceSystem`, such as
    /// `https://www.opengis.net/def/crs/EPSG/0/7415`; for a pair of codes that of the horizontal part. `None` when the
    /// system has no code.
    pub fn reference_system(&self) -> Option<String> {
        let (authority, code) = self.code.as_deref()?.split_once(':')?;
        let horizontal = code.split('+').next()?;
        let version = if authority == "OGC" { "1.3" } else { "0" };
        Some(format!("https://www.opengis.net/def/crs/{authority}/{version}/{horizontal}"))
    }

    /// The name of its vertical part, where it has one that has no code, so that [`Self::code`] says nothing of heights.
    pub fn unknown_heights(&self) -> Option<String> {
        definition::unknown_heights(&self.wkt)
    }

    /// WKT1 as GDAL writes it, for formats that know no other; `None` for what it cannot express.
    pub fn wkt1(&self) -> Option<String> {
        definition::wkt1(&self.wkt)
    }

    /// Whether two systems have the same horizontal part, so that x and y of one are x and y of the other: 28992 and
    /// 7415 do.
    pub fn is_same_horizontally(&self, other: &Self) -> bool {
        self == other || transform::is_same_horizontally(self, other)
    }
}

/// The code and the name: `EPSG:7415 (Amersfoort / RD New + NAP height)`.
impl fmt::Display for Crs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.code {
            Some(code) => write!(f, "{code} ({})", self.name),
            None => write!(f, "{} (no code)", self.name),
        }
    }
}
