//! `filters.ferry`: copies dimensions.

use crate::error::Result;
use crate::pipeline::expression::Misfit;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{Chosen, Points, usual_type};
use crate::pipeline::stage::{Filter, Flow, Role, Stage, StageKind};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.ferry",
    summary: "Copies dimensions to others, and makes dimensions",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    let help =
        "What goes where, such as `Z=>Height, =>Mark`; a dimension that is missing is made, without a source as zero";
    vec![OptionSpec::new("dimensions", Kind::Names, help).required()]
}

fn build(values: &Values) -> Result<Stage> {
    let mut pairs = Vec::new();
    for text in values.texts("dimensions") {
        // The older form has `=` for `=>`.
        let pair = text.split_once("=>").or_else(|| text.split_once('='));
        let pair = pair.map(|(from, to)| (from.trim(), to.trim()));
        let is_name = |name: &str| name.chars().all(|c| c.is_alphanumeric() || c == '_');
        let Some((from, to)) = pair.filter(|(from, to)| is_name(from) && is_name(to) && !to.is_empty()) else {
            let misfit = Misfit::new(format!("`{text}`"), "`FROM=>TO` or `=>TO`, parted by commas");
            return Err(values.misfit("dimensions", misfit).into());
        };
        pairs.push(((!from.is_empty()).then(|| from.to_owned()), to.to_owned()));
    }
    Ok(Stage::Filter(Box::new(FerryFilter { values: values.clone(), pairs, bound: Vec::new() })))
}

struct FerryFilter {
    values: Values,
    pairs: Vec<(Option<String>, String)>,
    bound: Vec<(usize, usize)>,
}

impl Filter for FerryFilter {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.bound.clear();
        for (from, to) in &self.pairs {
            let Some(from) = from else {
                flow.layout.add(to, usual_type(to));
                continue;
            };
            let place = flow.layout.require(from).map_err(|known| {
                let misfit = Misfit::new(format!("the dimension `{from}`, which the points lack"), known);
                self.values.misfit("dimensions", misfit)
            })?;
            // A copy has the type of its source, unless its name says otherwise, so that identifiers stay whole.
            let own = flow.layout.dimensions()[place].kind;
            let kind = if usual_type(to) == usual_type("") { own } else { usual_type(to) };
            self.bound.push((place, flow.layout.add(to, kind)));
        }
        Ok(())
    }

    fn chunk(&mut self, points: &mut Points, chosen: &Chosen) -> Result<()> {
        for &(from, to) in &self.bound {
            if matches!(chosen, Chosen::All) && points.column(from).kind() == points.column(to).kind() {
                let copy = points.column(from).clone();
                *points.column_mut(to) = copy;
                continue;
            }
            for i in (0..points.len()).filter(|&i| chosen.has(i)) {
                let value = points.get(from, i);
                if !points.column_mut(to).set(i, value) {
                    let to = &points.layout().dimensions()[to];
                    let expected = format!("values of the type {}, which {} has", to.kind, to.name);
                    return Err(self
                        .values
                        .place()
                        .fault(format!("the value {value} for {}", to.name), expected)
                        .into());
                }
            }
        }
        Ok(())
    }
}
