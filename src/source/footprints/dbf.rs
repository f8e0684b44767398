//! The attribute table of a shapefile (dBASE III to `FoxPro`).
//!
//! The `dbase` crate reads numbers as floating point and knows few encodings; ids of 18 digits and names with accents
//! must survive, so the records are read here.

use std::io::{BufReader, Read};
use std::path::Path;

use encoding_rs::{Encoding, UTF_8, WINDOWS_1252};
use serde_json::{Map, Number, Value};

use super::attributes::distinct;
use crate::error::{InputError, Result};
use crate::source::open::{self, Input};

/// Bytes of the header before the fields, and of each field.
const BLOCK: usize = 32;
/// Ends the list of fields.
const END_OF_FIELDS: u8 = 0x0D;
/// Marks a record as deleted.
const DELETED: u8 = b'*';

/// A column.
struct Field {
    name: String,
    kind: u8,
    length: usize,
    decimals: u8,
}

/// A table that is read record by record.
pub(super) struct Table {
    file: BufReader<Input>,
    fields: Vec<Field>,
    /// What is to be told of fields of one name.
    pub clashes: Vec<String>,
    record: Vec<u8>,
    encoding: &'static Encoding,
    /// What says that this is the encoding; `None` where nothing does.
    stated_by: Option<&'static str>,
    left: u32,
    /// How many records were read.
    number: u64,
    /// Values whose bytes are not of the encoding, and the first of them: its field, and its record from 1 on.
    misread: u64,
    first_misread: Option<(String, u64)>,
}

/// A record: its values, and whether it is marked as deleted.
pub(super) struct Record {
    pub attributes: Map<String, Value>,
    pub is_deleted: bool,
}

impl Table {
    /// Opens a table; `code_page` is what the `.cpg` file says, if there is one.
    pub(super) fn open(path: &Path, code_page: Option<&str>) -> Result<Self> {
        let mut file = BufReader::new(open::regular(path, "a dBASE table")?.0);
        let fault = |found: &str| InputError::new(path, found, "a dBASE table");
        let mut start = [0; BLOCK];
        file.read_exact(&mut start).map_err(|_| fault("a file that is too short"))?;
        let left = u32::from_le_bytes([start[4], start[5], start[6], start[7]]);
        let header_length = usize::from(u16::from_le_bytes([start[8], start[9]]));
        let record_length = usize::from(u16::from_le_bytes([start[10], start[11]]));
        let mut header = vec![0; header_length.saturating_sub(BLOCK)];
        file.read_exact(&mut header).map_err(|_| fault("a header that is cut off"))?;
        let (encoding, stated_by) = encoding_of(code_page, start[29]);
        let mut fields: Vec<Field> = header
            .as_chunks::<BLOCK>()
            .0
            .iter()
            .take_while(|field| field[0] != END_OF_FIELDS)
            .map(|field| {
                let name = field[..11].split(|&b| b == 0).next().unwrap_or_default();
                Field {
                    name: decode(name, encoding).0.trim().to_string(),
                    kind: field[11].to_ascii_uppercase(),
                    length: usize::from(field[16]),
                    decimals: field[17],
                }
            })
            .collect();
        if fields.iter().map(|field| field.length).sum::<usize>() >= record_length {
            return Err(fault("records that are shorter than their fields").into());
        }
        // Names are shortened to ten bytes, and then two may be one.
        let (names, clashes) = distinct(fields.iter().map(|field| field.name.clone()));
        fields.iter_mut().zip(names).for_each(|(field, name)| field.name = name);
        Ok(Self {
            file,
            fields,
            clashes,
            record: vec![0; record_length],
            encoding,
            stated_by,
            left,
            number: 0,
            misread: 0,
            first_misread: None,
        })
    }

    /// The names of the columns whose values are kept.
    pub(super) fn columns(&self) -> impl Iterator<Item = &String> {
        self.fields.iter().filter(|field| !field.is_binary()).map(|field| &field.name)
    }

    /// The names of the columns that hold what is not kept (memos, pictures).
    pub(super) fn binary_columns(&self) -> impl Iterator<Item = &String> {
        self.fields.iter().filter(|field| field.is_binary()).map(|field| &field.name)
    }

    /// What is to be said of values, read so far, that are not in the encoding that the table or the `.cpg` file states;
    /// `None` where all are, or where nothing is stated.
    pub(super) fn lie(&self) -> Option<String> {
        let (by, (field, record)) = (self.stated_by?, self.first_misread.as_ref()?);
        let done =
            if self.encoding == UTF_8 { "they were read as windows-1252" } else { "what is wrong in them became �" };
        Some(format!(
            "{} value(s) of the .dbf are not in {}, which {by} states, first `{field}` of record {record}: {done}; correct or \
             remove the .cpg if they look wrong",
            self.misread,
            self.encoding.name()
        ))
    }

    /// The next record; `None` at the end, also when the file is cut off.
    pub(super) fn next(&mut self) -> Option<Record> {
        self.left = self.left.checked_sub(1)?;
        self.file.read_exact(&mut self.record).ok()?;
        let (flag, mut rest) = self.record.split_first()?;
        let is_deleted = *flag == DELETED;
        self.number += 1;
        let mut attributes = Map::new();
        for field in &self.fields {
            let (bytes, after) = rest.split_at_checked(field.length)?;
            rest = after;
            if !field.is_binary() {
                let (value, is_misread) = field.value(bytes, self.encoding);
                if is_misread {
                    self.misread += 1;
                    self.first_misread.get_or_insert_with(|| (field.name.clone(), self.number));
                }
                attributes.insert(field.name.clone(), value);
            }
        }
        Some(Record { attributes, is_deleted })
    }
}

