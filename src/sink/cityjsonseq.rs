//! CityJSONSeq: a line for the head, then a `CityJSONFeature` a line (CityJSON 2.0, section 9).

use std::path::Path;

use super::header::Metadata;
use super::output::Output;
use super::sequence::Sequence;
use super::{Feature, Format, Sink, Written};
use crate::error::Result;

/// Writes a line a feature, of which nothing stays in memory.
pub(super) struct CityJsonSeq {
    output: Output,
    sequence: Sequence,
    features: usize,
}

impl CityJsonSeq {
    /// Opens a sink for `path`.
    pub(super) fn create(path: &Path, metadata: Metadata, overwrite: bool, scratch: Option<&Path>) -> Result<Self> {
        let sequence = Sequence::new(metadata)?;
        let mut output = Output::create(path, overwrite, scratch)?;
        output.write(&sequence.head()?)?;
        output.write(b"\n")?;
        Ok(Self { output, sequence, features: 0 })
    }
}

impl Sink for CityJsonSeq {
    fn write(&mut self, feature: &Feature) -> Result<()> {
        self.output.write(self.sequence.feature(feature)?)?;
        self.output.write(b"\n")?;
        self.features += 1;
        Ok(())
    }

    fn finish(self: Box<Self>) -> Result<Written> {
        let Self { output, sequence, features } = *self;
        let path = output.path().to_path_buf();
        let bytes = output.commit(&sequence.head()?)?;
        let (format, objects) = (Some(Format::CityJsonSeq), sequence.objects());
        Ok(Written { path, format, features, objects, bytes, notes: Vec::new() })
    }
}
