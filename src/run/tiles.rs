//! Opening the tiles and agreeing on their CRS.

use std::path::PathBuf;

use rayon::ThreadPool;
use rayon::prelude::*;

use super::feed::Fed;
use super::observer::{Event, Observer, Stage};
use crate::error::{InputError, Result};
use crate::report::{CrsSource, TileReport};
use crate::source::crs::Crs;
use crate::source::points::{Extent, Placement, Tile};

/// How far the points of a building, or of a few, usually reach, metres.
const USUAL_SIZE: std::ops::RangeInclusive<f64> = 2.0..=2000.0;

/// So many tiles per thread are opened before the next is told of.
const OPENED_AT_ONCE: usize = 4;

/// The tiles that could be opened.
#[derive(Debug)]
pub struct OpenTiles {
    /// The tiles, in the order of their paths.
    pub tiles: Vec<Tile>,
    /// One report per tile, those that could not be opened included.
    pub reports: Vec<TileReport>,
}

/// Opens all tiles, several at a time in `pool`, and takes the points that were `fed` for one more. One that cannot be opened
/// is told to the observer and left out.
///
/// # Errors
/// The fault of the first tile when none can be opened.
pub fn open(paths: &[PathBuf], fed: Option<&Fed>, pool: &ThreadPool, observer: &dyn Observer) -> Result<OpenTiles> {
    let mut open = OpenTiles { tiles: Vec::new(), reports: Vec::new() };
    let mut first_fault = None;
    let is_only = paths.len() + usize::from(fed.is_some()) == 1;
    let at_once = OPENED_AT_ONCE * pool.current_num_threads();
    let opened = paths.chunks(at_once).flat_map(|some| {
        let opened: Vec<_> = pool.install(|| some.par_iter().map(Tile::open).collect());
        some.iter().zip(opened)
    });
    for (path, opened) in opened {
        let mut report = TileReport {
            file: path.display().to_string(),
            cloud: None,
            points: 0,
            missing_points: 0,
            left_out: false,
            crs: None,
            problems: Vec::new(),
        };
        match opened {
            Ok(tile) => {
                report.points = tile.points;
                report.crs = tile.crs.as_ref().map(label);
                if tile.points == 0 && !is_only {
                    let problem = format!("{}: the tile holds no point", path.display());
                    observer.event(Event::Warning(&problem));
                    report.problems.push(problem);
                }
                open.tiles.push(tile);
            }
            Err(fault) => {
                report.problems.push(fault.to_string());
                report.left_out = true;
                if !is_only {
                    observer.event(Event::Warning(&format!("{fault}; the tile is left out")));
                }
                first_fault.get_or_insert(fault);
            }
        }
        open.reports.push(report);
        observer.event(Event::Advanced { stage: Stage::Read, by: 1 });
    }
    if let Some(fed) = fed {
        let crs = fed.tiles().first().and_then(|tile| tile.crs.as_ref()).map(label);
        open.tiles.extend_from_slice(fed.tiles());
        open.reports.push(TileReport {
            file: fed.name().display().to_string(),
            cloud: None,
            points: fed.points(),
            missing_points: 0,
            left_out: false,
            crs,
            problems: Vec::new(),
        });
        observer.event(Event::Advanced { stage: Stage::Read, by: 1 });
    }
    match first_fault {
        Some(fault) if open.tiles.is_empty() => Err(fault),
        _ => Ok(open),
    }
}

/// Refuses tiles without a single point.
///
/// # Errors
/// There is not one point in all of them.
pub fn refuse_emptiness(tiles: &[Tile]) -> Result<()> {
    let Some(first) = tiles.first().filter(|_| tiles.iter().all(|tile| tile.points == 0)) else { return Ok(()) };
    let found = match tiles.len() {
        1 => "no point: the header says 0".to_owned(),
        n => format!("no point, nor in any other of {n} tiles"),
    };
    let fault = InputError::new(&first.path, found, "tiles with points");
    Err(fault.remedy("Make or fetch the tiles again, or give those where the buildings are").into())
}

/// The code of a CRS, or its name when it has none.
pub fn label(crs: &Crs) -> String {
    crs.code.clone().unwrap_or_else(|| crs.name.clone())
}

/// The CRS that the tiles agree on, or the one that the user named, and what the user should know about the choice.
///
/// `footprints` is the CRS of the footprints: never taken for that of the tiles, but worth a hint when theirs is unknown.
///
/// # Errors
/// `option` cannot be understood; no tile names a CRS; two tiles name different ones; the CRS is geographic.
pub fn agree_on_crs(
    tiles: &[Tile],
    option: Option<&str>,
    footprints: Option<&Crs>,
) -> Result<(Crs, CrsSource, Vec<String>)> {
    let mut warnings = Vec::new();
    let named = || tiles.iter().filter_map(|tile| Some((tile, tile.crs.as_ref()?)));
    let (crs, source) = if let Some(text) = option {
        let crs = Crs::parse(text).map_err(|fault| InputError { file: "--crs".into(), ..fault })?;
        if let Some((tile, own)) = named().find(|(_, own)| !is_same(own, &crs)) {
            let tile = tile.path.display();
            warnings.push(format!("--crs {} goes before {} of {tile}", label(&crs), label(own)));
        }
        (crs, CrsSource::Option)
    } else {
        let Some((first, crs)) = named().next() else { return Err(unknown(tiles, footprints).into()) };
        if let Some((other, different)) = named().find(|(_, other)| !is_same(crs, other)) {
            let fault =
                InputError::new(&other.path, different.to_string(), format!("{crs} as in {}", first.path.display()));
            return Err(fault
                .remedy("Reproject the tiles to one CRS, or give --crs if one of the two is wrong")
                .into());
        }
        let nameless = tiles.iter().filter(|tile| tile.crs.is_none()).count();
        if nameless > 0 {
            warnings.push(format!(
                "{nameless} of {} tiles name no CRS; they are taken to be in {} like the others",
                tiles.len(),
                label(crs)
            ));
        }
        (crs.clone(), CrsSource::Tiles)
    };
    if crs.is_geographic {
        let place = named().next().filter(|_| source == CrsSource::Tiles);
        let file = place.map_or_else(|| PathBuf::from("--crs"), |(tile, _)| tile.path.clone());
        let fault = InputError::new(file, format!("{crs}, whose units are degrees"), "a projected CRS");
        let remedy = "Reproject the tiles first, for example with \
                      `pdal translate in.laz out.laz reprojection --filters.reprojection.out_srs=EPSG:…`";
        return Err(fault.remedy(remedy).into());
    }
    if let Some(vertical) = crs.unknown_heights() {
        warnings.push(format!(
            "nobody knows the vertical system `{vertical}`: heights are taken as they are, and the model is in {}; give \
             another with --crs if their datum is a known one",
            label(&crs)
        ));
    }
    Ok((crs, source, warnings))
}

