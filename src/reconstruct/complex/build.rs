//! From primitives and a box to the complex.

use nalgebra::Point3;

use super::patch::Patch;
use super::plane::{REACH, SCALE};
use super::split::Partition;
use super::tree::NodeId;
use super::{Cell, CellId, Complex, Facet, IntegerPlane, OUTSIDE, PlaneId, PrimitivePlane, Vertex, insertion_order};
use crate::geometry::Aabb;
use crate::reconstruct::primitives::{Extent, Primitive};

/// The number of cells at which a partition gives up, which bounds its memory at about 1.2 GB. A church of 218
/// primitives has 1 900; 1 000 rectangles of 20 to 80 m, strewn over a cube of 100 m, have a million.
pub const MAX_CELLS: usize = 1_500_000;

/// Why a complex could not be made.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ComplexError {
    /// The box is empty, not finite or too far from the origin.
    #[error("the bounds {min:?} to {max:?} are empty or not within {REACH} m of the origin of the local frame")]
    Bounds {
        /// Smallest x, y, z, metres.
        min: [f64; 3],
        /// Largest x, y, z, metres.
        max: [f64; 3],
    },
    /// The plane of a primitive is not finite or too far from the origin.
    #[error("the plane of primitive {primitive} is not finite or further than 16 384 m from the origin")]
    Plane {
        /// Index of the primitive.
        primitive: usize,
    },
    /// The patch of a primitive is not a polygon.
    #[error("the patch of primitive {primitive} has {corners} corners or one that is not finite")]
    Patch {
        /// Index of the primitive.
        primitive: usize,
        /// Number of its corners; at least three are needed.
        corners: usize,
    },
    /// The partition would have more cells than allowed.
    #[error("more than {limit} cells after {inserted} of {total} primitives")]
    TooManyCells {
        /// The largest number of cells allowed.
        limit: usize,
        /// Number of primitives inserted before the one that went over it.
        inserted: usize,
        /// Number of primitives.
        total: usize,
    },
}

impl Complex {
    /// The adaptive partition (paper, section 3.2): each primitive cuts the cells that its patch meets, in
    /// [`insertion_order`]. The box is widened to the grid of 2⁻²⁰ m.
    ///
    /// # Errors
    /// When the box or a primitive is out of range, or with more than [`MAX_CELLS`] cells.
    pub fn adaptive(primitives: &[Primitive], bounds: &Aabb) -> Result<Self, ComplexError> {
        Self::adaptive_within(primitives, bounds, MAX_CELLS)
    }

    /// [`Self::adaptive`] with a limit of its own on the number of cells.
    ///
    /// # Errors
    /// When the box or a primitive is out of range, or with more than `max_cells` cells.
    pub fn adaptive_within(primitives: &[Primitive], bounds: &Aabb, max_cells: usize) -> Result<Self, ComplexError> {
        partition(primitives, bounds, max_cells, |primitive| match &primitive.extent {
            Extent::Everywhere => None,
            Extent::Patch(corners) => Some(corners),
        })
    }

    /// The exhaustive partition, for comparison: each primitive cuts every cell that its plane meets. 60 planes in
    /// general position make 36 051 cells.
    ///
    /// # Errors
    /// When the box or a primitive is out of range, or with more than [`MAX_CELLS`] cells.
    pub fn exhaustive(primitives: &[Primitive], bounds: &Aabb) -> Result<Self, ComplexError> {
        Self::exhaustive_within(primitives, bounds, MAX_CELLS)
    }

    /// [`Self::exhaustive`] with a limit of its own on the number of cells.
    ///
    /// # Errors
    /// When the box or a primitive is out of range, or with more than `max_cells` cells.
    pub fn exhaustive_within(primitives: &[Primitive], bounds: &Aabb, max_cells: usize) -> Result<Self, ComplexError> {
        partition(primitives, bounds, max_cells, |_| None)
    }
}

