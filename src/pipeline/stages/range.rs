//! `filters.range`: keeps points whose dimensions lie within ranges.

use crate::error::Result;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{Chosen, Points};
use crate::pipeline::range::{Range, Ranges};
use crate::pipeline::stage::{Filter, Flow, Role, Stage, StageKind};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.range",
    summary: "Keeps points whose dimensions lie within ranges",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    let help = "Ranges such as Classification[2:2],Z(10:); of one dimension any must hold, of different ones all";
    vec![OptionSpec::new("limits", Kind::Texts, help).required()]
}

fn build(values: &Values) -> Result<Stage> {
    let ranges = Range::parse_list(&values.texts("limits").join(",")).map_err(|m| values.misfit("limits", m))?;
    Ok(Stage::Filter(Box::new(RangeFilter { values: values.clone(), ranges, bound: None })))
}

struct RangeFilter {
    values: Values,
    ranges: Vec<Range>,
    bound: Option<Ranges>,
}

impl Filter for RangeFilter {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        let bound = Ranges::bind(&self.ranges, &flow.layout).map_err(|m| self.values.misfit("limits", m))?;
        self.bound = Some(bound);
        Ok(())
    }

    fn chunk(&mut self, points: &mut Points, chosen: &Chosen) -> Result<()> {
        let Some(ranges) = &self.bound else { return Ok(()) };
        points.retain_of(chosen, |points, i| ranges.hold(points, i));
        Ok(())
    }
}
