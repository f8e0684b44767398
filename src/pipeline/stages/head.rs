//! `filters.head`: keeps the first points of each set.

use crate::error::Result;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{Chosen, Points};
use crate::pipeline::stage::{Filter, Flow, Role, Stage, StageKind};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.head",
    summary: "Keeps the first points of each set that comes in",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "",
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
    let count = values.whole("count").unwrap_or(0);
    Ok(Stage::Filter(Box::new(HeadFilter { count, drops: values.is_on("invert"), seen: 0 })))
}

struct HeadFilter {
    count: u64,
    /// Whether the first points are dropped, not kept.
    drops: bool,
    seen: u64,
}

impl Filter for HeadFilter {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.seen = 0;
        // Nobody knows where the points lie that are left out.
        flow.areas = None;
        Ok(())
    }

    fn chunk(&mut self, points: &mut Points, chosen: &Chosen) -> Result<()> {
        let mut kept = Vec::with_capacity(points.len());
        for i in 0..points.len() {
            let counts = chosen.has(i);
            kept.push(!counts || (self.seen < self.count) != self.drops);
            self.seen += u64::from(counts);
        }
        points.retain(&kept);
        Ok(())
    }

    fn end_view(&mut self) {
        self.seen = 0;
    }
}
