//! Indexes of tiles instead of tiles: which of the tiles that they name touch what is wanted. The others are never opened.

use std::borrow::Cow;
use std::path::Path;

use geo::BoundingRect;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

use super::job::{FootprintSource, Job};
use super::journal::Journal;
use super::layer;
use super::limit::Area;
use super::observer::Observer;
use crate::error::{InputError, Result};
use crate::source::crs::Crs;
use crate::source::footprints::{self, LARGEST_BUILDING, Within, extents_in};
use crate::source::points::Tile;
use crate::source::tile_index::{self, TileIndex};

/// What the tiles of indexes are held against.
struct Wanted {
    crs: Crs,
    area: Option<[f64; 4]>,
    /// The footprints, each with what is looked at around it; `None` where there are none.
    footprints: Option<Boxes>,
}

/// Rectangles in CRS units.
type Boxes = RTree<GeomWithData<Rectangle<[f64; 2]>, ()>>;

/// The job with indexes among its tiles replaced by those tiles that touch the footprints and the area that is wanted, as far
/// as it is known where they lie.
///
/// # Errors
/// An index cannot be read, no tile of it touches anything, or the footprints cannot be read.
pub(super) fn listed<'a>(job: &'a Job, journal: &Journal<'_>) -> Result<Cow<'a, Job>> {
    let is_index = |argument: &String| tile_index::is_index(Path::new(argument));
    if !job.all_tiles().iter().any(is_index) {
        return Ok(Cow::Borrowed(job));
    }
    let mut indexes = Vec::new();
    for argument in job.all_tiles().into_iter().filter(is_index) {
        let index = tile_index::read(Path::new(&argument))?;
        indexes.push((argument, index));
    }
    let wanted = wanted(job, indexes.iter().map(|(_, index)| index), journal)?;
    let mut kept_of = Vec::with_capacity(indexes.len());
    let mut kept_in_all = 0;
    for (argument, index) in &indexes {
        let kept = wanted.as_ref().map_or_else(|| all_of(index), |wanted| wanted.of(index));
        if wanted.is_some() {
            let (kept, all) = (kept.len(), index.tiles.len());
            journal.warn(&format!("{}: {kept} of {all} tiles touch what is wanted", index.path.display()));
        }
        kept_in_all += kept.len();
        kept_of.push((argument.as_str(), kept));
    }
    if let Some((_, index)) = indexes.first().filter(|_| kept_in_all == 0 && indexes.len() == job.all_tiles().len()) {
        let found = format!("{} tiles, none of which touches a footprint that is wanted", index.tiles.len());
        let fault = InputError::new(&index.path, found, "tiles where the footprints are");
        return Err(fault
            .remedy("Check that both show the same place, and that their reference systems are stated rightly")
            .into());
    }
    let spread = |arguments: &[String]| -> Vec<String> {
        let of_one = |argument: &String| match kept_of.iter().find(|(name, _)| name == argument) {
            Some((_, kept)) => kept.clone(),
            None => vec![argument.clone()],
        };
        arguments.iter().flat_map(of_one).collect()
    };
    let mut listed = job.clone();
    listed.tiles = spread(&job.tiles);
    for cloud in &mut listed.clouds {
        cloud.tiles = spread(&cloud.tiles);
    }
    Ok(Cow::Owned(listed))
}

fn all_of(index: &TileIndex) -> Vec<String> {
    index.tiles.iter().map(|tile| tile.path.to_string_lossy().into_owned()).collect()
}

/// What is wanted, in the CRS of the tiles; `None` where all is, or that CRS is not known: then what follows says so.
fn wanted<'i>(
    job: &Job,
    indexes: impl Iterator<Item = &'i TileIndex> + Clone,
    journal: &Journal<'_>,
) -> Result<Option<Wanted>> {
    if job.footprints.is_none() && job.limit.is_none() {
        return Ok(None);
    }
    let Some(crs) = crs_of_tiles(job, indexes.clone())? else { return Ok(None) };
    let reach = layer::margin(&job.segmentation, &crs);
    let area = Area::open(&job.limit, &crs, journal)?;
    let largest = LARGEST_BUILDING / crs.metres_per_unit[0];
    let area = area.map(|area| area.extent(reach[0].max(reach[1]) + largest));
    let Some(source) = &job.footprints else { return Ok(Some(Wanted { crs, area, footprints: None })) };
    let extents = indexes.flat_map(|index| in_crs(index, &crs));
    let extents: Option<Vec<[f64; 4]>> = extents.collect();
    let around = extents.and_then(|all| all.into_iter().reduce(joined));
    let within = match (around, area) {
        (Some(a), Some(b)) => Some([a[0].max(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].min(b[3])]),
        (one, other) => one.or(other),
    };
    let footprints = boxes(source, &crs, reach, within, area, journal)?;
    Ok(Some(Wanted { crs, area, footprints }))
}

