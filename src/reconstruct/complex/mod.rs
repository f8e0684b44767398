//! The cell complex (paper, section 3.2): an adaptive binary space partition in exact arithmetic.
//!
//! - `plane`, `exact`: planes snapped once to integers, vertices as the meeting of three of them, and the sign of a
//!   vertex against a plane. These signs are the only thing that decides topology.
//! - `order`: which primitive cuts first.
//! - `patch`, `tree`: which cells a primitive reaches.
//! - `split`, `build`: a cell in two, a box in a complex.
//! - `measure`, `samples`: volumes, areas, neighbours, and points to ask the occupancy at.
//! - `check`: the invariants, for tests.
//!
//! Facets are shared by the two cells they part and are cut once for both, so that the boundary between any two sets
//! of cells is watertight by construction and not by a tolerance.
//!
//! A facet has only true corners: no three of them are on one line. The facets on the other side of an edge may be
//! subdivided further, so an edge of one facet can be several edges of its neighbours; whoever needs matching edges
//! inserts the vertices that lie on it ([`IntegerPlane::side`] says which do, exactly).

mod build;
mod check;
mod cutter;
mod exact;
mod measure;
mod order;
mod patch;
mod plane;
mod samples;
mod split;
#[cfg(test)]
mod tests;
mod tree;

use nalgebra::Point3;

pub use build::{ComplexError, MAX_CELLS};
pub use check::Fault;
pub use cutter::Cutter;
pub use order::insertion_order;
pub use plane::REACH;

/// Index of a plane in [`Complex::planes`].
pub type PlaneId = u32;
/// Index of a vertex in [`Complex::vertices`].
pub type VertexId = u32;
/// Index of a facet in [`Complex::facets`].
pub type FacetId = u32;
/// Index of a cell in [`Complex::cells`].
pub type CellId = u32;

/// The far neighbour of a facet on the bounding box.
pub const OUTSIDE: CellId = CellId::MAX;

/// A partition of a box into convex cells that share their facets.
#[derive(Debug, Clone, Default)]
pub struct Complex {
    /// Distinct planes on the integer grid; no two are the same point set. The first six are those of the box: x min,
    /// x max, y min, y max, z min, z max.
    pub planes: Vec<IntegerPlane>,
    /// Distinct vertices: no two are the same point.
    pub vertices: Vec<Vertex>,
    /// Facets between two cells or between a cell and [`OUTSIDE`].
    pub facets: Vec<Facet>,
    /// Convex cells.
    pub cells: Vec<Cell>,
    /// For each primitive, in the order in which they were given, the plane that it became.
    pub primitive_planes: Vec<PrimitivePlane>,
}

/// The plane that a primitive became: several primitives may share one, with either direction.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PrimitivePlane {
    /// The plane on the integer grid.
    pub plane: PlaneId,
    /// Whether its positive side is the negative side of the primitive's own plane.
    pub flipped: bool,
}

/// The plane `a x + b y + c z + d = 0` with integer coefficients: the normal in steps of 2⁻²⁰, the offset in steps
/// of 2⁻²⁰ m (method, section 4), divided by their common divisor. The first of `c`, `b`, `a` that is not zero is
/// positive, so that planes that are not vertical point up and equal point sets are equal values.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct IntegerPlane {
    /// `a`, `b`, `c`: |·| ≤ 2²⁰.
    pub normal: [i64; 3],
    /// `d`.
    pub offset: i64,
}

/// The point where three planes meet, exactly and in floating point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Vertex {
    /// Homogeneous coordinates `x, y, z, w` with `w > 0`, without common divisor: equal points are equal arrays.
    pub homogeneous: [i128; 4],
    /// The floating-point position, local metres, right to within two units in the last place.
    pub position: Point3<f64>,
}

/// A convex polygon between two cells.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Facet {
    /// The plane it lies on.
    pub plane: PlaneId,
    /// Its corners, counter-clockwise seen from the positive side of the plane.
    pub corners: Vec<VertexId>,
    /// For each corner, the plane that cuts the edge from it to the next corner out of `plane`: both planes contain
    /// that edge exactly.
    pub edges: Vec<PlaneId>,
    /// The cells on the negative and on the positive side of the plane; one of them may be [`OUTSIDE`].
    pub cells: [CellId; 2],
}

/// A convex cell.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Cell {
    /// Its facets.
    pub facets: Vec<FacetId>,
}
