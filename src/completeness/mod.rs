//! Completeness without a reference: what was scanned and is not in the model, and what is in the model and was not
//! scanned.
//!
//! The plan is cut into square cells. What lies inside the footprint, and not so near its outline that wall points
//! mislead, is judged by the points in and around it:
//!
//! - **missing**: most of the top points of the cell lie above the model. Top points are those with no other building
//!   point well above them and near in plan: points on a wall below a roof edge say nothing of the roof.
//! - **excess**: the model lies above every building point around, of which there are some.
//! - **roofed ground**: half of the ground points of the cell, or more, lie under the model with no building point well
//!   above them and near in plan.
//!
//! Cells of one fault that share a side make an [`Area`]. A [`Judge`] is made once per building and judges any number of
//! models of it; its cost grows with the number of points. See [`Limits`] for what "near", "above" and "around" are.
//!
//! ```
//! use gable::completeness::{Judge, Limits, Scan};
//! use gable::geometry::Cover;
//! use nalgebra::Point3;
//!
//! // A roof at 5 m, of which the model has the left half; the right half is left at the floor.
//! let grid = (0..400).map(|i| Point3::new(0.25 + 0.5 * f64::from(i % 20), 0.25 + 0.5 * f64::from(i / 20), 5.0));
//! let points: Vec<_> = grid.collect();
//! let scan = Scan { footprint: None, floor: 0.0, points: &points, ground_points: &[] };
//! let corners = [[0.0, 0.0], [5.0, 0.0], [5.0, 10.0], [0.0, 10.0]].map(|[x, y]| Point3::new(x, y, 5.0));
//! let model = Cover::new([[corners[0], corners[1], corners[2]], [corners[0], corners[2], corners[3]]]);
//! let found = Judge::new(&scan, &Limits::default()).judge(&model);
//! assert_eq!(found.missing.len(), 1);
//! assert_eq!(found.missing[0].area, 50.0);
//! ```

mod areas;
mod judge;
mod lattice;
mod limits;
mod roofs;
mod tally;
#[cfg(test)]
mod tests;

pub use areas::{Area, Completeness};
pub use judge::{Judge, Scan};
pub use limits::Limits;
pub use roofs::tops;
pub use tally::{Count, Counts, Extent, Extents};
