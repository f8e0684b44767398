//! Planar primitives (paper, section 3.1): detection, refinement, and the planes of what was not scanned.
//!
//! ```text
//! points ─► cloud ─► neighbours ─► normals ─► region growing │ RANSAC ─► refine (Algorithm 1) ─► primitives
//! ```
//!
//! [`detect()`] is the whole of that road. Its tolerances follow from the noise and the density that it measures in each
//! building, so that one set of parameters serves laser scans of one to fifty points per square metre and noisier
//! clouds from image matching alike.

mod cloud;
pub mod connected;
mod detect;
pub mod enclosure;
pub mod footprint_edges;
mod gaps;
pub mod height_jumps;
mod hull;
mod moments;
mod moving_least_squares;
pub mod neighbours;
mod noisy;
mod normals;
mod octree;
mod parameters;
mod ransac;
mod refine;
mod region_growing;
mod regularise;
pub mod roof_map;
mod segmentation;
#[cfg(test)]
mod synthetic;
#[cfg(test)]
mod tests;
pub mod trace;
pub mod undersides;
pub mod walls;

use nalgebra::Point3;

use crate::geometry::Plane;

pub use detect::{Detection, detect, found_at_first};
pub use parameters::{DetectionParameters, Detector};
pub use refine::refine;

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
    /// residual, local metres) meets. For detected primitives it is the convex hull of the inliers projected onto the
    /// plane, counter-clockwise seen from the side of the normal, slightly enlarged where the hull had more than 16
    /// corners: tighter than the bounding rectangle of the reference code, and it cuts no cell that the inliers do not
    /// reach.
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

impl Primitive {
    /// The detected primitive on some points, its plane fitted by least squares (method, section 1: the PCA refit of
    /// each group). `None` when there are fewer than three of them or they lie on a line, or when an index is out of
    /// range.
    pub fn from_inliers(points: &[Point3<f64>], inliers: Vec<u32>) -> Option<Self> {
        let on_plane: Option<Vec<&Point3<f64>>> = inliers.iter().map(|&i| points.get(i as usize)).collect();
        let (plane, _) = Plane::fit(on_plane?)?;
        Self::on_plane(plane, points, inliers)
    }

    /// The detected primitive on some points with a plane that is given; the indices must be in range. `None` when the
    /// points do not span a polygon on the plane.
    pub(super) fn on_plane(plane: Plane, points: &[Point3<f64>], mut inliers: Vec<u32>) -> Option<Self> {
        inliers.sort_unstable();
        inliers.dedup();
        let at = |i: &u32| &points[*i as usize];
        let squares: f64 = inliers.iter().map(|i| plane.distance(at(i)).powi(2)).sum();
        let extent = Extent::Patch(hull::convex_hull(&plane, inliers.iter().map(at))?);
        let residual = (squares / inliers.len() as f64).sqrt();
        Some(Self { kind: PrimitiveKind::Detected, plane, inliers, residual, extent })
    }

    /// The corners of a plane that was detected by nobody, but which a person says is there: it has no inliers.
    pub(super) fn asserted(&self) -> Option<&[Point3<f64>]> {
        match &self.extent {
            Extent::Patch(corners) if self.inliers.is_empty() && self.kind == PrimitiveKind::Detected => Some(corners),
            _ => None,
        }
    }
}
