//! Scans as a flight would deliver them, with the truth beside: `points.laz` (ground 2, building 6), `footprints.geojson`
//! and `reference.city.json`. So the whole road can be run and measured on buildings that are known exactly.

mod footprints;
mod layout;
mod reference;
mod tile;

use std::collections::BTreeMap;
use std::path::PathBuf;

use geo::MultiPolygon;
use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::model::Model;
use super::options::{ScanOptions, SetupChoice};
use super::random::hash;
use super::scan::{Scan, scan};
use super::source::Source;
use crate::error::Result;
use crate::guard::guarded;
use crate::sink::{Encoder, PointCloud};
use crate::source::crs::Crs;

pub use layout::common_crs;

/// Scans in work at a time.
const BATCH: usize = 64;
/// Width of the ground around a building that is scanned with it, metres.
const SURROUNDINGS: f64 = 6.0;

/// Scans to be written.
#[derive(Debug, Clone)]
pub struct Job {
    /// The models, all of one CRS.
    pub sources: Vec<Source>,
    /// The CRS of the output.
    pub crs: Crs,
    /// How scans are made; every building has a footprint in its file, whatever they say.
    pub options: ScanOptions,
    /// What everything random follows from.
    pub seed: u64,
    /// The folder, which exists.
    pub output: PathBuf,
    /// Whether files there are replaced.
    pub overwrite: bool,
}

/// What was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Written {
    /// The files: points, footprints, reference.
    pub files: [PathBuf; 3],
    /// Number of buildings.
    pub buildings: usize,
    /// Number of building points and of ground points.
    pub points: [u64; 2],
    /// How many models could not be scanned, for each reason.
    pub failed: BTreeMap<String, usize>,
}

/// A scan of a model in its place.
struct Scanned<'a> {
    model: &'a Model,
    id: String,
    scan: Scan,
    attributes: Map<String, Value>,
}

impl Scanned<'_> {
    fn footprint(&self) -> &MultiPolygon<f64> {
        self.scan.footprint.as_ref().unwrap_or(&self.model.footprint)
    }
}

/// Scans every model once, where it stands (generated ones on a grid beside the others), and writes what came of it.
/// `progress` is told the number of models done since it was last told, from any thread.
///
/// # Errors
/// Files that exist and shall not be replaced, a place that LAZ cannot hold, or the system refuses.
pub fn write(job: &Job, progress: &(dyn Fn(u64) + Sync)) -> Result<Written> {
    let models = layout::arranged(&job.sources);
    let ids = layout::unique_ids(&models);
    // What a scanner around a building sees is not cut off at its footprint.
    let from_around =
        matches!(job.options.setup, SetupChoice::FullView | SetupChoice::NoBottom | SetupChoice::Photographs);
    let options = ScanOptions { footprint: if from_around { 0.0 } else { 1.0 }, ..job.options.clone() };
    let files = ["points.laz", "footprints.geojson", "reference.city.json"].map(|name| job.output.join(name));
    let mut tile = tile::TileFile::create(&files[0], &job.crs, layout::corner(&models), job.overwrite)?;
    let mut footprints = footprints::Footprints::create(&files[1], &job.crs, job.overwrite)?;
    let mut reference = reference::create(&files[2], job, &models)?;
    let mut encoder = Encoder::new(ids.iter().map(String::as_str).collect(), PointCloud::default());
    let mut failed = BTreeMap::new();
    let mut buildings = 0;
    let numbered: Vec<(&Model, &String)> = models.iter().zip(&ids).collect();
    for batch in numbered.chunks(BATCH) {
        let scans: Vec<Result<Scanned, String>> = batch
            .par_iter()
            .map(|(model, id)| {
                let made = guarded(|| scanned(model, id, &options, job.seed));
                progress(1);
                made.unwrap_or_else(|panic| Err(format!("internal: {panic}")))
            })
            .collect();
        for scanned in scans {
            match scanned {
                Ok(scanned) => {
                    tile.add(&scanned)?;
                    footprints.add(&scanned);
                    reference.write(&encoder.feature(&reference::building(&scanned)))?;
                    buildings += 1;
                }
                Err(reason) => *failed.entry(reason).or_default() += 1,
            }
        }
    }
    let points = tile.finish()?;
    footprints.finish()?;
    reference.finish()?;
    Ok(Written { files, buildings, points, failed })
}

fn scanned<'a>(model: &'a Model, id: &str, options: &ScanOptions, seed: u64) -> Result<Scanned<'a>, String> {
    let seed = hash(seed, &format!("{}/{}", model.tile, model.id));
    let scan = scan(&model.placed(), options, SURROUNDINGS, seed).ok_or("the model has no surface")?;
    let mut attributes = Map::new();
    attributes.insert("setup".to_owned(), scan.setup.name().into());
    attributes.insert("density".to_owned(), json!((scan.density * 1000.0).round() / 1000.0));
    attributes.insert("noise".to_owned(), json!(scan.noise));
    if let Some(shape) = &model.shape {
        attributes.insert("shape".to_owned(), shape.as_str().into());
    }
    Ok(Scanned { model, id: id.to_owned(), scan, attributes })
}
