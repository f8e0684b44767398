//! CityJSONSeq: a line for the head, then a `CityJSONFeature` a line (CityJSON 2.0, section 9).

use std::path::Path;

use super::header::Metadata;
use super::output::Output;
use super::sequence::Sequence;
use super::{Format, Sink, Written};
use crate::building::Building;
use crate::error::Result;

/// Writes a feature a building.
pub(super) struct CityJsonSeq {
    output: Output,
    sequence: Sequence,
    buildings: usize,
}

impl CityJsonSeq {
    /// Opens a sink for `path`.
    pub(super) fn create(path: &Path, metadata: Metadata, overwrite: bool, scratch: Option<&Path>) -> Result<Self> {
        let sequence = Sequence::new(metadata)?;
        let mut output = Output::create(path, overwrite, scratch)?;
        output.write(&sequence.head()?)?;
        output.write(b"\n")?;
        Ok(Self { output, sequence, buildings: 0 })
    }
}

impl Sink for CityJsonSeq {
    fn write(&mut self, building: &Building) -> Result<()> {
        self.output.write(self.sequence.feature(building)?)?;
        self.output.write(b"\n")?;
        self.buildings += 1;
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Written> {
        let Self { output, sequence, buildings } = *self;
        let path = output.path().to_path_buf();
        let bytes = output.commit(&sequence.head()?)?;
        Ok(Written { path, format: Some(Format::CityJsonSeq), buildings, objects: sequence.objects(), bytes })
    }
}
