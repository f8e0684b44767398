//! `filters.returns`: parts points by which echo of their pulse they are.

use crate::error::Result;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{Chosen, Points};
use crate::pipeline::returns::{Group, Returns};
use crate::pipeline::stage::{Context, Filter, Flow, Role, Stage, StageKind, Whole};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.returns",
    summary: "Keeps points by which echo of their pulse they are, each group on its own",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "with more than one group, because each gives points of its own",
    build,
};

fn options() -> Vec<OptionSpec> {
    let help = "Which groups: first (of several), intermediate, last (of several), only";
    vec![OptionSpec::new("groups", Kind::Names, help).or(vec!["last"])]
}

fn build(values: &Values) -> Result<Stage> {
    let groups = Group::parse_list(&values.texts("groups")).map_err(|m| values.misfit("groups", m))?;
    if groups.is_empty() {
        return Err(values.fault("groups", "nothing", "first, intermediate, last or only").into());
    }
    let is_one = groups.len() == 1;
    let filter = ReturnsFilter { values: values.clone(), groups, returns: None };
    Ok(if is_one { Stage::Filter(Box::new(filter)) } else { Stage::Whole(Box::new(filter)) })
}

struct ReturnsFilter {
    values: Values,
    groups: Vec<Group>,
    returns: Option<Returns>,
}

impl ReturnsFilter {
    fn bind(&mut self, flow: &Flow) -> Result<()> {
        let fault =
            |misfit: crate::pipeline::expression::Misfit| self.values.place().fault(misfit.found, misfit.expected);
        self.returns = Some(Returns::of_layout(&flow.layout).map_err(fault)?);
        Ok(())
    }
}

impl Filter for ReturnsFilter {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.bind(flow)
    }

    fn chunk(&mut self, points: &mut Points, chosen: &Chosen) -> Result<()> {
        let Some(returns) = self.returns else { return Ok(()) };
        points
            .retain_of(chosen, |points, i| returns.group(points, i).is_some_and(|group| self.groups.contains(&group)));
        Ok(())
    }
}

impl Whole for ReturnsFilter {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.bind(flow)
    }

    fn view(&mut self, points: Points, context: &Context<'_>) -> Result<Vec<Points>> {
        let Some(returns) = self.returns else { return Ok(vec![points]) };
        let groups: Vec<Option<Group>> = (0..points.len()).map(|i| returns.group(&points, i)).collect();
        let mut views = Vec::new();
        for group in &self.groups {
            let places: Vec<usize> = (0..points.len()).filter(|&i| groups[i] == Some(*group)).collect();
            if places.is_empty() {
                context.warn(&format!("filters.returns: no point is of the group `{}`", group.name()));
            } else {
                views.push(points.gather(&places));
            }
        }
        Ok(views)
    }
}
