//! Points: LAS 1.0 to 1.5, LAZ and COPC tiles, PLY and text, streamed so that memory stays flat whatever the file.
//!
//! - [`expand()`] turns arguments (files, globs, folders) into tiles.
//! - [`Tile::open`] reads and checks the header, nothing more; PLY and text, which have no index, once to their end.
//! - [`Tile::placed`] brings coordinates of another unit or with another axis upwards to metres with heights along z.
//! - [`Tile::stream`] hands out the points block by block; of a COPC tile only the octree nodes that are wanted.
//! - [`Tile::summary`] streams once and counts.
//! - [`SpillWriter`] makes tiles of points that come without a file.
//!
//! The `las` crate gives header, formats and COPC hierarchy, `laz` the decompression. The loop over the chunks is our
//! own, because a damaged or cut-off file must cost the points that are damaged or missing and nothing more: every
//! number that leads to an allocation or a seek is checked against the size of the file first, and a chunk that cannot
//! be decoded is left behind while the next one goes on.

mod block;
mod chunks;
mod claims;
mod cloud;
mod copc;
mod decode;
mod gps_time;
mod header;
mod layered_times;
mod parcels;
mod placement;
mod problem;
mod spill;
mod stream;
mod summary;
mod tile;

#[cfg(test)]
pub(crate) mod fixture;
#[cfg(test)]
mod tests;

use std::path::PathBuf;

use super::expand::Kind;
use super::tile_index;
use crate::error::Result;
pub use block::{Block, ScanPoint};
pub(crate) use cloud::{PlyFile, Scalar, lines};
pub use parcels::Parcels;
pub use placement::{Placement, Unit, UpAxis};
pub use problem::TileProblem;
pub use spill::SpillWriter;
pub use stream::{Reading, Region};
pub use summary::TileSummary;
pub use tile::{Extent, Tile};

/// The kind of file that a tile is: `.las` and `.laz` (so `.copc.laz` too), `.ply`, `.xyz` and `.pts`; other text where a
/// pattern says so.
const TILES: Kind = Kind {
    name: "tiles",
    wanted: "LAS, LAZ, COPC, PLY or text files, folders, glob patterns or an index of tiles",
    extensions: &["las", "laz", "ply", "xyz", "pts"],
    meant: &cloud::TEXT,
};

/// The tiles that arguments name: files, folders (the tiles directly in them) and glob patterns, also in object storage; and
/// those that an [index](super::tile_index) names. Sorted and without duplicates, both by canonical path. A file named outright is
/// taken whatever its extension, but for those of indexes.
///
/// # Errors
/// An argument that does not exist, a pattern that is malformed or matches no tile, a folder without tiles, no argument
/// at all, or a folder that cannot be read.
pub fn expand(arguments: &[String]) -> Result<Vec<PathBuf>> {
    super::expand::expand(&tile_index::spread(arguments)?, &TILES)
}
