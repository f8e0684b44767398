//! Why there is no building.

use crate::reconstruct::complex::ComplexError;
use crate::reconstruct::surface::SurfaceError;
use crate::validate::Fault;

/// Why a draft is no building.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Flaw {
    /// A plane is out of reach of the cell complex.
    #[error("a plane is too far from the origin")]
    Far,
    /// The cell complex cannot be made.
    #[error(transparent)]
    Complex(#[from] ComplexError),
    /// It touches itself along an edge or at a vertex.
    #[error(transparent)]
    Surface(#[from] SurfaceError),
    /// It is not one piece.
    #[error("it falls into {0} pieces")]
    Pieces(usize),
    /// The solid is not valid.
    #[error("the solid is not valid: {0}")]
    Invalid(Fault),
    /// Rounding changed the volume.
    #[error("the solid has {found:.3} m³ where its cells have {expected:.3} m³")]
    Volume {
        /// Volume of the cells, m³.
        expected: f64,
        /// Volume of the solid, m³.
        found: f64,
    },
    /// The outline is not a valid polygon.
    #[error("the outline is not a valid polygon")]
    Outline,
}

/// A seed that gave no building.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[error("seed {seed} gave no building in {attempts} attempts; the last: {flaw}")]
pub struct GenerateError {
    /// The seed.
    pub seed: u64,
    /// How many drafts were drawn from it.
    pub attempts: u32,
    /// What was wrong with the last.
    pub flaw: Flaw,
}
