//! `gable evaluate`: how good is a city model.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::Point3;

use super::flags::Flags;
use super::output::{print, say, table, thousands};
use super::{Outcome, held_out, trial};
use crate::completeness::{self, Limits};
use crate::error::{InputError, Result};
use crate::evaluate::{
    Agreement, BuildingCompleteness, BuildingEvaluation, CompletenessMeter, DistanceSummary, Evaluation, ModelFile,
    Overall, OverallReference, PointMeter, TileFilter, Typical, read_shapes, stream_points,
};
use crate::sink::write_json;
use crate::source::{cityjson, points};

/// How many buildings the table names; the JSON file has all.
const NAMED: usize = 10;

const EXAMPLES: &str = "\
Examples:
  How many faces has it, and are its solids valid?
    gable evaluate city.city.json
  How well does it fit the points it was made from?
    gable evaluate city.city.json --points tiles/*.laz --json figures.json
  How far is it from another model of the same buildings?
    gable evaluate city.city.json --reference other.city.jsonl
  What is a field worth, on virtual scans of these models and of 20 generated buildings?
    gable evaluate --field oracle,height-field,neural lod2/*.city.json --generate 20 --json worth.json
  And on real scans, reconstructed from half of the points and judged by the other half?
    gable evaluate --field height-field,neural --points tiles/ --footprints buildings.gpkg --hold-out 0.5";

/// What `gable evaluate` takes.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub struct Args {
    /// CityJSON (1.0 to 2.0) or CityJSONSeq file, `-` for standard input; with --field any number of them, folders of
    /// .city.json and .city.jsonl, and glob patterns
    #[arg(value_name = "MODEL", required_unless_present_any = ["fields", "generate"])]
    models: Vec<PathBuf>,

    /// Tiles whose building points are compared with the model: files, folders or glob patterns
    #[arg(long, num_args = 1.., value_name = "TILES")]
    points: Vec<String>,

    /// City model to compare with; buildings are matched by id
    #[arg(long, value_name = "FILE", conflicts_with = "fields")]
    reference: Option<PathBuf>,

    /// Classes of the building points
    #[arg(long, value_delimiter = ',', default_value = "6", value_name = "CLASS,…")]
    building_class: Vec<u8>,

    /// Classes of the ground points: where they lie under the model with nothing above, ground is roofed
    #[arg(long, value_delimiter = ',', default_value = "2", value_name = "CLASS,…")]
    ground_class: Vec<u8>,

    /// Level of detail that is measured, in the model and in the reference
    #[arg(long, default_value = "2.2", conflicts_with = "fields")]
    lod: String,

    /// Level of detail of the reference, where it differs
    #[arg(long, value_name = "LOD", requires = "reference")]
    reference_lod: Option<String>,

    /// Write all figures, building by building, to this JSON file
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,

    #[command(flatten)]
    limits: Flags<Limits>,

    #[command(flatten)]
    trial: trial::TrialArgs,

    #[command(flatten)]
    held_out: held_out::HeldOutArgs,
}

/// Runs the command; what is wrong with tiles goes to standard error.
///
/// # Errors
/// A file cannot be read or written, or the model, the tiles and the reference are not in one CRS.
pub fn main(args: &Args) -> Outcome {
    if args.held_out.is_given() {
        let shared = held_out::Shared {
            tiles: &args.points,
            building_classes: &args.building_class,
            ground_classes: &args.ground_class,
            limits: args.limits.0,
        };
        return held_out::main(&args.held_out, &args.trial, shared, args.json.as_deref());
    }
    if args.trial.is_given() {
        if !args.points.is_empty() {
            return Err(InputError::new("--points", "tiles for a trial on virtual scans", "none")
                .remedy("Give --hold-out and --footprints as well to try fields on real scans")
                .into());
        }
        return trial::main(&args.models, &args.trial, args.json.as_deref());
    }
    let models = cityjson::expand(&args.models)?;
    let [path] = models.as_slice() else {
        let found = format!("{} models", models.len());
        return Err(InputError::new("MODEL", found, "one; several only with --field").into());
    };
    let evaluation = evaluation(path, args, &mut |heard| {
        if let Heard::Warning(text) = heard {
            say(&format!("warning: {text}"));
        }
    })?;
    if let Some(path) = &args.json {
        write_json(path, &evaluation)?;
    }
    print(&text(&evaluation))?;
    Ok(0)
}

/// Something to be told while a model is measured.
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub enum Heard<'a> {
    /// Something that the user should know and that stops nothing.
    Warning(&'a str),
    /// So many more points of the tiles have been held against the model.
    Points(usize),
}

impl Args {
    /// Compares with the points of these tiles instead.
    pub(super) fn compare_with(&mut self, tiles: &[String]) {
        self.points = tiles.to_vec();
    }
}

/// Measures a model as `args` say.
///
/// # Errors
/// A file cannot be read, or the model, the tiles and the reference are not in one CRS.
pub(super) fn evaluation(path: &Path, args: &Args, heard: &mut dyn FnMut(Heard<'_>)) -> Result<Evaluation> {
    let model = read_shapes(path, &args.lod, None)?;
    let measured = if args.points.is_empty() { None } else { Some(measure(path, &model, args, heard)?) };
    let (points, completeness) = measured.unzip();
    let reference = args.reference.as_deref().map(|path| read_reference(path, &model, args)).transpose()?;
    let evaluation =
        Evaluation::new(&model.shapes, Some(&model.faults()), points, reference.as_ref().map(|r| r.shapes.as_slice()));
    Ok(match completeness {
        Some(found) => evaluation.with_completeness(found),
        None => evaluation,
    })
}

/// What the points say of a model: how well they agree with it, and what of it is missing or too much.
type Measured = ((Agreement, Vec<Agreement>), (completeness::Counts, Vec<Option<BuildingCompleteness>>));

fn measure(path: &Path, model: &ModelFile, args: &Args, heard: &mut dyn FnMut(Heard<'_>)) -> Result<Measured> {
    let tiles = points::expand(&args.points)?;
    let mut meter = PointMeter::new(&model.shapes);
    let mut judge = CompletenessMeter::new(&model.shapes, Arc::clone(meter.outlines()), args.limits.0);
    let boxes: Vec<_> = meter.boxes().collect();
    let classes = [args.building_class.as_slice(), &args.ground_class].concat();
    let filter = TileFilter { classes: &classes, frame: model.frame, crs: model.crs.as_ref() };
    let problems = stream_points(&tiles, filter, &boxes, &mut |points| {
        heard(Heard::Points(points.len()));
        let of = |classes: &[u8]| -> Vec<Point3<f64>> {
            points.iter().filter(|(_, class)| classes.contains(class)).map(|(point, _)| *point).collect()
        };
        let building_points = of(&args.building_class);
        meter.add(&building_points);
        judge.add(&building_points);
        judge.add_ground(&of(&args.ground_class));
    })?;
    for problem in problems {
        heard(Heard::Warning(&problem.to_string()));
    }
    let found = (meter.finish(), judge.finish(&model.frame));
    if found.0.0.points == 0 {
        let classes: Vec<String> = args.building_class.iter().map(u8::to_string).collect();
        heard(Heard::Warning(&format!(
            "no point of class {} lies on a building of {}: is --building-class right, and are model and tiles in the \
             same CRS?",
            classes.join(" or "),
            path.display()
        )));
    }
    Ok(found)
}

fn read_reference(path: &Path, model: &ModelFile, args: &Args) -> Result<ModelFile> {
    let lod = args.reference_lod.as_ref().unwrap_or(&args.lod);
    let reference = read_shapes(path, lod, Some(model.frame))?;
    if let (Some(ours), Some(theirs)) = (&model.crs, &reference.crs)
        && !ours.is_same_horizontally(theirs)
    {
        return Err(InputError::new(
            path,
            format!("the CRS {}", theirs.name),
            format!("{}, that of the model", ours.name),
        )
        .remedy("Compare models in one CRS")
        .into());
    }
    Ok(reference)
}

/// The evaluation for a person.
fn text(evaluation: &Evaluation) -> String {
    let mut rows = complexity(&evaluation.overall);
    if let Some(points) = &evaluation.overall.points {
        rows.extend(agreement(points, &evaluation.overall));
    }
    if let Some(counts) = &evaluation.overall.completeness {
        rows.extend(completeness_rows(counts));
    }
    if let Some(reference) = &evaluation.overall.reference {
        rows.extend(against_reference(reference));
    }
    table(&rows, "") + &worst(&evaluation.buildings)
}

fn row(name: &str, value: impl Into<String>) -> Vec<String> {
    vec![name.to_owned(), value.into()]
}

/// A figure in metres; `–` when there is none.
fn metres(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |v| format!("{v:.3} m"))
}

fn share(value: f64) -> String {
    format!("{:.1} %", 100.0 * value)
}

fn complexity(overall: &Overall) -> Vec<Vec<String>> {
    let number = |n: usize| thousands(n as u64);
    let typical = |t: Option<Typical>| t.map_or_else(|| "–".to_owned(), |t| format!("{:.1} / {:.1}", t.mean, t.median));
    let mut rows = vec![
        row("buildings", number(overall.buildings)),
        row("  with geometry", number(overall.with_geometry)),
        row("solids", number(overall.solids)),
    ];
    rows.extend(overall.valid_solids.map(|valid| row("  valid", number(valid))));
    rows.extend(overall.faults.iter().map(|(fault, &solids)| row(&format!("  fault {fault}"), number(solids))));
    rows.push(row("faces per solid, mean / median", typical(overall.faces)));
    rows.push(row("  coplanar ones merged", typical(overall.merged_faces)));
    rows.push(row("  triangles", typical(overall.triangles)));
    rows
}

fn agreement(points: &Agreement, overall: &Overall) -> Vec<Vec<String>> {
    let number = |n: usize| thousands(n as u64);
    let mut rows = vec![
        row("building points on buildings", number(points.points)),
        row("  without roof above or below", number(points.without_roof)),
    ];
    let mut distances = |name: &str, summary: Option<DistanceSummary>| {
        let Some(s) = summary else { return };
        rows.push(row(name, metres(Some(s.median))));
        rows.push(row("  90th percentile", metres(Some(s.p90))));
        rows.push(row("  root mean square (RMS)", metres(Some(s.rmse))));
        rows.push(row("  within 0.1 m", share(s.within_0_1)));
        rows.push(row("  within 0.2 m", share(s.within_0_2)));
        rows.push(row("  within 0.5 m", share(s.within_0_5)));
    };
    // Unlike the RMSE of a run, which is of each building.
    distances("vertical to the roof, all points at once: median", points.vertical);
    distances("to the nearest face, all points at once: median", points.orthogonal);
    rows.push(row("point over its roof, signed median", metres(points.vertical.map(|v| v.offset))));
    if let Some(tops) = overall.tops {
        rows.push(row("tops over the highest point", format!("of {} buildings", number(tops.buildings))));
        rows.push(row("  by more than 0.5 m", number(tops.above_0_5)));
        rows.push(row("  by more than 1 m", number(tops.above_1)));
    }
    rows
}

fn completeness_rows(counts: &completeness::Counts) -> Vec<Vec<String>> {
    let of = |name: &str, count: &completeness::Count| {
        let number = |n: usize| thousands(n as u64);
        let sizes = [count.from_4, count.from_10, count.from_25].map(number).join(" / ");
        row(name, format!("{sizes}, {:.0} m²", count.area))
    };
    vec![
        row(
            "buildings with areas from 4 / 10 / 25 m², all areas",
            format!("of {}", thousands(counts.buildings as u64)),
        ),
        of("  missing: scanned, not modelled", &counts.missing),
        of("  excess: modelled, not scanned", &counts.excess),
        of("  roofed ground", &counts.roofed_ground),
    ]
}

fn against_reference(reference: &OverallReference) -> Vec<Vec<String>> {
    let ratio = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.4}"));
    let mut rows = vec![
        row("buildings also in the reference", thousands(reference.matched as u64)),
        row("  missing from the model", thousands(reference.missing.len() as u64)),
        row("medians over these buildings:", ""),
        row("  distance between roofs", metres(reference.roof_distance)),
        row("  roof height over the reference", metres(reference.roof_offset)),
        row("  volume, intersection over union", ratio(reference.volume_iou)),
        row("  the least of them", ratio(reference.least_volume_iou)),
        row("  Hausdorff distance", metres(reference.hausdorff)),
        row("  symmetric mean Hausdorff distance", metres(reference.symmetric_mean)),
        row(
            "  the same over the largest side",
            reference.relative_symmetric_mean.map_or_else(|| "–".to_owned(), share),
        ),
    ];
    rows.push(row("  top over that of the reference", metres(reference.top_offset)));
    rows.push(row("  bottom over that of the reference", metres(reference.ground_offset)));
    rows
}

/// The buildings that agree least: with the points if there are any, else with the reference.
fn worst(buildings: &[BuildingEvaluation]) -> String {
    let by_points = |b: &BuildingEvaluation| b.points?.vertical.map(|v| v.p90);
    let by_reference = |b: &BuildingEvaluation| Some(1.0 - b.reference.as_ref()?.overlap?.volume_iou);
    let has_points = buildings.iter().any(|b| by_points(b).is_some());
    let badness = |b: &BuildingEvaluation| if has_points { by_points(b) } else { by_reference(b) };
    let mut ranked: Vec<(f64, &BuildingEvaluation)> = buildings.iter().filter_map(|b| Some((badness(b)?, b))).collect();
    ranked.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.id.cmp(&b.1.id)));
    if ranked.is_empty() {
        return String::new();
    }
    let number = |value: Option<f64>| value.map_or_else(|| "–".to_owned(), |v| format!("{v:.2}"));
    let mut rows =
        vec![["least agreement", "faces", "points", "median", "p90", "top", "IoU"].map(str::to_owned).to_vec()];
    rows.extend(ranked.into_iter().take(NAMED).map(|(_, b)| {
        let vertical = b.points.and_then(|p| p.vertical);
        vec![
            format!("  {}", b.id),
            b.solids.iter().map(|s| s.faces).sum::<usize>().to_string(),
            b.points.map_or_else(|| "–".to_owned(), |p| thousands(p.points as u64)),
            number(vertical.map(|v| v.median)),
            number(vertical.map(|v| v.p90)),
            number(b.points.and_then(|p| p.top)),
            number(b.reference.as_ref().and_then(|r| r.overlap).map(|o| o.volume_iou)),
        ]
    }));
    table(&rows, "")
}
