//! The head of a file: transform and metadata (CityJSON 2.0, sections 4 and 5).

use serde::Serialize;
use serde_json::{Map, Value};

use super::json::Extent;
use crate::error::{InputError, Result};
use crate::site::QUANTUM;
use crate::source::cityjson::Transform;
use crate::source::crs::Crs;

/// Room for the extent, which is known last but stands first: six numbers of at most 24 characters, and the key.
const ROOM: usize = 6 * 25 + 32;

/// What is known of the whole file before the first feature.
#[derive(Debug, Clone)]
pub struct Metadata {
    /// Title of the data set; empty for none.
    pub title: String,
    /// The CRS as an OGC URL, such as `https://www.opengis.net/def/crs/EPSG/0/7415`; see [`reference_system`].
    pub reference_system: Option<String>,
    /// The CRS itself, for formats that want its definition or go to another.
    pub crs: Option<Crs>,
    /// The grid of the numbers in a CityJSON file. For reconstructed buildings its scale is [`QUANTUM`], and its origin
    /// should depend on the footprints alone and lie near them.
    pub transform: Transform,
    /// Other members of the metadata, as they are.
    pub others: Map<String, Value>,
    /// The extensions that the features use, as CityJSON declares them.
    pub extensions: Option<Value>,
}

impl Default for Metadata {
    fn default() -> Self {
        Self {
            title: String::new(),
            reference_system: None,
            crs: None,
            transform: Transform { scale: [QUANTUM; 3], translate: [0.0; 3] },
            others: Map::new(),
            extensions: None,
        }
    }
}

impl Metadata {
    /// What gable tells of the making of its models: its version and these parameters.
    pub fn making(parameters: Value) -> Map<String, Value> {
        let version = Value::from(env!("CARGO_PKG_VERSION"));
        [("gable_version", version), ("gable_parameters", parameters)]
            .map(|(name, v)| (name.to_owned(), v))
            .into_iter()
            .collect()
    }
}

/// The OGC URL of a CRS code: `EPSG:7415` → `https://www.opengis.net/def/crs/EPSG/0/7415`.
///
/// `None` when it is not an authority and a code: CityJSON 2.0 has no way to name such a system (a compound
/// `EPSG:28992+5709` that has no code of its own, say).
pub fn reference_system(code: &str) -> Option<String> {
    let (authority, code) = code.split_once(':')?;
    let is_plain = |text: &str| !text.is_empty() && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    (is_plain(authority) && is_plain(code))
        .then(|| format!("https://www.opengis.net/def/crs/{}/0/{code}", authority.to_ascii_uppercase()))
}

/// The head of a file: the opening of its object up to and with the metadata.
#[derive(Debug)]
pub(super) struct Header {
    metadata: Metadata,
    len: usize,
}

#[derive(Serialize)]
struct JsonMetadata<'a> {
    #[serde(skip_serializing_if = "str::is_empty")]
    title: &'a str,
    #[serde(rename = "referenceSystem", skip_serializing_if = "Option::is_none")]
    reference_system: Option<&'a str>,
    #[serde(rename = "geographicalExtent", skip_serializing_if = "Option::is_none")]
    extent: Option<[f64; 6]>,
    #[serde(flatten)]
    others: &'a Map<String, Value>,
}

impl Header {
    /// The head for these metadata.
    pub(super) fn new(path: &std::path::Path, metadata: Metadata) -> Result<Self> {
        let is_url = |url: &String| {
            ["https", "http"].iter().any(|s| url.starts_with(&format!("{s}://www.opengis.net/def/crs/")))
        };
        if let Some(system) = metadata.reference_system.as_ref().filter(|url| !is_url(url)) {
            return Err(InputError::new(path, format!("the reference system {system:?}"), "an OGC URL")
                .remedy("CityJSON 2.0 wants https://www.opengis.net/def/crs/AUTHORITY/VERSION/CODE.")
                .into());
        }
        let mut header = Self { metadata, len: 0 };
        header.len = header.render(None)?.len() + ROOM;
        Ok(header)
    }

    /// The grid of the file.
    pub(super) fn transform(&self) -> &Transform {
        &self.metadata.transform
    }

    /// The text, padded with blanks to a length that does not depend on the extent.
    pub(super) fn text(&self, extent: Option<Extent>) -> Result<Vec<u8>> {
        let mut text = self.render(extent)?;
        text.resize(self.len.max(text.len()), b' ');
        Ok(text)
    }

    fn render(&self, extent: Option<Extent>) -> Result<Vec<u8>> {
        let Metadata { title, reference_system, transform, others, extensions, .. } = &self.metadata;
        let metadata = JsonMetadata {
            title,
            reference_system: reference_system.as_deref(),
            extent: extent.map(|e| e.to_crs(transform)),
            others,
        };
        let mut out = br#"{"type":"CityJSON","version":"2.0","transform":"#.to_vec();
        let fault = |e: serde_json::Error| crate::error::Error::io("metadata", "write", e.into());
        serde_json::to_writer(&mut out, transform).map_err(fault)?;
        out.extend_from_slice(br#","metadata":"#);
        serde_json::to_writer(&mut out, &metadata).map_err(fault)?;
        if let Some(extensions) = extensions {
            out.extend_from_slice(br#","extensions":"#);
            serde_json::to_writer(&mut out, extensions).map_err(fault)?;
        }
        Ok(out)
    }
}
