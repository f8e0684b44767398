//! Data sets: all scans of all models, in parallel and in an order that depends on the seed alone.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use rayon::prelude::*;

use super::super::model::Model;
use super::super::options::ScanOptions;
use super::super::random::{Random, hash};
use super::super::source::Source;
use super::super::split::{Split, split};
use super::file::{Head, VERSION};
use super::manifest::{Manifest, SourceRecord};
use super::sample::{Recipe, Sample};
use super::{Interface, Sizes};
use crate::error::{Error, Result};
use crate::guard::guarded;
use crate::reconstruct::Parameters;
use crate::sink::write_whole;

/// Scans between two looks at whether to stop.
const BATCH: usize = 64;

/// A data set to be made.
#[derive(Debug, Clone)]
pub struct Job {
    /// The models.
    pub sources: Vec<Source>,
    /// Scans of each model.
    pub variants: usize,
    /// How scans are made.
    pub options: ScanOptions,
    /// Whether every scan is of a model that was mirrored, turned and scaled.
    pub augment: bool,
    /// For which network.
    pub interface: Interface,
    /// Sizes of what is asked about one scan.
    pub sizes: Sizes,
    /// Shares of training, validation and test.
    pub shares: [f64; 3],
    /// What everything random follows from.
    pub seed: u64,
    /// Scans of a shard.
    pub shard: usize,
    /// The folder, which exists.
    pub output: PathBuf,
}

/// Listens to a simulation. Calls come from several threads.
pub trait Observer: Sync {
    /// So many more scans were made, or tried.
    fn advanced(&self, by: u64);

    /// Whether to stop: what is done is written.
    fn interrupted(&self) -> bool {
        false
    }
}

/// Makes a data set; returns what stands in its manifest.
///
/// # Errors
/// The system refuses to write.
pub fn run(job: &Job, observer: &dyn Observer) -> Result<Manifest> {
    let models: Vec<&Model> = job.sources.iter().flat_map(|source| &source.models).collect();
    let mut tiles: BTreeMap<Arc<str>, usize> = BTreeMap::new();
    for model in &models {
        *tiles.entry(Arc::clone(&model.tile)).or_default() += 1;
    }
    let tiles = split(&tiles, job.shares, job.seed);
    let mut manifest = Manifest {
        gable_version: env!("CARGO_PKG_VERSION"),
        format_version: VERSION,
        interface: job.interface,
        sizes: job.sizes,
        seed: job.seed,
        variants: job.variants,
        augmented: job.augment,
        options: job.options.clone(),
        sources: job.sources.iter().map(|source| SourceRecord::of(source, source.models.len())).collect(),
        tiles: tiles.iter().map(|(tile, split)| (tile.to_string(), *split)).collect(),
        scans: BTreeMap::new(),
        failed: BTreeMap::new(),
        shards: Vec::new(),
        interrupted: false,
    };
    let parameters = Parameters::default();
    for kind in Split::ALL {
        let of_split = models.iter().filter(|model| tiles.get(&model.tile) == Some(&kind));
        let mut scans: Vec<(&Model, usize)> =
            of_split.flat_map(|model| (0..job.variants).map(move |variant| (*model, variant))).collect();
        Random::new(hash(job.seed, kind.name())).shuffle(&mut scans);
        let recipe = Recipe {
            interface: job.interface,
            sizes: job.sizes,
            options: &job.options,
            parameters: &parameters,
            augment: job.augment,
            seed: job.seed,
        };
        let mut waiting: Vec<Sample> = Vec::with_capacity(job.shard + BATCH);
        for batch in scans.chunks(BATCH) {
            if observer.interrupted() {
                manifest.interrupted = true;
                break;
            }
            for made in
                batch.par_iter().map(|(model, variant)| made(&recipe, model, *variant, observer)).collect::<Vec<_>>()
            {
                match made {
                    Ok(sample) => waiting.push(sample),
                    Err(reason) => *manifest.failed.entry(reason).or_default() += 1,
                }
            }
            while waiting.len() >= job.shard {
                let rest = waiting.split_off(job.shard);
                write(job, kind, &waiting, &mut manifest)?;
                waiting = rest;
            }
        }
        if !waiting.is_empty() {
            write(job, kind, &waiting, &mut manifest)?;
        }
    }
    let path = job.output.join("manifest.json");
    let mut text = serde_json::to_vec_pretty(&manifest).map_err(|e| Error::io(&path, "write", e.into()))?;
    text.push(b'\n');
    write_whole(&path, &text)?;
    Ok(manifest)
}

/// One scan; a fault of the program is a reason like any other.
fn made(recipe: &Recipe, model: &Model, variant: usize, observer: &dyn Observer) -> Result<Sample, String> {
    let made = guarded(|| recipe.sample(model, variant)).unwrap_or_else(|panic| Err(format!("internal: {panic}")));
    observer.advanced(1);
    made
}

fn write(job: &Job, kind: Split, samples: &[Sample], manifest: &mut Manifest) -> Result<()> {
    let number = manifest.shards.iter().filter(|name| name.starts_with(kind.name())).count();
    let name = format!("{}-{number:05}.safetensors", kind.name());
    let head = Head { interface: job.interface, sizes: &job.sizes, split: kind, seed: job.seed };
    head.write(&job.output.join(&name), samples)?;
    manifest.shards.push(name);
    *manifest.scans.entry(kind).or_default() += samples.len();
    Ok(())
}
