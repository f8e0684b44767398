//! `filters.csf`: tells ground by a cloth that is laid under the points.

use crate::error::Result;
use crate::pipeline::ground::cloth::ClothSimulation;
use crate::pipeline::ground::{self, Classifier};
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::Points;
use crate::pipeline::stage::{Context, Flow, Role, Stage, StageKind, Whole};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.csf",
    summary: "Gives ground points class 2 by the simulation of a cloth (Zhang et al. 2016)",
    role: Role::Filter,
    options,
    elsewhere: &["dir", "debug", "option_file"],
    collects: "always",
    build,
};

/// The least distance of nodes: a tenth of a millimetre.
const SMALLEST: f64 = 1e-4;

fn options() -> Vec<OptionSpec> {
    let mut options = vec![
        OptionSpec::new("resolution", Kind::at_least(SMALLEST), "Distance of the nodes of the cloth, CRS units")
            .or(1.0),
        OptionSpec::new(
            "rigidness",
            Kind::whole(1, 1000),
            "How stiff the cloth is: 1 for mountains, 2 for hills, 3 for plains; beyond 14 nothing changes",
        )
        .or(3),
        OptionSpec::new("step", Kind::Number { whole: false, limits: [0.01, 10.0] }, "Length of a step in time")
            .or(0.65),
        OptionSpec::new("threshold", Kind::at_least(0.0), "How far a point may lie from the cloth and be ground")
            .or(0.5),
        OptionSpec::new("smooth", Kind::Boolean, "Whether the cloth is laid onto slopes in the end").or(true),
        OptionSpec::new("iterations", Kind::count(), "Most steps").or(500),
        OptionSpec::new(
            "hdiff",
            Kind::at_least(0.0),
            "With `smooth`: by how much less the terrain rises from node to node where the cloth is laid onto it",
        )
        .or(0.3),
    ];
    options.extend(ground::options());
    options
}

fn build(values: &Values) -> Result<Stage> {
    let number = |name: &str| values.number(name).unwrap_or_default();
    let method = ClothSimulation {
        resolution: number("resolution"),
        rigidness: values.whole("rigidness").and_then(|times| u32::try_from(times).ok()).unwrap_or(1),
        step: number("step"),
        threshold: number("threshold"),
        smooth: values.is_on("smooth"),
        iterations: values.whole("iterations").unwrap_or(0),
        hdiff: number("hdiff"),
    };
    let classifier = Classifier::new(KIND.name, values)?;
    Ok(Stage::Whole(Box::new(Csf { classifier, method })))
}

struct Csf {
    classifier: Classifier,
    method: ClothSimulation,
}

impl Whole for Csf {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.classifier.prepare(flow)
    }

    fn view(&mut self, mut points: Points, context: &Context<'_>) -> Result<Vec<Points>> {
        let method = self.method;
        self.classifier
            .classify(&mut points, context, "resolution", &|positions, stop| method.ground(positions, stop))?;
        Ok(vec![points])
    }
}
