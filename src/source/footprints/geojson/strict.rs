//! What files have that JSON has not: `NaN` and `Infinity`, which Python writes, and the record separators of RFC 8142.

use std::io::{Read, Result};

/// What stands before every text of a sequence (RFC 8142, section 2).
pub(in super::super) const RECORD_SEPARATOR: u8 = 0x1E;

/// Hands JSON on with `null` for every `NaN`, `Infinity` and `-Infinity` outside of strings, so that one number does
/// not make a whole file unreadable, and with a blank for every record separator.
pub(super) struct Strict<R> {
    inner: R,
    state: State,
    /// What was made of the bytes read so far, and how much of it was handed on.
    ready: Vec<u8>,
    given: usize,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum State {
    Outside,
    InString,
    AfterBackslash,
    /// After a minus, which is held back until it is clear what follows.
    AfterMinus,
    /// Within a word that was replaced.
    InWord,
}

impl<R: Read> Strict<R> {
    pub(super) fn new(inner: R) -> Self {
        Self { inner, state: State::Outside, ready: Vec::new(), given: 0 }
    }

    fn take(&mut self, byte: u8) {
        if self.state == State::InWord && byte.is_ascii_alphabetic() {
            return;
        }
        let starts_word = matches!(byte, b'N' | b'I');
        self.state = match (self.state, byte) {
            (State::InString, b'\\') => State::AfterBackslash,
            (State::InString, b'"') => State::Outside,
            (State::InString | State::AfterBackslash, _) => State::InString,
            (_, _) if starts_word => {
                self.ready.extend(b"null");
                self.state = State::InWord;
                return;
            }
            (previous, _) => {
                if previous == State::AfterMinus {
                    self.ready.push(b'-');
                }
                match byte {
                    b'"' => State::InString,
                    b'-' => {
                        self.state = State::AfterMinus;
                        return;
                    }
                    RECORD_SEPARATOR => {
                        self.state = State::Outside;
                        self.ready.push(b' ');
                        return;
                    }
                    _ => State::Outside,
                }
            }
        };
        self.ready.push(byte);
    }
}

impl<R: Read> Read for Strict<R> {
    fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
        let mut chunk = [0; 8192];
        while self.given == self.ready.len() {
            self.ready.clear();
            self.given = 0;
            let count = self.inner.read(&mut chunk)?;
            if count == 0 {
                return Ok(0);
            }
            chunk[..count].iter().for_each(|&byte| self.take(byte));
        }
        let rest = &self.ready[self.given..];
        let count = rest.len().min(buffer.len());
        buffer[..count].copy_from_slice(&rest[..count]);
        self.given += count;
        Ok(count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gives one byte at a time, so that every word is split.
    struct Drip<'a>(&'a [u8]);

    impl Read for Drip<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> Result<usize> {
            let Some((first, rest)) = self.0.split_first() else { return Ok(0) };
            buffer[0] = *first;
            self.0 = rest;
            Ok(1)
        }
    }

    #[test]
    fn only_words_outside_strings_are_replaced() {
        let json = br#"{"NaN":[NaN,-Infinity,Infinity,-1,-2e-3,null,true],"a\"N":"-Infinity \\","b":-NaN}"#;
        let mut text = String::new();
        Strict::new(Drip(json)).read_to_string(&mut text).unwrap();
        assert_eq!(text, r#"{"NaN":[null,null,null,-1,-2e-3,null,true],"a\"N":"-Infinity \\","b":null}"#);
        let mut text = String::new();
        Strict::new(Drip(b"\x1e{\"a\x1e\":1}\n\x1e2\n")).read_to_string(&mut text).unwrap();
        assert_eq!(text, " {\"a\x1e\":1}\n 2\n", "a separator in a string is none");
    }
}
