//! The attribute filter: one small part of SQL for all formats, with its three-valued logic.

use std::cmp::Ordering;
use std::path::Path;

use serde_json::{Map, Value};

use super::attribute;
use crate::error::{InputError, Result};

/// How deep parentheses and `NOT` may be nested.
const DEEPEST: usize = 64;

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
        let tokens = tokens(text).and_then(|tokens| {
            let mut parser = Parser { tokens: &tokens, next: 0, depth: 0, end: text.chars().count() };
            let root = parser.disjunction()?;
            parser.finish()?;
            Ok(root)
        });
        match tokens {
            Ok(root) => {
                let mut attributes = Vec::new();
                root.attributes(&mut attributes);
                Ok(Self { text: text.to_string(), root, attributes })
            }
            Err(Fault { at, found, expected }) => Err(InputError::new(path, found, expected)
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
        let unknown = self.attributes.iter().find(|name| !columns.iter().any(|c| c.eq_ignore_ascii_case(name)));
        match unknown {
            None => Ok(()),
            Some(name) => Err(InputError::new(path, format!("no attribute `{name}`"), "attributes that features have")
                .at(format!("filter `{}`", self.text))
                .remedy(format!("There are: {} (text stands in 'single quotes')", columns.join(", ")))
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

/// What is wrong, and at which character.
struct Fault {
    at: usize,
    found: String,
    expected: String,
}

impl Fault {
    fn new(at: usize, found: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { at, found: found.into(), expected: expected.into() }
    }
}

#[derive(Debug, Clone, PartialEq)]
enum Token {
    /// A bare word: a keyword or an attribute.
    Word(String),
    /// An attribute in double quotes.
    Quoted(String),
    Literal(Value),
    Comparison(Comparison),
    Open,
    Close,
    Comma,
}

/// Splits a filter into tokens, each with the place of its first character.
fn tokens(text: &str) -> Result<Vec<(usize, Token)>, Fault> {
    let chars: Vec<char> = text.chars().collect();
    let mut tokens = Vec::new();
    let mut at = 0;
    while let Some(&c) = chars.get(at) {
        let start = at;
        let token = match c {
            c if c.is_whitespace() => {
                at += 1;
                continue;
            }
            '(' => Token::Open,
            ')' => Token::Close,
            ',' => Token::Comma,
            '\'' | '"' => {
                let (word, end) = quoted(&chars, at)?;
                at = end - 1;
                if c == '"' { Token::Quoted(word) } else { Token::Literal(Value::String(word)) }
            }
            '=' | '!' | '<' | '>' => {
                let (comparison, length) = match (c, chars.get(at + 1)) {
                    ('=', Some('=')) => (Comparison::Equal, 2),
                    ('=', _) => (Comparison::Equal, 1),
                    ('!', Some('=')) | ('<', Some('>')) => (Comparison::NotEqual, 2),
                    ('<', Some('=')) => (Comparison::LessOrEqual, 2),
                    ('>', Some('=')) => (Comparison::GreaterOrEqual, 2),
                    ('<', _) => (Comparison::Less, 1),
                    ('>', _) => (Comparison::Greater, 1),
                    _ => return Err(Fault::new(at, "`!`", "`!=`")),
                };
                at += length - 1;
                Token::Comparison(comparison)
            }
            c if c.is_ascii_digit() || matches!(c, '-' | '+' | '.') => {
                let in_number = |i: usize| {
                    let c = chars[i];
                    c.is_ascii_alphanumeric() || c == '.' || (matches!(c, '-' | '+') && matches!(chars[i - 1], 'e' | 'E'))
                };
                let end = (at + 1..chars.len()).find(|&i| !in_number(i)).unwrap_or(chars.len());
                let word: String = chars[at..end].iter().collect();
                at = end - 1;
                let number = parse_number(&word).ok_or_else(|| Fault::new(start, format!("`{word}`"), "a number"))?;
                Token::Literal(number)
            }
            c if c.is_alphabetic() || c == '_' => {
                let in_word = |&c: &char| c.is_alphanumeric() || matches!(c, '_' | '.' | ':' | '-');
                let word: String = chars[at..].iter().copied().take_while(in_word).collect();
                at += word.chars().count() - 1;
                Token::Word(word)
            }
            other => return Err(Fault::new(at, format!("`{other}`"), "an attribute, a value or an operator")),
        };
        tokens.push((start, token));
        at += 1;
    }
    Ok(tokens)
}

/// The text in quotes that begins at `start` and the place after it; a doubled quote stands for one.
fn quoted(chars: &[char], start: usize) -> Result<(String, usize), Fault> {
    let quote = chars[start];
    let mut word = String::new();
    let mut at = start + 1;
    while let Some(&c) = chars.get(at) {
        at += 1;
        if c != quote {
            word.push(c);
        } else if chars.get(at) == Some(&quote) {
            word.push(quote);
            at += 1;
        } else {
            return Ok((word, at));
        }
    }
    Err(Fault::new(start, format!("{quote} without its end"), format!("a closing {quote}")))
}

fn parse_number(word: &str) -> Option<Value> {
    if let Ok(integer) = word.parse::<i64>() {
        return Some(integer.into());
    }
    if let Ok(integer) = word.parse::<u64>() {
        return Some(integer.into());
    }
    let is_plain = word.bytes().all(|b| b.is_ascii_digit() || matches!(b, b'.' | b'-' | b'+' | b'e' | b'E'));
    let number = if is_plain { word.parse::<f64>().ok()? } else { return None };
    serde_json::Number::from_f64(number).map(Value::Number)
}

/// Recursive descent: disjunction of conjunctions of negations of predicates.
struct Parser<'a> {
    tokens: &'a [(usize, Token)],
    next: usize,
    depth: usize,
    end: usize,
}

impl Parser<'_> {
    fn disjunction(&mut self) -> Result<Expression, Fault> {
        let mut terms = vec![self.conjunction()?];
        while self.keyword("OR") {
            terms.push(self.conjunction()?);
        }
        Ok(if terms.len() == 1 { terms.remove(0) } else { Expression::Or(terms) })
    }

    fn conjunction(&mut self) -> Result<Expression, Fault> {
        let mut terms = vec![self.negation()?];
        while self.keyword("AND") {
            terms.push(self.negation()?);
        }
        Ok(if terms.len() == 1 { terms.remove(0) } else { Expression::And(terms) })
    }

    fn negation(&mut self) -> Result<Expression, Fault> {
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(Fault::new(self.place(), "too deep a nesting", format!("at most {DEEPEST} levels")));
        }
        let expression = if self.keyword("NOT") {
            Expression::Not(Box::new(self.negation()?))
        } else if self.take(&Token::Open) {
            let inner = self.disjunction()?;
            if !self.take(&Token::Close) {
                return Err(self.unexpected("`)`"));
            }
            inner
        } else {
            self.predicate()?
        };
        self.depth -= 1;
        Ok(expression)
    }

    fn predicate(&mut self) -> Result<Expression, Fault> {
        let operand = self.operand()?;
        if let Some((_, Token::Comparison(comparison))) = self.tokens.get(self.next) {
            self.next += 1;
            return Ok(Expression::Compare(operand, *comparison, self.operand()?));
        }
        if self.keyword("IS") {
            let negated = self.keyword("NOT");
            if !self.keyword("NULL") {
                return Err(self.unexpected("NULL"));
            }
            return Ok(negate_if(negated, Expression::IsNull(operand)));
        }
        let negated = self.keyword("NOT");
        let ignore_case = self.keyword("ILIKE");
        if ignore_case || self.keyword("LIKE") {
            let Some((_, Token::Literal(Value::String(pattern)))) = self.tokens.get(self.next) else {
                return Err(self.unexpected("a pattern such as 'A%'"));
            };
            self.next += 1;
            let pattern = if ignore_case { pattern.to_lowercase() } else { pattern.clone() };
            let pattern = pattern.chars().collect();
            return Ok(negate_if(negated, Expression::Like { operand, pattern, ignore_case }));
        }
        if self.keyword("IN") {
            if !self.take(&Token::Open) {
                return Err(self.unexpected("`(`"));
            }
            let mut list = vec![self.operand()?];
            while self.take(&Token::Comma) {
                list.push(self.operand()?);
            }
            if !self.take(&Token::Close) {
                return Err(self.unexpected("`,` or `)`"));
            }
            return Ok(negate_if(negated, Expression::In(operand, list)));
        }
        Err(self.unexpected("a comparison, LIKE, IN or IS NULL"))
    }

    fn operand(&mut self) -> Result<Operand, Fault> {
        let operand = match self.tokens.get(self.next) {
            Some((_, Token::Literal(value))) => Operand::Literal(value.clone()),
            Some((_, Token::Quoted(name))) => Operand::Attribute(name.clone()),
            Some((_, Token::Word(word))) => match word.to_ascii_uppercase().as_str() {
                "TRUE" => Operand::Literal(Value::Bool(true)),
                "FALSE" => Operand::Literal(Value::Bool(false)),
                "NULL" => Operand::Literal(Value::Null),
                "AND" | "OR" | "NOT" | "IN" | "IS" | "LIKE" | "ILIKE" => {
                    return Err(self.unexpected("an attribute or a value"));
                }
                _ => Operand::Attribute(word.clone()),
            },
            _ => return Err(self.unexpected("an attribute or a value")),
        };
        self.next += 1;
        Ok(operand)
    }

    fn keyword(&mut self, keyword: &str) -> bool {
        let is_next = matches!(self.tokens.get(self.next), Some((_, Token::Word(w))) if w.eq_ignore_ascii_case(keyword));
        self.next += usize::from(is_next);
        is_next
    }

    fn take(&mut self, token: &Token) -> bool {
        let is_next = self.tokens.get(self.next).is_some_and(|(_, next)| next == token);
        self.next += usize::from(is_next);
        is_next
    }

    fn finish(&self) -> Result<(), Fault> {
        if self.next < self.tokens.len() { Err(self.unexpected("AND, OR or the end")) } else { Ok(()) }
    }

    fn place(&self) -> usize {
        self.tokens.get(self.next).map_or(self.end, |(at, _)| *at)
    }

    fn unexpected(&self, expected: &str) -> Fault {
        let found = match self.tokens.get(self.next).map(|(_, token)| token) {
            None => "the end".to_string(),
            Some(Token::Word(word) | Token::Quoted(word)) => format!("`{word}`"),
            Some(Token::Literal(value)) => format!("`{value}`"),
            Some(Token::Comparison(_)) => "a comparison".to_string(),
            Some(Token::Open) => "`(`".to_string(),
            Some(Token::Close) => "`)`".to_string(),
            Some(Token::Comma) => "`,`".to_string(),
        };
        Fault::new(self.place(), found, expected)
    }
}

fn negate_if(negated: bool, expression: Expression) -> Expression {
    if negated { Expression::Not(Box::new(expression)) } else { expression }
}
