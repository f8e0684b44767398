//! What is written of the buildings: the options that `gable reconstruct`, `gable edit` and `gable plan` share, beside those
//! that the buildings are [made](super::making) by.

use super::attributes::AttributeArgs;
use super::flags::Flags;
use super::making::{MakingArgs, POINTS, RUN};
use crate::error::InputError;
use crate::reconstruct::{Levels, Parameters};
use crate::run::{Job, memory, recording_date, translation};
use crate::sink::PointCloud;
use crate::terrain::TerrainOptions;

/// The heading of the options of the output; those of the other files have theirs there.
pub(super) const OUTPUT: &str = "Output";

/// What the model is to be, however it comes about.
#[derive(Debug, clap::Args)]
pub struct ModelArgs {
    /// Title of the model [default: the name of the file of footprints]
    #[arg(long, value_name = "TEXT", help_heading = OUTPUT)]
    title: Option<String>,

    /// Levels of detail, parted by commas: 0 (footprint), 0.1 (what the roofs cover, at one height), 0.3 (what each roof
    /// covers, at its height), 1.2 (blocks), 1.3 (blocks with steps), 2.2 (roofs as they are), 2.3 (roofs that hang over)
    /// [default: 0,1.2,2.2, and 2.3 with --roofprint]
    #[arg(long, value_name = "LEVELS", help_heading = OUTPUT)]
    lod: Option<Levels>,

    /// Where the number 0 of the coordinates of a CityJSON file is, CRS units, whole multiples of --grid-scale
    /// [default: whole units at the corner of the model]
    #[arg(long, value_name = "X,Y,Z", value_parser = translation, allow_hyphen_values = true, help_heading = OUTPUT)]
    translation: Option<[f64; 3]>,

    /// Name of the point cloud, such as AHN3; an attribute of every building
    #[arg(long, value_name = "NAME", help_heading = POINTS)]
    point_cloud_source: Option<String>,

    /// When the point cloud was recorded, such as 2014 or 2014-03-04; an attribute of every building
    #[arg(long, value_name = "DATE", value_parser = recording_date, help_heading = POINTS)]
    point_cloud_date: Option<String>,

    #[command(flatten)]
    attributes: AttributeArgs,
}

impl ModelArgs {
    /// The job of making buildings so for this model.
    ///
    /// # Errors
    /// A CRS that is none, or options that contradict each other.
    pub(super) fn into_job(self, making: MakingArgs) -> Result<Job, InputError> {
        let levels = self.lod.unwrap_or_else(|| Levels::usual(making.has_roofprints()));
        let job = making.into_job()?;
        Ok(Job {
            title: self.title,
            translation: self.translation,
            parameters: Parameters { lod: levels, ..job.parameters },
            attributes: self.attributes.into(),
            point_cloud: PointCloud { source: self.point_cloud_source, date: self.point_cloud_date },
            ..job
        })
    }
}

/// What a run writes, all of it on one machine.
#[derive(Debug, clap::Args)]
pub struct WrittenArgs {
    #[command(flatten)]
    model: ModelArgs,

    /// Write the terrain around the buildings too: a TIN of the ground points in tiles, which the buildings stand in
    #[arg(long, help_heading = OUTPUT)]
    terrain: bool,

    /// How many points that wait for the rest of their building may be held in memory, such as 64MB or 1GiB; the others wait
    /// in a temporary file, and the model is the same [default: 2GiB]
    #[arg(long, value_name = "SIZE", value_parser = memory, help_heading = RUN)]
    memory: Option<usize>,

    #[command(flatten)]
    terrain_options: Flags<TerrainOptions>,
}

impl WrittenArgs {
    /// The job of making buildings so and writing this of them.
    ///
    /// # Errors
    /// A CRS that is none, or options that contradict each other.
    pub(super) fn into_job(self, making: MakingArgs) -> Result<Job, InputError> {
        let terrain_options = self.terrain_options.0;
        if !self.terrain && terrain_options != TerrainOptions::default() {
            let fault =
                InputError::new("--terrain", "options of a terrain that nobody asked for", "--terrain with them");
            return Err(
                fault.remedy("Give --terrain as well, or leave --terrain-error, --terrain-tile and --terrain-gap out")
            );
        }
        let job = self.model.into_job(making)?;
        Ok(Job { memory: self.memory, terrain: self.terrain.then_some(terrain_options), ..job })
    }
}
