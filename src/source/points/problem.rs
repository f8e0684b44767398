//! What is wrong with a tile that is used nevertheless.

use schemars::JsonSchema;
use serde::Serialize;
use std::fmt;
use std::path::PathBuf;

/// What is wrong with a tile whose other points are used nevertheless.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "kebab-case")]
#[non_exhaustive]
pub enum TileProblem {
    /// The file is cut off or damaged: fewer points could be read than its header announces.
    MissingPoints {
        /// The tile.
        tile: PathBuf,
        /// Points announced by the header (by the octree nodes that were wanted, for COPC).
        expected: u64,
        /// Points read.
        read: u64,
        /// Why the rest could not be read.
        cause: String,
    },
    /// Points whose coordinates cannot be: far outside the extent in the header. They were left out.
    AbsurdCoordinates {
        /// The tile.
        tile: PathBuf,
        /// How many.
        points: u64,
    },
    /// The extent in the header is not one, or does not hold the points; that of the points was used.
    UnusableExtent {
        /// The tile.
        tile: PathBuf,
    },
}

impl fmt::Display for TileProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::MissingPoints { tile, expected, read, cause } => write!(
                f,
                "{}: {} of {expected} points are missing ({cause}); the {read} that could be read are used",
                tile.display(),
                expected.saturating_sub(*read)
            ),
            Self::AbsurdCoordinates { tile, points } => {
                write!(f, "{}: {points} points with impossible coordinates were left out", tile.display())
            }
            Self::UnusableExtent { tile } => {
                write!(f, "{}: the extent in the header is not that of the points; theirs is used", tile.display())
            }
        }
    }
}
