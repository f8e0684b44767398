//! What is wrong with a tile that is used nevertheless.

use schemars::JsonSchema;
use serde::Serialize;
use std::fmt;
use std::path::{Path, PathBuf};

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
    /// The extent in the header is not one; that of the points was used.
    UnusableExtent {
        /// The tile.
        tile: PathBuf,
    },
    /// The extent in the header does not hold all points; that of the points was used.
    PointsOutsideExtent {
        /// The tile.
        tile: PathBuf,
        /// How many lie outside.
        points: u64,
        /// Points read.
        read: u64,
    },
    /// The file holds more points than its header announces. They were not read.
    UnannouncedPoints {
        /// The tile.
        tile: PathBuf,
        /// How many more, at least.
        points: u64,
        /// Points that the header announces.
        announced: u64,
    },
}

impl TileProblem {
    /// The tile that has the problem.
    pub fn tile(&self) -> &Path {
        match self {
            Self::MissingPoints { tile, .. }
            | Self::AbsurdCoordinates { tile, .. }
            | Self::UnusableExtent { tile }
            | Self::PointsOutsideExtent { tile, .. }
            | Self::UnannouncedPoints { tile, .. } => tile,
        }
    }
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
                write!(f, "{}: the extent in the header is unusable; that of the points is used", tile.display())
            }
            Self::PointsOutsideExtent { tile, points, read } => write!(
                f,
                "{}: {points} of {read} points lie outside the extent in the header; that of the points is used",
                tile.display()
            ),
            Self::UnannouncedPoints { tile, points, announced } => write!(
                f,
                "{}: the file holds at least {points} points more than the {announced} that its header announces; they are \
                 not read: have the header completed, or write the file anew",
                tile.display()
            ),
        }
    }
}
