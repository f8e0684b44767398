//! Editing: the last buildings, which a person mends.
//!
//! A [`Session`] holds one building between solves. Each [edit](crate::edits) is data; after each the building is
//! [made again](crate::reconstruct::reconstruct_again) on the road of every run, which does over what the edit touches and
//! remembers the rest.
//!
//! A [`Desk`] holds all buildings of a model: a list of them, the most urgent first, the sessions of those that were asked for
//! last, and the file that all decisions stand in. [`server`] puts it behind a page for one person on the same machine.
//!
//! - `need` says how much a building needs a person, `roll` makes the list.
//! - `book` is the file of edits, `sessions` are those that are open.
//! - `around` holds the points of the tiles, with their classes and intensities.
//! - `payload` is what the page is given of a building, in `drawn`, `planes` and `words`.

#[cfg(feature = "edit")]
mod around;
#[cfg(feature = "edit")]
mod book;
#[cfg(feature = "edit")]
mod desk;
#[cfg(feature = "edit")]
mod drawn;
mod figures;
#[cfg(feature = "edit")]
mod need;
#[cfg(feature = "edit")]
mod payload;
#[cfg(feature = "edit")]
mod planes;
#[cfg(feature = "edit")]
mod roll;
#[cfg(feature = "edit")]
pub mod server;
mod session;
#[cfg(feature = "edit")]
mod sessions;
#[cfg(feature = "edit")]
mod words;

#[cfg(feature = "edit")]
pub use desk::{Desk, Exported, Opening, Refusal, export};
pub use figures::Figures;
pub use session::{Session, Solved};
