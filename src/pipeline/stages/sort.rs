//! `filters.sort`: puts points into the order of their values.

use crate::error::Result;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::Points;
use crate::pipeline::stage::{Context, Flow, Role, Stage, StageKind, Whole};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.sort",
    summary: "Puts points into the order of the values of dimensions",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "always",
    build,
};

fn options() -> Vec<OptionSpec> {
    let orders = Kind::choice(&[("ASC", "the least first"), ("DESC", "the greatest first")]);
    let algorithms = Kind::choice(&[
        ("NORMAL", "in any order, which here is the one that they came in"),
        ("STABLE", "in the order that they came in"),
    ]);
    vec![
        OptionSpec::new(
            "dimensions",
            Kind::Names,
            "Sorts by each of them in turn, so that the last one named counts most, as in PDAL",
        )
        .required()
        .aliases(&["dimension"]),
        OptionSpec::new("order", orders, "Which end comes first").or("ASC"),
        OptionSpec::new("algorithm", algorithms, "How points of equal values stand").or("NORMAL"),
    ]
}

fn build(values: &Values) -> Result<Stage> {
    if values.texts("dimensions").is_empty() {
        return Err(values.fault("dimensions", "nothing", "names of dimensions").into());
    }
    let is_descending = values.text("order") == Some("DESC");
    Ok(Stage::Whole(Box::new(Sort { values: values.clone(), is_descending, places: Vec::new() })))
}

struct Sort {
    values: Values,
    is_descending: bool,
    /// The places of the dimensions, the one that counts most first.
    places: Vec<usize>,
}

impl Whole for Sort {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.places.clear();
        for name in self.values.texts("dimensions").into_iter().rev() {
            let missing = |known: String| self.values.fault("dimensions", &format!("the dimension `{name}`"), known);
            self.places.push(flow.layout.require(name).map_err(missing)?);
        }
        Ok(())
    }

    fn view(&mut self, points: Points, _context: &Context<'_>) -> Result<Vec<Points>> {
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by(|&i, &j| {
            let (i, j) = if self.is_descending { (j, i) } else { (i, j) };
            let compared = self.places.iter().map(|&place| points.column(place).compare(i, j));
            compared.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
        });
        Ok(vec![points.gather(&order)])
    }
}
