//! CityJSONSeq: a line for the head, then a `CityJSONFeature` a line (CityJSON 2.0, section 9).

use std::path::Path;

use super::header::{Header, Metadata};
use super::objects::{Extent, Ids, encode};
use super::output::Output;
use super::vertices::{Vertices, write_json};
use super::{Format, Sink, Written};
use crate::building::Building;
use crate::error::Result;

/// Writes a feature a building; nothing of a building stays in memory but the hash of its id.
pub(super) struct CityJsonSeq {
    output: Output,
    header: Header,
    ids: Ids,
    vertices: Vertices,
    extent: Option<Extent>,
    buildings: usize,
    objects: usize,
    buffer: Vec<u8>,
}

impl CityJsonSeq {
    /// Opens a sink for `path`.
    pub(super) fn create(path: &Path, metadata: Metadata, overwrite: bool, scratch: Option<&Path>) -> Result<Self> {
        let mut header = Header::new(path, metadata)?;
        let mut output = Output::create(path, overwrite, scratch)?;
        output.write(&header.text(None)?)?;
        output.write(b",\"CityObjects\":{},\"vertices\":[]}\n")?;
        let ids = header.take_ids();
        Ok(Self {
            output,
            header,
            ids,
            vertices: Vertices::default(),
            extent: None,
            buildings: 0,
            objects: 0,
            buffer: Vec::new(),
        })
    }
}

impl Sink for CityJsonSeq {
    fn write(&mut self, building: &Building) -> Result<()> {
        let fault = |output: &Output, e: serde_json::Error| output.fault("write", e.into());
        self.buffer.clear();
        self.vertices.clear();
        self.buffer.extend_from_slice(br#"{"type":"CityJSONFeature","id":"#);
        serde_json::to_writer(&mut self.buffer, &building.id).map_err(|e| fault(&self.output, e))?;
        self.buffer.extend_from_slice(br#","CityObjects":{"#);
        let encoded = encode(building, self.header.metadata(), &mut self.ids, &mut self.vertices, &mut self.buffer)
            .map_err(|e| fault(&self.output, e))?;
        self.buffer.extend_from_slice(br#"},"vertices":["#);
        write_json(&self.vertices.take_fresh(), &mut self.buffer);
        self.buffer.extend_from_slice(b"]}\n");
        self.output.write(&self.buffer)?;
        self.buildings += 1;
        self.objects += encoded.objects;
        self.extent = Extent::union(self.extent, encoded.extent);
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Written> {
        let path = self.output.path().to_path_buf();
        let bytes = self.output.commit(&self.header.text(self.extent)?)?;
        let Self { buildings, objects, .. } = *self;
        Ok(Written { path, format: Format::CityJsonSeq, buildings, objects, bytes })
    }
}
