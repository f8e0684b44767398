//! The stages, one file each.

pub mod assign;
pub mod copc_reader;
pub mod crop;
pub mod expression;
pub mod ferry;
pub mod hag_nn;
pub mod head;
pub mod las_reader;
pub mod las_writer;
pub mod lod2_reader;
pub mod lod2_writer;
pub mod merge;
pub mod null_writer;
pub mod outlier;
pub mod range;
pub mod reprojection;
pub mod sample;
pub mod splitter;
pub mod stats;
pub mod text_writer;
