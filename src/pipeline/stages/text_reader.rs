//! `readers.text`: text with a point a line, whose columns have names.

use std::borrow::Cow;
use std::io::BufReader;
use std::path::PathBuf;
use std::sync::Arc;

use serde_json::{Map, Value, json};

use crate::error::{Error, InputError, Result};
use crate::pipeline::expression::Misfit;
use crate::pipeline::options::{Kind, OptionSpec, Values};
use crate::pipeline::points::{Layout, NumberType, usual_name};
use crate::pipeline::rows::Rows;
use crate::pipeline::source::{named_crs, plain_reader_options};
use crate::pipeline::stage::{Context, Flow, Next, Reader, Role, Stage, StageKind};
use crate::source::crs::Crs;
use crate::source::open::{self, Input};
use crate::source::points::lines::{Line, Lines, shown};

/// The type of this stage.
pub const KIND: StageKind = StageKind {
    name: "readers.text",
    summary: "Reads text with a point a line, under a line that names the dimensions",
    role: Role::Reader,
    options,
    elsewhere: &["option_file"],
    collects: "",
    build,
};

fn options() -> Vec<OptionSpec> {
    let mut options = plain_reader_options("Text file; a pattern such as scans/*.csv stands for one reader per file");
    options.extend([
        OptionSpec::new(
            "header",
            Kind::Text,
            "Names of the dimensions, such as `X Y Z Intensity`, for a file without a line of them",
        ),
        OptionSpec::new(
            "separator",
            Kind::Text,
            "What stands between the values; the first sign in the line of names that is no letter, digit or _ when not \
             given. Of blanks, several count as one",
        ),
        OptionSpec::new("skip", Kind::count(), "Lines that are passed over at the beginning").or(0),
    ]);
    options
}

fn build(values: &Values) -> Result<Stage> {
    let separator = values.text("separator").map(|text| {
        let text = text.replace("\\t", "\t");
        let mut signs = text.chars();
        match (signs.next(), signs.next()) {
            (Some(sign), None) => Ok(sign),
            _ => Err(values.fault("separator", &format!("`{text}`"), "one sign")),
        }
    });
    let [stated, default] = named_crs(values)?;
    let header = values.text("header").map(str::to_owned);
    Ok(Stage::Reader(Box::new(TextReader {
        path: values.text("filename").unwrap_or_default().into(),
        separator: separator.transpose()?,
        header,
        skip: values.whole("skip").unwrap_or(0),
        count: values.whole("count").unwrap_or(u64::MAX),
        crs: stated.or(default),
        values: values.clone(),
        opened: None,
        read: None,
        is_whole: true,
    })))
}

struct TextReader {
    values: Values,
    path: PathBuf,
    separator: Option<char>,
    header: Option<String>,
    skip: u64,
    count: u64,
    crs: Option<Arc<Crs>>,
    opened: Option<Opened>,
    /// Number of points that were handed on; `None` before.
    read: Option<u64>,
    is_whole: bool,
}

struct Opened {
    layout: Arc<Layout>,
    /// The place in the layout of each column of the file.
    places: Vec<usize>,
    separator: char,
    /// Lines before the first point.
    head: u64,
}

/// What is said of a file that is none.
const WANTED: &str = "a text file";

/// The sign between the columns, and their names.
///
/// # Errors
/// Something that is no name.
fn names(line: &str, separator: Option<char>) -> Result<(char, Vec<String>), Misfit> {
    let line = line.trim_start_matches('\u{feff}').trim();
    let separator = match separator {
        Some(separator) => separator,
        None if line.starts_with('"') => {
            let between = line.split('"').nth(2).unwrap_or_default().trim();
            let mut signs = between.chars();
            match (signs.next(), signs.next()) {
                (sign, None) => sign.unwrap_or(' '),
                _ => return Err(Misfit::new(shown(between), "one sign between the names")),
            }
        }
        None => line.chars().find(|c| !c.is_alphanumeric() && *c != '_').unwrap_or(' '),
    };
    let mut names = Vec::new();
    for part in parts(line, separator) {
        let name = part.trim().trim_matches('"');
        let is_name = name.starts_with(|c: char| c.is_ascii_alphabetic())
            && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        if !is_name {
            return Err(Misfit::new(shown(part), "names of dimensions, such as `X,Y,Z,Intensity`"));
        }
        names.push(name.to_owned());
    }
    if names.is_empty() {
        return Err(Misfit::new("an empty line", "names of dimensions, such as `X,Y,Z,Intensity`"));
    }
    Ok((separator, names))
}

