//! Pictures of the buildings of a CityJSON or CityJSONSeq file.
//!
//! ```text
//! cargo run --release --example render -- out/delft.city.json -o delft.png
//! cargo run --release --example render -- out/delft.city.json -o worst.png --points tile.laz --worst 12
//! ```
//!
//! Without `--id`, `--worst` or `--each` the whole neighbourhood is one picture; with them every building gets its own
//! on a contact sheet. Roofs are red, walls grey, the ground brown, undersides green; blue is the roof
//! of the LoD 1.2 block, or the footprint, where the level of detail is missing. Points are green on their roof, red above
//! and blue below it (full colour at half a metre), black where there is no roof.

mod camera;
mod canvas;
mod scene;
mod sheet;
mod text;

use std::collections::BTreeMap;
use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use gable::evaluate::{DistanceSummary, ModelFile, Shape, TileFilter, count_faces, read_shapes, stream_points};
use nalgebra::Point3;
use scene::{Subject, View, on_shape, picture};
use sheet::{Tile, contact_sheet};

/// Pictures of the buildings of a CityJSON or CityJSONSeq file, as PNG.
#[derive(Debug, Parser)]
struct Options {
    /// CityJSON (1.0 to 2.0) or CityJSONSeq file.
    model: PathBuf,
    /// The picture to write.
    #[arg(short, long, default_value = "buildings.png")]
    output: PathBuf,
    /// Level of detail.
    #[arg(long, default_value = "2.2")]
    lod: String,
    /// A building to show, by its id; may be repeated.
    #[arg(long)]
    id: Vec<String>,
    /// The buildings whose points are farthest from their roofs; needs points.
    #[arg(long, value_name = "N", requires = "points")]
    worst: Option<usize>,
    /// Every building, each on its own.
    #[arg(long)]
    each: bool,
    /// LAS or LAZ files whose building points are drawn over the model.
    #[arg(long, num_args = 1.., value_name = "TILE")]
    points: Vec<String>,
    /// The classes of the points that are drawn.
    #[arg(long, value_delimiter = ',', default_value = "6", value_name = "CLASS,…")]
    class: Vec<u8>,
    /// Width of a picture in pixels.
    #[arg(long, default_value_t = 800)]
    size: usize,
    /// Height over width of a picture.
    #[arg(long, default_value_t = 0.75)]
    aspect: f64,
    /// Pictures of each building on a contact sheet, from directions all around it.
    #[arg(long, default_value_t = 2)]
    views: usize,
    /// Where the viewer stands: degrees clockwise from north.
    #[arg(long, default_value_t = 205.0, allow_negative_numbers = true)]
    azimuth: f64,
    /// How high the viewer stands: degrees over the horizon.
    #[arg(long, default_value_t = 38.0, allow_negative_numbers = true)]
    elevation: f64,
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error}");
            ExitCode::FAILURE
        }
    }
}

fn run(options: &Options) -> Result<(), Box<dyn Error>> {
    let model = read_shapes(&options.model, &options.lod, None)?;
    let points = points_of(options, &model)?;
    let height = (options.size as f64 * options.aspect.clamp(0.1, 10.0)) as usize;
    let view = View { azimuth: options.azimuth, elevation: options.elevation, size: [options.size, height] };
    let subjects = with_blocks(model, options);
    let chosen = choose(&subjects, &points, options)?;
    let image = match chosen {
        None => {
            let all: Vec<&Subject> = subjects.iter().collect();
            let drawn: Vec<_> = all.iter().flat_map(|subject| on_shape(&subject.shape, &points)).collect();
            picture(&all, &drawn, view)
        }
        Some(chosen) => {
            let tiles: Vec<Tile> = chosen.iter().map(|subject| tile(subject, &points, view, options.views)).collect();
            contact_sheet(&tiles)
        }
    };
    let image = image.ok_or("nothing to draw")?;
    image.save_png(&options.output)?;
    println!("{}: {} × {} pixels", options.output.display(), image.width(), image.height());
    Ok(())
}

