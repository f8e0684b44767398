//! What buildings are made of, and how: the options that `gable reconstruct` and `gable explain` share.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use super::config::ConfigArgs;
use super::field::FieldArgs;
use super::flags::Flags;
use crate::error::{InputError, Result};
use crate::reconstruct::Parameters;
use crate::run::{FootprintSource, Job, MOST_THREADS};
use crate::segment::{BuildingClasses, SegmentOptions};
use crate::source::crs::Crs;
use crate::source::footprints::FootprintOptions;
use crate::source::points::{Placement, Unit, UpAxis};

/// What buildings are made of, and how.
#[derive(Debug, clap::Args)]
pub struct MakingArgs {
    /// LAS, LAZ, COPC, PLY or text (xyz, pts, txt, asc, csv) files, folders of them, or glob patterns
    #[arg(required = true, value_name = "TILES")]
    tiles: Vec<String>,

    /// Building footprints: GeoPackage, GeoJSON, Shapefile, FlatGeobuf, GeoParquet, SpatiaLite, or a PostGIS database
    /// ("PG:host=… dbname=…")
    #[arg(short, long, value_name = "FILE", conflicts_with = "no_footprint")]
    footprints: Option<PathBuf>,

    /// Outlines of the roofs, where the footprints are those of the walls: roofs hang over as far as these reach, at LoD 2.3
    #[arg(long, value_name = "FILE", conflicts_with = "no_footprint")]
    pub(super) roofprint: Option<PathBuf>,

    /// Take what stands apart in the building points for an object each
    #[arg(long)]
    no_footprint: bool,

    /// CRS of the tiles, such as EPSG:7415; goes before what they say
    #[arg(long, value_name = "CRS")]
    crs: Option<String>,

    /// Unit of the coordinates of points without a CRS, with --no-footprint [default: m]
    #[arg(long, value_name = "UNIT", conflicts_with_all = ["crs", "footprints"])]
    unit: Option<Unit>,

    /// Axis that points up in points without a CRS, with --no-footprint [default: z]
    #[arg(long, value_name = "AXIS", conflicts_with_all = ["crs", "footprints"])]
    up_axis: Option<UpAxis>,

    /// CRS of the footprints; goes before what the file says
    #[arg(long, value_name = "CRS", conflicts_with = "no_footprint")]
    footprint_crs: Option<String>,

    /// Layer or table of the footprints, if there are several
    #[arg(long, value_name = "NAME", conflicts_with = "no_footprint")]
    layer: Option<String>,

    /// SELECT that gives the footprints of a database, instead of a layer
    #[arg(long, value_name = "SQL", conflicts_with_all = ["no_footprint", "layer"])]
    query: Option<String>,

    /// Only footprints whose attributes satisfy this, such as "status = 'in use' AND height > 3"
    #[arg(long, value_name = "EXPRESSION", conflicts_with = "no_footprint")]
    filter: Option<String>,

    /// Attribute that holds the ids of the buildings [default: guessed]
    #[arg(long, value_name = "NAME", conflicts_with = "no_footprint")]
    id_attribute: Option<String>,

    /// Classes of building points, such as 1,6; "any" for clouds that are not classified
    #[arg(long, value_name = "CLASSES", default_value_t = SegmentOptions::default().building_classes)]
    building_class: BuildingClasses,

    /// Classes of ground points
    #[arg(long, value_name = "CLASSES", value_delimiter = ',', default_values_t = SegmentOptions::default().ground_classes)]
    ground_class: Vec<u8>,

    /// Number of threads [default: one per processor]
    #[arg(short, long, value_name = "N", value_parser = threads, allow_negative_numbers = true)]
    jobs: Option<NonZeroUsize>,

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

impl MakingArgs {
    /// A job that writes nothing as yet.
    ///
    /// # Errors
    /// A CRS that is none, or no footprints.
    pub(super) fn into_job(self) -> Result<Job, InputError> {
        if self.footprints.is_none() && !self.no_footprint {
            let fault = InputError::new("--footprints", "none", "the file of the outlines of the buildings");
            return Err(fault.remedy("Without outlines --no-footprint takes what stands apart for a building each"));
        }
        let named = |fault: InputError| InputError { file: "--footprint-crs".into(), ..fault };
        let crs = self.footprint_crs.as_deref().map(Crs::parse).transpose().map_err(named)?;
        let (layer, query) = (self.layer, self.query);
        let (filter, id_attribute) = (self.filter, self.id_attribute);
        let options = FootprintOptions { layer, query, filter, id_attribute, crs, within: None };
        Ok(Job {
            tiles: self.tiles,
            footprints: self.footprints.map(|path| FootprintSource { path, options }),
            roofprints: self.roofprint,
            crs: self.crs,
            placement: Placement::given(self.unit, self.up_axis),
            threads: self.jobs,
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
