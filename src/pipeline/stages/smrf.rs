//! `filters.smrf`: tells ground by the simple morphological filter.

use crate::error::Result;
use crate::pipeline::ground::morphology::Morphology;
use crate::pipeline::ground::{self, Classifier};
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::Points;
use crate::pipeline::stage::{Context, Flow, Role, Stage, StageKind, Whole};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.smrf",
    summary: "Gives ground points class 2 by a morphological filter (Pingel et al. 2013)",
    role: Role::Filter,
    options,
    elsewhere: &["dir", "option_file"],
    collects: "always",
    build,
};

/// The least side of a cell: a tenth of a millimetre.
const SMALLEST: f64 = 1e-4;
/// Cells of the window where none is given.
const WINDOW: f64 = 18.0;

fn options() -> Vec<OptionSpec> {
    let not_negative = || Kind::at_least(0.0);
    let mut options = vec![
        OptionSpec::new("cell", Kind::at_least(SMALLEST), "Side of a cell, CRS units").or(1.0),
        OptionSpec::new("slope", not_negative(), "Slope of the steepest terrain, rise over run").or(0.15),
        OptionSpec::new(
            "window",
            not_negative(),
            "Radius of the largest window, CRS units: what is twice as wide is taken for terrain; 18 cells when not given",
        ),
        OptionSpec::new(
            "scalar",
            not_negative(),
            "How much further a point may lie from the terrain where that is steep: this times its slope",
        )
        .or(1.25),
        OptionSpec::new("threshold", not_negative(), "How far a point may lie from flat terrain and be ground").or(0.5),
        OptionSpec::new(
            "cut",
            not_negative(),
            "Mesh of a net of low heights by which buildings larger than the window fall apart; 0 for none",
        )
        .or(0.0),
    ];
    options.extend(ground::options());
    options.push(ground::flags_option());
    options
}

fn build(values: &Values) -> Result<Stage> {
    let number = |name: &str| values.number(name).unwrap_or_default();
    let cell = number("cell");
    let method = Morphology {
        cell,
        slope: number("slope"),
        window: values.number("window").unwrap_or(WINDOW * cell),
        scalar: number("scalar"),
        threshold: number("threshold"),
        cut: number("cut"),
    };
    let classifier = Classifier::new(KIND.name, values)?;
    Ok(Stage::Whole(Box::new(Smrf { classifier, method })))
}

struct Smrf {
    classifier: Classifier,
    method: Morphology,
}

impl Whole for Smrf {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.classifier.prepare(flow)
    }

    fn view(&mut self, mut points: Points, context: &Context<'_>) -> Result<Vec<Points>> {
        self.classifier
            .classify(&mut points, context, "cell", &|positions, stop| self.method.ground(positions, stop))?;
        Ok(vec![points])
    }
}
