//! The vertices of a PLY file.

use super::lines::{Line, Lines, shown};
use super::ply_header::{Element, Encoding, Meaning, PlyHeader, Property, Scalar};
use super::{Visit, class_of};
use crate::error::InputError;
use std::io::{self, BufRead, Read, Seek, SeekFrom};
use std::ops::ControlFlow;
use std::path::Path;

/// Takes the numbers of a vertex that stand for themselves, in the order of its properties, until it has enough.
pub(super) type VisitValues<'a> = dyn FnMut(&[f64]) -> ControlFlow<()> + 'a;

/// Hands out the places and classes of the vertices. Gives what stood in the way, if not all could be read.
pub(super) fn read(
    header: &PlyHeader,
    path: &Path,
    file: impl BufRead + Seek,
    visit: &mut Visit,
) -> Option<InputError> {
    let meanings: Vec<Meaning> = header.vertex.singles().map(|property| property.meaning).collect();
    read_values(header, path, file, &mut |values| {
        let (mut position, mut class) = ([0.0; 3], 0);
        for (meaning, value) in meanings.iter().zip(values) {
            match *meaning {
                Meaning::Axis(axis) => position[axis] = *value,
                Meaning::Class => class = class_of(*value),
                Meaning::Other => {}
            }
        }
        visit(position, class)
    })
}

/// Hands out the vertices, each as the numbers of its properties without the lists. Gives what stood in the way, if not all
/// could be read.
pub(super) fn read_values(
    header: &PlyHeader,
    path: &Path,
    mut file: impl BufRead + Seek,
    visit: &mut VisitValues,
) -> Option<InputError> {
    let fault = |place: String, found: String| {
        let fault = InputError::new(path, found, format!("{} vertices, as its header says", header.vertices()));
        Some(fault.at(place).remedy("The file is damaged or cut off: fetch or export it again"))
    };
    if let Err(error) = file.seek(SeekFrom::Start(header.data_start)) {
        return fault("header".to_owned(), error.to_string());
    }
    if header.encoding == Encoding::Ascii {
        let mut lines = Lines::new(file, header.lines);
        return match read_text(header, &mut lines, visit) {
            Ok(()) => None,
            Err(found) => fault(format!("line {}", lines.number), found),
        };
    }
    match read_binary(header, file, visit) {
        Ok(()) => None,
        Err((vertex, error)) => {
            let found = match error.kind() {
                io::ErrorKind::UnexpectedEof => "the end of the file".to_owned(),
                _ => error.to_string(),
            };
            fault(format!("vertex {vertex}"), found)
        }
    }
}

/// The next line; the error is what was found instead.
fn advance<R: BufRead>(lines: &mut Lines<R>) -> Result<(), String> {
    match lines.advance() {
        Ok(Line::Read) => Ok(()),
        Ok(Line::End) => Err("the end of the file".to_owned()),
        Ok(Line::TooLong) => Err(Lines::<R>::too_long()),
        Err(error) => Err(error.to_string()),
    }
}

fn read_text<R: BufRead>(header: &PlyHeader, lines: &mut Lines<R>, visit: &mut VisitValues) -> Result<(), String> {
    let mut values = Vec::new();
    for element in &header.before {
        for _ in 0..element.count {
            advance(lines)?;
        }
    }
    for vertex in 1..=header.vertex.count {
        advance(lines)?;
        // A number of a line that is cut off is another number.
        let may_end = header.is_last && vertex == header.vertex.count;
        if !lines.is_ended && !may_end {
            return Err("the end of the file within a line".to_owned());
        }
        parse(&header.vertex, lines.text().ok_or_else(|| lines.shown())?, &mut values)?;
        if visit(&values).is_break() {
            break;
        }
    }
    Ok(())
}

