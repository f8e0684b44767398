//! Bounds on what an `SQLite` file can make its reader do.
//!
//! A view is a program, and need not end: a recursive one yields rows for ever, or works for ever on the first. Bounds on
//! recursion do not exist in `SQLite`, so steps, bytes and memory are bounded, by the size of the file where honest tables
//! need more the larger the file is. No table of an honest file comes near them.

use rusqlite::ffi;
use rusqlite::limits::Limit;
use rusqlite::types::ValueRef;
use rusqlite::{Connection, Error, ErrorCode};
use std::ffi::c_int;

/// Steps of `SQLite`'s machine that every file may take, some seconds' worth, and those for each of its bytes. A row takes
/// a few steps for each of its values, each of which has a byte at least.
const STEPS: u64 = 200_000_000;
const STEPS_PER_BYTE: u64 = 500;
/// Steps between two looks at their count.
const STRIDE: c_int = 100_000;
/// Bytes in memory that the features of every file may take, and those for each of its bytes.
const BYTES: u64 = 64 << 20;
const BYTES_PER_BYTE: u64 = 128;
/// What a value takes in memory besides its own bytes and those of its name.
const VALUE: u64 = 96;
/// The largest value or row; no outline is as large.
const LARGEST_VALUE: i32 = 64 << 20;
/// The memory of `SQLite` itself, in this process as a whole.
const HEAP: i64 = 1 << 30;

/// The bytes that features may still take.
pub(super) struct Allowance {
    left: u64,
    all: u64,
}

/// Bounds what `connection` to a file of `size` bytes may do from now on.
pub(super) fn bound(connection: &Connection, size: u64) -> rusqlite::Result<Allowance> {
    connection.set_limit(Limit::SQLITE_LIMIT_LENGTH, LARGEST_VALUE)?;
    connection.query_row(&format!("PRAGMA hard_heap_limit={HEAP}"), [], |_| Ok(()))?;
    let mut left = size.saturating_mul(STEPS_PER_BYTE).saturating_add(STEPS);
    let count = move || {
        left = left.saturating_sub(STRIDE as u64);
        left == 0
    };
    connection.progress_handler(STRIDE, Some(count));
    let all = size.saturating_mul(BYTES_PER_BYTE).saturating_add(BYTES);
    Ok(Allowance { left: all, all })
}

impl Allowance {
    /// Takes what a value of the column `name` needs.
    ///
    /// # Errors
    /// There is not so much left.
    pub fn take(&mut self, name: &str, value: ValueRef<'_>) -> rusqlite::Result<()> {
        let own = match value {
            ValueRef::Text(bytes) | ValueRef::Blob(bytes) => bytes.len(),
            ValueRef::Null | ValueRef::Integer(_) | ValueRef::Real(_) => 0,
        };
        let Some(left) = self.left.checked_sub(VALUE + (name.len() + own) as u64) else {
            let told = format!("more than {} MB of them", self.all >> 20);
            return Err(Error::SqliteFailure(ffi::Error::new(ffi::SQLITE_INTERRUPT), Some(told)));
        };
        self.left = left;
        Ok(())
    }
}

/// Whether a bound of this file was met.
pub(super) fn is_without_end(error: &Error) -> bool {
    matches!(
        error.sqlite_error_code(),
        Some(ErrorCode::OperationInterrupted | ErrorCode::OutOfMemory | ErrorCode::TooBig)
    )
}
