//! `filters.assign`: gives dimensions new values.

use crate::error::{InputError, Result};
use crate::pipeline::expression::{Assignment, Condition, Misfit, Number};
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{Chosen, NumberType, Points, usual_type};
use crate::pipeline::range::{Range, Ranges};
use crate::pipeline::stage::{Filter, Flow, Role, Stage, StageKind};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.assign",
    summary: "Gives dimensions new values, and makes dimensions",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    vec![
        OptionSpec::new(
            "value",
            Kind::Texts,
            "Assignments in their order, such as `Classification = 2 WHERE HeightAboveGround < 0.5`; a dimension that is \
             missing is made",
        ),
        OptionSpec::new(
            "assignment",
            Kind::Texts,
            "Older form: a range and the value that its dimension gets within it, such as Classification[:]=2",
        ),
        OptionSpec::new(
            "condition",
            Kind::Text,
            "Older form: the range within which `assignment` acts, such as Z[0:10]",
        ),
    ]
}

fn build(values: &Values) -> Result<Stage> {
    let mut steps = Vec::new();
    for text in values.texts("assignment") {
        // The older form takes several, parted by commas.
        let mut rest = text;
        loop {
            let (range, after) = Range::parse(rest).map_err(|m| values.misfit("assignment", m))?;
            let (value, after) = assigned(after).map_err(|m| values.misfit("assignment", m))?;
            steps.push(Step::Range { range, value });
            match after {
                Some(after) => rest = after,
                None => break,
            }
        }
    }
    for text in values.texts("value") {
        steps.push(Step::Assignment(Assignment::parse(text).map_err(|m| values.misfit("value", m))?));
    }
    if steps.is_empty() {
        return Err(values.place().fault("neither `value` nor `assignment`", "what is to be assigned").into());
    }
    let condition = values.text("condition").map(Range::parse_list).transpose();
    let condition = condition.map_err(|m| values.misfit("condition", m))?;
    Ok(Stage::Filter(Box::new(AssignFilter {
        values: values.clone(),
        steps,
        condition,
        bound: Vec::new(),
        within: None,
    })))
}

/// What stands behind a range: `=`, a number, and perhaps a comma and more.
fn assigned(text: &str) -> Result<(f64, Option<&str>), Misfit> {
    let fault = || Misfit::new(format!("`{}` behind a range", text.trim()), "`=` and a number");
    let rest = text.trim_start().strip_prefix('=').ok_or_else(fault)?;
    let (number, rest) = rest.split_once(',').map_or((rest, None), |(number, rest)| (number, Some(rest)));
    Ok((number.trim().parse().map_err(|_| fault())?, rest))
}

enum Step {
    Assignment(Assignment),
    Range { range: Range, value: f64 },
}

/// An assignment whose dimensions are known.
struct Bound {
    place: usize,
    value: Number<usize>,
    condition: Option<Condition<usize>>,
    range: Option<Ranges>,
}

struct AssignFilter {
    values: Values,
    steps: Vec<Step>,
    condition: Option<Vec<Range>>,
    bound: Vec<Bound>,
    within: Option<Ranges>,
}

impl Filter for AssignFilter {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        let fault = |m: Misfit| self.values.misfit("value", m);
        let within = self.condition.as_ref().map(|ranges| Ranges::bind(ranges, &flow.layout)).transpose();
        self.within = within.map_err(|m| self.values.misfit("condition", m))?;
        let mut bound = Vec::with_capacity(self.steps.len());
        for step in &self.steps {
            bound.push(match step {
                Step::Assignment(Assignment { dimension, value, condition }) => {
                    // The value may not use the dimension that it makes, but later assignments may.
                    let value = value.bind(&flow.layout).map_err(fault)?;
                    let place = flow.layout.add(dimension, usual_type(dimension));
                    let condition = condition.as_ref().map(|c| c.bind(&flow.layout)).transpose().map_err(fault)?;
                    Bound { place, value, condition, range: None }
                }
                Step::Range { range, value } => {
                    let ranges = Ranges::bind(std::slice::from_ref(range), &flow.layout)
                        .map_err(|m| self.values.misfit("assignment", m))?;
                    let place = flow.layout.add(&range.dimension, NumberType::F64);
                    Bound { place, value: Number::Constant(*value), condition: None, range: Some(ranges) }
                }
            });
        }
        self.bound = bound;
        Ok(())
    }

    fn chunk(&mut self, points: &mut Points, chosen: &Chosen) -> Result<()> {
        for bound in &self.bound {
            for i in 0..points.len() {
                let is_meant = chosen.has(i)
                    && self.within.as_ref().is_none_or(|ranges| ranges.hold(points, i))
                    && bound.range.as_ref().is_none_or(|ranges| ranges.hold(points, i))
                    && bound.condition.as_ref().is_none_or(|condition| condition.holds(points, i));
                if !is_meant {
                    continue;
                }
                let value = bound.value.at(points, i);
                if !points.column_mut(bound.place).set(i, value) {
                    return Err(unfit(&self.values, points, bound.place, value).into());
                }
            }
        }
        Ok(())
    }
}

/// The refusal of a value that the type of a dimension does not reach.
fn unfit(values: &Values, points: &Points, place: usize, value: f64) -> InputError {
    let dimension = &points.layout().dimensions()[place];
    let expected = format!("values of the type {}, which {} has", dimension.kind, dimension.name);
    values.place().fault(format!("the value {value} for {}", dimension.name), expected)
}
