//! CityJSONSeq: a line for the head, then a `CityJSONFeature` a line (CityJSON 2.0, section 9).

use std::path::Path;

use super::header::{Header, Metadata};
use super::json::{Extent, encode};
use super::output::Output;
use super::vertices::{Vertices, write_json};
use super::{Feature, Format, Sink, Written};
use crate::error::Result;

/// Writes a line a feature, of which nothing stays in memory.
pub(super) struct CityJsonSeq {
    output: Output,
    header: Header,
    vertices: Vertices,
    extent: Option<Extent>,
    features: usize,
    objects: usize,
    buffer: Vec<u8>,
}

impl CityJsonSeq {
    /// Opens a sink for `path`.
    pub(super) fn create(path: &Path, metadata: Metadata, overwrite: bool, scratch: Option<&Path>) -> Result<Self> {
        let header = Header::new(path, metadata)?;
        let mut output = Output::create(path, overwrite, scratch)?;
        output.write(&header.text(None)?)?;
        output.write(b",\"CityObjects\":{},\"vertices\":[]}\n")?;
        Ok(Self {
            output,
            header,
            vertices: Vertices::default(),
            extent: None,
            features: 0,
            objects: 0,
            buffer: Vec::new(),
        })
    }
}

impl Sink for CityJsonSeq {
    fn write(&mut self, feature: &Feature) -> Result<()> {
        let fault = |output: &Output, e: serde_json::Error| output.fault("write", e.into());
        self.buffer.clear();
        self.vertices.clear();
        self.buffer.extend_from_slice(br#"{"type":"CityJSONFeature","id":"#);
        serde_json::to_writer(&mut self.buffer, &feature.id).map_err(|e| fault(&self.output, e))?;
        self.buffer.extend_from_slice(br#","CityObjects":{"#);
        let encoded = encode(feature, self.header.transform(), &mut self.vertices, &mut self.buffer)
            .map_err(|e| fault(&self.output, e))?;
        self.buffer.extend_from_slice(br#"},"vertices":["#);
        write_json(&self.vertices.take_fresh(), &mut self.buffer);
        self.buffer.extend_from_slice(b"]}\n");
        self.output.write(&self.buffer)?;
        self.features += 1;
        self.objects += encoded.objects;
        self.extent = Extent::union(self.extent, encoded.extent);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Written> {
        let path = self.output.path().to_path_buf();
        let bytes = self.output.commit(&self.header.text(self.extent)?)?;
        let Self { features, objects, .. } = *self;
        Ok(Written { path, format: Format::CityJsonSeq, features, objects, bytes, notes: Vec::new() })
    }
}
