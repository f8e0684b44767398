//! `filters.decimation`: keeps every so many-th point.

use crate::error::Result;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{Chosen, Points};
use crate::pipeline::stage::{Filter, Flow, Role, Stage, StageKind};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.decimation",
    summary: "Keeps every so many-th point of each set that comes in",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    vec![
        OptionSpec::new(
            "step",
            Kind::at_least(1.0),
            "Distance from one kept point to the next; 2 keeps every second, 1.6 keeps 62.5 of 100",
        )
        .or(1.0),
        OptionSpec::new("offset", Kind::count(), "Number of the first point that is kept, from 0").or(0),
        OptionSpec::new("limit", Kind::count(), "Number of the point from which on none is kept"),
    ]
}

#[expect(clippy::unnecessary_wraps, reason = "the type of all stages")]
fn build(values: &Values) -> Result<Stage> {
    Ok(Stage::Filter(Box::new(Decimation {
        step: values.number("step").unwrap_or(1.0),
        offset: values.whole("offset").unwrap_or(0),
        limit: values.whole("limit").unwrap_or(u64::MAX),
        seen: 0,
        kept: 0,
    })))
}

struct Decimation {
    step: f64,
    offset: u64,
    limit: u64,
    seen: u64,
    kept: u64,
}

impl Decimation {
    /// Whether the next point is kept.
    fn keeps(&mut self) -> bool {
        // The number of the next point that is kept; halves are rounded away from zero, as PDAL does.
        let next = self.offset.saturating_add((self.kept as f64 * self.step).round() as u64);
        let keeps = self.seen == next && self.seen < self.limit;
        self.seen += 1;
        self.kept += u64::from(keeps);
        keeps
    }

    fn restart(&mut self) {
        (self.seen, self.kept) = (0, 0);
    }
}

impl Filter for Decimation {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.restart();
        if self.offset > 0 || self.limit < u64::MAX {
            // Nobody knows where the points lie that are left out at the ends.
            flow.areas = None;
        }
        Ok(())
    }

    fn chunk(&mut self, points: &mut Points, chosen: &Chosen) -> Result<()> {
        points.retain_of(chosen, |_, _| self.keeps());
        Ok(())
    }

    fn end_view(&mut self) {
        self.restart();
    }
}
