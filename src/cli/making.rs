//! What buildings are made of, and how: the options that `gable reconstruct` and `gable explain` share.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use super::config::ConfigArgs;
use super::field::FieldArgs;
use super::flags::Flags;
use super::outlines::OutlineArgs;
use crate::error::{InputError, Result};
use crate::pipeline::options::Tunable;
use crate::reconstruct::Parameters;
use crate::run::{CloudSource, Job, MOST_THREADS, cloud};
use crate::segment::{BuildingClasses, SegmentOptions};
use crate::source::points::{Placement, Unit, UpAxis};

/// The headings of the options that stand here; those of the other files have theirs there.
pub(super) const POINTS: &str = "Points";
pub(super) const RUN: &str = "Run";
const POINTS_OF_BUILDINGS: &str = SegmentOptions::HEADING;

/// What buildings are made of, and how.
#[derive(Debug, clap::Args)]
pub struct MakingArgs {
    /// LAS, LAZ, COPC, PLY or text (xyz, pts, txt, asc, csv) files, folders of them, or glob patterns, also in object storage or on
    /// the web (s3://, az://, gs://, https://); or an index of tiles (STAC, `pdal tindex`)
    #[arg(required_unless_present = "cloud", value_name = "TILES")]
    tiles: Vec<String>,

    #[command(flatten)]
    outlines: OutlineArgs,

    /// CRS of the tiles, such as EPSG:7415; goes before what they say
    #[arg(long, value_name = "CRS", help_heading = POINTS)]
    crs: Option<String>,

    /// Unit of the coordinates of points without a CRS, with --no-footprint [default: m]
    #[arg(long, value_name = "UNIT", conflicts_with_all = ["crs", "footprints"], help_heading = POINTS)]
    unit: Option<Unit>,

    /// Axis that points up in points without a CRS, with --no-footprint [default: z]
    #[arg(long, value_name = "AXIS", conflicts_with_all = ["crs", "footprints"], help_heading = POINTS)]
    up_axis: Option<UpAxis>,

    /// Classes of building points, such as 1,6; "any" for clouds that are not classified
    #[arg(
        long,
        value_name = "CLASSES",
        default_value_t = SegmentOptions::default().building_classes,
        help_heading = POINTS_OF_BUILDINGS
    )]
    building_class: BuildingClasses,

    /// Classes of ground points
    #[arg(
        long,
        value_name = "CLASSES",
        value_delimiter = ',',
        default_values_t = SegmentOptions::default().ground_classes,
        help_heading = POINTS_OF_BUILDINGS
    )]
    ground_class: Vec<u8>,

    /// One of several point clouds, of which each building gets the best: its name and tiles, then its date, its priority
    /// (0 unless given), its building classes and more tiles, as in AHN4=ahn4/*.laz,date=2020-05-01,priority=2,class=1+6.
    /// Higher priorities and then newer clouds go first; another is taken where the first is too thin. May be given again;
    /// TILES are one of them
    #[arg(long, value_name = "NAME=TILES", value_parser = cloud, help_heading = POINTS)]
    cloud: Vec<CloudSource>,

    /// What a person has decided about buildings: a JSON file of edits, by which each of them is made
    #[arg(long, value_name = "FILE", help_heading = RUN)]
    edits: Option<PathBuf>,

    // Spelt out before this grammar reads the words; see there.
    #[command(flatten)]
    _config: ConfigArgs,

    #[command(flatten)]
    field: FieldArgs,

    #[command(flatten)]
    segmentation: Flags<SegmentOptions>,

    #[command(flatten)]
    parameters: Flags<Parameters>,
}

/// On how many threads.
#[derive(Debug, clap::Args)]
pub struct ThreadArgs {
    /// Number of threads [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = threads, allow_negative_numbers = true, help_heading = RUN)]
    pub(super) jobs: Option<NonZeroUsize>,
}

impl MakingArgs {
    /// Whether outlines of roofs are given.
    pub(super) fn has_roofprints(&self) -> bool {
        self.outlines.has_roofprints()
    }

    /// A job that writes nothing as yet.
    ///
    /// # Errors
    /// A CRS that is none, or no footprints.
    pub(super) fn into_job(self) -> Result<Job, InputError> {
        let (footprints, limit, roofprints) = self.outlines.source()?;
        Ok(Job {
            tiles: self.tiles,
            clouds: self.cloud,
            footprints,
            limit,
            roofprints,
            crs: self.crs,
            edits: self.edits,
            placement: Placement::given(self.unit, self.up_axis),
            segmentation: SegmentOptions {
                building_classes: self.building_class,
                ground_classes: self.ground_class,
                ..self.segmentation.0
            },
            parameters: self.parameters.0,
            field: self.field.into(),
            command: std::env::args_os().map(|arg| arg.to_string_lossy().into_owned()).collect(),
            ..Job::default()
        })
    }
}

/// A number of threads.
pub(super) fn threads(text: &str) -> Result<NonZeroUsize, String> {
    let threads = text.trim().parse().ok().filter(|threads: &NonZeroUsize| threads.get() <= MOST_THREADS as usize);
    threads.ok_or_else(|| format!("a whole number from 1 to {MOST_THREADS} is expected"))
}
