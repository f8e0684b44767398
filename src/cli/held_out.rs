//! `gable evaluate --field … --hold-out SHARE`: what fields are worth on real scans.

use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;

use super::Outcome;
use super::output::{print, say};
use super::progress::{Progress, Verbosity};
use super::trial::{TrialArgs, markdown};
use crate::completeness::{Count, Limits};
use crate::error::{InputError, Result};
use crate::reconstruct::Parameters;
use crate::run::{FootprintSource, Job, sites};
use crate::segment::{BuildingClasses, SegmentOptions};
use crate::sink::write_json;
use crate::source::crs::Crs;
use crate::source::footprints::{self, FootprintOptions};
use crate::trial::{HeldOutField, HeldOutFigures, HeldOutTrial, Holding};

/// What `gable evaluate --hold-out` takes beside fields and tiles.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Trial of fields on real scans")]
pub struct HeldOutArgs {
    /// Hold this share of the points back: fields reconstruct from the rest and are judged by it
    #[arg(long, value_name = "SHARE", value_parser = share, requires_all = ["fields", "points", "footprints"])]
    hold_out: Option<f64>,

    /// Thin the points that are not held out to so many per m² of footprint
    #[arg(long, value_name = "DENSITY", value_parser = density, requires = "hold_out")]
    density: Option<f64>,

    /// Building footprints: GeoPackage, GeoJSON, Shapefile, FlatGeobuf, GeoParquet, SpatiaLite, or a PostGIS database
    /// ("PG:host=… dbname=…")
    #[arg(short, long, value_name = "FILE", requires = "hold_out")]
    footprints: Option<PathBuf>,

    /// CRS of the tiles, such as EPSG:7415; goes before what they say
    #[arg(long, value_name = "CRS", requires = "hold_out")]
    crs: Option<String>,

    /// CRS of the footprints; goes before what the file says
    #[arg(long, value_name = "CRS", requires = "hold_out")]
    footprint_crs: Option<String>,
}

impl HeldOutArgs {
    /// Whether points are to be held out.
    pub fn is_given(&self) -> bool {
        self.hold_out.is_some()
    }
}

/// What the trial shares with the evaluation of a model.
#[derive(Debug, Clone, Copy)]
pub struct Shared<'a> {
    /// The tiles.
    pub tiles: &'a [String],
    /// Classes of building points.
    pub building_classes: &'a [u8],
    /// Classes of ground points.
    pub ground_classes: &'a [u8],
    /// What is a fault.
    pub limits: Limits,
}

/// The trial as data.
#[derive(Debug, Serialize)]
struct Report<'a> {
    gable: &'static str,
    tiles: &'a [String],
    footprints: Option<PathBuf>,
    holding: Holding,
    network: Option<String>,
    parameters: &'a Parameters,
    fields: &'a [HeldOutField],
}

/// Runs the trial.
///
/// # Errors
/// A file cannot be read or written, a network cannot be run, or no building holds enough points.
pub fn main(args: &HeldOutArgs, trial: &TrialArgs, shared: Shared<'_>, json: Option<&Path>) -> Outcome {
    let contenders = trial.contenders()?;
    if let Some(oracle) = contenders.iter().find(|contender| contender.field.is_none()) {
        return Err(InputError::new("--field", oracle.name.clone(), "fields that need no truth")
            .remedy("Of a real building nobody knows it: leave it out with --hold-out")
            .into());
    }
    let job = job(args, trial, shared)?;
    let sites = sites(&job, &Progress::new(Verbosity::Normal))?;
    let holding = Holding { share: args.hold_out.unwrap_or_default(), density: args.density, seed: trial.seed() };
    let trial_of_fields = HeldOutTrial {
        contenders,
        holding,
        parameters: Parameters { completeness: shared.limits, ..Parameters::default() },
    };
    let template = "{wide_bar} {pos} of {len} buildings, {eta} left";
    let style = ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar());
    let bar = ProgressBar::new(sites.len() as u64).with_style(style);
    let found = trial.pool()?.install(|| trial_of_fields.run(&sites, &|| bar.inc(1)));
    bar.finish_and_clear();
    if found.iter().all(|field| field.buildings.is_empty()) {
        return Err(InputError::new(
            "--footprints",
            "no footprint with enough building points",
            "at least one with 50",
        )
        .remedy("See whether --building-class is right and the tiles are those of the footprints")
        .into());
    }
    if let Some(path) = json {
        let report = Report {
            gable: env!("CARGO_PKG_VERSION"),
            tiles: shared.tiles,
            footprints: args.footprints.as_deref().map(footprints::label),
            holding,
            network: trial.network(),
            parameters: &trial_of_fields.parameters,
            fields: &found,
        };
        write_json(path, &report)?;
    }
    let left_out = sites.len() - found.first().map_or(0, |field| field.buildings.len());
    if left_out > 0 {
        say(&format!("{left_out} footprints hold too few building points to be tried"));
    }
    print(&markdown(&rows(&found)))?;
    Ok(0)
}

