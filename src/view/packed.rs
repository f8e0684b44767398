//! What pages are given: a head in JSON and columns of numbers, packed into text.

use std::io::Write;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::DeflateEncoder;
use serde::Serialize;

use crate::error::{Error, Result};

/// Steps of the coordinates of the page per metre.
pub(crate) const STEPS_PER_METRE: f64 = 1000.0;

/// Farther from the origin nothing is shown where it is: 2^40 mm, a million kilometres.
const FAR: f64 = (1u64 << 40) as f64;

/// A place of the local frame in steps.
pub(crate) fn steps(local: [f64; 3]) -> [i64; 3] {
    local.map(|metres| (metres * STEPS_PER_METRE).round().clamp(-FAR, FAR) as i64)
}

/// A number of either sign as one without: 0, -1, 1, -2, … as 0, 1, 2, 3, …
pub(crate) fn folded(number: i64) -> u64 {
    ((number << 1) ^ (number >> 63)) as u64
}

/// Integers in LEB128: seven bits a byte, the lowest first, the eighth bit set while more follow.
#[derive(Debug, Default)]
pub(crate) struct Column(Vec<u8>);

impl Column {
    /// Appends a number.
    pub fn push(&mut self, number: u64) {
        let mut rest = number;
        while rest >= 0x80 {
            self.0.push(rest as u8 | 0x80);
            rest >>= 7;
        }
        self.0.push(rest as u8);
    }

    /// Appends a count or an index.
    pub fn push_index(&mut self, index: usize) {
        self.push(index as u64);
    }

    /// Appends a place as its difference from `last`, which it becomes.
    pub fn push_place(&mut self, place: [i64; 3], last: &mut [i64; 3]) {
        for (now, before) in place.iter().zip(last.iter()) {
            self.push(folded(now - before));
        }
        *last = place;
    }

    /// Number of its bytes.
    pub fn len(&self) -> usize {
        self.0.len()
    }
}

/// A head, which says how many bytes each column has, and the columns: deflated, and in base 64.
///
/// # Errors
/// Never in practice: memory takes every byte.
pub(crate) fn packed<'a>(head: &impl Serialize, columns: impl IntoIterator<Item = &'a Column>) -> Result<String> {
    packed_by(Compression::new(7), head, columns)
}

/// The same with less effort, for what is read once, on the same machine.
///
/// # Errors
/// As [`packed`].
#[cfg(feature = "edit")]
pub(crate) fn packed_quickly<'a>(
    head: &impl Serialize,
    columns: impl IntoIterator<Item = &'a Column>,
) -> Result<String> {
    packed_by(Compression::fast(), head, columns)
}

fn packed_by<'a>(
    compression: Compression,
    head: &impl Serialize,
    columns: impl IntoIterator<Item = &'a Column>,
) -> Result<String> {
    let fault = |e| Error::io("the page", "pack", e);
    let head = serde_json::to_vec(head).map_err(|e| fault(e.into()))?;
    let mut deflated = DeflateEncoder::new(Vec::new(), compression);
    let pack = |out: &mut DeflateEncoder<Vec<u8>>| -> std::io::Result<()> {
        out.write_all(&(head.len() as u32).to_le_bytes())?;
        out.write_all(&head)?;
        columns.into_iter().try_for_each(|column| out.write_all(&column.0))
    };
    pack(&mut deflated).map_err(fault)?;
    Ok(STANDARD.encode(deflated.finish().map_err(fault)?))
}
