//! What is to be done.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::feed::Fed;
use crate::error::{Error, Result};
use crate::network::FieldOptions;
use crate::reconstruct::Parameters;
use crate::segment::SegmentOptions;
use crate::sink::PointCloud;
use crate::source::footprints::{self, FootprintOptions};
use crate::source::points::Placement;

/// What is to be done. All but the tiles or points, the footprints and the output has a default.
#[derive(Debug, Clone, Default)]
pub struct Job {
    /// LAS, LAZ, COPC, PLY and text files, folders of them, and glob patterns.
    pub tiles: Vec<String>,
    /// Points that came without a file; they count as one more tile. With them there need be no other.
    pub fed: Option<Fed>,
    /// The footprints; `None` takes what stands apart in the points for an object each.
    pub footprints: Option<FootprintSource>,
    /// The outlines of the roofs, for LoD 2.3: as [`FootprintSource::path`], where the footprints are those of the walls.
    pub roofprints: Option<PathBuf>,
    /// A file, whose extension chooses the format, or a folder (see [`super::output::model_path`]); or a stream, which gets
    /// CityJSONSeq: `-` for standard output, or a pipe. Only a run into a sink
    /// of one's own (see [`super::run_into`]) may leave it empty; then no model is written to a file.
    pub output: PathBuf,
    /// The title of the model; `None` takes the name of the file of footprints, or else of the first tile.
    pub title: Option<String>,
    /// Whether files that exist are replaced.
    pub overwrite: bool,
    /// Whether to go on from what a run that was killed has left for this output.
    pub resume: bool,
    /// Where the report goes; `None` puts it next to the model, if that goes to a file.
    pub report: Option<PathBuf>,
    /// The CRS of the tiles, whatever they say.
    pub crs: Option<String>,
    /// How the coordinates of tiles that name no CRS are meant; only without footprints and [`Self::crs`].
    pub placement: Option<Placement>,
    /// Number of threads; `None` for one per processor.
    pub threads: Option<NonZeroUsize>,
    /// Which points belong to a building.
    pub segmentation: SegmentOptions,
    /// The parameters of the method.
    pub parameters: Parameters,
    /// Which implicit field says how much each cell is inside.
    pub field: FieldOptions,
    /// What the model says of the point cloud.
    pub point_cloud: PointCloud,
    /// The command line, for the report.
    pub command: Vec<String>,
}

/// Where the footprints come from.
#[derive(Debug, Clone)]
pub struct FootprintSource {
    /// The file; or a `PostGIS` database, `PG:` and a connection string of libpq, or its `postgresql://` URL.
    pub path: PathBuf,
    /// How to read it.
    pub options: FootprintOptions,
}

impl FootprintSource {
    /// What the model is named after where the output is a folder; see [`footprints::name`].
    pub fn name(&self) -> PathBuf {
        footprints::name(&self.path, &self.options)
    }
}

impl Job {
    /// The threads that do the work.
    ///
    /// # Errors
    /// The system does not give that many.
    pub(super) fn pool(&self) -> Result<ThreadPool> {
        let threads = self.threads.or_else(|| std::thread::available_parallelism().ok()).map_or(1, NonZeroUsize::get);
        ThreadPoolBuilder::new()
            .num_threads(threads)
            .thread_name(|i| format!("gable-{i}"))
            .build()
            .map_err(|e| Error::io(format!("{threads} threads"), "start", std::io::Error::other(e)))
    }
}
