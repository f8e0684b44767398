//! `filters.expression`: keeps points that satisfy an expression.

use crate::error::Result;
use crate::pipeline::expression::Condition;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{Chosen, Points};
use crate::pipeline::stage::{Filter, Flow, Role, Stage, StageKind};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.expression",
    summary: "Keeps points that satisfy an expression",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    let help = "Expression over dimensions, such as `Classification == 6 && Z > 10`";
    vec![OptionSpec::new("expression", Kind::Text, help).required()]
}

fn build(values: &Values) -> Result<Stage> {
    let text = values.text("expression").unwrap_or_default();
    let condition = Condition::parse(text).map_err(|m| values.misfit("expression", m))?;
    Ok(Stage::Filter(Box::new(ExpressionFilter { values: values.clone(), condition, bound: None })))
}

struct ExpressionFilter {
    values: Values,
    condition: Condition,
    bound: Option<Condition<usize>>,
}

impl Filter for ExpressionFilter {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        let bound = self.condition.bind(&flow.layout).map_err(|m| self.values.misfit("expression", m))?;
        self.bound = Some(bound);
        Ok(())
    }

    fn chunk(&mut self, points: &mut Points, chosen: &Chosen) -> Result<()> {
        let Some(condition) = &self.bound else { return Ok(()) };
        points.retain_of(chosen, |points, i| condition.holds(points, i));
        Ok(())
    }
}
