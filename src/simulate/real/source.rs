//! Reading real scans: one tile at a time.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use super::RealSite;
use crate::error::Result;
use crate::run::agree_on_crs;
use crate::segment::{BuildingClasses, SegmentOptions, segment};
use crate::source::footprints::FootprintLayer;
use crate::source::points::Tile;

/// A site with fewer building points shows too little of its building to learn from.
const FEWEST_POINTS: usize = 50;

/// How real tiles are read.
#[derive(Debug, Clone)]
pub struct RealOptions {
    /// Where buildings stand.
    pub footprints: FootprintLayer,
    /// The CRS of the tiles, whatever they say.
    pub crs: Option<String>,
    /// Which points belong to a building.
    pub segmentation: SegmentOptions,
}

/// The buildings that a tile shows.
#[derive(Debug, Clone)]
pub struct RealSource {
    /// The name of the tile's file.
    pub name: String,
    /// Those with points enough.
    pub sites: Vec<RealSite>,
    /// How many were left out, for each reason.
    pub left_out: BTreeMap<String, usize>,
    /// Whether the tile is kept for validation, whatever the shares are.
    pub held_back: bool,
    /// What the user should know.
    pub warnings: Vec<String>,
}

/// Reads the buildings of one tile.
///
/// # Errors
/// The tile cannot be read or is in no known CRS, no footprint lies in it, or none of its points are of a building.
pub fn read_tile(path: &Path, options: &RealOptions, held_back: bool) -> Result<RealSource> {
    let tile = Tile::open(path)?;
    let tiles = std::slice::from_ref(&tile);
    let mut layer = options.footprints.clone();
    let (crs, _, mut warnings) = agree_on_crs(tiles, options.crs.as_deref(), layer.crs.as_ref())?;
    warnings.extend(layer.reproject(&crs)?);
    layer.reject_giants(&crs);
    let found = segment(tiles, layer.footprints.clone(), &crs, &options.segmentation, &|_| ())?;
    warnings.extend(found.problems.iter().map(ToString::to_string));
    let on_ground = SegmentOptions {
        building_classes: BuildingClasses::Listed(options.segmentation.ground_classes.clone()),
        ground_classes: Vec::new(),
        ..options.segmentation.clone()
    };
    // A cloud that is not classified has no ground points, and so says nothing about open ground.
    let open = segment(tiles, layer.footprints, &crs, &on_ground, &|_| ()).ok();
    let mut open = open.map_or_else(Vec::new, |found| found.sites).into_iter();

    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let tile: Arc<str> = name.as_str().into();
    let mut left_out = BTreeMap::new();
    let mut sites = Vec::new();
    for site in found.sites {
        let open = open.next().map_or_else(Vec::new, |site| site.points);
        if site.points.is_empty() {
            continue;
        }
        if site.points.len() < FEWEST_POINTS {
            *left_out.entry(format!("fewer than {FEWEST_POINTS} building points")).or_default() += 1;
            continue;
        }
        sites.push(RealSite { tile: Arc::clone(&tile), site, open });
    }
    Ok(RealSource { name, sites, left_out, held_back, warnings })
}
