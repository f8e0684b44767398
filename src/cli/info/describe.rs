//! What is in the files, as data.

use std::path::PathBuf;
use std::slice;

use geo::{Area, BoundingRect};
use serde::Serialize;

use super::model::ModelInfo;
use crate::error::{Error, Result};
use crate::run;
use crate::source::classes::OVERLAP;
use crate::source::crs::Crs;
use crate::source::footprints::{self, FootprintLayer, FootprintOptions};
use crate::source::points::{self, Placement, Tile, TileProblem, TileSummary};

/// What is in the files.
#[derive(Debug, Default, Serialize)]
pub struct Info {
    /// The tiles.
    pub tiles: Vec<TileInfo>,
    /// The footprint files.
    pub footprints: Vec<FootprintsInfo>,
    /// The city models.
    pub models: Vec<ModelInfo>,
}

/// What is in a tile.
#[derive(Debug, Serialize)]
pub struct TileInfo {
    /// The file.
    pub file: String,
    /// What kind of file it is: `LAS`, `LAZ`, `COPC`, `PLY` or `text`.
    pub format: String,
    /// LAS version, such as `1.4`; of other files how they are written.
    pub version: String,
    /// Point format, 0 to 10; absent where it is no LAS file.
    pub point_format: Option<u8>,
    /// Whether it is compressed.
    pub compressed: bool,
    /// Whether it is a cloud-optimised point cloud.
    pub copc: bool,
    /// When it was made, `YYYY-MM-DD`.
    pub date: Option<String>,
    /// What made it.
    pub software: String,
    /// Its CRS, or the one that the user named.
    pub crs: Option<CrsInfo>,
    /// What is wrong with its CRS.
    pub crs_fault: Option<String>,
    /// What a user should know before a run, one sentence each.
    pub notes: Vec<String>,
    /// What its points are.
    #[serde(flatten)]
    pub summary: TileSummary,
}

/// A CRS.
#[derive(Debug, Serialize)]
pub struct CrsInfo {
    /// Authority and code.
    pub code: Option<String>,
    /// Its name.
    pub name: String,
    /// Metres per unit along x, y and z.
    pub metres_per_unit: [f64; 3],
    /// Whether its units are degrees.
    pub geographic: bool,
}

/// What is in a footprint file.
#[derive(Debug, Serialize)]
pub struct FootprintsInfo {
    /// The file.
    pub file: String,
    /// Its CRS, or the one that the user named.
    pub crs: Option<CrsInfo>,
    /// Number of footprints.
    pub footprints: usize,
    /// Number of those that had to be repaired or got another id.
    pub mended: usize,
    /// Features without a usable polygon.
    pub rejected: Vec<RejectedInfo>,
    /// The attribute that the ids are taken from.
    pub id_attribute: Option<String>,
    /// The names of the attributes.
    pub attributes: Vec<String>,
    /// Smallest and largest coordinates, CRS units.
    pub extent: Option<[[f64; 2]; 2]>,
    /// Area of all footprints in square metres; absent in a CRS in degrees.
    pub area: Option<f64>,
    /// What is odd about the file.
    pub warnings: Vec<String>,
    /// How they lie on the tiles that were given.
    pub overlap: Option<OverlapInfo>,
    /// Whether all of it is there; the warnings tell what is not.
    pub is_whole: bool,
}

impl Info {
    /// Whether every file could be read to its end.
    pub fn is_whole(&self) -> bool {
        let is_missing = |problem: &TileProblem| matches!(problem, TileProblem::MissingPoints { .. });
        self.tiles.iter().all(|tile| !tile.summary.problems.iter().any(is_missing))
            && self.footprints.iter().all(|layer| layer.is_whole)
    }
}

/// A feature without a usable polygon.
#[derive(Debug, Serialize)]
pub struct RejectedInfo {
    /// Its id.
    pub id: String,
    /// What is wrong with it.
    pub detail: String,
}

/// How footprints lie on tiles, by the rectangles of both.
#[derive(Debug, Serialize)]
pub struct OverlapInfo {
    /// Footprints that lie on a tile, wholly or in part.
    pub touching: usize,
    /// Footprints that lie wholly on one tile.
    pub within: usize,
    /// Why it cannot be told.
    pub fault: Option<String>,
}

impl CrsInfo {
    pub(super) fn new(crs: &Crs) -> Self {
        Self {
            code: crs.code.clone(),
            name: crs.name.clone(),
            metres_per_unit: crs.metres_per_unit,
            geographic: crs.is_geographic,
        }
    }
}

/// Describes tiles (files, folders, patterns) and footprint files; also says which could not be read.
///
/// # Errors
/// `crs` is none.
pub fn describe(
    tiles: &[String],
    footprints: &[PathBuf],
    crs: Option<&str>,
    options: &FootprintOptions,
    placement: Option<Placement>,
) -> Result<(Info, Vec<Error>)> {
    let crs = crs.map(Crs::parse).transpose()?;
    let (mut info, mut faults, mut extents) = (Info::default(), Vec::new(), Vec::new());
    let mut tile_crs = crs.clone();
    let paths = if tiles.is_empty() { Ok(Vec::new()) } else { points::expand(tiles) };
    for path in paths.unwrap_or_else(|fault| {
        faults.push(fault);
        Vec::new()
    }) {
        let opened = Tile::open(&path).and_then(|tile| run::place(tile, placement));
        match opened.and_then(|tile| Ok((describe_tile(&tile, crs.as_ref())?, tile))) {
            Ok((description, tile)) => {
                extents.extend(description.summary.extent);
                tile_crs = tile_crs.or(tile.crs);
                info.tiles.push(description);
            }
            Err(fault) => faults.push(fault),
        }
    }
    for path in footprints {
        match footprints::read(path, options) {
            Ok(layer) => {
                let mut description = describe_layer(footprints::label(path).display().to_string(), &layer);
                description.overlap = (!extents.is_empty()).then(|| overlap(layer, tile_crs.as_ref(), &extents));
                info.footprints.push(description);
            }
            Err(fault) => faults.push(fault),
        }
    }
    Ok((info, faults))
}

