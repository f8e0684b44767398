//! Data sets: all scans of all models, in parallel and in an order that depends on the seed alone.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use rayon::prelude::*;

use super::super::options::ScanOptions;
use super::super::random::{Random, hash};
use super::super::real::RealSource;
use super::super::source::Source;
use super::super::split::{Split, split};
use super::file::{Head, VERSION};
use super::manifest::{Manifest, SourceRecord};
use super::sample::{Recipe, Sample, Subject};
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
    /// The real scans.
    pub real: Vec<RealSource>,
    /// Scans of each model and copies of each real scan.
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
    let tiles = tiles(job);
    let held_back = held_back(job, &tiles);
    let mut manifest = Manifest {
        gable_version: env!("CARGO_PKG_VERSION"),
        format_version: VERSION,
        interface: job.interface,
        sizes: job.sizes,
        seed: job.seed,
        variants: job.variants,
        augmented: job.augment,
        options: job.options.clone(),
        sources: job
            .sources
            .iter()
            .map(|source| SourceRecord::of(source, source.models.len()))
            .chain(job.real.iter().map(SourceRecord::of_real))
            .collect(),
        tiles: tiles.iter().map(|(tile, split)| (tile.to_string(), *split)).collect(),
        scans: BTreeMap::new(),
        failed: BTreeMap::new(),
        shards: Vec::new(),
        interrupted: false,
    };
    let parameters = Parameters::default();
    for kind in Split::ALL {
        let models = job.sources.iter().flat_map(|source| &source.models).map(Subject::Model);
        let real = job.real.iter().flat_map(|source| &source.sites);
        // A building at the end of a tile, or of several clouds, is of one split only: the rarest.
        let real = real.filter(|real| held_back.get(real.site.id.as_str()) == Some(&kind)).map(Subject::Real);
        let of_split = models.chain(real).filter(|subject| tiles.get(subject.tile()) == Some(&kind));
        let mut scans: Vec<(Subject<'_>, usize)> =
            of_split.flat_map(|subject| (0..job.variants).map(move |variant| (subject, variant))).collect();
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
            for made in batch
                .par_iter()
                .map(|(subject, variant)| made(&recipe, *subject, *variant, observer))
                .collect::<Vec<_>>()
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

/// Which tile is of which split.
fn tiles(job: &Job) -> BTreeMap<Arc<str>, Split> {
    let mut sizes: BTreeMap<Arc<str>, usize> = BTreeMap::new();
    for model in job.sources.iter().flat_map(|source| &source.models) {
        *sizes.entry(Arc::clone(&model.tile)).or_default() += 1;
    }
    let (kept, free): (Vec<_>, Vec<_>) = job.real.iter().partition(|source| source.held_back);
    for real in free.into_iter().flat_map(|source| &source.sites) {
        *sizes.entry(Arc::clone(&real.tile)).or_default() += 1;
    }
    let mut tiles = split(&sizes, job.shares, job.seed);
    for real in kept.into_iter().flat_map(|source| &source.sites) {
        tiles.insert(Arc::clone(&real.tile), Split::Validation);
    }
    tiles
}

/// The split of every building that was really scanned: of those of its tiles the last.
fn held_back<'a>(job: &'a Job, tiles: &BTreeMap<Arc<str>, Split>) -> BTreeMap<&'a str, Split> {
    let mut found: BTreeMap<&str, Split> = BTreeMap::new();
    for real in job.real.iter().flat_map(|source| &source.sites) {
        if let Some(&split) = tiles.get(&real.tile) {
            let known = found.entry(&real.site.id).or_insert(split);
            *known = split.max(*known);
        }
    }
    found
}

/// One scan; a fault of the program is a reason like any other.
fn made(recipe: &Recipe, subject: Subject<'_>, variant: usize, observer: &dyn Observer) -> Result<Sample, String> {
    let made = guarded(|| recipe.sample(subject, variant)).unwrap_or_else(|panic| Err(format!("internal: {panic}")));
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
