//! Segmentation: tiles and footprints become sites, one per footprint, whatever the tiling.
//!
//! Every tile is streamed once, tiles in parallel. Of its points only those inside a footprint are kept, of the
//! ground around footprints one point per square metre, and of the ground inside them four. What is kept is a set: joining tiles in any order, cutting a
//! cloud into tiles, overlapping them or giving one twice leaves every site as it is, bit for bit. A site depends on its
//! own footprint and the points in and around it; of its neighbours it knows only that the ground inside them is not the
//! ground around it, and, where no ground was scanned around it, on which floors they stand.

mod change;
mod counts;
mod coverage;
mod ground;
mod harvest;
mod naming;
mod neighbourhood;
mod options;
mod outside;
mod refuse;
mod roof_height;
mod scanned;
mod strays;
mod thinned;
mod unused;
mod vegetation;

#[cfg(test)]
mod tests;

pub use change::between;
pub use counts::{DroppedPoints, PointCounts};
pub use options::{AnyClass, BuildingClasses, GroundLevel, HeightAbove, NOISE, SegmentOptions, UseFlagged};
pub use scanned::Scanned;

use crate::error::Result;
use crate::record::Record;
use crate::site::{Coverage, Eaves, Ground, Site};
use crate::source::crs::Crs;
use crate::source::footprints::Footprint;
use crate::source::points::{Tile, TileProblem};
use crate::terrain::GroundStore;
use geo::MultiPolygon;
use harvest::{Harvest, Roles};
use nalgebra::Point3;
use naming::Naming;
use neighbourhood::Neighbourhood;
use rayon::prelude::*;
use std::sync::{Mutex, PoisonError};

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
    join(tiles, footprints, crs, options, Meaning::Outlines, progress, terrain)
}

/// The same for an object without a footprint: the polygon that stands in for it is only where it stands, and says nothing of
/// its walls.
///
/// # Errors
/// As [`segment`].
pub fn segment_object(
    tiles: &[Tile],
    footprints: Vec<Footprint>,
    crs: &Crs,
    options: &SegmentOptions,
    progress: &(dyn Fn(u64) + Sync),
    terrain: Option<&GroundStore>,
) -> Result<Segmentation> {
    join(tiles, footprints, crs, options, Meaning::Places, progress, terrain)
}

/// The same for tiles whose points all name their building, or belong to none: the footprints are only where the buildings
/// stand.
///
/// # Errors
/// As [`segment`].
pub fn segment_named(
    tiles: &[Tile],
    footprints: Vec<Footprint>,
    crs: &Crs,
    options: &SegmentOptions,
    progress: &(dyn Fn(u64) + Sync),
    terrain: Option<&GroundStore>,
) -> Result<Segmentation> {
    join(tiles, footprints, crs, options, Meaning::PlacesOfNamed, progress, terrain)
}

/// What footprints are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Meaning {
    /// The outlines of buildings: what lies inside is theirs, and there their walls stand.
    Outlines,
    /// Where an object stands: what lies inside is its own.
    Places,
    /// Where buildings stand whose points name them.
    PlacesOfNamed,
}

