//! The attribute filter: one small part of SQL for all formats, with its three-valued logic.

mod parse;

#[cfg(test)]
mod tests;

use std::cmp::Ordering;
use std::path::Path;

use serde_json::{Map, Value};

use super::attributes::meant;
use super::{attribute, names};
use crate::error::{InputError, Result};

/// A parsed filter.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Filter {
    text: String,
    root: Expression,
    /// The attributes that it names.
    attributes: Vec<String>,
}

#[derive(Debug, Clone, PartialEq)]
enum Expression {
    And(Vec<Expression>),
    Or(Vec<Expression>),
    Not(Box<Expression>),
    Compare(Operand, Comparison, Operand),
    Like { operand: Operand, pattern: Vec<char>, ignore_case: bool },
    In(Operand, Vec<Operand>),
    IsNull(Operand),
}

#[derive(Debug, Clone, PartialEq)]
enum Operand {
    Attribute(String),
    Literal(Value),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Comparison {
    Equal,
    NotEqual,
    Less,
    LessOrEqual,
    Greater,
    GreaterOrEqual,
}

impl Filter {
    /// Parses a filter for the features of `path`.
    pub(super) fn parse(text: &str, path: &Path) -> Result<Self> {
        match parse::expression(text) {
            Ok(root) => {
                let mut attributes = Vec::new();
                root.attributes(&mut attributes);
                Ok(Self { text: text.to_string(), root, attributes })
            }
            Err(parse::Fault { at, found, expected }) => Err(InputError::new(path, found, expected)
                .at(format!("filter `{text}`, character {}", at + 1))
                .remedy("Write for example: status = 'in use' AND height > 3.5 AND NOT name IS NULL")
                .into()),
        }
    }

    /// Whether a feature passes; an attribute that it lacks is null, and *unknown* does not pass.
    pub(super) fn matches(&self, attributes: &Map<String, Value>) -> bool {
        self.root.evaluate(attributes) == Some(true)
    }

    /// Whether all attributes that it names are among `columns`.
    pub(super) fn check(&self, columns: &[String], path: &Path) -> Result<()> {
        for name in &self.attributes {
            if let Err(alike) = meant(name, columns) {
                let found = format!("no attribute `{name}`, but several that differ from it in case");
                return Err(InputError::new(path, found, "attributes that features have")
                    .at(format!("filter `{}`", self.text))
                    .remedy(format!("Write one of {}", alike.join(", ")))
                    .into());
            }
        }
        let unknown = self.attributes.iter().find(|name| !columns.iter().any(|c| c.eq_ignore_ascii_case(name)));
        match unknown {
            None => Ok(()),
            Some(name) => Err(InputError::new(path, format!("no attribute `{name}`"), "attributes that features have")
                .at(format!("filter `{}`", self.text))
                .remedy(format!(
                    "{} (text stands in 'single quotes')",
                    names::remedy(name, columns.iter().map(String::as_str))
                ))
                .into()),
        }
    }
}

impl Expression {
    fn evaluate(&self, attributes: &Map<String, Value>) -> Option<bool> {
        match self {
            Self::And(terms) => decide(false, terms.iter().map(|term| term.evaluate(attributes))),
            Self::Or(terms) => decide(true, terms.iter().map(|term| term.evaluate(attributes))),
            Self::Not(inner) => inner.evaluate(attributes).map(|truth| !truth),
            Self::Compare(a, comparison, b) => {
                let order = compare(a.value(attributes)?, b.value(attributes)?)?;
                Some(match comparison {
                    Comparison::Equal => order == Ordering::Equal,
                    Comparison::NotEqual => order != Ordering::Equal,
                    Comparison::Less => order == Ordering::Less,
                    Comparison::LessOrEqual => order != Ordering::Greater,
                    Comparison::Greater => order == Ordering::Greater,
                    Comparison::GreaterOrEqual => order != Ordering::Less,
                })
            }
            Self::Like { operand, pattern, ignore_case } => {
                let text = match operand.value(attributes)? {
                    Value::String(text) => text.clone(),
                    other => other.to_string(),
                };
                let text = if *ignore_case { text.to_lowercase() } else { text };
                Some(is_like(&text.chars().collect::<Vec<_>>(), pattern))
            }
            Self::In(operand, list) => {
                let value = operand.value(attributes)?;
                let is_equal = |item: &Operand| Some(compare(value, item.value(attributes)?)? == Ordering::Equal);
                decide(true, list.iter().map(is_equal))
            }
            Self::IsNull(operand) => Some(operand.value(attributes).is_none()),
        }
    }

