//! A procedural generator of buildings: what cities have, and what laser scans leave open.
//!
//! A building is drawn as the union of convex pieces (a block under its roof, a dormer, a chimney) without some others (a
//! courtyard, an arcade), and becomes a closed, valid, labelled [`Solid`] by the same exact cell complex and surface
//! extraction as a reconstructed one.
//!
//! - `convex`, `plan`, `roof`: half-spaces, and what makes blocks of them.
//! - `draft`: what is drawn, and from it to [`Generated`].
//! - `principal`, `court`: the main block; `annexes`, `details`, `openings`, `party`: what comes beside, onto, into and
//!   next to it.
//! - `expression`: from pieces to the solid.

mod annexes;
mod convex;
mod court;
mod details;
mod draft;
mod error;
mod expression;
mod openings;
mod party;
mod plan;
mod principal;
mod roof;
#[cfg(test)]
mod tests;

use geo::MultiPolygon;
use serde::{Deserialize, Serialize};

use crate::geometry::Random;
use crate::site::Frame;
use crate::solid::Solid;

pub use error::{Flaw, GenerateError};
pub use roof::RoofKind;

/// How many drafts are drawn from a seed before it is given up. About one draft in a hundred touches itself along an edge or
/// has faces too small for the grid.
pub const ATTEMPTS: u32 = 12;

/// A building that is known exactly.
#[derive(Debug, Clone, PartialEq)]
pub struct Generated {
    /// The true solid, closed and without faults by [`validate`](crate::validate), its faces labelled.
    pub solid: Solid,
    /// The local frame, in metres.
    pub frame: Frame,
    /// The outline as a mapping agency would draw it, local metres: the walls at the ground, and with an overhang or an
    /// arcade the projection of all storeys. Eaves are left out.
    pub footprint: MultiPolygon<f64>,
    /// Height of the ground, local metres.
    pub ground: f64,
    /// Buildings that share a wall with it. They do not overlap it, hide it from the scanner, and are not part of it.
    pub neighbours: Vec<Solid>,
    /// What was drawn.
    pub shape: Shape,
}

/// What a generated building is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Shape {
    /// Roof of the main block.
    pub roof: RoofKind,
    /// Number of blocks: the main block, wings, annexes, setbacks, towers.
    pub blocks: u8,
    /// Number of dormers.
    pub dormers: u8,
    /// Number of chimneys and other boxes on the roof.
    pub chimneys: u8,
    /// Whether there is a courtyard, with the building on all sides.
    pub courtyard: bool,
    /// Whether a storey, a bay, a balcony or a canopy reaches beyond the walls below it.
    pub overhang: bool,
    /// Whether there is a passage under it, open on one or more sides.
    pub arcade: bool,
    /// Whether its roof reaches beyond its walls.
    pub eaves: bool,
    /// Number of neighbours with a party wall.
    pub party_walls: u8,
}

impl Shape {
    /// Whether whatever lies below its roofs, down to the ground, is inside. Eaves are not looked at: they are thin.
    pub fn is_height_field(&self) -> bool {
        !self.overhang && !self.arcade
    }
}

/// The building of a seed. The same seed gives the same building on every machine.
///
/// # Errors
/// When none of [`ATTEMPTS`] drafts is a valid solid; about one seed in many thousands.
pub fn building(seed: u64) -> Result<Generated, GenerateError> {
    let mut random = Random::new(seed);
    let mut flaw = Flaw::Outline;
    for _ in 0..ATTEMPTS {
        match principal::draw(&mut random).finish() {
            Ok(generated) => return Ok(generated),
            Err(found) => flaw = found,
        }
    }
    Err(GenerateError { seed, attempts: ATTEMPTS, flaw })
}
