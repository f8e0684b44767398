//! Telling ground from everything else: what the stages that do have in common.
//!
//! | module | holds |
//! |---|---|
//! | [`raster`] | heights in cells |
//! | [`morphology`] | the filter of Pingel et al. (2013) |
//! | [`cloth`] | the filter of Zhang et al. (2016) |
//! | this one | which points take part, and the classes that they get |

pub(super) mod cloth;
pub(super) mod morphology;
mod raster;

use super::expression::Misfit;
use super::options::{Kind, OptionSpec, Place, Values};
use super::points::{NumberType, Points};
use super::range::{Range, Ranges};
use super::returns::{Group, Returns};
use super::stage::{Context, Flow};
use crate::error::{Error, Result};

/// The cells that a raster may have: more would not fit into memory.
const MOST_CELLS: f64 = 1e8;

/// Why ground was not told.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Failure {
    /// Somebody said to stop.
    Interrupted,
    /// The points lie too far apart for cells of this size: there would be so many.
    TooManyCells(f64),
}

/// Tells which of some points, all finite and one at least, are ground; asks now and then whether to stop.
pub(super) type Method<'a> = dyn Fn(&[[f64; 3]], &(dyn Fn() -> bool + Sync)) -> Result<Vec<bool>, Failure> + 'a;

/// The flags of points that can be left out, by their names in options.
const FLAGS: [(&str, &str); 3] = [("synthetic", "Synthetic"), ("keypoint", "KeyPoint"), ("withheld", "Withheld")];

/// The options of all such stages but the flags.
pub(super) fn options() -> Vec<OptionSpec> {
    vec![
        OptionSpec::new(
            "ignore",
            Kind::Texts,
            "Ranges of dimensions, such as Classification[7:7]; points in them take no part and keep their class",
        ),
        OptionSpec::new(
            "returns",
            Kind::Names,
            "Which echoes take part: first (of several), intermediate, last (of several), only; the others keep their \
             class. Without a name all do",
        )
        .or(vec!["last", "only"]),
        OptionSpec::new("ground_class", Kind::whole(0, 255), "Class of ground points").or(2),
        OptionSpec::new("other_class", Kind::whole(0, 255), "Class of the other points that take part").or(1),
        OptionSpec::new("only_ground", Kind::Boolean, "Whether the others keep the class that they had").or(false),
    ]
}

/// The option for flags.
pub(super) fn flags_option() -> OptionSpec {
    let help = "Flags of points that take no part: synthetic, keypoint, withheld";
    OptionSpec::new("classbits", Kind::Names, help)
}

/// A stage that gives ground points their class.
pub(super) struct Classifier {
    values: Values,
    name: &'static str,
    ignored: Vec<Range>,
    groups: Vec<Group>,
    /// The dimensions that mark points which take no part.
    flags: Vec<&'static str>,
    ground: f64,
    /// The class of the others; `None` leaves them theirs.
    other: Option<f64>,
    bound: Option<Bound>,
}

/// Where everything stands.
struct Bound {
    class: usize,
    ignored: Ranges,
    has_ignored: bool,
    returns: Option<Returns>,
    flags: Vec<usize>,
}

impl Classifier {
    /// Of the stage called `name`.
    ///
    /// # Errors
    /// Options that contradict one another, or cannot be understood.
    pub fn new(name: &'static str, values: &Values) -> Result<Self> {
        let ignored = values.texts("ignore").join(",");
        let ignored = if ignored.is_empty() { Ok(Vec::new()) } else { Range::parse_list(&ignored) };
        let ignored = ignored.map_err(|m| values.misfit("ignore", m))?;
        let groups = Group::parse_list(&values.texts("returns")).map_err(|m| values.misfit("returns", m))?;
        let mut flags = Vec::new();
        for name in values.texts("classbits") {
            let flag = FLAGS.iter().find(|(own, _)| own.eq_ignore_ascii_case(name));
            let misfit = || Misfit::new(format!("`{name}`"), "synthetic, keypoint and withheld, parted by commas");
            flags.push(flag.ok_or_else(|| values.misfit("classbits", misfit()))?.1);
        }
        let class = |option: &str| values.number(option).unwrap_or_default();
        let (ground, other) = (class("ground_class"), class("other_class"));
        let other = (!values.is_on("only_ground")).then_some(other);
        if other == Some(ground) {
            let found = format!("{ground} as `ground_class` and as `other_class`");
            return Err(values.place().fault(found, "two classes, or `only_ground`").into());
        }
        Ok(Self { values: values.clone(), name, ignored, groups, flags, ground, other, bound: None })
    }