fn join(
    tiles: &[Tile],
    mut footprints: Vec<Footprint>,
    crs: &Crs,
    options: &SegmentOptions,
    meaning: Meaning,
    progress: &(dyn Fn(u64) + Sync),
    terrain: Option<&GroundStore>,
) -> Result<Segmentation> {
    refuse::options(options)?;
    refuse::geographic(crs)?;
    refuse::without_points(tiles)?;
    let reach = options.ring_limit.max(options.ring_width);
    let all = Neighbourhood::new(&footprints, crs, reach);
    refuse::apart(tiles, &footprints, &all, crs)?;

    let roles = Roles::new(options);
    let naming = Naming::new(tiles, &footprints, meaning != Meaning::PlacesOfNamed);
    // From here on only the polygons in their own frames are asked.
    for footprint in &mut footprints {
        footprint.polygon = MultiPolygon(Vec::new());
        footprint.roofprint = None;
    }
    let mut harvest = tiles
        .par_iter()
        .map(|tile| Harvest::of(tile, &all, &roles, &naming, crs.metres_per_unit, (progress, terrain)))
        .try_reduce(
            || Harvest::new(crs.metres_per_unit),
            |mut a, b| {
                a.merge(b);
                Ok(a)
            },
        )?;
    refuse::without_buildings(tiles, &harvest.counts, &roles, options)?;

    let rectangles = coverage::seamless(&harvest.extents, crs.metres_per_unit);
    let mut gathered: Vec<Vec<[f64; 3]>> =
        (0..footprints.len()).map(|index| harvest.points.remove(&index).unwrap_or_default()).collect();
    let used: Vec<u64> = gathered.iter().map(|points| points.len() as u64).collect();
    gathered.par_iter_mut().chain(harvest.under_eaves.par_iter_mut().map(|(_, points)| points)).for_each(|points| {
        points.sort_unstable_by(lexicographic);
        points.dedup();
    });
    // A building without points stands on its ground, too, where the height of its roof is stated.
    let is_asked = |index: usize| used[index] > 0 || options.roof_height_attribute.is_some();
    let stated = ground::read_stated(&footprints, &all, crs, is_asked, options)?;
    let grounds = ground::estimate(&all, &harvest.ground, &harvest.lows, &gathered, &stated, meaning, options);
    let roofs = roof_height::stated(&footprints, &all, &grounds, options);
    let inner: Vec<_> = (0..footprints.len()).map(|index| harvest.inner_ground.remove(&index)).collect();
    let counts = Mutex::new(harvest.counts);
    let finished: Vec<Finished> = gathered
        .into_par_iter()
        .zip(grounds)
        .zip(inner)
        .enumerate()
        .map(|(index, ((points, (ground, line)), inner))| {
            let duplicate = used[index] - points.len() as u64;
            let (mut finished, mut count) = finish(index, points, ground, &all, &rectangles, options);
            if used[index] > 0 {
                count.dropped.duplicate = duplicate;
                counts.lock().unwrap_or_else(PoisonError::into_inner).add(&count);
            }
            finished.ground_line = line.into_iter().map(Point3::from).collect();
            let ground_points = ground::inside(&all.frames[index], inner.as_ref());
            finished.ground_points = ground_points.into_iter().map(Point3::from).collect();
            finished
        })
        .collect();
    let counts = counts.into_inner().unwrap_or_else(PoisonError::into_inner);
    let mut sites = Vec::with_capacity(footprints.len());
    let mut notes = Vec::with_capacity(footprints.len());
    let places = all.frames.into_iter().zip(all.polygons).zip(all.roofprints);
    for (index, ((footprint, ((frame, polygon), roofprint)), finished)) in
        footprints.into_iter().zip(places).zip(finished).enumerate()
    {
        let Finished { points, ground_points, ground, ground_line, coverage, covered } = finished;
        let (id, attributes) = (footprint.id, footprint.attributes);
        let eaves = roofprint.map(|roof| {
            let points = harvest.under_eaves.remove(&index).unwrap_or_default();
            Eaves { outline: roof.polygon, points: points.into_iter().map(Point3::from).collect() }
        });
        sites.push(Site {
            id,
            frame,
            footprint: Some(polygon),
            points,
            ground_points,
            ground,
            ground_line,
            coverage,
            covered,
            eaves,
            attributes,
            record: Record { roof_height: roofs.get(&index).copied(), ..Record::default() },
            edits: Vec::new(),
        });
        let mut own_notes = footprint.notes;
        own_notes.extend(stated.notes.get(&index).cloned());
        // Of an object more is known once its planes are found.
        own_notes.extend(sites.last().filter(|_| meaning == Meaning::Outlines).and_then(ground::guess));
        notes.push(own_notes);
    }
    let warnings = [
        unused::absent(&counts, options),
        unused::warning(&used, &harvest.unused, options),
        ground::guesses(&sites, options).filter(|_| meaning == Meaning::Outlines),
    ];
    let warnings = stated.warnings.into_iter().chain(warnings.into_iter().flatten()).collect();
    let mut problems = harvest.problems;
    problems.sort();
    Ok(Segmentation { sites, notes, counts, problems, warnings })
}

/// What is known of the place of one footprint.
struct Finished {
    points: Vec<Point3<f64>>,
    ground_points: Vec<Point3<f64>>,
    ground: Ground,
    ground_line: Vec<Point3<f64>>,
    coverage: Coverage,
    covered: Option<MultiPolygon<f64>>,
}

/// Makes footprint `index` ready, whose `points` these are, sorted and without repeated ones, on this `ground`. Gives the
/// counts of its points as well.
fn finish(
    index: usize,
    mut points: Vec<[f64; 3]>,
    ground: Ground,
    all: &Neighbourhood,
    rectangles: &[([f64; 2], [f64; 2])],
    options: &SegmentOptions,
) -> (Finished, PointCounts) {
    let has_points = !points.is_empty();
    let mut counts = PointCounts::default();
    let dropped = &mut counts.dropped;
    if has_points {
        if options.building_classes.is_any() {
            let least = ground.height + options.least_height;
            dropped.low = without(&mut points, |points| points.retain(|p| p[2] >= least));
            dropped.vegetation = vegetation::drop_vegetation(&mut points, options) as u64;
        }
        dropped.hovering = strays::drop_hovering(&mut points, options) as u64;
        dropped.beyond_party_wall = strays::drop_beyond_party_wall(&mut points, all.prepared(index), options) as u64;
    }
    counts.kept = points.len() as u64;
    let (polygon, frame) = (&all.polygons[index], &all.frames[index]);
    let coverage = coverage::coverage(polygon, frame, rectangles);
    let covered = if coverage.is_complete() { None } else { coverage::covered(polygon, frame, rectangles) };
    let points = points.into_iter().map(Point3::from).collect();
    let finished = Finished { points, ground_points: Vec::new(), ground, ground_line: Vec::new(), coverage, covered };
    (finished, counts)
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
