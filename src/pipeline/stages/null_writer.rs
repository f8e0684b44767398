//! `writers.null`: writes nothing.

use crate::error::Result;
use crate::pipeline::options::{OptionSpec, Values};
use crate::pipeline::points::Points;
use crate::pipeline::stage::{Context, Finished, Flow, Role, Stage, StageKind, Writer};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "writers.null",
    summary: "Writes nothing, for pipelines whose metadata is what is wanted",
    role: Role::Writer,
    options,
    elsewhere: &["option_file"],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    Vec::new()
}

#[expect(clippy::unnecessary_wraps, reason = "the type of all stages")]
fn build(_values: &Values) -> Result<Stage> {
    Ok(Stage::Writer(Box::new(NullWriter)))
}

struct NullWriter;

impl Writer for NullWriter {
    fn prepare(&mut self, _flow: &Flow, _is_last: bool) -> Result<()> {
        Ok(())
    }

    fn write(&mut self, _points: &Points, _context: &Context<'_>) -> Result<()> {
        Ok(())
    }

    fn finish(&mut self, _context: &Context<'_>) -> Result<Finished> {
        Ok(Finished::default())
    }
}
