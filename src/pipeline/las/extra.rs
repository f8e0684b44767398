//! The extra bytes of point records (LAS 1.4 R15, section 2.6.6 and tables 24 and 25).

use las::{Header, Vlr};

use crate::pipeline::points::NumberType;

/// Who defines the record that describes extra bytes, and its number.
const USER_ID: &str = "LASF_Spec";
const RECORD_ID: u16 = 4;
/// Bytes of one description.
const DESCRIPTION: usize = 192;
/// Bits of its options: the scale and the offset count.
const HAS_SCALE: u8 = 0x08;
const HAS_OFFSET: u8 = 0x10;

/// A dimension in the extra bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct ExtraDimension {
    /// Its name.
    pub name: String,
    /// How it is stored.
    pub kind: NumberType,
    /// Where it stands in the extra bytes.
    pub at: usize,
    /// Scale and offset of the stored number, where it has them; then the dimension is a double.
    pub scaled: Option<(f64, f64)>,
}

impl ExtraDimension {
    /// The dimensions that a header describes, as far as the records have room for them. Undocumented bytes are passed
    /// over; arrays become a dimension per element, as in PDAL.
    pub fn of_header(header: &Header) -> Vec<Self> {
        let room = usize::from(header.point_format().extra_bytes);
        let record = header.all_vlrs().find(|vlr| vlr.user_id == USER_ID && vlr.record_id == RECORD_ID);
        let mut found = Vec::new();
        let mut at = 0;
        for description in record.map_or(&[][..], |vlr| &vlr.data).chunks_exact(DESCRIPTION) {
            let (code, options) = (description[2], description[3]);
            if code == 0 {
                at += usize::from(options);
                continue;
            }
            // Codes 11 to 20 are pairs and 21 to 30 triples of the types 1 to 10.
            let (Some(kind), elements) =
                (NumberType::of_las_code((code - 1) % 10 + 1), usize::from((code - 1) / 10 + 1))
            else {
                break;
            };
            if elements > 3 {
                break;
            }
            let name = String::from_utf8_lossy(&description[4..36]);
            let name = valid_name(name.trim_end_matches('\0').trim());
            for element in 0..elements {
                if at + kind.size() > room {
                    return found;
                }
                let double = |start: usize| {
                    let start = start + 8 * element;
                    description
                        .get(start..)
                        .and_then(|bytes| bytes.first_chunk())
                        .map_or(0.0, |b| f64::from_le_bytes(*b))
                };
                let scale = if options & HAS_SCALE != 0 { double(112) } else { 1.0 };
                let offset = if options & HAS_OFFSET != 0 { double(136) } else { 0.0 };
                let is_scaled = options & (HAS_SCALE | HAS_OFFSET) != 0;
                let name = if elements > 1 { format!("{name}{element}") } else { name.clone() };
                found.push(Self { name, kind, at, scaled: is_scaled.then_some((scale, offset)) });
                at += kind.size();
            }
        }
        found
    }

    /// The record that describes these dimensions.
    pub fn describe(dimensions: &[Self]) -> Vlr {
        let mut data = Vec::with_capacity(dimensions.len() * DESCRIPTION);
        for dimension in dimensions {
            let mut description = [0; DESCRIPTION];
            description[2] = dimension.kind.las_code();
            // The last byte stays zero, as the end of the text.
            for (byte, letter) in description[4..35].iter_mut().zip(dimension.name.bytes()) {
                *byte = letter;
            }
            data.extend_from_slice(&description);
        }
        Vlr { user_id: USER_ID.to_owned(), record_id: RECORD_ID, description: "Extra bytes".to_owned(), data }
    }
}

/// A name of a dimension: letters, digits and `_`, others become `_`, as PDAL's `fix_dims` does.
fn valid_name(name: &str) -> String {
    let valid = |c: char| if c.is_alphanumeric() || c == '_' { c } else { '_' };
    let name: String = name.chars().map(valid).collect();
    if name.starts_with(|c: char| c.is_alphabetic() || c == '_') { name } else { format!("_{name}") }
}
