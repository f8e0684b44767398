//! Planes, boxes, triangles and polygons in floating point, and random numbers: what every floor above may use.
//!
//! Exact arithmetic, where topology is decided, lives with the [cell complex](crate::reconstruct::complex).

mod boxes;
mod cover;
mod linked;
mod plane;
mod prepared;
mod random;
mod scattered;
mod triangulate;
pub mod validity;

pub(crate) use boxes::Boxes;
pub use cover::{Cover, projected_area};
pub(crate) use linked::Linked;
pub use plane::Plane;
pub use prepared::PreparedPolygon;
pub use random::{Random, hash, seed_of};
pub(crate) use scattered::Scattered;
pub use triangulate::{newell, triangle_indices, triangulate};

/// An axis-aligned box in metres of the local frame; `min` is never above `max`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Aabb {
    /// Smallest x, y, z.
    pub min: [f64; 3],
    /// Largest x, y, z.
    pub max: [f64; 3],
}

impl Aabb {
    /// The box of some points; `None` without any.
    pub fn of<'a>(points: impl IntoIterator<Item = &'a nalgebra::Point3<f64>>) -> Option<Self> {
        let mut points = points.into_iter();
        let first = points.next()?;
        let start = Self { min: [first.x, first.y, first.z], max: [first.x, first.y, first.z] };
        Some(points.fold(start, |mut aabb, p| {
            for (axis, value) in [p.x, p.y, p.z].into_iter().enumerate() {
                aabb.min[axis] = aabb.min[axis].min(value);
                aabb.max[axis] = aabb.max[axis].max(value);
            }
            aabb
        }))
    }

    /// Length of the sides.
    pub fn extent(&self) -> [f64; 3] {
        [self.max[0] - self.min[0], self.max[1] - self.min[1], self.max[2] - self.min[2]]
    }
}
