//! Text with a point a line: numbers parted by blanks, commas or semicolons.

use super::lines::{Line, Lines, shown};
use super::{Visit, class_of, is_class};
use crate::error::{Error, InputError, Result};
use std::io::BufRead;
use std::path::Path;

const REMEDY: &str = "Correct the line, or begin it with # to leave it out; decimals need a point, not a comma";
/// What the columns of x, y and z are called.
const NAMES: [&[&str]; 3] =
    [&["x", "easting", "east"], &["y", "northing", "north"], &["z", "height", "elevation", "altitude"]];
/// What comments begin with.
const COMMENTS: [&str; 4] = ["#", "//", "%", "!"];

/// Which columns are read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::source::points) struct Columns {
    /// Those of x, y and z, from 0.
    pub axes: [usize; 3],
    /// That of the class.
    pub class: Option<usize>,
    /// Lines before the first point.
    head: u64,
}

impl Columns {
    /// Their numbers for a person, from 1.
    pub fn places(&self) -> String {
        let [x, y, z] = self.axes.map(|column| column + 1);
        match self.class {
            Some(class) => format!("{x}, {y} and {z}, class in {}", class + 1),
            None => format!("{x}, {y} and {z}"),
        }
    }
}

/// The parts of a line.
fn parts(line: &str) -> impl Iterator<Item = &str> {
    let mark = [';', ','].into_iter().find(|mark| line.contains(*mark));
    let marked = mark.map(|mark| line.split(mark).map(str::trim));
    let blank = mark.is_none().then(|| line.split_whitespace());
    marked.into_iter().flatten().chain(blank.into_iter().flatten())
}

/// What is behind the mark of a comment; `None` when it is none.
fn comment(line: &str) -> Option<&str> {
    COMMENTS.iter().find_map(|mark| line.strip_prefix(mark)).map(|rest| rest.trim_start_matches(['#', '/', ' ']))
}

/// A line as text, without a mark of its encoding.
fn plain(line: &str) -> &str {
    line.trim_start_matches('\u{feff}').trim()
}

/// Looks at the beginning of the file at `path`: for names of the columns, in a line of their own or a comment.
///
/// # Errors
/// There are names, but none of x, y and z; something that is neither names nor numbers; no point at all; or the file
/// cannot be read.
pub(super) fn columns(path: &Path, file: &mut impl BufRead) -> Result<Columns> {
    let mut lines = Lines::new(file, 0);
    let mut named = None;
    loop {
        let line = lines.advance().map_err(|e| Error::io(path, "read", e))?;
        let number = lines.number;
        let fault = |found: String, expected: &str| {
            InputError::new(path, found, expected).at(format!("line {number}")).remedy(REMEDY)
        };
        match line {
            Line::Read => {}
            Line::End => return Err(fault("no point".into(), "a point a line: x, y and z").into()),
            Line::TooLong => return Err(fault(Lines::<&[u8]>::too_long(), "a point a line").into()),
        }
        let Some(text) = lines.text() else { return Err(fault(lines.shown(), "text: numbers, UTF-8").into()) };
        let text = plain(text);
        if let Some(rest) = comment(text) {
            named = of_names(rest, number).ok().or(named);
        } else if !text.is_empty() && !is_count(text) {
            let columns = named.unwrap_or(Columns { axes: [0, 1, 2], class: None, head: 0 });
            match parse(&columns, text) {
                Ok(_) => return Ok(Columns { head: number - 1, ..columns }),
                // Numbers with something wrong in them are no names.
                Err((found, expected)) if named.is_some() || begins_as_number(text) => {
                    return Err(fault(found, &expected).into());
                }
                Err(_) => {}
            }
            named =
                Some(of_names(text, number).map_err(|found| fault(found, "names of columns, x, y and z among them"))?);
        }
    }
}

/// The columns by their names; the error is what was found.
fn of_names(line: &str, number: u64) -> Result<Columns, String> {
    let names: Vec<String> = parts(line)
        .map(|name| name.trim_matches(['"', '\'']).split([' ', '(', '[']).next().unwrap_or_default().to_lowercase())
        .collect();
    let mut axes = [0; 3];
    for (axis, known) in axes.iter_mut().zip(NAMES) {
        *axis = names.iter().position(|name| known.contains(&name.as_str())).ok_or_else(|| shown(line))?;
    }
    let class = names.iter().position(|name| is_class(name));
    Ok(Columns { axes, class, head: number })
}

fn begins_as_number(line: &str) -> bool {
    line.starts_with(|c: char| c.is_ascii_digit() || "+-.".contains(c))
}

/// Whether a line is a single whole number: how many points follow, as PTS files say before each scan.
fn is_count(line: &str) -> bool {
    line.bytes().all(|b| b.is_ascii_digit())
}

/// Hands out the points. Gives what stood in the way, if not all could be read.
pub(super) fn read(columns: &Columns, path: &Path, file: impl BufRead, visit: &mut Visit) -> Option<InputError> {
    let mut lines = Lines::new(file, 0);
    loop {
        let line = lines.advance();
        let fault = |found: String, expected: String| {
            let fault = InputError::new(path, found, expected).at(format!("line {}", lines.number));
            Some(fault.remedy(REMEDY))
        };
        match line {
            Ok(Line::Read) => {}
            Ok(Line::End) => return None,
            Ok(Line::TooLong) => return fault(Lines::<&[u8]>::too_long(), "a point a line".into()),
            Err(error) => return fault(error.to_string(), "a file that can be read".into()),
        }
        if lines.number <= columns.head {
            continue;
        }
        let Some(text) = lines.text() else { return fault(lines.shown(), "text: numbers, UTF-8".into()) };
        let text = plain(text);
        if text.is_empty() || comment(text).is_some() || is_count(text) {
            continue;
        }
        match parse(columns, text) {
            Ok((position, class)) => {
                if visit(position, class).is_break() {
                    return None;
                }
            }
            Err((found, expected)) => return fault(found, expected),
        }
    }
}

/// A point from its line; the error is what was found and what was expected.
fn parse(columns: &Columns, text: &str) -> Result<([f64; 3], u8), (String, String)> {
    let (mut position, mut class) = ([0.0; 3], 0);
    let mut held = 0;
    for (column, part) in parts(text).enumerate() {
        held = column + 1;
        let number = || part.parse::<f64>().map_err(|_| (shown(part), "a number".to_owned()));
        if let Some(axis) = columns.axes.iter().position(|axis| *axis == column) {
            position[axis] = number()?;
        } else if columns.class == Some(column) {
            class = class_of(number()?);
        }
    }
    let needed = 1 + columns.axes.into_iter().chain(columns.class).max().unwrap_or(0);
    if held < needed {
        return Err((format!("{} with {held} numbers", shown(text)), format!("{needed} at least")));
    }
    Ok((position, class))
}
