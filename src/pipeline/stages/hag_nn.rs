//! `filters.hag_nn`: the height of points above the ground points nearest to them.

use crate::error::Result;
use crate::pipeline::heights::{Heights, Near, class_option, extrapolation_option};
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::Points;
use crate::pipeline::stage::{Context, Flow, Role, Stage, StageKind, Whole};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.hag_nn",
    summary: "Gives points their height above the nearest ground points, as HeightAboveGround",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "always",
    build,
};

fn options() -> Vec<OptionSpec> {
    vec![
        OptionSpec::new(
            "count",
            Kind::whole(1, 1_000_000),
            "Number of ground points whose heights are averaged, nearer ones more",
        )
        .or(1),
        OptionSpec::new(
            "max_distance",
            Kind::number(),
            "With several: ground points further off do not count; 0 for no limit",
        )
        .or(0.0),
        extrapolation_option(
            "With several: whether points outside the box around all ground points get a height, not 0",
        ),
        class_option(),
    ]
}

#[expect(clippy::unnecessary_wraps, reason = "the type of all stages")]
fn build(values: &Values) -> Result<Stage> {
    let furthest = values.number("max_distance").unwrap_or_default();
    Ok(Stage::Whole(Box::new(HeightAboveGround { heights: Heights::new(KIND.name, values), furthest })))
}

struct HeightAboveGround {
    heights: Heights,
    furthest: f64,
}

impl Whole for HeightAboveGround {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.heights.prepare(flow)
    }

    fn view(&mut self, mut points: Points, context: &Context<'_>) -> Result<Vec<Points>> {
        let limit = if self.furthest > 0.0 { self.furthest * self.furthest } else { f64::INFINITY };
        self.heights.give(&mut points, context, &|ground, _, near: &[Near]| {
            let near = near.iter().take_while(|near| near.square <= limit);
            let (weights, sum) = near.fold((0.0, 0.0), |(weights, sum), near| {
                let weight = 1.0 / near.square;
                (weights + weight, sum + weight * ground.heights[near.item])
            });
            (weights > 0.0).then(|| sum / weights)
        })?;
        Ok(vec![points])
    }
}