/// The columns of a line: blanks that part are one however many they are.
fn parts(line: &str, separator: char) -> impl Iterator<Item = &str> {
    let is_blank = separator == ' ';
    let blank = is_blank.then(|| line.split_ascii_whitespace());
    let other = (!is_blank).then(|| line.split(separator));
    blank.into_iter().flatten().chain(other.into_iter().flatten())
}

/// The numbers of a line; the error is what was found instead.
fn parse(line: &str, separator: char, count: usize, values: &mut Vec<f64>) -> Result<(), String> {
    values.clear();
    for part in parts(line, separator) {
        let plain = if part.contains(' ') { Cow::Owned(part.replace(' ', "")) } else { Cow::Borrowed(part) };
        let number = plain.parse().map_err(|_| format!("{} where a number stands", shown(part)))?;
        if values.len() == count {
            return Err(format!("{} with more than {count} values", shown(line)));
        }
        values.push(number);
    }
    if values.len() < count { Err(format!("{} with {} of {count} values", shown(line), values.len())) } else { Ok(()) }
}

impl TextReader {
    fn lines(&self) -> Result<Lines<BufReader<Input>>> {
        let (file, _) = open::regular(&self.path, WANTED)?;
        Ok(Lines::new(BufReader::new(file), 0))
    }
}

impl Reader for TextReader {
    fn prepare(&mut self, _context: &Context<'_>) -> Result<Flow> {
        let mut lines = self.lines()?;
        let in_file = self.header.is_none();
        let head = self.skip.saturating_add(u64::from(in_file));
        for _ in 0..head {
            let line = lines.advance().map_err(|e| Error::io(&self.path, "read", e))?;
            let found = match line {
                Line::Read => continue,
                Line::End => "the end of the file".to_owned(),
                Line::TooLong => Lines::<&[u8]>::too_long(),
            };
            if !in_file && matches!(line, Line::End) {
                break;
            }
            let fault = InputError::new(&self.path, found, "a line with the names of the dimensions");
            return Err(fault.at(format!("line {}", lines.number)).into());
        }
        let fault = |misfit: Misfit| match &self.header {
            Some(_) => self.values.misfit("header", misfit),
            None => {
                InputError::new(&self.path, misfit.found, misfit.expected).at(format!("line {}", self.skip + 1)).remedy(
                    "Give the names as `header` when the file has no line of them; `skip` passes over lines before",
                )
            }
        };
        let line = match &self.header {
            Some(header) => Ok(header.as_str()),
            None => lines.text().ok_or_else(|| Misfit::new(lines.shown(), "text, UTF-8")),
        };
        let (separator, names) = line.and_then(|line| names(line, self.separator)).map_err(fault)?;
        let mut layout = Layout::default();
        let mut places: Vec<usize> = Vec::new();
        for name in &names {
            let place = layout.add(usual_name(name), NumberType::F64);
            if places.contains(&place) {
                return Err(fault(Misfit::new(format!("the dimension `{name}` twice"), "each dimension once")).into());
            }
            places.push(place);
        }
        if let Some(axis) = (0..3).find(|axis| !places.contains(axis)) {
            let missing = layout.dimensions()[axis].name.clone();
            let found = format!("{} without {missing}", names.join(", "));
            return Err(fault(Misfit::new(found, "X, Y and Z among the names")).into());
        }
        let flow = Flow { layout: layout.clone(), crs: self.crs.clone(), ..Flow::default() };
        self.opened = Some(Opened { layout: Arc::new(layout), places, separator, head });
        self.read = None;
        self.is_whole = true;
        Ok(flow)
    }

