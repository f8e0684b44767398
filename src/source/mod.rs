//! What comes in: points, footprints, coordinate reference systems.

pub mod cityjson;
pub mod classes;
pub mod crs;
pub mod edits;
mod expand;
pub mod footprints;
pub mod groups;
pub(crate) mod objects;
pub(crate) mod open;
pub mod points;
pub mod raster;
pub(crate) mod reread;
pub mod tile_index;
