//! Reading real scans: one tile at a time.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use super::RealSite;
use crate::error::Result;
use crate::run::agree_on_crs;
use crate::segment::{SegmentOptions, segment};
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
    let found = segment(tiles, layer.footprints, &crs, &options.segmentation, &|_| (), None)?;
    warnings.extend(found.problems.iter().map(ToString::to_string));
    let name = path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
    let tile: Arc<str> = name.as_str().into();
    let mut left_out = BTreeMap::new();
    let mut sites = Vec::new();
    for site in found.sites {
        if site.points.is_empty() {
            continue;
        }
        if site.points.len() < FEWEST_POINTS {
            *left_out.entry(format!("fewer than {FEWEST_POINTS} building points")).or_default() += 1;
            continue;
        }
        sites.push(RealSite { tile: Arc::clone(&tile), site });
    }
    Ok(RealSource { name, sites, left_out, held_back, warnings })
}
