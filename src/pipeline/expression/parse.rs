//! From text to expressions: a recursive descent, one function per level of precedence.

use super::{Arithmetic, Assignment, Comparison, Condition, Misfit, Number};

/// How deep parentheses, negations and minus signs may be nested: more than anyone writes, less than the stack holds.
const DEEPEST: usize = 100;

/// What a part of an expression came out as.
enum Part {
    Number(Number),
    Condition(Condition),
}

/// A word of the text, with the number of its first character, from 1.
#[derive(Debug, Clone, PartialEq)]
struct Token {
    what: Word,
    at: usize,
}

#[derive(Debug, Clone, PartialEq)]
enum Word {
    Number(f64),
    Name(String),
    Sign(&'static str),
}

/// Longer signs first.
const SIGNS: [&str; 15] = ["&&", "||", "==", "!=", "<=", ">=", "<", ">", "!", "(", ")", "+", "-", "*", "/"];

pub(super) fn condition(text: &str) -> Result<Condition, Misfit> {
    let mut parser = Parser::new(text)?;
    let at = parser.at();
    let part = parser.any(0)?;
    parser.end()?;
    as_condition(part, at)
}

pub(super) fn assignment(text: &str) -> Result<Assignment, Misfit> {
    let mut parser = Parser::new(text)?;
    let Some(Token { what: Word::Name(dimension), .. }) = parser.next() else {
        return Err(Misfit::new(format!("`{text}`"), "`Dimension = value`, such as `Classification = 6`"));
    };
    if !parser.take("=") {
        return Err(parser.unexpected("`=` and the value"));
    }
    let at = parser.at();
    let part = parser.sum(0)?;
    let value = as_number(part, at)?;
    let condition = if parser.take_word("where") {
        let at = parser.at();
        let part = parser.any(0)?;
        Some(as_condition(part, at)?)
    } else {
        None
    };
    parser.end()?;
    Ok(Assignment { dimension, value, condition })
}

struct Parser {
    tokens: Vec<Token>,
    position: usize,
    length: usize,
}

impl Parser {
    fn new(text: &str) -> Result<Self, Misfit> {
        let tokens = tokens(text)?;
        let length = text.chars().count();
        Ok(Self { tokens, position: 0, length })
    }

    fn next(&mut self) -> Option<Token> {
        let token = self.tokens.get(self.position).cloned();
        self.position += usize::from(token.is_some());
        token
    }

    /// The character at which the next word begins.
    fn at(&self) -> usize {
        self.tokens.get(self.position).map_or(self.length + 1, |token| token.at)
    }

    fn take(&mut self, sign: &str) -> bool {
        let is_it = matches!(self.tokens.get(self.position), Some(Token { what: Word::Sign(s), .. }) if *s == sign);
        self.position += usize::from(is_it);
        is_it
    }

