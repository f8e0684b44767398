//! `gable simulate`: from models to training data, and to tiles that look like those of a flight.

mod args;
mod progress;

use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use super::output::{counted, duration, print, say, table, thousands};
use super::{Outcome, interrupt};
use crate::error::{Error, InputError, Result};
use crate::segment::SegmentOptions;
use crate::simulate::shards::{Job, Manifest, Observer, Sizes, run};
use crate::simulate::{
    Model, RealOptions, RealSource, Source, Split, Statistics, generate, read, read_tile, scans,
    table as statistics_table,
};
use crate::sink::write_whole;
use crate::source::cityjson;
use crate::source::crs::Crs;
use crate::source::footprints::{self, FootprintOptions};
use crate::source::points;
pub use args::Args;
use progress::Progress;

/// The exit code when not all was done that was asked for.
const INCOMPLETE: u8 = 2;

/// Runs the command.
///
/// # Errors
/// No source gives a model, a file cannot be read, or the output cannot be written.
pub fn main(args: &Args) -> Outcome {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.jobs.map_or(0, NonZeroUsize::get)).build();
    let pool = pool.map_err(|fault| {
        InputError::new("--jobs", format!("threads that the system does not give: {fault}"), "fewer of them")
    })?;
    pool.install(|| simulate(args))
}

fn simulate(args: &Args) -> Outcome {
    let old = args.output.as_deref().map(|folder| training_data(folder, args.overwrite)).transpose()?;
    let sources = sources(args)?;
    let real = real_sources(args)?;
    let mut code = 0;
    if let Some(folder) = &args.scans {
        code = code.max(write_scans(args, &sources, folder)?);
    }
    if let Some(path) = &args.statistics {
        write_statistics(args, &sources, &real, path)?;
    }
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "create", e))?;
        // What is left of more shards than there will be must not be taken for part of the new data.
        for path in old.unwrap_or_default() {
            std::fs::remove_file(&path).map_err(|e| Error::io(&path, "remove", e))?;
        }
        code = code.max(make_training_data(args, sources, real, folder)?);
    }
    Ok(code)
}

/// Scans every model once, as it stands.
fn write_scans(args: &Args, sources: &[Source], folder: &Path) -> Outcome {
    let given = args.crs.as_deref().map(Crs::parse).transpose();
    let given = given.map_err(|fault| InputError { file: "--crs".into(), ..fault })?;
    let crs = scans::common_crs(sources, given)?;
    std::fs::create_dir_all(folder).map_err(|e| Error::io(folder, "create", e))?;
    let total: usize = sources.iter().map(|source| source.models.len()).sum();
    let job = scans::Job {
        sources: sources.to_vec(),
        crs,
        options: args.conditions.0.clone(),
        seed: args.seed,
        output: folder.to_path_buf(),
        overwrite: args.overwrite,
    };
    let progress = Progress::new(total as u64, args.quiet);
    let written = scans::write(&job, &|by| progress.advanced(by))?;
    let elapsed = progress.finish();
    for (reason, &count) in &written.failed {
        say(&format!("warning: {} not scanned: {reason}", counted(count as u64, "model")));
    }
    if !args.quiet {
        let [building, ground] = written.points.map(thousands);
        let files: Vec<String> = written.files.iter().map(|file| format!("  {}", file.display())).collect();
        print(&format!(
            "{} scanned in {}: {building} building points, {ground} ground points\n{}\n",
            counted(written.buildings as u64, "building"),
            duration(elapsed),
            files.join("\n")
        ))?;
    }
    Ok(if written.failed.is_empty() { 0 } else { INCOMPLETE })
}

/// Tells what the scans look like: the virtual ones together, and the real ones tile by tile.
fn write_statistics(args: &Args, sources: &[Source], real: &[RealSource], path: &Path) -> Result<()> {
    let models: Vec<&Model> = sources.iter().flat_map(|source| &source.models).collect();
    let mut columns: Vec<Statistics> =
        real.iter().map(|source| Statistics::of_real(&source.name, &source.sites)).collect();
    if !models.is_empty() {
        columns.push(Statistics::of_models("virtual", &models, &args.conditions.0, args.seed));
    }
    write_whole(path, statistics_table(&columns).as_bytes())
}

fn make_training_data(args: &Args, sources: Vec<Source>, real: Vec<RealSource>, folder: &Path) -> Outcome {
    let subjects: usize = sources.iter().map(|source| source.models.len()).sum();
    let scans = (subjects + real.iter().map(|source| source.sites.len()).sum::<usize>()) * args.variants.get();
    let job = Job {
        sources,
        real,
        variants: args.variants.get(),
        options: args.conditions.0.clone(),
        augment: !args.no_augmentation,
        interface: args.interface,
        sizes: sizes(args),
        shares: args.split.0,
        seed: args.seed,
        shard: args.sizes.shard.get(),
        output: folder.to_path_buf(),
    };
    interrupt::listen();
    interrupt::something_to_save();
    let progress = Progress::new(scans as u64, args.quiet);
    let manifest = run(&job, &progress)?;
    let elapsed = progress.finish();
    if !args.quiet {
        print(&summary(&manifest, elapsed))?;
    }
    Ok(if manifest.interrupted { INCOMPLETE } else { 0 })
}