    fn attributes(&self, names: &mut Vec<String>) {
        let mut operand = |operand: &Operand| {
            if let Operand::Attribute(name) = operand {
                names.push(name.clone());
            }
        };
        match self {
            Self::And(terms) | Self::Or(terms) => terms.iter().for_each(|term| term.attributes(names)),
            Self::Not(inner) => inner.attributes(names),
            Self::Compare(a, _, b) => {
                operand(a);
                operand(b);
            }
            Self::Like { operand: o, .. } | Self::IsNull(o) => operand(o),
            Self::In(o, list) => {
                operand(o);
                list.iter().for_each(operand);
            }
        }
    }
}

/// Three-valued OR (`winner` true) and AND (`winner` false): the winner wins, else *unknown* does.
fn decide(winner: bool, terms: impl Iterator<Item = Option<bool>>) -> Option<bool> {
    let mut is_known = true;
    for term in terms {
        if term == Some(winner) {
            return term;
        }
        is_known &= term.is_some();
    }
    is_known.then_some(!winner)
}

impl Operand {
    /// The value; `None` for null.
    fn value<'a>(&'a self, attributes: &'a Map<String, Value>) -> Option<&'a Value> {
        let value = match self {
            Self::Attribute(name) => attribute(attributes, name)?,
            Self::Literal(value) => value,
        };
        (!value.is_null()).then_some(value)
    }
}

/// The order of two values; numbers by value also where one of them stands as text; `None` where there is no order.
fn compare(a: &Value, b: &Value) -> Option<Ordering> {
    match (a, b) {
        (Value::String(a), Value::String(b)) => Some(a.cmp(b)),
        (Value::Bool(a), Value::Bool(b)) => Some(a.cmp(b)),
        _ => match (integer(a), integer(b)) {
            (Some(a), Some(b)) => Some(a.cmp(&b)),
            _ => number(a)?.partial_cmp(&number(b)?),
        },
    }
}

fn integer(value: &Value) -> Option<i128> {
    match value {
        Value::Number(n) => n.as_i64().map(i128::from).or_else(|| n.as_u64().map(i128::from)),
        Value::String(text) => text.trim().parse().ok(),
        Value::Bool(value) => Some(i128::from(*value)),
        _ => None,
    }
}

fn number(value: &Value) -> Option<f64> {
    match value {
        Value::Number(n) => n.as_f64(),
        Value::String(text) => text.trim().parse().ok(),
        Value::Bool(value) => Some(f64::from(u8::from(*value))),
        _ => None,
    }
}

/// SQL's `LIKE`: `%` is any text, `_` any character. Time at most the product of the lengths.
fn is_like(text: &[char], pattern: &[char]) -> bool {
    let (mut t, mut p) = (0, 0);
    let mut retry = None;
    while t < text.len() {
        match pattern.get(p) {
            Some('%') => {
                retry = Some((p, t));
                p += 1;
            }
            Some(&c) if c == '_' || c == text[t] => {
                t += 1;
                p += 1;
            }
            _ => {
                let Some((percent, start)) = retry else { return false };
                retry = Some((percent, start + 1));
                p = percent + 1;
                t = start + 1;
            }
        }
    }
    pattern[p..].iter().all(|&c| c == '%')
}
