//! How good is a city model: distances, overlap, complexity.
//!
//! ```text
//! CityJSON ──read_shapes──► Shape ─┬─ PointMeter: laser points to roofs and faces
//!                                  ├─ CompletenessMeter: what is missing, in excess, or roofed ground
//!                                  ├─ surface_distance, overlap: to a reference
//!                                  └─ count_faces: how compact it is
//! ```
//!
//! A [`Shape`] is a building in one level of detail, all its parts together, in local metres; it need not be valid or
//! closed. [`Evaluation`] holds all figures of a model, over all buildings and building by building.
//!
//! ```
//! use gable::evaluate::{PointMeter, Shape, ShapeFace};
//! use nalgebra::Point3;
//!
//! // A flat roof at 3 m over a square of 4 m.
//! let ring = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]].map(|[x, y]| Point3::new(x, y, 3.0)).to_vec();
//! let roof = Shape::new("roof", vec![ShapeFace { rings: vec![ring], kind: None, solid: 0 }], &[]);
//!
//! let mut meter = PointMeter::new(&[roof]);
//! meter.add(&[Point3::new(1.0, 1.0, 3.1), Point3::new(2.0, 3.0, 2.95), Point3::new(9.0, 9.0, 3.0)]);
//! let (all, _) = meter.finish();
//! assert_eq!((all.points, all.without_roof), (2, 0));
//! assert_eq!(all.vertical.unwrap().within_0_2, 1.0);
//! ```

mod agreement;
mod completeness;
mod evaluation;
mod faces;
mod hausdorff;
mod model;
mod outlines;
mod overlap;
mod residual;
mod shape;
mod summary;
mod tiles;

#[cfg(test)]
mod tests;

pub use crate::geometry::{Cover, triangulate};
pub use agreement::{Agreement, PointMeter};
pub use completeness::{BuildingCompleteness, CompletenessMeter, Fault, FaultyArea};
pub use evaluation::{BuildingEvaluation, Evaluation, Overall, OverallReference, ReferenceAgreement, Tops, Typical};
pub use faces::{FaceCount, count_faces};
pub use hausdorff::{NearestFace, SurfaceDistance, surface_distance};
pub use model::{ModelFile, read_shapes};
pub use outlines::Outlines;
pub use overlap::{Overlap, overlap};
pub use residual::Residuals;
pub use shape::{Shape, ShapeFace};
pub use summary::{DistanceSummary, median};
pub use tiles::{Classified, TileFilter, stream_points};
