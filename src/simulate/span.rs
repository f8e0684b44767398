//! A value, or the span from which it is drawn.

use std::fmt;
use std::str::FromStr;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize};

use super::random::Random;

/// A fixed value such as `0.5`, or a span such as `0..2` from which every scan draws its own. It is text in JSON and on
/// the command line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Span {
    from: f64,
    to: f64,
}

impl Span {
    /// The span between two values, in any order. They must be finite and not negative; what is not becomes 0.
    pub fn new(from: f64, to: f64) -> Self {
        let [from, to] = [from, to].map(|v| if v.is_finite() { v.max(0.0) } else { 0.0 });
        Self { from: from.min(to), to: from.max(to) }
    }

    /// Always this value.
    pub fn fixed(value: f64) -> Self {
        Self::new(value, value)
    }

    /// The least value.
    pub fn least(&self) -> f64 {
        self.from
    }

    /// The largest value.
    pub fn most(&self) -> f64 {
        self.to
    }

    /// A value of it, all equally likely.
    pub(super) fn draw(&self, random: &mut Random) -> f64 {
        random.between(self.from, self.to)
    }

    /// A value of it, all magnitudes equally likely: the span of a density.
    pub(super) fn draw_magnitude(&self, random: &mut Random) -> f64 {
        let least = self.from.max(1e-6);
        least * (self.to.max(least) / least).powf(random.unit())
    }

    /// A whole number of it, both ends included.
    pub(super) fn draw_count(&self, random: &mut Random) -> usize {
        let [least, most] = [self.from.round() as usize, self.to.round() as usize];
        least + random.below(most - least + 1)
    }
}

impl FromStr for Span {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |text: &str| text.trim().parse::<f64>().ok().filter(|v| v.is_finite() && *v >= 0.0);
        let (from, to) = text.split_once("..").unwrap_or((text, text));
        match number(from).zip(number(to)) {
            Some((from, to)) if from <= to => Ok(Self { from, to }),
            _ => Err(format!("found '{text}', expected a number such as 0.5 or a span such as 0..2, not negative")),
        }
    }
}

impl fmt::Display for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.from == self.to { write!(f, "{}", self.from) } else { write!(f, "{}..{}", self.from, self.to) }
    }
}

impl TryFrom<String> for Span {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Span> for String {
    fn from(span: Span) -> Self {
        span.to_string()
    }
}

impl JsonSchema for Span {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "Span".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        String::json_schema(generator)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_are_read_as_they_are_written() {
        for text in ["0.5", "0..2", "1..60", "0..0.005"] {
            assert_eq!(text.parse::<Span>().unwrap().to_string(), text);
        }
        assert_eq!(" 1 .. 2 ".parse::<Span>().unwrap(), Span::new(2.0, 1.0));
        for bad in ["", "2..1", "-1", "1..", "a", "nan", "inf", "1...2"] {
            assert!(bad.parse::<Span>().is_err(), "{bad}");
        }
    }

    #[test]
    fn draws_stay_inside_and_reach_both_ends() {
        let mut random = Random::new(1);
        let span = Span::new(1.0, 3.0);
        let counts: std::collections::BTreeSet<usize> = (0..100).map(|_| span.draw_count(&mut random)).collect();
        assert_eq!(counts.into_iter().collect::<Vec<_>>(), [1, 2, 3]);
        let magnitudes: Vec<f64> = (0..2000).map(|_| Span::new(1.0, 100.0).draw_magnitude(&mut random)).collect();
        let low = magnitudes.iter().filter(|&&m| m < 10.0).count();
        assert!((900..1100).contains(&low) && magnitudes.iter().all(|m| (1.0..=100.0).contains(m)));
        assert_eq!(Span::fixed(0.2).draw(&mut random), 0.2);
    }
}