/// The numbers of a vertex from its line.
fn parse(vertex: &Element, text: &str, values: &mut Vec<f64>) -> Result<(), String> {
    let mut words = text.split_ascii_whitespace();
    values.clear();
    for property in &vertex.properties {
        let mut number = || {
            let word = words.next().ok_or_else(|| format!("{}, which is too short", shown(text)))?;
            word.parse::<f64>().map_err(|_| format!("{} where a number stands", shown(word)))
        };
        let value = number()?;
        if property.list.is_some() {
            // A line has an end, so a list that claims more than it has ends there.
            for _ in 0..value.max(0.0) as u64 {
                number()?;
            }
            continue;
        }
        values.push(value);
    }
    Ok(())
}

/// Reads vertices; the error comes with the number of the vertex.
fn read_binary(header: &PlyHeader, mut file: impl BufRead, visit: &mut VisitValues) -> Result<(), (u64, io::Error)> {
    let mut of_list = [0; 8];
    for element in &header.before {
        skip_all(element, header.encoding, &mut file).map_err(|e| (0, e))?;
    }
    let mut record = vec![0; header.vertex.size().unwrap_or(0)];
    let mut values = Vec::new();
    for index in 0..header.vertex.count {
        values.clear();
        if record.is_empty() {
            for property in &header.vertex.properties {
                if property.list.is_some() {
                    skip(property, header.encoding, &mut file).map_err(|e| (index, e))?;
                } else {
                    let bytes = &mut of_list[..property.kind.size()];
                    file.read_exact(bytes).map_err(|e| (index, e))?;
                    values.push(number(property.kind, header.encoding, bytes));
                }
            }
        } else {
            file.read_exact(&mut record).map_err(|e| (index, e))?;
            let mut rest = record.as_slice();
            for property in &header.vertex.properties {
                let (bytes, behind) = rest.split_at(property.kind.size());
                values.push(number(property.kind, header.encoding, bytes));
                rest = behind;
            }
        }
        if visit(&values).is_break() {
            break;
        }
    }
    Ok(())
}

/// Passes over all of an element.
fn skip_all(element: &Element, encoding: Encoding, file: &mut impl BufRead) -> io::Result<()> {
    if let Some(size) = element.size() {
        let bytes = element.count.checked_mul(size as u64).ok_or(io::ErrorKind::UnexpectedEof)?;
        return pass_over(file, bytes);
    }
    for _ in 0..element.count {
        for property in &element.properties {
            skip(property, encoding, file)?;
        }
    }
    Ok(())
}

/// Passes over a property.
fn skip(property: &Property, encoding: Encoding, file: &mut impl BufRead) -> io::Result<()> {
    let Some(of_count) = property.list else { return pass_over(file, property.kind.size() as u64) };
    let mut bytes = [0; 8];
    let bytes = &mut bytes[..of_count.size()];
    file.read_exact(bytes)?;
    let count = number(of_count, encoding, bytes);
    if count < 0.0 {
        return Err(io::Error::new(io::ErrorKind::InvalidData, format!("a list of {count} numbers")));
    }
    pass_over(file, (count as u64).saturating_mul(property.kind.size() as u64))
}

/// Passes over some bytes, which must be there.
fn pass_over(file: &mut impl BufRead, bytes: u64) -> io::Result<()> {
    let passed = io::copy(&mut file.by_ref().take(bytes), &mut io::sink())?;
    if passed == bytes { Ok(()) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
}

/// A number from its bytes, as many as its type has.
fn number(kind: Scalar, encoding: Encoding, bytes: &[u8]) -> f64 {
    let mut low = [0; 8];
    for (i, byte) in bytes.iter().take(8).enumerate() {
        let place = if encoding == Encoding::BigEndian { bytes.len() - 1 - i } else { i };
        low[place] = *byte;
    }
    let bits = u64::from_le_bytes(low);
    match kind {
        Scalar::I8 => f64::from(bits as i8),
        Scalar::U8 => f64::from(bits as u8),
        Scalar::I16 => f64::from(bits as i16),
        Scalar::U16 => f64::from(bits as u16),
        Scalar::I32 => f64::from(bits as i32),
        Scalar::U32 => f64::from(bits as u32),
        Scalar::I64 => bits as i64 as f64,
        Scalar::U64 => bits as f64,
        Scalar::F32 => f64::from(f32::from_bits(bits as u32)),
        Scalar::F64 => f64::from_bits(bits),
    }
}
