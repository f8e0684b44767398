//! `readers.las`: LAS and LAZ files, with all dimensions of their point formats and extra bytes.

use crate::error::Result;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::source::{TileReader, reader_options};
use crate::pipeline::stage::{Role, Stage, StageKind};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "readers.las",
    summary: "Reads LAS and LAZ files",
    role: Role::Reader,
    options,
    elsewhere: &[
        "extra_dims",
        "use_eb_vlr",
        "compression",
        "ignore_vlr",
        "ignore_missing_vlrs",
        "fix_dims",
        "threads",
        "header",
        "query",
        "srs_vlr_order",
        "option_file",
    ],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    let mut options = reader_options("LAS or LAZ file; a pattern such as tiles/*.laz stands for one reader per file");
    options.push(OptionSpec::new("start", Kind::count(), "Number of the first point that is read, from 0").or(0));
    options
}

fn build(values: &Values) -> Result<Stage> {
    Ok(Stage::Reader(Box::new(TileReader::new(values, Vec::new())?)))
}