    fn take_any(&mut self, signs: &[&'static str]) -> Option<&'static str> {
        signs.iter().copied().find(|sign| self.take(sign))
    }

    fn take_word(&mut self, word: &str) -> bool {
        let is_it = matches!(self.tokens.get(self.position),
            Some(Token { what: Word::Name(name), .. }) if name.eq_ignore_ascii_case(word));
        self.position += usize::from(is_it);
        is_it
    }

    fn unexpected(&self, expected: &str) -> Misfit {
        let found = match self.tokens.get(self.position) {
            Some(token) => {
                let word = match &token.what {
                    Word::Number(value) => value.to_string(),
                    Word::Name(name) => name.clone(),
                    Word::Sign(sign) => (*sign).to_owned(),
                };
                format!("`{word}` at character {}", token.at)
            }
            None => "the end of the expression".to_owned(),
        };
        Misfit::new(found, expected)
    }

    fn end(&self) -> Result<(), Misfit> {
        if self.position == self.tokens.len() { Ok(()) } else { Err(self.unexpected("an operator, or the end")) }
    }

    fn any(&mut self, depth: usize) -> Result<Part, Misfit> {
        let at = self.at();
        let first = self.all(depth)?;
        if !self.take("||") {
            return Ok(first);
        }
        let mut parts = vec![as_condition(first, at)?];
        loop {
            let at = self.at();
            let next = self.all(depth)?;
            parts.push(as_condition(next, at)?);
            if !self.take("||") {
                return Ok(Part::Condition(Condition::Any(parts)));
            }
        }
    }

    fn all(&mut self, depth: usize) -> Result<Part, Misfit> {
        let at = self.at();
        let first = self.comparison(depth)?;
        if !self.take("&&") {
            return Ok(first);
        }
        let mut parts = vec![as_condition(first, at)?];
        loop {
            let at = self.at();
            let next = self.comparison(depth)?;
            parts.push(as_condition(next, at)?);
            if !self.take("&&") {
                return Ok(Part::Condition(Condition::All(parts)));
            }
        }
    }

    fn comparison(&mut self, depth: usize) -> Result<Part, Misfit> {
        let at = self.at();
        let left = self.sum(depth)?;
        let Some(sign) = self.take_any(&["==", "!=", "<=", ">=", "<", ">"]) else { return Ok(left) };
        let how = match sign {
            "==" => Comparison::Equal,
            "!=" => Comparison::NotEqual,
            "<=" => Comparison::AtMost,
            ">=" => Comparison::AtLeast,
            "<" => Comparison::Less,
            _ => Comparison::Greater,
        };
        let right_at = self.at();
        let right = self.sum(depth)?;
        let sides = [as_number(left, at)?, as_number(right, right_at)?];
        Ok(Part::Condition(Condition::Compare(how, Box::new(sides))))
    }

    fn sum(&mut self, depth: usize) -> Result<Part, Misfit> {
        let at = self.at();
        let mut left = self.product(depth)?;
        while let Some(sign) = self.take_any(&["+", "-"]) {
            let what = if sign == "+" { Arithmetic::Plus } else { Arithmetic::Minus };
            let right_at = self.at();
            let right = self.product(depth)?;
            left = both(what, (left, at), (right, right_at))?;
        }
        Ok(left)
    }

    fn product(&mut self, depth: usize) -> Result<Part, Misfit> {
        let at = self.at();
        let mut left = self.single(depth)?;
        while let Some(sign) = self.take_any(&["*", "/"]) {
            let what = if sign == "*" { Arithmetic::Times } else { Arithmetic::Over };
            let right_at = self.at();
            let right = self.single(depth)?;
            left = both(what, (left, at), (right, right_at))?;
        }
        Ok(left)
    }

    fn single(&mut self, depth: usize) -> Result<Part, Misfit> {
        if depth > DEEPEST {
            return Err(Misfit::new(format!("more than {DEEPEST} parentheses or signs in one another"), "fewer"));
        }
        if self.take("!") {
            let at = self.at();
            let inner = self.single(depth + 1)?;
            return Ok(Part::Condition(Condition::Not(Box::new(as_condition(inner, at)?))));
        }
        if self.take("-") {
            let at = self.at();
            let inner = self.single(depth + 1)?;
            return Ok(Part::Number(Number::Negated(Box::new(as_number(inner, at)?))));
        }
        if self.take("+") {
            return self.single(depth + 1);
        }
        if self.take("(") {
            let inner = self.any(depth + 1)?;
            return if self.take(")") { Ok(inner) } else { Err(self.unexpected("`)`")) };
        }
        let expected = "a number, a dimension or `(`";
        match self.tokens.get(self.position).map(|token| &token.what) {
            Some(Word::Number(_) | Word::Name(_)) => {}
            _ => return Err(self.unexpected(expected)),
        }
        match self.next().map(|token| token.what) {
            Some(Word::Number(value)) => Ok(Part::Number(Number::Constant(value))),
            Some(Word::Name(name)) => Ok(Part::Number(Number::Dimension(name))),
            _ => Err(self.unexpected(expected)),
        }
    }
}

fn both(what: Arithmetic, left: (Part, usize), right: (Part, usize)) -> Result<Part, Misfit> {
    let sides = [as_number(left.0, left.1)?, as_number(right.0, right.1)?];
    Ok(Part::Number(Number::Both(what, Box::new(sides))))
}

fn as_number(part: Part, at: usize) -> Result<Number, Misfit> {
    match part {
        Part::Number(number) => Ok(number),
        Part::Condition(_) => Err(Misfit::new(format!("a condition at character {at}"), "a number there")),
    }
}

fn as_condition(part: Part, at: usize) -> Result<Condition, Misfit> {
    match part {
        Part::Condition(condition) => Ok(condition),
        Part::Number(_) => {
            Err(Misfit::new(format!("a number at character {at}"), "a condition there, such as `Intensity != 0`"))
        }
    }
}

fn tokens(text: &str) -> Result<Vec<Token>, Misfit> {
    let mut tokens = Vec::new();
    let (mut rest, mut at) = (text, 1);
    while let Some(first) = rest.chars().next() {
        let (what, bytes) = if first.is_whitespace() {
            (None, first.len_utf8())
        } else if first.is_ascii_digit() || first == '.' {
            let bytes = number_length(rest);
            let value = rest[..bytes].parse().map_err(|_| {
                Misfit::new(format!("`{}` at character {at}", &rest[..bytes]), "a number such as 2.5 or 1e-3")
            })?;
            (Some(Word::Number(value)), bytes)
        } else if first.is_alphabetic() || first == '_' {
            let bytes = rest.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(rest.len());
            (Some(Word::Name(rest[..bytes].to_owned())), bytes)
        } else if let Some(sign) = SIGNS.iter().find(|sign| rest.starts_with(**sign)) {
            (Some(Word::Sign(sign)), sign.len())
        } else if first == '=' {
            (Some(Word::Sign("=")), 1)
        } else {
            return Err(Misfit::new(
                format!("`{first}` at character {at}"),
                "names, numbers, `&& || ! == != < <= > >=`",
            ));
        };
        tokens.extend(what.map(|what| Token { what, at }));
        at += rest[..bytes].chars().count();
        rest = &rest[bytes..];
    }
    Ok(tokens)
}

/// Bytes of the number that the text begins with.
fn number_length(text: &str) -> usize {
    let bytes = text.as_bytes();
    let digits = |mut i: usize| {
        while bytes.get(i).is_some_and(|b| b.is_ascii_digit() || *b == b'.') {
            i += 1;
        }
        i
    };
    let mantissa = digits(0);
    let exponent = bytes.get(mantissa).is_some_and(|b| b.eq_ignore_ascii_case(&b'e'));
    if !exponent {
        return mantissa;
    }
    let signed = mantissa + 1 + usize::from(matches!(bytes.get(mantissa + 1), Some(b'+' | b'-')));
    let end = digits(signed);
    if end > signed { end } else { mantissa }
}