/// The training data that a folder holds, which is there or not.
///
/// # Errors
/// There are some, and they shall not be replaced.
fn training_data(folder: &Path, overwrite: bool) -> Result<Vec<PathBuf>> {
    let entries = match std::fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(fault) if fault.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(fault) => return Err(Error::io(folder, "read", fault)),
    };
    let mut found = Vec::new();
    for entry in entries {
        let path = entry.map_err(|e| Error::io(folder, "read", e))?.path();
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        let is_shard = name.ends_with(".safetensors") && Split::ALL.iter().any(|split| name.starts_with(split.name()));
        if !is_shard && name != "manifest.json" {
            continue;
        }
        if !overwrite {
            return Err(InputError::new(folder, format!("training data ({name})"), "a folder without any")
                .remedy("Give --overwrite to replace them, or another folder")
                .into());
        }
        found.push(path);
    }
    Ok(found)
}

fn sources(args: &Args) -> Result<Vec<Source>> {
    let mut sources = Vec::new();
    for path in &cityjson::expand(&args.files)? {
        let mut source = read(path, args.lod.as_deref())?;
        // Two files of one name in different folders are two tiles.
        let double = sources.iter().filter(|other: &&Source| other.name == source.name).count();
        if double > 0 {
            for model in &mut source.models {
                model.tile = format!("{} ({})", model.tile, double + 1).into();
            }
        }
        sources.push(source);
    }
    if args.generate > 0 {
        sources.push(generate(args.generate, args.seed));
    }
    for source in &mut sources {
        source.models.truncate(args.limit.map_or(usize::MAX, NonZeroUsize::get));
    }
    let expects_models = !args.files.is_empty() || args.generate > 0;
    if expects_models && sources.iter().all(|source| source.models.is_empty()) {
        let reasons: Vec<String> =
            sources.iter().flat_map(|s| &s.left_out).map(|(reason, count)| format!("{count} × {reason}")).collect();
        let named = args.files.first().map_or_else(|| PathBuf::from("--generate"), Clone::clone);
        return Err(InputError::new(named, format!("no model that could be scanned ({})", reasons.join(", ")), "some")
            .remedy("`gable validate` tells what is wrong with a file, solid by solid")
            .into());
    }
    Ok(sources)
}

/// Reads the tiles of real scans, in the order in which they are named.
fn real_sources(args: &Args) -> Result<Vec<RealSource>> {
    let given = &args.real;
    let Some(path) = &given.footprints else { return Ok(Vec::new()) };
    let named = |fault: InputError| InputError { file: "--footprint-crs".into(), ..fault };
    let crs = given.footprint_crs.as_deref().map(Crs::parse).transpose().map_err(named)?;
    let options = RealOptions {
        footprints: footprints::read(path, &FootprintOptions { crs, ..FootprintOptions::default() })?,
        crs: args.crs.clone(),
        segmentation: SegmentOptions { building_classes: given.building_class.clone(), ..SegmentOptions::default() },
    };
    let mut found: Vec<RealSource> = Vec::new();
    for (tiles, held_back) in [(&given.real, false), (&given.hold_back, true)] {
        if tiles.is_empty() {
            continue;
        }
        for tile in points::expand(tiles)? {
            let mut source = read_tile(&tile, &options, held_back)?;
            for warning in &source.warnings {
                say(&format!("warning: {}: {warning}", source.name));
            }
            source.sites.truncate(args.limit.map_or(usize::MAX, NonZeroUsize::get));
            found.push(source);
        }
    }
    if found.iter().all(|source| source.sites.is_empty()) {
        let fault = InputError::new(path, "no building with points enough in the tiles", "some");
        return Err(fault.remedy("Is --building-class right? `gable info` tells which classes a tile has").into());
    }
    Ok(found)
}

fn sizes(args: &Args) -> Sizes {
    let given = &args.sizes;
    let usual = Sizes::of(args.interface);
    Sizes {
        grid: if usual.grid == 0 { 0 } else { given.grid.get() },
        neighbours: given.patch_points.map_or(usual.neighbours, NonZeroUsize::get),
        near: given.near,
        uniform: given.uniform,
        cells: given.cells,
        samples_per_cell: given.samples_per_cell.get(),
        ..usual
    }
}

/// What was made, for a person.
fn summary(manifest: &Manifest, elapsed: f64) -> String {
    let row = |name: String, value: String| vec![name, value];
    let mut rows = Vec::new();
    for source in &manifest.sources {
        rows.push(row(source.name.clone(), counted(source.models as u64, "model")));
        for (reason, &count) in &source.left_out {
            rows.push(row(format!("  left out: {reason}"), thousands(count as u64)));
        }
    }
    for split in Split::ALL {
        let tiles = manifest.tiles.values().filter(|of| **of == split).count();
        let scans = manifest.scans.get(&split).copied().unwrap_or(0);
        if tiles > 0 {
            rows.push(row(
                format!("{} ({})", split.name(), counted(tiles as u64, "tile")),
                counted(scans as u64, "scan"),
            ));
        }
    }
    for (reason, &count) in &manifest.failed {
        rows.push(row(format!("  gave nothing: {reason}"), thousands(count as u64)));
    }
    let mut text = table(&rows, "");
    let scans: usize = manifest.scans.values().sum();
    let ended = if manifest.interrupted { "interrupted after" } else { "in" };
    let _ = writeln!(
        text,
        "{} in {}, {ended} {}",
        counted(scans as u64, "scan"),
        counted(manifest.shards.len() as u64, "shard"),
        duration(elapsed)
    );
    text
}
