//! Segmentation: tiles and footprints become sites, one per footprint, whatever the tiling.
//!
//! Every tile is streamed once, tiles in parallel, and a [`Sweep`] gives each site as soon as all is known of it. Of its points only those inside a footprint are kept, of the
//! ground around footprints one point per square metre, and of the ground inside them four. What is kept is a set: joining tiles in any order, cutting a
//! cloud into tiles, overlapping them or giving one twice leaves every site as it is, bit for bit. A site depends on its
//! own footprint and the points in and around it; of its neighbours it knows only that the ground inside them is not the
//! ground around it, and, where no ground was scanned around it, on which floors they stand.

mod boxes;
mod change;
mod company;
mod counts;
mod coverage;
mod dense;
mod front;
mod ground;
mod harvest;
mod naming;
mod neighbourhood;
mod options;
mod order;
mod outside;
mod refuse;
mod roof_height;
mod scanned;
mod shelf;
mod strays;
mod sweep;
mod thinned;
mod totals;
mod unused;
mod vegetation;
mod waiting;

#[cfg(test)]
mod tests;

pub use change::between;
pub use company::{Company, TileTree};
pub use counts::{DroppedPoints, PointCounts};
pub use options::{AnyClass, BuildingClasses, GroundLevel, HeightAbove, NOISE, SegmentOptions, UseFlagged};
pub use scanned::Scanned;

use crate::error::Result;
use crate::site::{Coverage, Ground, Site};
use crate::source::crs::Crs;
use crate::source::footprints::Footprint;
use crate::source::points::{Tile, TileProblem};
use crate::terrain::GroundStore;
use boxes::{Boxes, Rectangle};
use geo::MultiPolygon;
use harvest::Roles;
use nalgebra::Point3;
use neighbourhood::Place;
#[cfg(feature = "edit")]
pub(crate) use neighbourhood::as_collected;
pub(crate) use neighbourhood::frame_of;
use rayon::prelude::*;
pub use sweep::{Part, Sweep};
pub use totals::Swept;

/// What segmentation gives.
#[derive(Debug, Default)]
pub struct Segmentation {
    /// One site per footprint, in the order of the footprints.
    pub sites: Vec<Site>,
    /// The notes of the footprints, in the same order.
    pub notes: Vec<Vec<String>>,
    /// What became of the points.
    pub counts: PointCounts,
    /// What is wrong with the tiles, sorted.
    pub problems: Vec<TileProblem>,
    /// What the user should know of the points as a whole, one sentence each.
    pub warnings: Vec<String>,
}

/// Joins `tiles` and `footprints`, both in `crs`, into sites; `progress` is told the number of points done since it was
/// last told, from any thread, and gets to the sum of [`Tile::points`].
///
/// Points outside the footprint, under the eaves' overhang too, are not building points: the footprint is where the
/// model stands. Where the outline of its roof is known, those under it are the [eaves](Site::eaves). Only points that
/// name their building ([`Tile::buildings`]) are given to its footprint wherever they lie.
/// Tiles are read on the threads of the current rayon pool. All ground points go to `terrain` as well, if there is one; then
/// no part of a tile is passed over.
///
/// # Errors
/// An option is out of range; the CRS is geographic; no tile holds a point; no footprint lies in or near any tile; the
/// building classes do not occur; a tile can no longer be opened; what is kept for the terrain cannot be written.
pub fn segment(
    tiles: &[Tile],
    footprints: Vec<Footprint>,
    crs: &Crs,
    options: &SegmentOptions,
    progress: &(dyn Fn(u64) + Sync),
    terrain: Option<&GroundStore>,
) -> Result<Segmentation> {
    segment_as(tiles, footprints, crs, options, Meaning::Outlines, progress, terrain)
}

/// Refuses what a run of these tiles and footprints would refuse before it reads points.
///
/// # Errors
/// As [`segment`], as far as headers tell.
pub fn refuse(tiles: &[Tile], footprints: &[Footprint], crs: &Crs, options: &SegmentOptions) -> Result<()> {
    refuse::options(options)?;
    refuse::geographic(crs)?;
    refuse::without_points(tiles)?;
    refuse::apart(tiles, &Boxes::new(footprints), crs)?;
    options.ground_attribute.as_deref().map_or(Ok(()), |name| ground::refuse_unknown(name, footprints))
}

/// Refuses tiles in which the building classes do not occur, where these are the `counts` of all points that were read.
///
/// # Errors
/// The classes that there are.
pub fn refuse_classes(tiles: &[Tile], counts: &PointCounts, options: &SegmentOptions) -> Result<()> {
    let tiles: Vec<&Tile> = tiles.iter().collect();
    refuse::without_buildings(&tiles, counts, &Roles::new(options), options)
}

