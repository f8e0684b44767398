//! Points as columns.

use std::ffi::c_char;

use super::text::from_c;
use crate::error::{InputError, Result};
use crate::run::Feed;
use crate::source::points::ScanPoint;

/// Bits of a point's flags, as in LAS 1.4 R15, table 16.
const SYNTHETIC: u8 = 0x01;
const WITHHELD: u8 = 0x04;
const OVERLAP: u8 = 0x08;

/// A chunk of points, as columns of the same length. Set all of it to zero first (`gable_chunk chunk = {0};`): a column
/// that is NULL is not there. The columns are read during the call and stay yours.
#[repr(C)]
#[derive(Debug, Clone, Copy)]
pub struct GableChunk {
    /// sizeof(gable_chunk): tells which columns you know of, so that later versions may add some at the end.
    pub struct_size: usize,
    /// Number of points: the length of every column.
    pub count: usize,
    /// Coordinates in the units of the CRS, easting or its like first. Required; finite.
    pub x: *const f64,
    /// See x.
    pub y: *const f64,
    /// See x.
    pub z: *const f64,
    /// ASPRS classes (2 ground, 6 building, 7 and 18 noise). Required; with the option "building-class": "any" the class
    /// of a point that has none is 0 or 1.
    pub classification: *const u8,
    /// Optional: numbers of the returns, from 1.
    pub return_number: *const u8,
    /// Optional: 1 synthetic, 4 withheld, 8 overlap of two strips; sums of these. Synthetic and withheld points are not used.
    pub flags: *const u8,
    /// Optional: the building that a point belongs to, as a number; negative for none. The number is the id of a
    /// footprint as text, so 17 is "17". Not together with building_name.
    pub building_number: *const i64,
    /// Optional: the same as UTF-8 text; NULL or "" for none.
    pub building_name: *const *const c_char,
}

/// The columns of a chunk after they have been checked.
pub(super) struct Columns<'a> {
    coordinates: [&'a [f64]; 3],
    classes: &'a [u8],
    returns: Option<&'a [u8]>,
    flags: Option<&'a [u8]>,
    numbers: Option<&'a [i64]>,
    names: Option<Vec<Option<&'a str>>>,
}

