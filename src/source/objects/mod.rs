//! Objects: what lies in object storage or on a web server, read by ranges and written when it is whole.
//!
//! An object is opened once, and what is read of it afterwards is of that version: a range of another is a fault, never a
//! mixture. Requests are tried again with growing pauses, and a fault that stays ends all reading of that object.

mod address;
#[cfg(feature = "remote")]
mod cache;
#[cfg(feature = "remote")]
mod client;
#[cfg(feature = "remote")]
mod fault;
#[cfg(feature = "remote")]
mod listing;
#[cfg(feature = "remote")]
mod object;
#[cfg(feature = "remote")]
mod reader;
#[cfg(not(feature = "remote"))]
mod refused;
#[cfg(feature = "remote")]
mod upload;
#[cfg(feature = "remote")]
mod window;

pub(crate) use address::{is_object, is_web, label, redacted, resolved};
#[cfg(feature = "remote")]
pub(crate) use listing::{exists, list};
#[cfg(feature = "remote")]
pub(crate) use object::Object;
#[cfg(feature = "remote")]
pub(crate) use reader::ObjectReader;
#[cfg(not(feature = "remote"))]
pub(crate) use refused::{Object, ObjectReader, exists, list, put, put_folder};
#[cfg(feature = "remote")]
pub(crate) use upload::{put, put_folder};
