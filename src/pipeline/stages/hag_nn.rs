//! `filters.hag_nn`: the height of points above the ground points nearest to them.

use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::error::Result;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{NumberType, Points};
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

/// The dimension that it makes.
const HEIGHT: &str = "HeightAboveGround";

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
        OptionSpec::new(
            "allow_extrapolation",
            Kind::Boolean,
            "With several: whether points outside the box around all ground points get a height, not 0",
        )
        .or(true),
        OptionSpec::new("class", Kind::whole(0, 255), "Class of ground points").or(2),
    ]
}

#[expect(clippy::unnecessary_wraps, reason = "the type of all stages")]
fn build(values: &Values) -> Result<Stage> {
    let count = usize::try_from(values.whole("count").unwrap_or(1)).unwrap_or(usize::MAX);
    Ok(Stage::Whole(Box::new(HeightAboveGround {
        values: values.clone(),
        count,
        furthest: values.number("max_distance").unwrap_or_default(),
        extrapolates: values.is_on("allow_extrapolation"),
        class: values.number("class").unwrap_or_default(),
        places: [0; 2],
    })))
}

struct HeightAboveGround {
    values: Values,
    count: usize,
    furthest: f64,
    extrapolates: bool,
    class: f64,
    /// The places of the class and of the height above ground.
    places: [usize; 2],
}

impl HeightAboveGround {
    /// The height of the ground at a place; `near` are its ground points with their squared distances, nearest first.
    /// `None` where nothing is known.
    fn ground(&self, near: &[(f64, f64)], is_inside: bool) -> Option<f64> {
        let (nearest, at) = *near.first()?;
        // There is one at this very place, or only one that counts.
        if nearest == 0.0 || near.len() == 1 {
            return Some(at);
        }
        if !is_inside && !self.extrapolates {
            return None;
        }
        let limit = if self.furthest > 0.0 { self.furthest * self.furthest } else { f64::INFINITY };
        let near = near.iter().take_while(|(square, _)| *square <= limit);
        let (weights, sum) = near.fold((0.0, 0.0), |(weights, sum), (square, height)| {
            let weight = 1.0 / square;
            (weights + weight, sum + weight * height)
        });
        (weights > 0.0).then(|| sum / weights)
    }
}

impl Whole for HeightAboveGround {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        let class = flow
            .layout
            .require("Classification")
            .map_err(|known| self.values.place().fault("points without the dimension `Classification`", known))?;
        self.places = [class, flow.layout.add(HEIGHT, NumberType::F64)];
        Ok(())
    }

    fn view(&mut self, mut points: Points, context: &Context<'_>) -> Result<Vec<Points>> {
        let [class, height] = self.places;
        points.finite_positions().map_err(|i| self.values.place().not_finite(i))?;
        let ground: Vec<usize> = (0..points.len()).filter(|&i| points.get(class, i) == self.class).collect();
        let plan = |i: usize| [points.get(0, i), points.get(1, i)];
        let places: Vec<[f64; 2]> = ground.iter().map(|&i| plan(i)).collect();
        let tree = ImmutableKdTree::<f64, 2>::new_from_slice(&places).ok();
        let (Some(tree), Some(wanted)) = (tree, NonZero::new(self.count.min(places.len()))) else {
            context.warn(&format!(
                "filters.hag_nn: no point is of class {}, so all heights above ground are 0",
                self.class
            ));
            return Ok(vec![points]);
        };
        let heights: Vec<f64> = ground.iter().map(|&i| points.get(2, i)).collect();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for place in &places {
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
        }
        for i in 0..points.len() {
            let above = if points.get(class, i) == self.class {
                0.0
            } else {
                let place = [points.get(0, i), points.get(1, i)];
                let mut found = tree.query(&place).nearest_n::<SquaredEuclidean<f64>>(wanted).execute();
                found.sort_unstable_by(|a, b| a.distance.total_cmp(&b.distance).then(a.item.cmp(&b.item)));
                let near: Vec<(f64, f64)> =
                    found.into_iter().map(|hit| (hit.distance, heights[hit.item as usize])).collect();
                let is_inside = (0..2).all(|axis| low[axis] <= place[axis] && place[axis] <= high[axis]);
                self.ground(&near, is_inside).map_or(0.0, |ground| points.get(2, i) - ground)
            };
            // A double fits into the double that was made, and into any other type that it had, or stays as it was.
            let _ = points.column_mut(height).set(i, above);
        }
        Ok(vec![points])
    }
}