impl Columns<'_> {
    /// Reads what `chunk` points to.
    ///
    /// # Errors
    /// A required column is missing, a column is misaligned or longer than memory, a coordinate is not a finite number, a
    /// name is no UTF-8, or the structure is not of this version or an earlier one.
    ///
    /// # Safety
    /// `chunk` is null or points to `struct_size` bytes of a chunk whose columns are null or hold `count` values, names
    /// ending with a zero, all of which stay as they are for `'a`.
    pub(super) unsafe fn read(chunk: *const GableChunk) -> Result<Self, InputError> {
        let fault = |found: String, expected: &str| InputError::new("gable_chunk", found, expected);
        if chunk.is_null() || !chunk.is_aligned() {
            let kind = if chunk.is_null() { "null" } else { "misaligned" };
            return Err(fault(format!("a {kind} pointer"), "one to a chunk"));
        }
        // SAFETY: not null and aligned; the size comes first.
        let size = unsafe { (&raw const (*chunk).struct_size).read() };
        if size != size_of::<GableChunk>() {
            let expected = format!("{} bytes, as this version has", size_of::<GableChunk>());
            return Err(fault(format!("a struct_size of {size}"), &expected)
                .remedy("Set struct_size to sizeof(gable_chunk), and compile with the header of this version"));
        }
        // SAFETY: it is as large as the caller and we agree that it is.
        let chunk = unsafe { chunk.read() };
        let count = chunk.count;
        // SAFETY: the columns hold `count` values, as the caller vouches.
        unsafe {
            let coordinates =
                [required(chunk.x, count, "x")?, required(chunk.y, count, "y")?, required(chunk.z, count, "z")?];
            for (name, column) in ["x", "y", "z"].into_iter().zip(coordinates) {
                if let Some(place) = column.iter().position(|value| !value.is_finite()) {
                    let found = format!("{name} = {}", column[place]);
                    return Err(fault(found, "finite coordinates")
                        .at(format!("point {place}"))
                        .remedy("None of the chunk's points were taken: leave such points out"));
                }
            }
            if !chunk.building_number.is_null() && !chunk.building_name.is_null() {
                return Err(fault("building_number and building_name".to_owned(), "one of them"));
            }
            let names = match optional(chunk.building_name, count, "building_name")? {
                None => None,
                Some(names) => {
                    let text = |(place, name): (usize, &*const c_char)| match from_c(*name, "gable_chunk") {
                        Ok(name) => Ok(name.filter(|name| !name.is_empty())),
                        Err(fault) => Err(fault.at(format!("building_name of point {place}"))),
                    };
                    Some(names.iter().enumerate().map(text).collect::<Result<Vec<_>, _>>()?)
                }
            };
            Ok(Self {
                coordinates,
                classes: required(chunk.classification, count, "classification")?,
                returns: optional(chunk.return_number, count, "return_number")?,
                flags: optional(chunk.flags, count, "flags")?,
                numbers: optional(chunk.building_number, count, "building_number")?,
                names,
            })
        }
    }

    /// Pushes all points.
    ///
    /// # Errors
    /// The temporary folder cannot be written to.
    pub(super) fn push(&self, feed: &mut Feed) -> Result<()> {
        let [x, y, z] = self.coordinates;
        // Points of a building mostly come together, and a number need not be written out for each.
        let mut last = (-1, None);
        for (i, &class) in self.classes.iter().enumerate() {
            let mut point = ScanPoint::new([x[i], y[i], z[i]], class);
            if let Some(returns) = self.returns {
                point.return_number = returns[i];
            }
            if let Some(flags) = self.flags {
                point.synthetic = flags[i] & SYNTHETIC != 0;
                point.withheld = flags[i] & WITHHELD != 0;
                point.overlap = flags[i] & OVERLAP != 0;
            }
            if let Some(numbers) = self.numbers {
                let number = numbers[i];
                if last.0 != number {
                    last = (number, (number >= 0).then(|| feed.building(&number.to_string())));
                }
                point.building = last.1;
            }
            if let Some(names) = &self.names {
                point.building = names[i].map(|name| feed.building(name));
            }
            feed.push([point])?;
        }
        Ok(())
    }
}

/// # Errors
/// The column is null (unless there is no point), misaligned or too long.
///
/// # Safety
/// As [`optional`].
unsafe fn required<'a, T>(column: *const T, count: usize, name: &str) -> Result<&'a [T], InputError> {
    // SAFETY: the same holds.
    match unsafe { optional(column, count, name) }? {
        Some(values) => Ok(values),
        None if count == 0 => Ok(&[]),
        None => Err(InputError::new("gable_chunk", format!("no column {name}"), format!("one of {count} values"))),
    }
}

/// # Errors
/// The column is misaligned or too long.
///
/// # Safety
/// `column` is null or holds `count` values that stay as they are for `'a`.
unsafe fn optional<'a, T>(column: *const T, count: usize, name: &str) -> Result<Option<&'a [T]>, InputError> {
    if column.is_null() {
        return Ok(None);
    }
    let fault = |found: String, expected: &str| Err(InputError::new("gable_chunk", found, expected).at(name));
    if !column.is_aligned() {
        return fault("a misaligned pointer".to_owned(), "one to values of its type");
    }
    if count.checked_mul(size_of::<T>()).is_none_or(|bytes| bytes > isize::MAX as usize) {
        return fault(format!("a count of {count}"), "one that fits in memory");
    }
    // SAFETY: not null, aligned, not longer than an object can be, and the caller vouches for the rest.
    Ok(Some(unsafe { std::slice::from_raw_parts(column, count) }))
}
