//! `filters.tail`: keeps the last points of each set.

use crate::error::Result;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::Points;
use crate::pipeline::stage::{Context, Flow, Role, Stage, StageKind, Whole};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.tail",
    summary: "Keeps the last points of each set that comes in",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "always",
    build,
};

fn options() -> Vec<OptionSpec> {
    vec![
        OptionSpec::new("count", Kind::count(), "How many").or(10),
        OptionSpec::new("invert", Kind::Boolean, "Whether these are dropped, and the others kept").or(false),
    ]
}

#[expect(clippy::unnecessary_wraps, reason = "the type of all stages")]
fn build(values: &Values) -> Result<Stage> {
    let count = usize::try_from(values.whole("count").unwrap_or(0)).unwrap_or(usize::MAX);
    Ok(Stage::Whole(Box::new(Tail { count, drops: values.is_on("invert") })))
}

struct Tail {
    count: usize,
    /// Whether the last points are dropped, not kept.
    drops: bool,
}

impl Whole for Tail {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        // Nobody knows where the points lie that are left out.
        flow.areas = None;
        Ok(())
    }

    fn view(&mut self, points: Points, _context: &Context<'_>) -> Result<Vec<Points>> {
        let start = points.len().saturating_sub(self.count);
        let range = if self.drops { 0..start } else { start..points.len() };
        Ok(vec![points.gather(&range.collect::<Vec<_>>())])
    }
}
