//! Heights above ground points: what the stages that give points theirs have in common.

use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::options::{Kind, OptionSpec, Values};
use super::points::{NumberType, Points};
use super::stage::{Context, Flow};
use crate::error::{Error, Result};

/// The dimension that such a stage makes.
const HEIGHT: &str = "HeightAboveGround";
/// Points between two looks at whether to stop.
const BLOCK: usize = 1 << 14;

/// The ground points of a view, in the plan.
pub(super) struct GroundPoints {
    /// Their x and y.
    pub places: Vec<[f64; 2]>,
    /// Their z.
    pub heights: Vec<f64>,
    tree: ImmutableKdTree<f64, 2>,
    low: [f64; 2],
    high: [f64; 2],
}

/// A ground point near a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Near {
    /// The square of its distance in the plan.
    pub square: f64,
    /// Its number among the ground points.
    pub item: usize,
}

impl GroundPoints {
    /// Those of a class; `None` when there is none.
    fn of(points: &Points, place: usize, class: f64) -> Option<Self> {
        let ground: Vec<usize> = (0..points.len()).filter(|&i| points.get(place, i) == class).collect();
        let places: Vec<[f64; 2]> = ground.iter().map(|&i| [points.get(0, i), points.get(1, i)]).collect();
        let heights = ground.iter().map(|&i| points.get(2, i)).collect();
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for place in &places {
            for axis in 0..2 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis]);
            }
        }
        let tree = ImmutableKdTree::new_from_slice(&places).ok().filter(|_| !places.is_empty())?;
        Some(Self { places, heights, tree, low, high })
    }

    /// The nearest to a place, nearest first.
    fn near(&self, place: [f64; 2], count: NonZero<usize>) -> Vec<Near> {
        let found = self.tree.query(&place).nearest_n::<SquaredEuclidean<f64>>(count).execute();
        let mut near: Vec<Near> =
            found.into_iter().map(|hit| Near { square: hit.distance, item: hit.item as usize }).collect();
        near.sort_unstable_by(|a, b| a.square.total_cmp(&b.square).then(a.item.cmp(&b.item)));
        near
    }

    fn is_around(&self, place: [f64; 2]) -> bool {
        (0..2).all(|axis| self.low[axis] <= place[axis] && place[axis] <= self.high[axis])
    }
}

/// The height of the ground at a place from ground points near it, nearest first, of which there are two at least and none
/// at the place itself; `None` where nothing is known.
pub(super) type GroundAt<'a> = dyn Fn(&GroundPoints, [f64; 2], &[Near]) -> Option<f64> + Sync + 'a;

/// Gives points their height above ground.
pub(super) struct Heights {
    values: Values,
    name: &'static str,
    count: usize,
    extrapolates: bool,
    class: f64,
    /// The places of the class and of the height.
    places: [usize; 2],
}

/// The option for points outside.
pub(super) fn extrapolation_option(help: &str) -> OptionSpec {
    OptionSpec::new("allow_extrapolation", Kind::Boolean, help).or(true)
}

/// The option for the class of ground points.
pub(super) fn class_option() -> OptionSpec {
    OptionSpec::new("class", Kind::whole(0, 255), "Class of ground points").or(2)
}

impl Heights {
    /// Of the stage called `name`, by its options `count`, `allow_extrapolation` and `class`.
    pub fn new(name: &'static str, values: &Values) -> Self {
        Self {
            values: values.clone(),
            name,
            count: usize::try_from(values.whole("count").unwrap_or(1)).unwrap_or(usize::MAX),
            extrapolates: values.is_on("allow_extrapolation"),
            class: values.number("class").unwrap_or_default(),
            places: [0; 2],
        }
    }

    /// Makes the dimension.
    ///
    /// # Errors
    /// Points have no class.
    pub fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        let class = flow
            .layout
            .require("Classification")
            .map_err(|known| self.values.place().fault("points without the dimension `Classification`", known))?;
        self.places = [class, flow.layout.add(HEIGHT, NumberType::F64)];
        Ok(())
    }

    /// Gives all points of a view their height; ground points have 0, as points have for which nothing is known.
    ///
    /// # Errors
    /// Coordinates that are not finite, or an interruption.
    pub fn give(&self, points: &mut Points, context: &Context<'_>, ground_at: &GroundAt<'_>) -> Result<()> {
        let [class, height] = self.places;
        let positions = points.finite_positions().map_err(|i| self.values.place().not_finite(i))?;
        let ground = GroundPoints::of(points, class, self.class);
        let wanted = ground.as_ref().and_then(|ground| NonZero::new(self.count.min(ground.places.len())));
        let (Some(ground), Some(wanted)) = (ground, wanted) else {
            let class = self.class;
            context.warn(&format!("{}: no point is of class {class}, so all heights above ground are 0", self.name));
            return Ok(());
        };
        let above = |i: usize| {
            if points.get(class, i) == self.class {
                return 0.0;
            }
            let [x, y, z] = positions[i];
            let near = ground.near([x, y], wanted);
            let at = match near.as_slice() {
                [] => None,
                // There is one at this very place, or only one that counts.
                [nearest] => Some(ground.heights[nearest.item]),
                [nearest, ..] if nearest.square == 0.0 => Some(ground.heights[nearest.item]),
                _ if !self.extrapolates && !ground.is_around([x, y]) => None,
                near => ground_at(&ground, [x, y], near),
            };
            at.map_or(0.0, |at| z - at)
        };
        let mut heights = Vec::with_capacity(points.len());
        while heights.len() < points.len() {
            if context.observer.interrupted() {
                return Err(Error::Interrupted);
            }
            let block = heights.len()..(heights.len() + BLOCK).min(points.len());
            heights.extend(block.into_par_iter().map(above).collect::<Vec<f64>>());
        }
        for (i, above) in heights.into_iter().enumerate() {
            // A double fits into the double that was made, and into any other type that it had, or stays as it was.
            let _ = points.column_mut(height).set(i, above);
        }
        Ok(())
    }
}
