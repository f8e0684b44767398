//! Planar primitives (paper, section 3.1): detection, refinement, and the planes of what was not scanned.

use nalgebra::Point3;

use crate::geometry::Plane;

/// Where a primitive comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum PrimitiveKind {
    /// Detected in the points.
    Detected,
    /// Vertical plane through a (regularised) footprint edge.
    FootprintEdge,
    /// Vertical plane along a height jump between two roof segments.
    HeightJump,
}

/// Where a primitive cuts the cell complex.
#[derive(Debug, Clone, PartialEq)]
pub enum Extent {
    /// Every cell that its plane meets.
    Everywhere,
    /// Only cells that this convex polygon (at least three corners, in order, on the plane up to the inliers'
    /// residual, local metres) meets.
    Patch(Vec<Point3<f64>>),
}

/// A planar primitive: a plane, the points on it, and how far it reaches.
#[derive(Debug, Clone, PartialEq)]
pub struct Primitive {
    /// Where it comes from.
    pub kind: PrimitiveKind,
    /// Its plane in the local frame; detected non-vertical planes point up.
    pub plane: Plane,
    /// Indices of its inliers among the site's points, ascending; empty for planes that were not detected.
    pub inliers: Vec<u32>,
    /// Root mean square of the inliers' orthogonal residuals, metres; 0 without inliers.
    pub residual: f64,
    /// How far it reaches in the adaptive partition.
    pub extent: Extent,
}
