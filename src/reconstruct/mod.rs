//! The method: one [`Site`](crate::site::Site) in, one [`Reconstruction`] out.
//!
//! The modules stand in the order of the paper: [`primitives`] → [`complex`] → [`occupancy`] → [`labelling`] →
//! [`surface`]. Nothing here does I/O, starts a thread or reads a clock; random numbers are drawn from a seed derived
//! from the building id: the same site gives the same bytes.

pub mod blocks;
pub mod complex;
pub mod labelling;
pub mod occupancy;
mod parameters;
pub mod primitives;
pub mod surface;

pub use parameters::Parameters;
