//! The terrain of a run: ground points are put aside while tiles stream by, and become a surface once all buildings stand.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayon::ThreadPool;

use super::job::Job;
use super::journal::Journal;
use super::observer::{Event, Observer, Stage};
use super::ordered::in_order;
use super::plan::Plan;
use crate::error::{Error, Result};
use crate::report::TerrainReport;
use crate::sink::Feature;
use crate::source::crs::Crs;
use crate::source::objects;
use crate::terrain::{Grid, GroundStore, Outlines, Tally, Terrain, TerrainOptions};

/// Where the ground points of a job wait: beside the model, of an object in the folder that the run was started in, else in the system's temporary folder. `None` where no terrain is
/// asked for.
///
/// # Errors
/// The folder cannot be written to.
pub(super) fn store(job: &Job, model: Option<&Path>, crs: &Crs) -> Result<Option<Arc<GroundStore>>> {
    let Some(options) = &job.terrain else { return Ok(None) };
    GroundStore::create(&folder(model), Grid::new(options, crs.metres_per_unit)).map(|store| Some(Arc::new(store)))
}

/// Where files without a name may stand.
fn folder(model: Option<&Path>) -> PathBuf {
    let Some(parent) = model.and_then(Path::parent) else { return std::env::temp_dir() };
    if parent.as_os_str().is_empty() || model.is_some_and(objects::is_object) {
        PathBuf::from(".")
    } else {
        parent.to_path_buf()
    }
}

/// The terrain of a run, ready to be made tile by tile.
pub(super) struct Laid {
    terrain: Terrain,
    options: TerrainOptions,
    ground_points: u64,
}

/// Makes ready the terrain of these ground points and buildings.
///
/// # Errors
/// The terrain model cannot be read.
pub(super) fn lay(
    job: &Job,
    plan: &Plan,
    (store, outlines): (Arc<GroundStore>, Outlines),
    journal: &Journal<'_>,
) -> Result<Laid> {
    let options = job.terrain.clone().unwrap_or_default();
    let ground_points = store.points();
    let areas = plan.tiles.iter().flat_map(|tile| tile.areas().iter().copied()).collect();
    let mut terrain = Terrain::new(options.clone(), store, outlines, areas);
    if let Some(path) = &plan.segmentation.dtm {
        terrain = terrain.on_model(path, &plan.crs, &folder(plan.model.as_deref()))?;
    } else if ground_points == 0 {
        let classes: Vec<String> = plan.segmentation.ground_classes.iter().map(u8::to_string).collect();
        journal.warn(&format!(
            "no point of ground class {}: there is no terrain; --ground-class says which classes are ground, --dtm where a \
             terrain model lies",
            classes.join(",")
        ));
    }
    if terrain.left_out() > 0 {
        journal.warn(&format!("{} outlines reach too far for the terrain; it passes below them", terrain.left_out()));
    }
    Ok(Laid { terrain, options, ground_points })
}

/// Makes the tiles on the threads of `pool` and hands their features to `write`, in the order of the tiles.
///
/// # Errors
/// What `write` says; the ground points or the terrain model cannot be read.
pub(super) fn write(
    laid: &Laid,
    pool: &ThreadPool,
    journal: &Journal<'_>,
    write: &mut dyn FnMut(&mut Feature) -> Result<()>,
) -> Result<TerrainReport> {
    let tiles = laid.terrain.tiles();
    let (mut tally, mut not_reached) = (Tally::default(), 0);
    journal.stage(Stage::Terrain, tiles.len() as u64, |journal| {
        in_order(
            pool,
            tiles,
            |_| 0,
            |key| {
                let made = laid.terrain.tile(key);
                journal.event(Event::Advanced { stage: Stage::Terrain, by: 1 });
                made
            },
            || journal.interrupted(),
            |_, made| {
                let Some(made) = made else {
                    not_reached += 1;
                    return Ok::<(), Error>(());
                };
                let made = made?;
                tally.add(&made.tally);
                made.features.into_iter().try_for_each(|mut feature| write(&mut feature))
            },
        )
    })?;
    let report = TerrainReport::new(laid.options.clone(), laid.ground_points, &tally);
    tell(&report, not_reached, journal);
    Ok(TerrainReport { not_reached, ..report })
}

/// What the user must know of the terrain.
fn tell(report: &TerrainReport, not_reached: usize, journal: &Journal<'_>) {
    if not_reached > 0 {
        journal.warn(&format!("the run was interrupted: {not_reached} tiles of the terrain are missing"));
    }
    if report.left_out >= 1.0 {
        journal.warn(&format!(
            "{:.0} m² of what was scanned have no ground point within a circle of {} m (water, or buildings without a \
             footprint): there the terrain has holes; --terrain-gap spans wider ones",
            report.left_out, report.options.terrain_gap
        ));
    }
    if report.missed > 0 {
        journal.warn(&format!("{} edges of outlines cross others: the terrain does not meet them", report.missed));
    }
}