/// Partitions the box by all primitives, each where `reach` says; everywhere where it says nothing.
fn partition<'a>(
    primitives: &'a [Primitive],
    bounds: &Aabb,
    max_cells: usize,
    reach: impl Fn(&'a Primitive) -> Option<&'a Vec<Point3<f64>>>,
) -> Result<Complex, ComplexError> {
    let mut partition = start(bounds)?;
    for (index, primitive) in primitives.iter().enumerate() {
        let (plane, flipped) = IntegerPlane::snap(&primitive.plane).ok_or(ComplexError::Plane { primitive: index })?;
        let plane = partition.plane_id(plane);
        partition.complex.primitive_planes.push(PrimitivePlane { plane, flipped });
    }
    for (inserted, index) in insertion_order(primitives).into_iter().enumerate() {
        let plane = partition.complex.primitive_planes[index].plane;
        let patch = match reach(&primitives[index]) {
            None => None,
            Some(corners) => Some(
                patch(corners, plane, &partition)
                    .ok_or(ComplexError::Patch { primitive: index, corners: corners.len() })?,
            ),
        };
        if !insert(&mut partition, plane, patch, max_cells) {
            return Err(ComplexError::TooManyCells { limit: max_cells, inserted, total: primitives.len() });
        }
    }
    Ok(partition.complex)
}

/// Cuts the cells that `patch` meets, or all cells without one, by `plane`; false when they became more than allowed.
pub(super) fn insert(partition: &mut Partition, plane: PlaneId, patch: Option<Patch>, max_cells: usize) -> bool {
    partition.begin_plane();
    for (leaf, cell) in reached(partition, patch) {
        partition.cut_cell(leaf, cell, plane);
        if partition.complex.cells.len() > max_cells {
            return false;
        }
    }
    true
}

/// The patch with these corners, unless they are no polygon.
fn patch(corners: &[Point3<f64>], plane: PlaneId, partition: &Partition) -> Option<Patch> {
    let finite = corners.iter().all(|p| p.iter().all(|c| c.is_finite()));
    (corners.len() >= 3 && finite).then(|| Patch::on_plane(corners, &partition.float_planes[plane as usize]))
}

/// The cells inside the box that `patch` meets, or all cells without one.
fn reached(partition: &Partition, patch: Option<Patch>) -> Vec<(NodeId, CellId)> {
    let Some(mut patch) = patch else { return partition.tree.leaves(None, &partition.float_planes) };
    // The six planes of the box, of which every second one has the box on its negative side.
    for (index, plane) in partition.float_planes.iter().take(6).enumerate() {
        let (negative, positive) = patch.divide(plane);
        match if index % 2 == 0 { positive } else { negative } {
            Some(inside) => patch = inside,
            None => return Vec::new(),
        }
    }
    partition.tree.leaves(Some(patch), &partition.float_planes)
}

/// The box as a partition of one cell.
pub(super) fn start(bounds: &Aabb) -> Result<Partition, ComplexError> {
    let error = ComplexError::Bounds { min: bounds.min, max: bounds.max };
    let mut planes = Vec::with_capacity(6);
    for axis in 0..3 {
        let (low, high) = (bounds.min[axis], bounds.max[axis]);
        // NaN fails both comparisons.
        if !(low >= -REACH && high <= REACH) {
            return Err(error);
        }
        let (low, high) = ((low * SCALE).floor() as i64, (high * SCALE).ceil() as i64);
        if low >= high {
            return Err(error);
        }
        planes.extend([IntegerPlane::across(axis, low), IntegerPlane::across(axis, high)]);
    }
    let mut partition = Partition::new(&planes);
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        // Counter-clockwise seen from where the axis points to; each edge lies on the second plane of its first corner.
        let sides = [[2 * u, 2 * v], [2 * u + 1, 2 * v], [2 * u + 1, 2 * v + 1], [2 * u, 2 * v + 1]];
        let edges = [2 * v, 2 * u + 1, 2 * v + 1, 2 * u].map(|plane| plane as PlaneId);
        for (plane, cells) in [(2 * axis, [OUTSIDE, 0]), (2 * axis + 1, [0, OUTSIDE])] {
            let mut corners = Vec::with_capacity(4);
            for [a, b] in sides {
                let corner = Vertex::meet([&planes[plane], &planes[a], &planes[b]]).ok_or_else(|| error.clone())?;
                corners.push(partition.vertex_id(corner));
            }
            let facet = Facet { plane: plane as PlaneId, corners, edges: edges.to_vec(), cells };
            partition.complex.facets.push(facet);
        }
    }
    partition.complex.cells.push(Cell { facets: (0..6).collect() });
    Ok(partition)
}
