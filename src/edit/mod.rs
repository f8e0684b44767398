//! Editing: the last buildings, which a person mends.
//!
//! A [`Session`] holds one building between solves. Each [edit](crate::edits) is data; after each the building is
//! [made again](crate::reconstruct::reconstruct_again) on the road of every run, which does over what the edit touches and
//! remembers the rest.

mod figures;
mod session;

pub use figures::Figures;
pub use session::{Session, Solved};