/// What footprints are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Meaning {
    /// The outlines of buildings: what lies inside is theirs, and there their walls stand.
    Outlines,
    /// The same of a share of the footprints of a run, those [beside](Company) it among them, with the tiles that it needs; of
    /// the other tiles only where they lie is known ([`Tile::elsewhere`]). Each site is the one that all footprints and tiles
    /// give. What others may have where the share lacks it is no error: points, points of the building classes, an attribute, a height of the
    /// terrain model.
    OutlinesOfShare,
    /// Where an object without a footprint stands: what lies inside is its own, and nothing is said of its walls.
    Places,
    /// Where buildings stand whose points all name them, or belong to none.
    PlacesOfNamed,
}

impl Meaning {
    /// Whether walls stand on them.
    fn is_outline(self) -> bool {
        matches!(self, Self::Outlines | Self::OutlinesOfShare)
    }
}

/// The same for footprints that mean this.
///
/// # Errors
/// As [`segment`].
pub fn segment_as(
    tiles: &[Tile],
    footprints: Vec<Footprint>,
    crs: &Crs,
    options: &SegmentOptions,
    meaning: Meaning,
    progress: &(dyn Fn(u64) + Sync),
    terrain: Option<&GroundStore>,
) -> Result<Segmentation> {
    // All is held, because all is asked for.
    let sweep = Sweep::new(tiles, footprints, crs, options, meaning, terrain, usize::MAX)?;
    let parts: Vec<Part> =
        (0..sweep.tiles()).into_par_iter().map(|tile| sweep.read(tile, progress)).collect::<Result<_>>()?;
    for (tile, part) in parts.into_iter().enumerate() {
        sweep.take(tile, part)?;
    }
    let first: Vec<_> =
        (0..sweep.footprints()).into_par_iter().map(|index| sweep.site(index)).collect::<Result<_>>()?;
    sweep.rest();
    let made = first.into_par_iter().enumerate().map(|(index, made)| match made {
        Some(made) => Ok(Some(made)),
        None => sweep.site(index),
    });
    let (sites, notes) = made.collect::<Result<Vec<_>>>()?.into_iter().flatten().unzip();
    let Swept { counts, problems, warnings } = sweep.finish()?;
    Ok(Segmentation { sites, notes, counts, problems, warnings })
}

/// What is known of the place of one footprint.
struct Finished {
    points: Vec<Point3<f64>>,
    ground: Ground,
    coverage: Coverage,
    covered: Option<MultiPolygon<f64>>,
}

/// Makes a footprint ready, whose `points` these are, sorted and without repeated ones, on this `ground`. Gives the counts of
/// its points as well.
fn finish(
    mut points: Vec<[f64; 3]>,
    ground: Ground,
    place: &Place,
    rectangles: &[Rectangle],
    options: &SegmentOptions,
) -> (Finished, PointCounts) {
    let has_points = !points.is_empty();
    let mut counts = PointCounts::default();
    let dropped = &mut counts.dropped;
    if has_points {
        dropped.dense = dense::thin(&mut points, &place.polygon);
        if options.building_classes.is_any() {
            let least = ground.height + options.least_height;
            dropped.low = without(&mut points, |points| points.retain(|p| p[2] >= least));
            dropped.vegetation = vegetation::drop_vegetation(&mut points, options) as u64;
        }
        dropped.hovering = strays::drop_hovering(&mut points, options) as u64;
        dropped.beyond_party_wall = strays::drop_beyond_party_wall(&mut points, place.prepared(), options) as u64;
    }
    counts.kept = points.len() as u64;
    let (polygon, frame) = (&place.polygon, &place.frame);
    let coverage = coverage::coverage(polygon, frame, rectangles);
    let covered = if coverage.is_complete() { None } else { coverage::covered(polygon, frame, rectangles) };
    let points = points.into_iter().map(Point3::from).collect();
    (Finished { points, ground, coverage, covered }, counts)
}

fn lexicographic(a: &[f64; 3], b: &[f64; 3]) -> std::cmp::Ordering {
    a[0].total_cmp(&b[0]).then_with(|| a[1].total_cmp(&b[1])).then_with(|| a[2].total_cmp(&b[2]))
}

/// How many points `change` takes away.
fn without(points: &mut Vec<[f64; 3]>, change: impl FnOnce(&mut Vec<[f64; 3]>)) -> u64 {
    let before = points.len();
    change(points);
    (before - points.len()) as u64
}