/// The CRS of tiles that are reconstructed without footprints: as [`agree_on_crs`], or coordinates of their own where no tile
/// names one, and what is to be said of that. `is_placed` says whether the user told how these are meant.
///
/// # Errors
/// As [`agree_on_crs`]; a CRS that a tile names and nobody can understand; points that reach so far that their coordinates
/// can hardly be metres.
pub fn agree_on_crs_or_none(
    tiles: &[Tile],
    option: Option<&str>,
    is_placed: bool,
) -> Result<(Crs, CrsSource, Vec<String>)> {
    let names_one = |tile: &Tile| tile.crs.is_some() || tile.crs_fault.is_some();
    if option.is_some() || tiles.iter().any(names_one) {
        return agree_on_crs(tiles, option, None);
    }
    let mut whole = Extent::EMPTY;
    for extent in tiles.iter().filter_map(|tile| tile.extent) {
        whole.join(&extent);
    }
    let size = (0..3).map(|axis| whole.max[axis] - whole.min[axis]).fold(0.0, f64::max);
    let is_unusual = !whole.is_empty() && !is_placed && !USUAL_SIZE.contains(&size);
    let first = tiles.first().filter(|_| is_unusual);
    if let Some(first) = first {
        let found = format!("points that reach over {size} units, and no word on how long a unit is");
        let [low, high] = [USUAL_SIZE.start(), USUAL_SIZE.end()];
        let fault = InputError::new(&first.path, found, format!("{low} to {high} m of one or several buildings"));
        return Err(fault
            .remedy("Say what a unit is with --unit, such as --unit mm, or --unit m if it is a metre")
            .into());
    }
    let warning = "no coordinate reference system: the model is written in coordinates of its own, in metres with heights \
                   along z, and names no system; --crs names it, --unit and --up-axis say how its coordinates are meant";
    Ok((Crs::local(), CrsSource::Local, vec![warning.to_owned()]))
}

/// A tile with its coordinates in metres and heights along z, as the user says how they are meant.
///
/// # Errors
/// It names a CRS, which says so already.
pub fn place(tile: Tile, placement: Option<Placement>) -> Result<Tile> {
    let Some(placement) = placement else { return Ok(tile) };
    if let Some(crs) = &tile.crs {
        let fault = InputError::new(&tile.path, format!("the system {crs}"), "none, with --unit or --up-axis");
        return Err(fault
            .remedy("It says what its units are and that heights are along z: leave these options out")
            .into());
    }
    Ok(tile.placed(placement))
}

/// The CRS with units as long as they are where the tiles lie, and a warning, if those of its map are not; else as it is.
pub fn true_to_length(crs: Crs, tiles: &[Tile]) -> (Crs, Option<String>) {
    if crs.is_local() {
        return (crs, None);
    }
    let Some(extent) = tiles.iter().find_map(|tile| tile.extent) else { return (crs, None) };
    let centre = [0, 1].map(|axis| f64::midpoint(extent.min[axis], extent.max[axis]));
    let Some(scale) = crs.distortion(centre) else { return (crs, None) };
    let warning = format!(
        "a metre of {crs} is {:.3} m on the ground here: lengths, areas and volumes are corrected for it, the coordinates of \
         the model stay in that system; better reproject the tiles to a system of the country",
        scale[0]
    );
    (crs.corrected(scale), Some(warning))
}

/// Whether two tiles mean the same system; one that comes without a code is taken by what it says.
fn is_same(a: &Crs, b: &Crs) -> bool {
    match (&a.code, &b.code) {
        (Some(a), Some(b)) => a == b,
        _ => a.metres_per_unit == b.metres_per_unit && a.is_same_horizontally(b),
    }
}

fn unknown(tiles: &[Tile], footprints: Option<&Crs>) -> InputError {
    let faulty = tiles.iter().find_map(|tile| Some((tile, tile.crs_fault.as_ref()?)));
    let (tile, found) = match (faulty, tiles.first()) {
        (Some((tile, fault)), _) => (tile.path.clone(), fault.clone()),
        (None, Some(tile)) => (tile.path.clone(), "no coordinate reference system".to_owned()),
        (None, None) => (PathBuf::from("tiles"), "none".to_owned()),
    };
    let hint = match footprints {
        Some(crs) if !crs.is_geographic => {
            format!("; the footprints are in {crs}: if the tiles are too, give --crs {}", label(crs))
        }
        _ => String::new(),
    };
    let expected = "a WKT record or GeoTIFF keys that name one";
    InputError::new(tile, found, expected)
        .remedy(format!("Give it with --crs, as in --crs EPSG:7415 (with heights if they have a datum){hint}"))
}