fn describe_tile(tile: &Tile, crs: Option<&Crs>) -> Result<TileInfo> {
    let crs = crs.or(tile.crs.as_ref());
    let (true_crs, warning) = match crs {
        Some(crs) => run::true_to_length(crs.clone(), slice::from_ref(tile)),
        None => return described(tile, None, [1.0; 3], Vec::new()),
    };
    let unknown = true_crs
        .unknown_heights()
        .map(|name| format!("nobody knows the vertical system `{name}`: heights are taken as they are"));
    described(tile, crs, true_crs.metres_per_unit, warning.into_iter().chain(unknown).collect())
}

fn described(tile: &Tile, crs: Option<&Crs>, metres_per_unit: [f64; 3], mut notes: Vec<String>) -> Result<TileInfo> {
    let summary = tile.summary(metres_per_unit)?;
    notes.extend(not_used(&summary));
    if !tile.has_classes {
        let note = "the points have no classes: all are taken for points of buildings, or with footprints what stands out of \
                    the ground in them";
        notes.push(note.to_owned());
    }
    let software = tile.header.generating_software().trim_end_matches(['\0', ' ']);
    let software = if tile.is_las() { software.to_owned() } else { String::new() };
    Ok(TileInfo {
        file: tile.path.display().to_string(),
        format: tile.kind().to_owned(),
        version: tile.version.clone(),
        point_format: tile.is_las().then_some(tile.point_format),
        compressed: tile.header.point_format().is_compressed,
        copc: tile.is_copc,
        date: tile.header.date().filter(|_| tile.is_las()).map(|date| date.to_string()),
        software,
        crs: crs.map(CrsInfo::new),
        crs_fault: tile.crs_fault.clone(),
        notes,
        summary,
    })
}

/// What a run leaves out unless it is told to take it.
fn not_used(summary: &TileSummary) -> Vec<String> {
    let overlap = summary.classes.get(&OVERLAP).copied().unwrap_or(0);
    let said = [
        (overlap, "are of class 12 (overlap), which is used only with --building-class 6,12"),
        (summary.synthetic, "are marked as synthetic and used only with --use-flagged synthetic"),
        (summary.withheld, "are marked as withheld and used only with --use-flagged withheld"),
    ];
    said.into_iter().filter(|(n, _)| *n > 0).map(|(n, what)| format!("{n} points {what}")).collect()
}

fn describe_layer(file: String, layer: &FootprintLayer) -> FootprintsInfo {
    let area = || layer.footprints.iter().map(|f| f.polygon.unsigned_area()).sum::<f64>();
    FootprintsInfo {
        file,
        crs: layer.crs.as_ref().map(CrsInfo::new),
        footprints: layer.footprints.len(),
        mended: layer.footprints.iter().filter(|f| !f.notes.is_empty()).count(),
        rejected: layer
            .rejected
            .iter()
            .map(|feature| RejectedInfo { id: feature.id.clone(), detail: feature.reason.clone() })
            .collect(),
        id_attribute: layer.id_attribute.clone(),
        attributes: layer.columns.clone(),
        extent: layer.extent().map(|rectangle| [rectangle.min().into(), rectangle.max().into()]),
        area: layer
            .crs
            .as_ref()
            .filter(|crs| !crs.is_geographic)
            .map(|crs| area() * crs.metres_per_unit[0] * crs.metres_per_unit[1]),
        warnings: layer.warnings.clone(),
        overlap: None,
        is_whole: layer.missing == 0 && !layer.is_damaged,
    }
}

/// Counts the footprints whose rectangle meets that of a tile.
fn overlap(mut layer: FootprintLayer, crs: Option<&Crs>, extents: &[[[f64; 3]; 2]]) -> OverlapInfo {
    let mut overlap = OverlapInfo { touching: 0, within: 0, fault: None };
    let Some(crs) = crs else {
        overlap.fault = Some("the CRS of the tiles is not known: give it with --crs".to_owned());
        return overlap;
    };
    if let Err(fault) = layer.reproject(crs) {
        overlap.fault = Some(fault.to_string());
        return overlap;
    }
    for rectangle in layer.footprints.iter().filter_map(|footprint| footprint.polygon.bounding_rect()) {
        let (low, high) = (<[f64; 2]>::from(rectangle.min()), <[f64; 2]>::from(rectangle.max()));
        let meets = |[min, max]: &[[f64; 3]; 2]| (0..2).all(|i| low[i] <= max[i] && high[i] >= min[i]);
        let holds = |[min, max]: &[[f64; 3]; 2]| (0..2).all(|i| low[i] >= min[i] && high[i] <= max[i]);
        overlap.touching += usize::from(extents.iter().any(meets));
        overlap.within += usize::from(extents.iter().any(holds));
    }
    overlap
}
