//! `filters.sample`: thins points so that none lies nearer to another than a radius.

use std::collections::HashMap;

use crate::error::Result;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{Chosen, NumberType, Points};
use crate::pipeline::stage::{Filter, Flow, Role, Stage, StageKind};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.sample",
    summary: "Thins points so that none lies nearer to another than a radius (Poisson sampling)",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    let origin = |axis: &str| {
        let help =
            format!("{axis} of a corner of the cubes by which neighbours are found; the result does not hang on it");
        OptionSpec::new(format!("origin_{}", axis.to_lowercase()), Kind::number(), help)
    };
    vec![
        OptionSpec::new("radius", Kind::number(), "Smallest distance between points; or give `cell`"),
        OptionSpec::new(
            "cell",
            Kind::number(),
            "Edge of a cube around which `radius` makes a sphere; or give `radius`",
        ),
        OptionSpec::new(
            "dimension",
            Kind::Text,
            "Keep all points, and mark those of the sample with 1 in this dimension",
        ),
        origin("X"),
        origin("Y"),
        origin("Z"),
    ]
}

fn build(values: &Values) -> Result<Stage> {
    let radius = match (values.number("radius"), values.number("cell")) {
        (Some(radius), None) => radius,
        (None, Some(cell)) => cell / 2.0 * 3.0_f64.sqrt(),
        (Some(_), Some(_)) => {
            return Err(values.place().fault("both `radius` and `cell`", "one of them").into());
        }
        (None, None) => return Err(values.place().fault("neither `radius` nor `cell`", "one of them").into()),
    };
    if !(radius > 0.0 && radius.is_finite()) {
        return Err(values.place().fault(format!("a radius of {radius}"), "a number greater than 0").into());
    }
    let origin = ["origin_x", "origin_y", "origin_z"].map(|name| values.number(name));
    let dimension = values.text("dimension").map(str::to_owned);
    Ok(Stage::Filter(Box::new(SampleFilter {
        radius,
        given: origin,
        origin: None,
        dimension,
        mark: None,
        cubes: HashMap::new(),
    })))
}

struct SampleFilter {
    radius: f64,
    /// The origin of the cubes as far as it was given; the rest is that of the first point.
    given: [Option<f64>; 3],
    origin: Option<[f64; 3]>,
    dimension: Option<String>,
    /// The place of the dimension that is marked.
    mark: Option<usize>,
    /// The points that were kept, by the cube that they lie in.
    cubes: HashMap<[i64; 3], Vec<[f64; 3]>>,
}

impl SampleFilter {
    /// Keeps a point if none that was kept before lies nearer than the radius.
    fn keep(&mut self, position: [f64; 3]) -> bool {
        let origin = *self.origin.get_or_insert_with(|| std::array::from_fn(|i| self.given[i].unwrap_or(position[i])));
        // The edge is longer than the radius, so that all points nearer than it lie in the cubes around.
        let edge = 2.0 * self.radius / 3.0_f64.sqrt();
        let cube: [i64; 3] = std::array::from_fn(|i| ((position[i] - origin[i]) / edge).floor() as i64);
        let is_near = |other: &[f64; 3]| {
            let squared: f64 = (0..3).map(|i| (other[i] - position[i]).powi(2)).sum();
            squared < self.radius * self.radius
        };
        let taken = neighbours(cube).any(|cube| self.cubes.get(&cube).is_some_and(|points| points.iter().any(is_near)));
        if !taken {
            self.cubes.entry(cube).or_default().push(position);
        }
        !taken
    }
}

/// A cube and those around it, itself first.
fn neighbours([x, y, z]: [i64; 3]) -> impl Iterator<Item = [i64; 3]> {
    const STEPS: [i64; 3] = [0, -1, 1];
    let step = |n: i64, by: i64| n.saturating_add(by);
    STEPS.into_iter().flat_map(move |dx| {
        STEPS.into_iter().flat_map(move |dy| STEPS.into_iter().map(move |dz| [step(x, dx), step(y, dy), step(z, dz)]))
    })
}

impl Filter for SampleFilter {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.cubes.clear();
        self.origin = None;
        self.mark = self.dimension.as_ref().map(|name| flow.layout.add(name, NumberType::U8));
        Ok(())
    }

    fn chunk(&mut self, points: &mut Points, chosen: &Chosen) -> Result<()> {
        let kept: Vec<bool> = (0..points.len()).map(|i| !chosen.has(i) || self.keep(points.position(i))).collect();
        let Some(mark) = self.mark else {
            points.retain(&kept);
            return Ok(());
        };
        for (i, kept) in kept.into_iter().enumerate().filter(|(i, _)| chosen.has(*i)) {
            // 0 and 1 fit into every type.
            let _ = points.column_mut(mark).set(i, f64::from(u8::from(kept)));
        }
        Ok(())
    }
}
