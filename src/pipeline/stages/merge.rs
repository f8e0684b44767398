//! `filters.merge`: makes one set of points of all that come in.

use crate::error::Result;
use crate::pipeline::options::{OptionSpec, Values};
use crate::pipeline::stage::{Role, Stage, StageKind};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.merge",
    summary: "Makes one set of points of all that come in",
    role: Role::Filter,
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
    Ok(Stage::Merge)
}