/// The CRS of the tiles: what the user says, or what the first tile does that can be opened and says it.
fn crs_of_tiles<'i>(job: &Job, indexes: impl Iterator<Item = &'i TileIndex>) -> Result<Option<Crs>> {
    /// So many are tried.
    const TRIED: usize = 3;
    if let Some(text) = &job.crs {
        return Crs::parse(text).map(Some).map_err(|fault| InputError { file: "--crs".into(), ..fault }.into());
    }
    let tiles = indexes.flat_map(|index| &index.tiles).take(TRIED);
    Ok(tiles.into_iter().find_map(|tile| Tile::open(&tile.path).ok()?.crs).filter(|crs| !crs.is_geographic))
}

/// The boxes of the footprints, in `crs`, with `reach` units around each; those outside `area` are left out.
fn boxes(
    source: &FootprintSource,
    crs: &Crs,
    reach: [f64; 2],
    within: Option<[f64; 4]>,
    area: Option<[f64; 4]>,
    journal: &Journal<'_>,
) -> Result<Option<Boxes>> {
    let mut options = source.options.clone();
    options.within = within.map(|extent| Within { crs: crs.clone(), extent });
    let mut layer = footprints::read_until(&source.path, &options, &|| journal.interrupted())?;
    // Footprints of an unknown system are taken to be in that of the tiles, which is told when they are read for good.
    layer.reproject(crs)?;
    let boxes = layer.footprints.iter().filter_map(|footprint| {
        let rect = footprint.polygon.bounding_rect()?;
        let own = [rect.min().x, rect.min().y, rect.max().x, rect.max().y];
        area.is_none_or(|area| touch(&own, &area)).then(|| {
            let around =
                AABB::from_corners([own[0] - reach[0], own[1] - reach[1]], [own[2] + reach[0], own[3] + reach[1]]);
            GeomWithData::new(Rectangle::from_aabb(around), ())
        })
    });
    Ok(Some(RTree::bulk_load(boxes.collect())))
}

impl Wanted {
    /// The tiles of an index that touch what is wanted, and those of which nobody knows where they lie.
    fn of(&self, index: &TileIndex) -> Vec<String> {
        let is_wanted = |extent: [f64; 4]| {
            let own = AABB::from_corners([extent[0], extent[1]], [extent[2], extent[3]]);
            self.area.is_none_or(|area| touch(&extent, &area))
                && self.footprints.as_ref().is_none_or(|all| all.locate_in_envelope_intersecting(&own).next().is_some())
        };
        let tiles = index.tiles.iter().zip(in_crs(index, &self.crs));
        let wanted = tiles.filter(|(_, extent)| extent.is_none_or(is_wanted));
        wanted.map(|(tile, _)| tile.path.to_string_lossy().into_owned()).collect()
    }
}

/// The extents of the tiles of an index in another CRS, each a little wider than it is; `None` where nobody knows it.
fn in_crs(index: &TileIndex, crs: &Crs) -> Vec<Option<[f64; 4]>> {
    let extents: Vec<Option<[f64; 4]>> = index.tiles.iter().map(|tile| tile.extent).collect();
    index.crs.as_ref().map_or_else(|| vec![None; extents.len()], |own| extents_in(own, &extents, crs))
}

fn joined(a: [f64; 4], b: [f64; 4]) -> [f64; 4] {
    [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])]
}

fn touch(a: &[f64; 4], b: &[f64; 4]) -> bool {
    (0..2).all(|axis| a[axis] <= b[axis + 2] && b[axis] <= a[axis + 2])
}
