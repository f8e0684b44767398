//! How good is a model: distances, overlap, complexity.

mod cover;
mod faces;
mod hausdorff;
mod overlap;
mod shape;
mod summary;
mod triangulate;

pub use cover::Cover;
pub use faces::{FaceCount, count_faces};
pub use hausdorff::{NearestFace, SurfaceDistance, surface_distance};
pub use overlap::{Overlap, overlap};
pub use shape::{Shape, ShapeFace};
pub use summary::DistanceSummary;
pub use triangulate::triangulate;