    fn read(&mut self, context: &Context<'_>, next: &mut Next<'_>) -> Result<()> {
        let mut lines = self.lines()?;
        let Some(Opened { layout, places, separator, head }) = &self.opened else { return Ok(()) };
        let mut rows = Rows::new(Arc::clone(layout), self.crs.clone(), places.clone());
        let mut values = Vec::with_capacity(places.len());
        let mut given = 0;
        // The first line that holds no point, what is in it, and how many there are.
        let mut lost: Option<(u64, String, u64)> = None;
        while given < self.count {
            let line = lines.advance().map_err(|e| Error::io(&self.path, "read", e))?;
            let number = lines.number;
            if matches!(line, Line::End) {
                break;
            }
            if number <= *head {
                continue;
            }
            let found = match (line, lines.text()) {
                (Line::TooLong, _) => Err(format!("{}; what follows is not read", Lines::<&[u8]>::too_long())),
                (_, None) => Err(lines.shown()),
                (_, Some(text)) if text.trim().is_empty() => continue,
                (_, Some(text)) => parse(text, *separator, places.len(), &mut values),
            };
            if let Err(found) = found {
                lost.get_or_insert((number, found, 0)).2 += 1;
                if matches!(line, Line::TooLong) {
                    break;
                }
                continue;
            }
            given += 1;
            rows.push(&values, context, next)?;
        }
        rows.finish(context, next)?;
        self.read = Some(given);
        if let Some((number, found, count)) = lost {
            self.is_whole = false;
            let file = self.path.display();
            context.warn(&format!(
                "{file}, line {number}: {found}; {count} lines that hold no point were left out, {given} points were read"
            ));
        }
        Ok(())
    }

    fn is_whole(&self) -> bool {
        self.is_whole
    }

    fn metadata(&self) -> Map<String, Value> {
        let Some(Opened { layout, separator, .. }) = &self.opened else { return Map::new() };
        Map::from_iter([
            ("filename".to_owned(), json!(self.path.display().to_string())),
            ("separator".to_owned(), json!(separator)),
            ("read".to_owned(), json!(self.read)),
            ("dimensions".to_owned(), json!(layout.names())),
        ])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_line_of_names_tells_the_separator() {
        let of = |line: &str| names(line, None).map(|(separator, names)| (separator, names.join("|")));
        assert_eq!(of("X,Y,Z"), Ok((',', "X|Y|Z".into())));
        assert_eq!(of("X  Y Z Return_Number"), Ok((' ', "X|Y|Z|Return_Number".into())));
        assert_eq!(of("X, Y, Z"), Ok((',', "X|Y|Z".into())));
        assert_eq!(of("X\tY\tZ"), Ok(('\t', "X|Y|Z".into())));
        assert_eq!(of("\u{feff}\"X\";\"Y\";\"Z\""), Ok((';', "X|Y|Z".into())));
        assert_eq!(of("\"X\" \"Y\""), Ok((' ', "X|Y".into())));
        assert_eq!(names("X-Y-Z", Some('-')).unwrap().1.len(), 3);
        for bad in ["1.0 2.0 3.0", "", "X,,Z", "X,Y,3D", "\"X\",-\"Y\""] {
            assert!(of(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn lines_have_a_number_for_each_name() {
        let of = |line: &str, separator| {
            let mut values = Vec::new();
            parse(line, separator, 3, &mut values).map(|()| values)
        };
        assert_eq!(of("1,-2.5, 3e2", ','), Ok(vec![1.0, -2.5, 300.0]));
        assert_eq!(of("  1   2 3 ", ' '), Ok(vec![1.0, 2.0, 3.0]));
        assert_eq!(of("1 000;2;3", ';'), Ok(vec![1000.0, 2.0, 3.0]));
        assert!(of("1,2", ',').unwrap_err().contains("2 of 3"));
        assert!(of("1,2,3,4", ',').unwrap_err().contains("more than 3"));
        assert!(of("1,x,3", ',').unwrap_err().contains("`x`"));
    }
}