/// Where the sites come from.
fn job(args: &HeldOutArgs, trial: &TrialArgs, shared: Shared<'_>) -> Result<Job> {
    let named = |fault: InputError| InputError { file: "--footprint-crs".into(), ..fault };
    let crs = args.footprint_crs.as_deref().map(Crs::parse).transpose().map_err(named)?;
    let options = FootprintOptions { crs, ..FootprintOptions::default() };
    Ok(Job {
        tiles: shared.tiles.to_vec(),
        footprints: args.footprints.clone().map(|path| FootprintSource { path, options }),
        crs: args.crs.clone(),
        threads: trial.threads(),
        segmentation: SegmentOptions {
            building_classes: BuildingClasses::Listed(shared.building_classes.to_vec()),
            ground_classes: shared.ground_classes.to_vec(),
            ..SegmentOptions::default()
        },
        ..Job::default()
    })
}

/// The table: figures by fields.
fn rows(fields: &[HeldOutField]) -> Vec<Vec<String>> {
    let mut rows = vec![vec!["by the points held out".to_owned()]];
    rows[0].extend(fields.iter().map(|field| field.field.clone()));
    let mut row = |title: &str, of: &dyn Fn(&HeldOutFigures) -> String| {
        let mut row = vec![title.to_owned()];
        row.extend(fields.iter().map(|field| of(&field.figures)));
        rows.push(row);
    };
    let optional = |value: Option<f64>, decimals: usize| {
        value.map_or_else(|| "–".to_owned(), |value| format!("{value:.decimals$}"))
    };
    let buildings = |count: &Count| format!("{} / {} / {}", count.from_4, count.from_10, count.from_25);
    let area = |count: &Count| format!("{:.0}", count.area);
    row("Buildings", &|f| f.buildings.to_string());
    row("With LoD 2.2", &|f| f.lod22.to_string());
    row("Missing, buildings from 4 / 10 / 25 m²", &|f| buildings(&f.completeness.missing));
    row("Missing, m²", &|f| area(&f.completeness.missing));
    row("Excess, buildings from 4 / 10 / 25 m²", &|f| buildings(&f.completeness.excess));
    row("Excess, m²", &|f| area(&f.completeness.excess));
    row("Roofed ground, buildings from 4 / 10 / 25 m²", &|f| buildings(&f.completeness.roofed_ground));
    row("Roofed ground, m²", &|f| area(&f.completeness.roofed_ground));
    row("Vertical distance to the roof, m, median", &|f| optional(f.vertical.map(|v| v.median), 4));
    row("Within 0.2 m, %", &|f| optional(f.vertical.map(|v| 100.0 * v.within_0_2), 2));
    row("Faces, mean", &|f| optional(f.faces, 2));
    row("Confidence from 0.9, buildings", &|f| f.confident.buildings.to_string());
    row("  with a fault from 10 m²", &|f| f.confident.at_fault.to_string());
    row("  their share, %", &|f| optional(f.confident.share.map(|share| 100.0 * share), 1));
    row("Processor time per footprint, ms", &|f| optional(f.cpu_ms, 1));
    rows
}

/// A share that leaves points on both sides.
fn share(text: &str) -> Result<f64, String> {
    let share = text.trim().parse().ok().filter(|share: &f64| *share > 0.0 && *share < 1.0);
    share.ok_or_else(|| "a number above 0 and below 1 is expected".to_owned())
}

/// Points per m².
fn density(text: &str) -> Result<f64, String> {
    let density = text.trim().parse().ok().filter(|density: &f64| *density > 0.0 && density.is_finite());
    density.ok_or_else(|| "a number above 0 is expected".to_owned())
}