    /// Finds the dimensions; makes that of the class.
    ///
    /// # Errors
    /// A dimension of `ignore` that is missing.
    pub fn prepare(&mut self, flow: &mut Flow) -> Result<()> {
        let ignored = Ranges::bind(&self.ignored, &flow.layout).map_err(|m| self.values.misfit("ignore", m))?;
        let flags = self.flags.iter().filter_map(|name| flow.layout.find(name)).collect();
        let returns = Returns::of_layout(&flow.layout).ok().filter(|_| !self.groups.is_empty());
        let class = flow.layout.add("Classification", NumberType::U8);
        self.bound = Some(Bound { class, ignored, has_ignored: !self.ignored.is_empty(), returns, flags });
        Ok(())
    }

    /// The points that take part.
    fn partakers(&self, bound: &Bound, points: &Points, context: &Context<'_>) -> Result<Vec<usize>> {
        let mut partakers: Vec<usize> = (0..points.len())
            .filter(|&i| !(bound.has_ignored && bound.ignored.hold(points, i)))
            .filter(|&i| bound.flags.iter().all(|&flag| points.get(flag, i) == 0.0))
            .collect();
        let Some(returns) = bound.returns else {
            if !self.groups.is_empty() {
                context.warn(&format!("{}: points do not say which echoes they are, so all take part", self.name));
            }
            return Ok(partakers);
        };
        let without = partakers.iter().filter(|&&i| returns.numbers(points, i).contains(&0.0)).count();
        let is_blank = partakers.iter().all(|&i| returns.numbers(points, i) == [0.0; 2]);
        if is_blank {
            context.warn(&format!("{}: the numbers of all echoes are 0, so all points take part", self.name));
        } else if without > 0 {
            let found =
                format!("{without} points whose ReturnNumber or NumberOfReturns is 0, and others that have them");
            let fault = self.values.place().fault(found, "numbers from 1 on everywhere, or nowhere");
            return Err(fault.remedy("Give `returns` as an empty text, so that all points take part").into());
        } else {
            partakers.retain(|&i| returns.group(points, i).is_some_and(|group| self.groups.contains(&group)));
        }
        Ok(partakers)
    }

    /// Gives the points of a view their classes by a method. `cell` is the option for the size of its cells.
    ///
    /// # Errors
    /// Coordinates that are not finite, no point that takes part, too many cells, or an interruption.
    pub fn classify(&self, points: &mut Points, context: &Context<'_>, cell: &str, method: &Method<'_>) -> Result<()> {
        let Some(bound) = &self.bound else { return Ok(()) };
        let place: &Place = self.values.place();
        let positions = points.finite_positions().map_err(|i| place.not_finite(i))?;
        let partakers = self.partakers(bound, points, context)?;
        if partakers.is_empty() {
            let expected = "some that take part";
            let fault = place.fault(format!("none of {} points that takes part", points.len()), expected);
            return Err(fault.remedy("`returns`, `ignore` and `classbits` say which do").into());
        }
        let taking_part: Vec<[f64; 3]> = partakers.iter().map(|&i| positions[i]).collect();
        let is_ground = match method(&taking_part, &|| context.observer.interrupted()) {
            Ok(is_ground) => is_ground,
            Err(Failure::Interrupted) => return Err(Error::Interrupted),
            Err(Failure::TooManyCells(cells)) => {
                let found = format!("points so far apart that they would need {cells:.0} cells");
                let fault = place.fault(found, format!("{MOST_CELLS:.0} at most"));
                let remedy = format!(
                    "Drop points that have gone astray (filters.outlier, filters.crop), part the points \
                     (filters.splitter), or enlarge `{cell}`"
                );
                return Err(fault.remedy(remedy).into());
            }
        };
        for (i, is_ground) in partakers.into_iter().zip(is_ground) {
            let class = if is_ground { Some(self.ground) } else { self.other };
            if let Some(class) = class {
                // A class fits by the table of the options.
                let _ = points.column_mut(bound.class).set(i, class);
            }
        }
        Ok(())
    }
}
