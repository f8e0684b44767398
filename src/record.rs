//! What is known of a building otherwise than by the points that its model is made of.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// What is known of a building otherwise than by the points that its model is made of.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Height of its roof as the user states it, metres in the local frame.
    pub roof_height: Option<f64>,
    /// The point cloud that its points are of, where there are several or one may be too old.
    pub cloud: Option<CloudOf>,
    /// What has become of it between two surveys, where two tell.
    pub change: Option<Change>,
    /// The file of its points, where they were cropped.
    pub points_file: Option<PointsFile>,
}

/// The file of the points of a building.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct PointsFile {
    /// Its name in the folder of the index.
    pub name: String,
    /// Number of points in it, of all classes.
    pub points: u64,
}

/// The point cloud that models were made from, in the words of whoever made them. Files do not tell: the names and dates of
/// tiles change with the way a cloud was cut.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct PointCloud {
    /// Its name, such as `AHN3`.
    pub source: Option<String>,
    /// When it was recorded, such as `2014` or `2014-03-04`.
    pub date: Option<String>,
}

/// The point cloud of a building, and why it is that one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CloudOf {
    /// The cloud.
    pub cloud: PointCloud,
    /// Why it was chosen.
    pub choice: Choice,
    /// What is to be said where no cloud may be taken.
    pub outdated: Option<String>,
}

/// Why a building is made from one of several clouds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Choice {
    /// It goes before all others, and is good enough.
    First,
    /// Those before it are too thin here, or do not cover the building.
    OthersTooThin,
    /// None is good enough; it tells most.
    BestOfThin,
    /// It is the newest that shows the building as it is: others are denser, but older than a change.
    OthersOutdated,
    /// All are older than the building.
    NoneNewEnough,
}

/// What has become of a building between two surveys.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Change {
    /// What has become of it; `None` where it is as it was.
    pub mutation: Option<Mutation>,
    /// How much of it has changed, square metres.
    pub area: f64,
    /// Heights that differ by less are the same, metres.
    pub tolerance: f64,
    /// The older of the two clouds.
    pub since: Option<PointCloud>,
}

/// What becomes of buildings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Mutation {
    /// Where there was ground stands a building.
    Built,
    /// Where a building stood there is ground.
    TornDown,
    /// It is higher.
    Raised,
    /// It is lower.
    Lowered,
}
