//! Text that comes from and goes to C.

use std::ffi::{CStr, CString, c_char};

use crate::error::InputError;

/// The text at `text`, which messages call `name`; `None` when it is null.
///
/// # Errors
/// It is no UTF-8.
///
/// # Safety
/// `text` is null or points to a text that ends with a zero and stays as it is for `'a`.
pub(super) unsafe fn from_c<'a>(text: *const c_char, name: &str) -> Result<Option<&'a str>, InputError> {
    if text.is_null() {
        return Ok(None);
    }
    // SAFETY: not null, and the caller vouches for the rest.
    let text = unsafe { CStr::from_ptr(text) };
    match text.to_str() {
        Ok(text) => Ok(Some(text)),
        Err(fault) => {
            let found = format!("a byte that is no UTF-8 at {}", fault.valid_up_to());
            Err(InputError::new(name, found, "text in UTF-8"))
        }
    }
}

/// The text for C; zeros in it, which would end it, become blanks.
pub(super) fn to_c(text: impl Into<Vec<u8>>) -> CString {
    let mut bytes = text.into();
    bytes.iter_mut().filter(|byte| **byte == 0).for_each(|byte| *byte = b' ');
    CString::new(bytes).unwrap_or_default()
}
