//! CityJSON 2.0: one object, one vertex list.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

use super::header::{Header, Metadata};
use super::json::{Extent, encode};
use super::output::Output;
use super::vertices::{Vertices, write_json};
use super::{Feature, Format, Sink, Written};
use crate::error::{InputError, Result};

/// Writes one CityJSON object.
///
/// `CityObjects` go to the file as they come, vertices to a spill file that is appended at the end. What stays in memory
/// is the table that merges vertices, about 30 bytes each.
pub(super) struct CityJson {
    output: Output,
    spill: BufWriter<File>,
    header: Header,
    vertices: Vertices,
    extent: Option<Extent>,
    features: usize,
    objects: usize,
    buffer: Vec<u8>,
}

impl CityJson {
    /// Opens a sink for `path`.
    pub(super) fn create(path: &Path, metadata: Metadata, overwrite: bool, scratch: Option<&Path>) -> Result<Self> {
        let header = Header::new(path, metadata)?;
        let mut output = Output::create(path, overwrite, scratch)?;
        let spill = output.spill()?;
        output.write(&header.text(None)?)?;
        output.write(br#","CityObjects":{"#)?;
        Ok(Self {
            output,
            spill,
            header,
            vertices: Vertices::default(),
            extent: None,
            features: 0,
            objects: 0,
            buffer: Vec::new(),
        })
    }
}

impl Sink for CityJson {
    fn write(&mut self, feature: &Feature) -> Result<()> {
        let is_first_vertex = self.vertices.len() == 0;
        self.buffer.clear();
        self.buffer.extend_from_slice(if self.features == 0 { b"\n" } else { b",\n" });
        let encoded = encode(feature, self.header.transform(), &mut self.vertices, &mut self.buffer)
            .map_err(|e| self.output.fault("write", e.into()))?;
        if u32::try_from(self.vertices.len()).is_err() {
            return Err(InputError::new(self.output.path(), "more than 2³² vertices", "fewer")
                .remedy("Write CityJSONSeq (.city.jsonl), which has no such limit.")
                .into());
        }
        self.output.write(&self.buffer)?;
        self.buffer.clear();
        let fresh = self.vertices.take_fresh();
        if !is_first_vertex && !fresh.is_empty() {
            self.buffer.push(b',');
        }
        write_json(&fresh, &mut self.buffer);
        self.spill.write_all(&self.buffer).map_err(|e| self.output.fault("write", e))?;
        self.features += 1;
        self.objects += encoded.objects;
        self.extent = Extent::union(self.extent, encoded.extent);
        Ok(())
    }

    fn finish(mut self: Box<Self>) -> Result<Written> {
        self.output.write(b"\n},\"vertices\":[")?;
        self.output.append(self.spill)?;
        self.output.write(b"]}\n")?;
        let path = self.output.path().to_path_buf();
        let bytes = self.output.commit(&self.header.text(self.extent)?)?;
        let Self { features, objects, .. } = *self;
        Ok(Written { path, format: Some(Format::CityJson), features, objects, bytes, notes: Vec::new() })
    }
}
