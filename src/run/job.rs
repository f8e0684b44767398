//! What is to be done.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use rayon::{ThreadPool, ThreadPoolBuilder};

use super::clouds::CloudSource;
use super::crop;
use super::feed::Fed;
use super::limit::Limit;
use super::output;
use super::template::Template;
use crate::error::{Error, InputError, Result};
use crate::network::FieldOptions;
use crate::reconstruct::Parameters;
use crate::segment::SegmentOptions;
use crate::sink::{AttributeOptions, PointCloud};
use crate::source::footprints::{self, FootprintOptions};
use crate::source::points::Placement;
use crate::terrain::TerrainOptions;

/// What is to be done. All but the tiles or points, the footprints and the output has a default.
#[derive(Debug, Clone, Default)]
pub struct Job {
    /// LAS, LAZ, COPC, PLY and text files, folders of them, and glob patterns.
    pub tiles: Vec<String>,
    /// Points that came without a file; they count as one more tile. With them there need be no other.
    pub fed: Option<Fed>,
    /// More point clouds: each building is made from the best of them and of the tiles.
    pub clouds: Vec<CloudSource>,
    /// The footprints; `None` takes what stands apart in the points for an object each.
    pub footprints: Option<FootprintSource>,
    /// The outlines of the roofs, for LoD 2.3: as [`FootprintSource::path`], where the footprints are those of the walls.
    pub roofprints: Option<PathBuf>,
    /// Which of the footprints are reconstructed.
    pub limit: Limit,
    /// A file, whose extension chooses the format; several, by a name with `{tile}` or `{id}` in it; a folder (see [`super::output::model_path`]); or a stream, which gets
    /// CityJSONSeq: `-` for standard output, or a pipe. Only a run into a sink
    /// of one's own (see [`super::run_into`]) may leave it empty; then no model is written to a file.
    pub output: PathBuf,
    /// Whether the points of each building are written to a file of its own in the folder [`Self::output`], with an index of
    /// all, instead of models.
    pub crop_only: bool,
    /// Where the number 0 of the coordinates of a CityJSON file is, CRS units: whole multiples of
    /// [`Parameters::grid_scale`]; `None` takes whole units at the corner of the model.
    pub translation: Option<[f64; 3]>,
    /// The file of what a person has decided about buildings, see [`crate::edits`].
    pub edits: Option<PathBuf>,
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
    /// So many bytes of points that wait for the rest of theirs are held in memory, the others in a temporary file; `None` for
    /// [`MEMORY`](super::MEMORY). The model is the same.
    pub memory: Option<usize>,
    /// Which points belong to a building.
    pub segmentation: SegmentOptions,
    /// The parameters of the method.
    pub parameters: Parameters,
    /// Which implicit field says how much each cell is inside.
    pub field: FieldOptions,
    /// What the terrain around the buildings shall be like; `None` makes none.
    pub terrain: Option<TerrainOptions>,
    /// Which attributes are written, and what gable's own are called.
    pub attributes: AttributeOptions,
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
    /// Whether the model goes to several files.
    ///
    /// # Errors
    /// A place in the name of the output that means nothing, or an extension of no format.
    pub fn goes_to_many_files(&self) -> Result<bool, InputError> {
        Ok(!self.crop_only && Template::of(&self.output)?.is_some())
    }

    /// The files, folders and patterns of all tiles, of all clouds together.
    pub fn all_tiles(&self) -> Vec<String> {
        self.tiles.iter().chain(self.clouds.iter().flat_map(|source| &source.tiles)).cloned().collect()
    }

    /// What the checkpoint and the report are named after, where the points and the footprints are called so: the file of
    /// the model, or `gable` in the folder that all its files share.
    ///
    /// # Errors
    /// As [`Self::goes_to_many_files`].
    pub fn base(&self, tiles: &[PathBuf]) -> Result<PathBuf, InputError> {
        if self.crop_only {
            return Ok(crop::index(&self.output));
        }
        let footprints = self.footprints.as_ref().map(FootprintSource::name);
        Ok(match Template::of(&self.output)? {
            Some(template) => template.base(),
            None => output::model_path(&self.output, tiles, footprints.as_deref()),
        })
    }

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
