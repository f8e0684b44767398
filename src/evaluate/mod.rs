//! How good is a model: distances, overlap, complexity.

mod agreement;
mod cover;
mod evaluation;
mod faces;
mod hausdorff;
mod model;
mod overlap;
mod shape;
mod summary;
mod triangulate;

pub use agreement::{Agreement, PointMeter};
pub use cover::Cover;
pub use evaluation::{BuildingEvaluation, Evaluation, Overall, OverallReference, ReferenceAgreement, Tops, Typical};
pub use faces::{FaceCount, count_faces};
pub use hausdorff::{NearestFace, SurfaceDistance, surface_distance};
pub use model::{ModelFile, read_points, read_shapes};
pub use overlap::{Overlap, overlap};
pub use shape::{Shape, ShapeFace};
pub use summary::DistanceSummary;
pub use triangulate::triangulate;
