//! From the text of a filter to its expression.

use serde_json::Value;

use super::{Comparison, Expression, Operand};

/// How deep parentheses and `NOT` may be nested.
const DEEPEST: usize = 64;

/// The expression that a text stands for.
pub(super) fn expression(text: &str) -> Result<Expression, Fault> {
    let tokens = tokens(text)?;
    let mut parser = Parser { tokens: &tokens, next: 0, depth: 0, end: text.chars().count() };
    let root = parser.disjunction()?;
    parser.finish()?;
    Ok(root)
}

/// What is wrong, and at which character.
pub(super) struct Fault {
    pub at: usize,
    pub found: String,
    pub expected: String,
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
                    c.is_ascii_alphanumeric()
                        || c == '.'
                        || (matches!(c, '-' | '+') && matches!(chars[i - 1], 'e' | 'E'))
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
        let is_next =
            matches!(self.tokens.get(self.next), Some((_, Token::Word(w))) if w.eq_ignore_ascii_case(keyword));
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
