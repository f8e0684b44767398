//! The lines of a CityJSONSeq (CityJSON 2.0, section 9): a head, then a `CityJSONFeature` a line.

use super::Feature;
use super::header::{Header, Metadata};
use super::json::{Extent, encode};
use super::vertices::{Vertices, write_json};
use crate::error::{Error, Result};

/// Makes the lines of a CityJSONSeq one by one; nothing of a feature stays in memory.
pub struct Sequence {
    header: Header,
    vertices: Vertices,
    extent: Option<Extent>,
    objects: usize,
    buffer: Vec<u8>,
}

impl Sequence {
    /// A sequence with this head.
    ///
    /// # Errors
    /// The reference system is no OGC URL.
    pub fn new(metadata: Metadata) -> Result<Self> {
        let header = Header::new("metadata".as_ref(), metadata)?;
        Ok(Self { header, vertices: Vertices::default(), extent: None, objects: 0, buffer: Vec::new() })
    }

    /// The first line without its line end: a CityJSON object without objects, with the transform that all features
    /// use. `geographicalExtent` is that of the features until now; blanks make every head of a sequence equally long.
    ///
    /// # Errors
    /// It cannot be written as JSON.
    pub fn head(&self) -> Result<Vec<u8>> {
        let mut head = self.header.text(self.extent)?;
        head.extend_from_slice(b",\"CityObjects\":{},\"vertices\":[]}");
        Ok(head)
    }

    /// The line of a feature, without its line end. Its id and those of its objects must differ from those of all others.
    ///
    /// # Errors
    /// It cannot be written as JSON.
    pub fn feature(&mut self, feature: &Feature) -> Result<&[u8]> {
        let fault = |e: serde_json::Error| Error::io(&feature.id, "write", e.into());
        self.buffer.clear();
        self.vertices.clear();
        self.buffer.extend_from_slice(br#"{"type":"CityJSONFeature","id":"#);
        serde_json::to_writer(&mut self.buffer, &feature.id).map_err(fault)?;
        self.buffer.extend_from_slice(br#","CityObjects":{"#);
        let encoded = encode(feature, self.header.transform(), &mut self.vertices, &mut self.buffer).map_err(fault)?;
        self.buffer.extend_from_slice(br#"},"vertices":["#);
        write_json(&self.vertices.take_fresh(), &mut self.buffer);
        self.buffer.extend_from_slice(b"]}");
        self.objects += encoded.objects;
        self.extent = Extent::union(self.extent, encoded.extent);
        Ok(&self.buffer)
    }

    /// Number of `CityObject`s until now: features and their parts.
    pub fn objects(&self) -> usize {
        self.objects
    }
}
