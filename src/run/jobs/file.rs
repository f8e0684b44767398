//! The plan of a run in several jobs, as its file holds it.

use std::hash::{DefaultHasher, Hasher};
use std::path::PathBuf;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::error::Result;
use crate::network::FieldOptions;
use crate::reconstruct::Parameters;
use crate::report::{CrsReport, Inputs};
use crate::run::Job;
use crate::segment::{BuildingClasses, SegmentOptions};
use crate::sink::{AttributeOptions, PointCloud};
use crate::source::crs::Crs;
use crate::source::points::Extent;

/// The layout that is written and read.
pub(super) const LAYOUT: u32 = 1;

/// The plan of a run in several jobs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(title = "gable plan")]
#[serde(deny_unknown_fields)]
pub struct JobPlan {
    /// Version of this layout.
    pub layout: u32,
    /// Version of gable; jobs are done and joined by the same.
    pub gable: String,
    /// What makes it this plan and no other: parts of another are refused.
    pub identity: String,
    /// The command line that made it; empty when gable was called as a library.
    pub command: Vec<String>,
    /// Title of the model.
    pub title: String,
    /// The coordinate reference system of the tiles, and of the model.
    pub crs: Crs,
    /// The same for the report, with where it was taken from.
    pub crs_report: CrsReport,
    /// The options of the run, those at their defaults too.
    pub options: Options,
    /// The point clouds, in the order in which they are looked at; one where there is no choice.
    pub clouds: Vec<PlannedCloud>,
    /// The tiles that could be opened.
    pub tiles: Vec<PlannedTile>,
    /// What came in, for the report.
    pub inputs: Inputs,
    /// Number of features that are reconstructed, those without a usable polygon among them. Their places in the model are
    /// 0, 1, 2 and so on: first the footprints in the order of their file, then the features without a usable polygon.
    pub footprints: usize,
    /// How many of them have no usable polygon.
    pub rejected: usize,
    /// What the user was told when it was made.
    pub warnings: Vec<String>,
    /// The jobs, by their numbers.
    pub jobs: Vec<PlannedJob>,
}

/// The options of a run that say what comes out.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Options {
    /// The parameters of the method.
    pub parameters: Parameters,
    /// Which implicit field says how much each cell is inside.
    pub field: FieldOptions,
    /// What that field is: its network may not change between jobs.
    pub field_identity: Value,
    /// Which points belong to a building.
    pub segmentation: SegmentOptions,
    /// Which attributes are written.
    pub attributes: AttributeOptions,
    /// What the model says of the point cloud.
    pub point_cloud: PointCloud,
    /// Where the number 0 of the coordinates of a CityJSON file is.
    pub translation: Option<[f64; 3]>,
}

/// A point cloud.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlannedCloud {
    /// Its name and date.
    pub about: PointCloud,
    /// Clouds of higher priority are looked at first.
    pub priority: i32,
    /// The classes of its building points, where they are not those of the options.
    pub building_classes: Option<BuildingClasses>,
}

/// A tile.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlannedTile {
    /// The file, absolute.
    pub path: PathBuf,
    /// The cloud that it is of, as a place in the list of clouds.
    pub cloud: usize,
    /// Number of points that its header announces.
    pub points: u64,
    /// Smallest x, y and z and largest x, y and z, as its header states them; absent where they cannot be relied on at all.
    pub extent: Option<[[f64; 3]; 2]>,
    /// Whether its points lie there, as far as some thousands of them tell. If not, every job reads it.
    pub is_reliable: bool,
}

/// A job.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PlannedJob {
    /// Its number, from 0.
    pub job: usize,
    /// Number of features that it reconstructs.
    pub footprints: usize,
    /// Number of footprints beside them that it must know.
    pub beside: usize,
    /// Smallest x and y and largest x and y of the middles of its footprints, CRS units.
    pub extent: Option<[f64; 4]>,
    /// The tiles that it reads, as places in the list of tiles.
    pub tiles: Vec<usize>,
    /// Number of points in them.
    pub points: u64,
    /// What it is expected to cost, in seconds of one processor core; good for comparing jobs, not for a clock.
    pub cost: f64,
    /// Checksum of the file of its footprints.
    pub checksum: String,
}

impl PlannedTile {
    /// Where its points lie.
    pub(super) fn extent(&self) -> Option<Extent> {
        self.extent.map(|[min, max]| Extent { min, max })
    }
}

impl JobPlan {
    /// The identity of all the rest of the plan.
    ///
    /// # Errors
    /// It cannot be written as JSON.
    pub(super) fn identify(&self) -> serde_json::Result<String> {
        let bare = Self { identity: String::new(), command: Vec::new(), ..self.clone() };
        let mut hasher = DefaultHasher::new();
        hasher.write(&serde_json::to_vec(&bare)?);
        Ok(format!("{:016x}", hasher.finish()))
    }

    /// The options as those of a run, without tiles, footprints and output.
    pub(super) fn job(&self) -> Job {
        let Options { parameters, field, field_identity: _, segmentation, attributes, point_cloud, translation } =
            self.options.clone();
        let title = Some(self.title.clone());
        Job { translation, title, segmentation, parameters, field, attributes, point_cloud, ..Job::default() }
    }

    /// Refuses to go on with a network that is not that of the plan.
    ///
    /// # Errors
    /// It is another, or cannot be read.
    pub(super) fn check_field(&self) -> Result<()> {
        let found = self.options.field.identity()?;
        if found == self.options.field_identity {
            return Ok(());
        }
        let expected = format!("that of the plan, {}", self.options.field_identity);
        let fault = crate::error::InputError::new("the network", found.to_string(), expected);
        Err(fault.remedy("Use the network that the plan was made with, or make the plan anew").into())
    }
}

/// The JSON Schema of [`JobPlan`], as text with a line end: what `schemas/plan.schema.json` holds.
pub fn schema() -> String {
    let mut generator = schemars::generate::SchemaSettings::draft2020_12().for_serialize().into_generator();
    let schema = generator.root_schema_for::<JobPlan>();
    format!("{:#}\n", schema.to_value())
}
