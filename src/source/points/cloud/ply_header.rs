//! The header of a PLY file: which numbers the vertices have, and where they begin.

use super::is_class;
use super::lines::{Line, Lines, shown};
use crate::error::{Error, InputError, Result};
use std::io::{self, BufRead};
use std::path::Path;

/// Lines of a header; files of programs have some dozens.
const MOST_LINES: u64 = 10_000;

/// How the numbers are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

impl Encoding {
    /// Its name for a person.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ascii => "ASCII",
            Self::LittleEndian => "binary, little-endian",
            Self::BigEndian => "binary, big-endian",
        }
    }
}

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl Scalar {
    /// By its old or its new name.
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "int64" | "long" => Self::I64,
            "uint64" | "ulong" => Self::U64,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Its size in bytes.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::I64 | Self::U64 | Self::F64 => 8,
        }
    }
}

/// What a property of a vertex is to us.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meaning {
    /// The coordinate along an axis.
    Axis(usize),
    /// The class.
    Class,
    /// Nothing.
    Other,
}

/// A property of an element.
#[derive(Debug, Clone)]
pub(super) struct Property {
    /// Its name.
    pub name: String,
    /// The type of the number, or of those in the list.
    pub kind: Scalar,
    /// The type of the number of those in the list; `None` for a single number.
    pub list: Option<Scalar>,
    /// What it is to us.
    pub meaning: Meaning,
}

/// A kind of things in the file.
#[derive(Debug, Clone)]
pub(super) struct Element {
    name: String,
    /// How many the header announces.
    pub count: u64,
    /// What each of them has, in this order.
    pub properties: Vec<Property>,
}

impl Element {
    /// The properties that are a number, not a list.
    pub fn singles(&self) -> impl Iterator<Item = &Property> {
        self.properties.iter().filter(|property| property.list.is_none())
    }

    /// Bytes of one of them; `None` when it has lists.
    pub fn size(&self) -> Option<usize> {
        self.properties.iter().map(|p| p.list.is_none().then(|| p.kind.size())).sum()
    }
}

/// What the header says.
#[derive(Debug, Clone)]
pub(in crate::source::points) struct PlyHeader {
    pub(super) encoding: Encoding,
    /// What stands before the vertices.
    pub(super) before: Vec<Element>,
    pub(super) vertex: Element,
    /// Whether nothing is announced behind the vertices.
    pub(super) is_last: bool,
    /// Byte at which the data begin.
    pub(super) data_start: u64,
    /// Lines of the header.
    pub(super) lines: u64,
}

impl PlyHeader {
    /// Number of vertices that it announces.
    pub fn vertices(&self) -> u64 {
        self.vertex.count
    }

    /// Whether vertices have a class.
    pub fn has_classes(&self) -> bool {
        self.vertex.properties.iter().any(|property| property.meaning == Meaning::Class)
    }
}

/// Whether a file begins as PLY does. Leaves it at its beginning.
///
/// # Errors
/// The system refuses to read.
pub(super) fn is_ply(file: &mut impl BufRead) -> io::Result<bool> {
    let start = file.fill_buf()?;
    Ok(start.starts_with(b"ply\n") || start.starts_with(b"ply\r\n"))
}

/// Reads the header of the file at `path`.
///
/// # Errors
/// What is wrong with it, and in which line; or that the file cannot be read.
pub(super) fn read(path: &Path, file: &mut impl BufRead) -> Result<PlyHeader> {
    let mut lines = Lines::new(file, 0);
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        let line = lines.advance().map_err(|e| Error::io(path, "read", e))?;
        let number = lines.number;
        let fault = |found: String, expected: &str| -> Error {
            InputError::new(path, found, expected)
                .at(format!("line {number}"))
                .remedy("The header of the PLY file is damaged: fetch or export it again")
                .into()
        };
        let text = match line {
            Line::Read if number <= MOST_LINES => lines.text(),
            Line::Read => return Err(fault(format!("a header of more than {MOST_LINES} lines"), "`end_header`")),
            Line::End => return Err(fault("the end of the file".into(), "`end_header` before it")),
            Line::TooLong => return Err(fault(Lines::<&[u8]>::too_long(), "a line of a header")),
        };
        let Some(text) = text else { return Err(fault(lines.shown(), "a line of a header, as text")) };
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        match words[..] {
            ["ply"] if number == 1 => {}
            [] | ["comment" | "obj_info", ..] => {}
            ["format", name, _] if encoding.is_none() => {
                encoding = Some(match name {
                    "ascii" => Encoding::Ascii,
                    "binary_little_endian" => Encoding::LittleEndian,
                    "binary_big_endian" => Encoding::BigEndian,
                    _ => return Err(fault(shown(name), "ascii, binary_little_endian or binary_big_endian")),
                });
            }
            ["element", name, count] => {
                let count = count.parse().map_err(|_| fault(shown(count), "how many there are"))?;
                elements.push(Element { name: name.to_owned(), count, properties: Vec::new() });
            }
            ["property", ref property @ ..] => {
                let Some(element) = elements.last_mut() else {
                    return Err(fault(shown(text), "an element before its properties"));
                };
                let property = parse_property(property).map_err(|found| fault(found, PROPERTY))?;
                element.properties.push(property);
            }
            ["end_header"] => break,
            _ => return Err(fault(shown(text), "format, element, property, comment or end_header")),
        }
    }
    let (data_start, lines) = (lines.read, lines.number);
    let fault = |found: &str, expected: &str| {
        let fault = InputError::new(path, found, expected).at("header");
        fault.remedy("Export the cloud as PLY with its points as vertices with x, y and z")
    };
    let encoding = encoding.ok_or_else(|| fault("no line `format`", "one that says how numbers are written"))?;
    let place = elements.iter().position(|element| element.name == "vertex");
    let place = place.ok_or_else(|| fault("no element `vertex`", "the points as vertices"))?;
    let is_last = elements[place + 1..].iter().all(|element| element.count == 0);
    elements.truncate(place + 1);
    let vertex = elements.pop().ok_or_else(|| fault("no element `vertex`", "the points as vertices"))?;
    for (axis, name) in ["x", "y", "z"].into_iter().enumerate() {
        let held = vertex.properties.iter().filter(|property| property.meaning == Meaning::Axis(axis)).count();
        if held != 1 {
            return Err(fault(&format!("{held} properties `{name}` of a vertex"), "one, a number").into());
        }
    }
    Ok(PlyHeader { encoding, before: elements, vertex, is_last, data_start, lines })
}

const PROPERTY: &str =
    "`property TYPE NAME` or `property list TYPE TYPE NAME` with types such as uchar, int, float or double";

/// A property from the words behind `property`; the error is what was found.
fn parse_property(words: &[&str]) -> Result<Property, String> {
    let kind = |name: &str| Scalar::named(name).ok_or_else(|| shown(name));
    match *words {
        ["list", count, of, name] => {
            let count = kind(count)?;
            if matches!(count, Scalar::F32 | Scalar::F64) {
                return Err("a list whose length is no whole number".to_owned());
            }
            Ok(Property { name: name.to_owned(), kind: kind(of)?, list: Some(count), meaning: Meaning::Other })
        }
        [of, name] => {
            let meaning = match name {
                "x" | "X" => Meaning::Axis(0),
                "y" | "Y" => Meaning::Axis(1),
                "z" | "Z" => Meaning::Axis(2),
                name if is_class(name) => Meaning::Class,
                _ => Meaning::Other,
            };
            Ok(Property { name: name.to_owned(), kind: kind(of)?, list: None, meaning })
        }
        _ => Err(shown(&words.join(" "))),
    }
}
