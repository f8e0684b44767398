//! Lines of a file that may have none: no line makes more room than a line may have.

use std::io::{self, BufRead};

/// The longest line, bytes. Those of clouds have some hundred.
const LONGEST: usize = 1 << 16;

/// What came of reading a line.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Line {
    /// One, without its end.
    Read,
    /// None: the file is over.
    End,
    /// More than a line may have.
    TooLong,
}

/// Reads lines and counts them.
#[derive(Debug)]
pub(crate) struct Lines<R> {
    input: R,
    bytes: Vec<u8>,
    /// The number of the line that was read last, from 1.
    pub number: u64,
    /// Bytes read, line ends included.
    pub read: u64,
    /// Whether the line that was read last has an end; the last of a file that is cut off has none.
    pub is_ended: bool,
}

impl<R: BufRead> Lines<R> {
    /// Of `input`, whose next line has the number `before` + 1.
    pub fn new(input: R, before: u64) -> Self {
        Self { input, bytes: Vec::new(), number: before, read: 0, is_ended: false }
    }

    /// Goes to the next line, which ends with a line feed, a carriage return before it or not, or with the file.
    ///
    /// # Errors
    /// The system refuses to read.
    pub fn advance(&mut self) -> io::Result<Line> {
        self.bytes.clear();
        self.number += 1;
        self.is_ended = false;
        loop {
            let available = match self.input.fill_buf() {
                Err(e) if e.kind() == io::ErrorKind::Interrupted => continue,
                other => other?,
            };
            if available.is_empty() {
                return Ok(if self.bytes.is_empty() { Line::End } else { Line::Read });
            }
            let end = memchr::memchr(b'\n', available);
            let (taken, used) = end.map_or((available.len(), available.len()), |end| (end, end + 1));
            if self.bytes.len() + taken > LONGEST {
                return Ok(Line::TooLong);
            }
            self.bytes.extend_from_slice(&available[..taken]);
            self.input.consume(used);
            self.read += used as u64;
            if end.is_some() {
                self.is_ended = true;
                if self.bytes.last() == Some(&b'\r') {
                    self.bytes.pop();
                }
                return Ok(Line::Read);
            }
        }
    }

    /// The line that was read last; `None` when it is no text.
    pub fn text(&self) -> Option<&str> {
        std::str::from_utf8(&self.bytes).ok()
    }

    /// The same for messages, shortened.
    pub fn shown(&self) -> String {
        shown(&String::from_utf8_lossy(&self.bytes[..self.bytes.len().min(4 * SHOWN)]))
    }

    /// What is said of a line that is too long.
    pub fn too_long() -> String {
        format!("more than {LONGEST} bytes without the end of a line")
    }
}

/// Letters of a text that messages show.
const SHOWN: usize = 40;

/// A text for messages: shortened, without control characters.
pub(crate) fn shown(text: &str) -> String {
    let plain: String = text.chars().map(|c| if c.is_control() { ' ' } else { c }).take(SHOWN).collect();
    if text.chars().nth(SHOWN).is_some() { format!("`{plain}…`") } else { format!("`{plain}`") }
}
