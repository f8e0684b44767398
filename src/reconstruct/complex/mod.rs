//! The cell complex (paper, section 3.2): an adaptive binary space partition in exact arithmetic.

use nalgebra::Point3;

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
#[derive(Debug, Clone)]
pub struct Complex {
    /// Distinct planes on the integer grid; no two are the same point set.
    pub planes: Vec<IntegerPlane>,
    /// Distinct vertices: no two are the same point.
    pub vertices: Vec<Vertex>,
    /// Facets between two cells or between a cell and [`OUTSIDE`].
    pub facets: Vec<Facet>,
    /// Convex cells.
    pub cells: Vec<Cell>,
}

/// The plane `a x + b y + c z + d = 0` with integer coefficients: the normal in steps of 2⁻²⁰, the offset in steps
/// of 2⁻²⁰ m (method, section 4), divided by their common divisor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
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
    /// The nearest floating-point position, local metres.
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