impl Field {
    fn is_binary(&self) -> bool {
        matches!(self.kind, b'M' | b'B' | b'G' | b'P' | b'Q' | b'V' | b'W' | b'T' | b'@' | b'0')
            && !(self.kind == b'B' && self.length == 8)
    }

    /// The value, and whether it is text whose bytes are not of the encoding.
    fn value(&self, bytes: &[u8], encoding: &'static Encoding) -> (Value, bool) {
        let mut is_misread = false;
        let value = match (self.kind, bytes.len()) {
            (b'I' | b'+', 4) => bytes.first_chunk().map_or(Value::Null, |b| i32::from_le_bytes(*b).into()),
            (b'O' | b'B', 8) => bytes
                .first_chunk()
                .and_then(|b| Number::from_f64(f64::from_le_bytes(*b)))
                .map_or(Value::Null, Value::Number),
            (b'N' | b'F', _) => self.number(&String::from_utf8_lossy(bytes)),
            (b'L', _) => match bytes.first() {
                Some(b'T' | b't' | b'Y' | b'y') => Value::Bool(true),
                Some(b'F' | b'f' | b'N' | b'n') => Value::Bool(false),
                _ => Value::Null,
            },
            (b'D', 8) if bytes.iter().all(u8::is_ascii_digit) => {
                let text = String::from_utf8_lossy(bytes);
                format!("{}-{}-{}", &text[..4], &text[4..6], &text[6..]).into()
            }
            _ => {
                let text;
                (text, is_misread) = decode(bytes, encoding);
                let text = text.trim_end_matches([' ', '\0']);
                if text.is_empty() { Value::Null } else { text.into() }
            }
        };
        (value, is_misread)
    }

    /// A number that stands as text. What a JSON number would change (leading zeros, too many digits) stays text.
    fn number(&self, text: &str) -> Value {
        let text = text.trim_matches([' ', '\0']);
        if text.is_empty() || text.contains('*') {
            return Value::Null;
        }
        let is_integer =
            self.decimals == 0 && text.bytes().enumerate().all(|(i, b)| b.is_ascii_digit() || (i == 0 && b == b'-'));
        if is_integer {
            let number = text.parse::<i64>().map(Number::from).or_else(|_| text.parse::<u64>().map(Number::from));
            return match number {
                Ok(number) if number.to_string() == text => Value::Number(number),
                _ => text.into(),
            };
        }
        text.parse().ok().and_then(Number::from_f64).map_or_else(|| text.into(), Value::Number)
    }
}

/// The encoding by the `.cpg` file, else by the header's language driver, and which of them states it; else UTF-8, which
/// [`decode`] leaves for Windows-1252 where the bytes are none.
fn encoding_of(code_page: Option<&str>, language_driver: u8) -> (&'static Encoding, Option<&'static str>) {
    let label = code_page.map(|label| label.trim().to_ascii_lowercase().replace("ansi ", ""));
    let named = label.and_then(|label| {
        let bare = label.trim_start_matches("cp").trim_start_matches("windows-");
        let label = match bare {
            "65001" | "utf8" => "utf-8".to_string(),
            "932" => "shift_jis".to_string(),
            "936" => "gbk".to_string(),
            "949" => "euc-kr".to_string(),
            "950" => "big5".to_string(),
            "88591" => "iso-8859-1".to_string(),
            number if number.starts_with("125") => format!("windows-{number}"),
            number if number.starts_with("8859") => format!("iso-8859-{}", number[4..].trim_start_matches('-')),
            _ => label,
        };
        Encoding::for_label(label.as_bytes())
    });
    let by_driver = match language_driver {
        0x03 | 0x57 | 0x58 | 0x59 => Some(WINDOWS_1252),
        0x13 | 0x7B => Some(encoding_rs::SHIFT_JIS),
        0x26 | 0x65 => Some(encoding_rs::IBM866),
        0x4D | 0x7A => Some(encoding_rs::GBK),
        0x4E | 0x79 => Some(encoding_rs::EUC_KR),
        0x4F | 0x78 => Some(encoding_rs::BIG5),
        0x7D => Some(encoding_rs::WINDOWS_1255),
        0x7E => Some(encoding_rs::WINDOWS_1256),
        0xC8 => Some(encoding_rs::WINDOWS_1250),
        0xC9 => Some(encoding_rs::WINDOWS_1251),
        0xCA => Some(encoding_rs::WINDOWS_1254),
        0xCB => Some(encoding_rs::WINDOWS_1253),
        _ => None,
    };
    match (named, by_driver) {
        (Some(encoding), _) => (encoding, Some("the .cpg beside it")),
        (None, Some(encoding)) => (encoding, Some("its header")),
        (None, None) => (UTF_8, None),
    }
}

/// The text of some bytes, and whether they are not of the encoding.
fn decode(bytes: &[u8], encoding: &'static Encoding) -> (String, bool) {
    let (text, had_errors) = encoding.decode_without_bom_handling(bytes);
    if had_errors && encoding == UTF_8 {
        return (WINDOWS_1252.decode_without_bom_handling(bytes).0.into_owned(), true);
    }
    (text.into_owned(), had_errors)
}
