//! `filters.outlier`: marks points that lie apart from others as noise.

use std::num::NonZero;

use kiddo::{ImmutableKdTree, SquaredEuclidean};
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use crate::error::Result;
use crate::pipeline::options::{Kind, OptionSpec, Place, Values};
use crate::pipeline::points::{NumberType, Points};
use crate::pipeline::stage::{Context, Flow, Role, Stage, StageKind, Whole};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "filters.outlier",
    summary: "Marks points that lie apart from others as noise",
    role: Role::Filter,
    options,
    elsewhere: &["option_file"],
    collects: "always",
    build,
};

fn options() -> Vec<OptionSpec> {
    let methods = Kind::choice(&[
        ("statistical", "points whose mean distance to their neighbours is large among those of all points"),
        ("radius", "points with few neighbours within a radius"),
    ]);
    vec![
        OptionSpec::new("method", methods, "How they are told").or("statistical"),
        OptionSpec::new("min_k", Kind::count(), "Radius: fewest neighbours of a point that is none").or(2),
        OptionSpec::new("radius", Kind::at_least(0.0), "Radius: within which neighbours count").or(1.0),
        OptionSpec::new("mean_k", Kind::count(), "Statistical: number of neighbours").or(8),
        OptionSpec::new(
            "multiplier",
            Kind::number(),
            "Statistical: how many standard deviations above the mean a distance is large",
        )
        .or(2.0),
        OptionSpec::new("class", Kind::whole(0, 255), "Class that they get").or(7),
        OptionSpec::new("threads", Kind::count(), "Taken for the sake of PDAL's files; all processors are used anyway"),
    ]
}

#[expect(clippy::unnecessary_wraps, reason = "the type of all stages")]
fn build(values: &Values) -> Result<Stage> {
    let count = |name: &str| usize::try_from(values.whole(name).unwrap_or(0)).unwrap_or(usize::MAX);
    let number = |name: &str| values.number(name).unwrap_or_default();
    let method = match values.text("method") {
        Some("radius") => Method::Radius { radius: number("radius"), least: count("min_k") },
        _ => Method::Statistical { neighbours: count("mean_k").max(1), multiplier: number("multiplier") },
    };
    Ok(Stage::Whole(Box::new(Outlier {
        method,
        class: number("class"),
        place_of_stage: values.place().clone(),
        place: 0,
    })))
}

#[derive(Clone, Copy)]
enum Method {
    Statistical { neighbours: usize, multiplier: f64 },
    Radius { radius: f64, least: usize },
}

struct Outlier {
    method: Method,
    class: f64,
    place_of_stage: Place,
    /// The place of the class.
    place: usize,
}

impl Method {
    /// Which points lie apart.
    fn outliers(self, positions: &[[f64; 3]]) -> Vec<bool> {
        let wanted = match self {
            Self::Statistical { neighbours, .. } => neighbours,
            Self::Radius { least, .. } => least,
        };
        // The point itself comes first.
        let wanted = wanted.saturating_add(1).min(positions.len());
        let (Ok(tree), Some(wanted)) = (ImmutableKdTree::<f64, 3>::new_from_slice(positions), NonZero::new(wanted))
        else {
            return vec![false; positions.len()];
        };
        let squares = |position: &[f64; 3]| -> Vec<f64> {
            let found = tree.query(position).nearest_n::<SquaredEuclidean<f64>>(wanted).execute();
            let mut squares: Vec<f64> = found.into_iter().map(|hit| hit.distance).collect();
            squares.sort_unstable_by(f64::total_cmp);
            squares
        };
        match self {
            Self::Radius { radius, least } => {
                let is_apart = |position: &[f64; 3]| {
                    squares(position).iter().filter(|square| **square < radius * radius).count() <= least
                };
                positions.par_iter().map(is_apart).collect()
            }
            Self::Statistical { multiplier, .. } => {
                let mean = |position: &[f64; 3]| {
                    let squares = squares(position);
                    let others = squares.get(1..).unwrap_or_default();
                    others.iter().map(|square| square.sqrt()).sum::<f64>() / others.len().max(1) as f64
                };
                let means: Vec<f64> = positions.par_iter().map(mean).collect();
                let count = means.len() as f64;
                let mean = means.iter().sum::<f64>() / count;
                let variance = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>() / (count - 1.0);
                let threshold = mean + multiplier * variance.sqrt();
                means.into_iter().map(|mean| mean >= threshold).collect()
            }
        }
    }
}

impl Whole for Outlier {
    fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        self.place = flow.layout.add("Classification", NumberType::U8);
        Ok(())
    }

    fn view(&mut self, mut points: Points, context: &Context<'_>) -> Result<Vec<Points>> {
        let positions = points.finite_positions().map_err(|i| self.place_of_stage.not_finite(i))?;
        let outliers = self.method.outliers(&positions);
        if outliers.iter().all(|&is_outlier| is_outlier) {
            context.warn("filters.outlier: all points would be noise, so none was marked; a wider radius may help");
            return Ok(vec![points]);
        }
        for i in (0..points.len()).filter(|&i| outliers[i]) {
            // A class fits by the table of the options.
            let _ = points.column_mut(self.place).set(i, self.class);
        }
        Ok(vec![points])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Eleven points on a line one apart, and one ten further on.
    fn line() -> Vec<[f64; 3]> {
        (0..11).map(|i| [f64::from(i), 0.0, 0.0]).chain([[20.0, 0.0, 0.0]]).collect()
    }

    #[test]
    fn few_neighbours_within_the_radius() {
        let marked = |radius, least| {
            let outliers = Method::Radius { radius, least }.outliers(&line());
            (0..12).filter(|&i| outliers[i]).collect::<Vec<usize>>()
        };
        // Neighbours at exactly the radius do not count.
        assert_eq!(marked(1.0, 1).len(), 12);
        assert_eq!(marked(1.5, 1), [11]);
        assert_eq!(marked(1.5, 2), [0, 10, 11]);
        assert_eq!(marked(10.5, 1), Vec::<usize>::new());
    }

    #[test]
    fn large_mean_distances() {
        // Two neighbours: means of 1 in the line, 1.5 at its ends, 10.5 at the point apart. The mean of the twelve is
        // (9 + 3 + 10.5) / 12 = 1.875 and their standard deviation 2.722: above 4.6 with a multiplier of 1.
        let outliers = Method::Statistical { neighbours: 2, multiplier: 1.0 }.outliers(&line());
        assert_eq!((0..12).filter(|&i| outliers[i]).collect::<Vec<_>>(), [11]);
        // 1.875 + 3.3 × 2.722 = 10.86.
        let outliers = Method::Statistical { neighbours: 2, multiplier: 3.3 }.outliers(&line());
        assert!(outliers.iter().all(|is_outlier| !is_outlier));
    }
}