/// The buildings of the model, with LoD 1.2 blocks for those that lack the level of detail.
fn with_blocks(model: ModelFile, options: &Options) -> Vec<Subject> {
    let has_gaps = model.shapes.iter().any(|shape| shape.faces.is_empty());
    // A file without any block shows its footprints instead.
    let blocks = has_gaps.then(|| read_shapes(&options.model, "1.2", Some(model.frame)).ok()).flatten();
    let blocks: BTreeMap<String, Shape> =
        blocks.into_iter().flat_map(|model| model.shapes).map(|shape| (shape.id.clone(), shape)).collect();
    let subject = |shape: Shape| {
        let block = if shape.faces.is_empty() { blocks.get(&shape.id) } else { None };
        Subject { is_fallback: block.is_some(), shape: block.cloned().unwrap_or(shape) }
    };
    model.shapes.into_iter().map(subject).collect()
}

/// The points of the tiles that the options name, in the frame of the model.
fn points_of(options: &Options, model: &ModelFile) -> Result<Vec<Point3<f64>>, Box<dyn Error>> {
    let mut points = Vec::new();
    if options.points.is_empty() {
        return Ok(points);
    }
    let tiles = gable::source::points::expand(&options.points)?;
    let filter = TileFilter { classes: &options.class, frame: model.frame, crs: model.crs.as_ref() };
    let everywhere = [[[f64::NEG_INFINITY; 2], [f64::INFINITY; 2]]];
    for problem in
        stream_points(&tiles, filter, &everywhere, &mut |batch| points.extend(batch.iter().map(|(point, _)| *point)))?
    {
        eprintln!("warning: {problem}");
    }
    Ok(points)
}

/// The buildings that the options ask for; `None` when they ask for the neighbourhood as a whole.
fn choose<'a>(
    subjects: &'a [Subject],
    points: &[Point3<f64>],
    options: &Options,
) -> Result<Option<Vec<&'a Subject>>, Box<dyn Error>> {
    if let Some(count) = options.worst {
        let mut ranked: Vec<(f64, &Subject)> = subjects
            .iter()
            .filter_map(|subject| {
                let distances = on_shape(&subject.shape, points).into_iter().map(|(_, d)| d.unwrap_or(100.0) as f32);
                Some((DistanceSummary::of(distances)?.p90, subject))
            })
            .collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0).then_with(|| a.1.shape.id.cmp(&b.1.shape.id)));
        return Ok(Some(ranked.into_iter().take(count).map(|(_, subject)| subject).collect()));
    }
    if options.each {
        return Ok(Some(subjects.iter().collect()));
    }
    if options.id.is_empty() {
        return Ok(None);
    }
    let find = |id: &String| {
        subjects
            .iter()
            .find(|s| s.shape.id == *id)
            .or_else(|| subjects.iter().find(|s| s.shape.id.ends_with(id.as_str())))
    };
    options
        .id
        .iter()
        .map(|id| find(id).ok_or_else(|| format!("no building {id}").into()))
        .collect::<Result<_, _>>()
        .map(Some)
}

/// Pictures of one building with its figures.
fn tile(subject: &Subject, points: &[Point3<f64>], view: View, views: usize) -> Tile {
    let shape = &subject.shape;
    let points = on_shape(shape, points);
    let pictures = (0..views.max(1)).filter_map(|turn| {
        let azimuth = view.azimuth + 360.0 * turn as f64 / views.max(1) as f64;
        picture(&[subject], &points, View { azimuth, ..view })
    });
    let faces = count_faces(shape);
    let [total, merged] = [faces.iter().map(|c| c.faces).sum::<usize>(), faces.iter().map(|c| c.merged).sum()];
    let mut caption = vec![shape.id.clone()];
    caption.push(if shape.faces.is_empty() {
        "no model".to_owned()
    } else {
        let level = if subject.is_fallback { "LoD 1.2, " } else { "" };
        format!("{level}{} solid(s), {total} faces ({merged} merged), {:.0} m3", faces.len(), shape.volume())
    });
    if !points.is_empty() {
        let bare = points.iter().filter(|(_, d)| d.is_none()).count();
        let figures = DistanceSummary::of(points.iter().filter_map(|(_, d)| d.map(|d| d as f32)));
        let highest = points.iter().map(|(p, _)| p.z).fold(f64::NEG_INFINITY, f64::max);
        let top = shape.aabb().map_or(0.0, |aabb| aabb.max[2] - highest);
        caption.push(format!("{} points, {bare} without roof, top {top:+.2}", points.len()));
        caption.extend(
            figures.map(|s| format!("median {:.2}, p90 {:.2}, {:.0}% in 0.2 m", s.median, s.p90, 100.0 * s.within_0_2)),
        );
    }
    Tile { pictures: pictures.collect(), caption }
}
