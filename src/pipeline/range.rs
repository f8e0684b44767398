//! Ranges of dimensions, such as `Classification[2:2], Z(10:)`: those of `filters.range` and `filters.assign`.

use super::expression::Misfit;
use super::points::{Layout, Points};

/// The values of a dimension between two limits.
#[derive(Debug, Clone, PartialEq)]
pub struct Range {
    /// The dimension.
    pub dimension: String,
    limits: Limits,
}

#[derive(Debug, Clone, Copy, PartialEq)]
struct Limits {
    negated: bool,
    low: f64,
    low_inclusive: bool,
    high: f64,
    high_inclusive: bool,
}

impl Limits {
    fn has(&self, value: f64) -> bool {
        // Not a number is in no range; outside every one, then, when the range is negated, as in PDAL.
        let above = if self.low_inclusive { value >= self.low } else { value > self.low };
        let below = if self.high_inclusive { value <= self.high } else { value < self.high };
        (above && below) != self.negated
    }
}

impl Range {
    /// Reads one range; gives what stands behind it too.
    ///
    /// # Errors
    /// What was found where it cannot be understood.
    pub fn parse(text: &str) -> Result<(Self, &str), Misfit> {
        let expected = "a range such as Classification[2:2], Z(10:) or Intensity![0:5)";
        let fault = || Misfit::new(format!("`{}`", text.trim()), expected);
        let text = text.trim_start();
        let open = text.find(['[', '(']).ok_or_else(fault)?;
        let name = text[..open].trim();
        let (name, negated) = name.strip_suffix('!').map_or((name, false), |name| (name.trim_end(), true));
        if name.is_empty() || !name.chars().all(|c| c.is_alphanumeric() || c == '_') {
            return Err(fault());
        }
        let inside = &text[open + 1..];
        let close = inside.find([']', ')']).ok_or_else(fault)?;
        let (low, high) = inside[..close].split_once(':').ok_or_else(fault)?;
        let limit = |text: &str, none: f64| match text.trim() {
            "" => Ok(none),
            number => number.parse::<f64>().ok().filter(|value| !value.is_nan()).ok_or_else(fault),
        };
        let limits = Limits {
            negated,
            low: limit(low, f64::NEG_INFINITY)?,
            low_inclusive: text[open..].starts_with('['),
            high: limit(high, f64::INFINITY)?,
            high_inclusive: inside[close..].starts_with(']'),
        };
        Ok((Self { dimension: name.to_owned(), limits }, &inside[close + 1..]))
    }

    /// Reads ranges that are parted by commas.
    ///
    /// # Errors
    /// As [`Self::parse`].
    pub fn parse_list(text: &str) -> Result<Vec<Self>, Misfit> {
        let mut ranges = Vec::new();
        let mut rest = text;
        loop {
            let (range, after) = Self::parse(rest)?;
            ranges.push(range);
            match after.trim_start() {
                "" => return Ok(ranges),
                after => {
                    let expected = "a comma between two ranges";
                    rest = after.strip_prefix(',').ok_or_else(|| Misfit::new(format!("`{after}`"), expected))?;
                }
            }
        }
    }

    /// Whether the range holds a value.
    pub fn has(&self, value: f64) -> bool {
        self.limits.has(value)
    }
}

/// Ranges whose dimensions are known: those of one dimension are alternatives, those of different ones must all hold.
#[derive(Debug, Clone)]
pub struct Ranges(Vec<(usize, Vec<Limits>)>);

impl Ranges {
    /// Finds the dimensions.
    ///
    /// # Errors
    /// A dimension that is not there.
    pub fn bind(ranges: &[Range], layout: &Layout) -> Result<Self, Misfit> {
        let mut bound: Vec<(usize, Vec<Limits>)> = Vec::new();
        for range in ranges {
            let place = layout.require(&range.dimension).map_err(|known| {
                Misfit::new(format!("the dimension `{}`, which the points lack", range.dimension), known)
            })?;
            match bound.iter_mut().find(|(own, _)| *own == place) {
                Some((_, limits)) => limits.push(range.limits),
                None => bound.push((place, vec![range.limits])),
            }
        }
        Ok(Self(bound))
    }

    /// Whether point `i` is within them.
    pub fn hold(&self, points: &Points, i: usize) -> bool {
        self.0.iter().all(|(place, limits)| {
            let value = points.get(*place, i);
            limits.iter().any(|limits| limits.has(value))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn has(range: &str, values: [f64; 3]) -> [bool; 3] {
        let (range, rest) = Range::parse(range).unwrap();
        assert_eq!(rest, "");
        values.map(|value| range.has(value))
    }

    #[test]
    fn brackets_include_and_parentheses_do_not() {
        assert_eq!(has("Z[10:20]", [10.0, 15.0, 20.0]), [true, true, true]);
        assert_eq!(has("Z(10:20)", [10.0, 15.0, 20.0]), [false, true, false]);
        assert_eq!(has("Z[10:20)", [9.9, 10.0, 20.0]), [false, true, false]);
        assert_eq!(has("Z![10:20]", [9.9, 10.0, 20.1]), [true, false, true]);
        assert_eq!(has(" Z ( 10 : ]", [10.0, 10.1, 1e9]), [false, true, true]);
        assert_eq!(has("Z[:-2.5e1]", [-26.0, -25.0, -24.0]), [true, true, false]);
        assert_eq!(has("Red!(20:40]", [20.0, 30.0, 41.0]), [true, false, true]);
    }

    #[test]
    fn lists_are_parted_by_commas() {
        let names: Vec<String> = Range::parse_list("Classification[2:2], Z(10:),Classification[6:6]")
            .unwrap()
            .into_iter()
            .map(|range| range.dimension)
            .collect();
        assert_eq!(names, ["Classification", "Z", "Classification"]);
        for bad in ["", "Z", "Z[1]", "Z[1:2", "[1:2]", "Z[a:2]", "Z[1:2]Y[1:2]", "Z[1:2],", "Z[1:2] and X[1:2]"] {
            assert!(Range::parse_list(bad).is_err(), "{bad}");
        }
    }
}
