//! Expressions over the dimensions of a point: those of `where`, of `filters.expression` and of `filters.assign`.
//!
//! The grammar is PDAL's, a part of C: `|| && ! == != < <= > >= + - * /` and parentheses, over numbers and names of
//! dimensions. Everything is computed in doubles; conditions and numbers are never taken for one another.

mod parse;
#[cfg(test)]
mod tests;

use super::points::{Chosen, Layout, Points};

/// What stands where it should not.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Misfit {
    /// What was found, and where.
    pub found: String,
    /// What was expected.
    pub expected: String,
}

impl Misfit {
    /// A misfit.
    pub fn new(found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { found: found.into(), expected: expected.into() }
    }
}

/// A number computed from the dimensions of a point. `D` is how dimensions are called: by name, or, once they are
/// [bound](Number::bind), by their place in the layout.
#[derive(Debug, Clone, PartialEq)]
pub enum Number<D = String> {
    /// A constant.
    Constant(f64),
    /// The value of a dimension.
    Dimension(D),
    /// The opposite.
    Negated(Box<Self>),
    /// Two numbers and what is done with them.
    Both(Arithmetic, Box<[Self; 2]>),
}

/// What is done with two numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say all")]
pub enum Arithmetic {
    Plus,
    Minus,
    Times,
    Over,
}

/// A condition on the dimensions of a point.
#[derive(Debug, Clone, PartialEq)]
pub enum Condition<D = String> {
    /// Two numbers and how they must compare.
    Compare(Comparison, Box<[Number<D>; 2]>),
    /// The opposite.
    Not(Box<Self>),
    /// All of them.
    All(Vec<Self>),
    /// Any of them.
    Any(Vec<Self>),
}

/// How two numbers must compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say all")]
pub enum Comparison {
    Equal,
    NotEqual,
    Less,
    AtMost,
    Greater,
    AtLeast,
}

/// `Dimension = number [WHERE condition]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Assignment {
    /// The dimension that gets the value.
    pub dimension: String,
    /// The value.
    pub value: Number,
    /// Which points get it.
    pub condition: Option<Condition>,
}

impl Number {
    /// The same with dimensions by their place in `layout`.
    ///
    /// # Errors
    /// A dimension that is not there.
    pub fn bind(&self, layout: &Layout) -> Result<Number<usize>, Misfit> {
        Ok(match self {
            Self::Constant(value) => Number::Constant(*value),
            Self::Dimension(name) => Number::Dimension(bind(name, layout)?),
            Self::Negated(inner) => Number::Negated(Box::new(inner.bind(layout)?)),
            Self::Both(what, sides) => {
                let [left, right] = &**sides;
                Number::Both(*what, Box::new([left.bind(layout)?, right.bind(layout)?]))
            }
        })
    }
}

impl Number<usize> {
    /// Its value at point `i`.
    pub fn at(&self, points: &Points, i: usize) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Dimension(place) => points.get(*place, i),
            Self::Negated(inner) => -inner.at(points, i),
            Self::Both(what, sides) => {
                let [left, right] = sides.each_ref().map(|side| side.at(points, i));
                match what {
                    Arithmetic::Plus => left + right,
                    Arithmetic::Minus => left - right,
                    Arithmetic::Times => left * right,
                    Arithmetic::Over => left / right,
                }
            }
        }
    }
}

impl Condition {
    /// Reads a condition, such as `Classification == 6 && Z > 10`.
    ///
    /// # Errors
    /// Where it cannot be understood, and what was expected there.
    pub fn parse(text: &str) -> Result<Self, Misfit> {
        parse::condition(text)
    }

    /// The same with dimensions by their place in `layout`.
    ///
    /// # Errors
    /// A dimension that is not there.
    pub fn bind(&self, layout: &Layout) -> Result<Condition<usize>, Misfit> {
        let all = |parts: &[Self]| parts.iter().map(|part| part.bind(layout)).collect::<Result<Vec<_>, _>>();
        Ok(match self {
            Self::Compare(how, sides) => {
                let [left, right] = &**sides;
                Condition::Compare(*how, Box::new([left.bind(layout)?, right.bind(layout)?]))
            }
            Self::Not(inner) => Condition::Not(Box::new(inner.bind(layout)?)),
            Self::All(parts) => Condition::All(all(parts)?),
            Self::Any(parts) => Condition::Any(all(parts)?),
        })
    }
}

impl Condition<usize> {
    /// Whether point `i` satisfies it.
    pub fn holds(&self, points: &Points, i: usize) -> bool {
        match self {
            Self::Compare(how, sides) => {
                let [left, right] = sides.each_ref().map(|side| side.at(points, i));
                match how {
                    Comparison::Equal => left == right,
                    Comparison::NotEqual => left != right,
                    Comparison::Less => left < right,
                    Comparison::AtMost => left <= right,
                    Comparison::Greater => left > right,
                    Comparison::AtLeast => left >= right,
                }
            }
            Self::Not(inner) => !inner.holds(points, i),
            Self::All(parts) => parts.iter().all(|part| part.holds(points, i)),
            Self::Any(parts) => parts.iter().any(|part| part.holds(points, i)),
        }
    }

    /// The points that satisfy it.
    pub fn choose(&self, points: &Points) -> Chosen {
        Chosen::Some((0..points.len()).map(|i| self.holds(points, i)).collect())
    }
}

impl Assignment {
    /// Reads an assignment, such as `Classification = 2 WHERE HeightAboveGround < 0.5`.
    ///
    /// # Errors
    /// Where it cannot be understood, and what was expected there.
    pub fn parse(text: &str) -> Result<Self, Misfit> {
        parse::assignment(text)
    }
}

fn bind(name: &str, layout: &Layout) -> Result<usize, Misfit> {
    layout.require(name).map_err(|known| Misfit::new(format!("the dimension `{name}`, which the points lack"), known))
}
