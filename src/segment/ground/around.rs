//! What the points around a footprint tell of its ground.

use geo::{Centroid, MultiPolygon};

use super::super::Meaning;
use super::super::neighbourhood::{Neighbourhood, Place, to_local};
use super::super::options::{GroundLevel, SegmentOptions};
use super::super::thinned::Thinned;
use super::feet::{self, Feet};
use super::fit::sigma;
use super::surface::Surface;
use super::{GROUND_CELL, Lows, outline, percentile};

/// Fewer cells than this say nothing of the ground.
const FEWEST_CELLS: usize = 4;
/// The lowest points around a building are of the ground if they lie this far below the middle of its points, metres.
const BELOW_MIDDLE: f64 = 1.0;
/// Lowest points that lie within this about a surface, standard deviation in metres, are of that surface; else there are
/// plants among them, and only the lowest of them count.
const EVEN: f64 = 0.3;
/// Fewer ground points than this have no shape.
const FEWEST_EVEN: usize = 12;
/// Share of the points that may lie below the lower end of a building, per cent: wrong ones.
const BELOW: f64 = 0.5;
/// How far outside the outline points of its walls are looked for, metres.
const BESIDE: f64 = 0.75;

/// A height of the floor with what is unsure about it, and the ground along the outline.
#[derive(Debug, Clone, Default)]
pub(in crate::segment) struct Level {
    /// Height of the floor, local metres.
    pub height: f64,
    /// How much the heights that it comes from vary, metres.
    pub spread: f64,
    /// How unsure it is, metres; nothing of ground points, which go first anyhow.
    pub unsure: f64,
    /// Places on the outline with the height of the ground there; none where no ground was seen.
    pub line: Vec<[f64; 3]>,
}

/// What the points in and around one footprint tell of its ground.
#[derive(Debug, Clone, Default)]
pub(in crate::segment) struct Around {
    /// From ground points.
    pub ground: Option<Level>,
    /// From the lowest points around the building and on its walls, for want of ground points.
    pub lowest: Option<Level>,
    /// The floor is not above this: the lowest point of a wall.
    pub ceiling: Option<f64>,
    /// The lower end of the building's points, for want of all else.
    pub bottom: Option<f64>,
}

/// What is told around footprint `index`, whose building points these are (local metres, without repeated ones).
pub(in crate::segment) fn look(
    index: usize,
    all: &Neighbourhood,
    ground: &Thinned,
    lows: &Lows,
    points: &[[f64; 3]],
    meaning: Meaning,
    options: &SegmentOptions,
) -> Around {
    let place = all.place(index);
    if let Some(ground) = from_ground(index, &place, all, ground, options) {
        return Around { ground: Some(ground), ..Around::default() };
    }
    let mut heights: Vec<f64> = points.iter().map(|p| p[2]).collect();
    heights.sort_unstable_by(f64::total_cmp);
    let middle = percentile(&heights, 50.0);
    let others = points_around(index, &place, all, &lows.others, options.ring_width);
    let has_walls = meaning.is_outline();
    let beside = if has_walls { points_around(index, &place, all, &lows.building, BESIDE) } else { Vec::new() };
    let feet = feet::of(place.prepared(), points, &beside).filter(|_| has_walls);
    let open = from_lowest(&place.polygon, &others, options)
        .filter(|level| heights.is_empty() || level.height < middle - BELOW_MIDDLE);
    let walls = feet.filter(|feet| feet.is_wall);
    let on_walls =
        walls.map(|Feet { height, spacing, .. }| Level { height, spread: spacing, unsure: spacing, line: Vec::new() });
    // Both lie too high where plants hide the ground, or the lower part of a wall: the lower one is nearer to the truth.
    let lowest = [open, on_walls].into_iter().flatten().min_by(|a, b| a.height.total_cmp(&b.height));
    // Points that may be of a wall are better than none.
    let first = heights.first().map(|_| percentile(&heights, BELOW));
    let bottom = first.into_iter().chain(feet.map(|feet| feet.height)).reduce(f64::min);
    Around { ground: None, lowest, ceiling: walls.map(|feet| feet.lowest), bottom }
}

/// From ground points in a ring outside the footprint and outside all others, widened until there is enough of it.
fn from_ground(
    index: usize,
    place: &Place,
    all: &Neighbourhood,
    ground: &Thinned,
    options: &SegmentOptions,
) -> Option<Level> {
    let mut width = options.ring_width;
    loop {
        let points = points_around(index, place, all, ground, width);
        let is_last = width >= options.ring_limit;
        if points.len() >= options.ring_area as usize || (is_last && points.len() >= FEWEST_CELLS) {
            return along_outline(&place.polygon, points, width, options);
        }
        if is_last {
            return None;
        }
        width = (2.0 * width).min(options.ring_limit);
    }
}

/// The level of the ground that `points` (local metres, at most `width` from the outline of `polygon`) show where they come
/// near it.
fn along_outline(
    polygon: &MultiPolygon<f64>,
    points: Vec<[f64; 3]>,
    width: f64,
    options: &SegmentOptions,
) -> Option<Level> {
    let heights = sorted(&points);
    let spread = spread(&heights);
    let surface = Surface::of(points)?;
    let line = line(polygon, &surface, width + GROUND_CELL);
    if heights.len() < FEWEST_EVEN && spread > EVEN && options.ground == GroundLevel::Lowest {
        // Too few for any shape, and not level: the low ones of them.
        return Some(Level { height: percentile(&heights, options.ground_percentile), spread, unsure: 0.0, line });
    }
    let plane = || polygon.centroid().map(|centre| surface.plane_at([centre.x(), centre.y()]));
    let height = if options.ground == GroundLevel::Plane { plane()? } else { height_of(&line, options) };
    Some(Level { height, spread, unsure: 0.0, line })
}

/// The level of the floor on ground of this line along the outline.
pub(super) fn height_of(line: &[[f64; 3]], options: &SegmentOptions) -> f64 {
    let percent = if options.ground == GroundLevel::Lowest { options.ground_percentile } else { 50.0 };
    percentile(&sorted(line), percent)
}

/// From the lowest points of what is not of the building.
fn from_lowest(polygon: &MultiPolygon<f64>, points: &[[f64; 3]], options: &SegmentOptions) -> Option<Level> {
    if points.len() < FEWEST_CELLS {
        return None;
    }
    let heights = sorted(points);
    let surface = Surface::of(points.to_vec())?;
    let off = sigma(points.iter().map(|p| p[2] - surface.at([p[0], p[1]])));
    let (height, unsure) = if off <= EVEN {
        (height_of(&line(polygon, &surface, options.ring_width + GROUND_CELL), options), off)
    } else {
        (percentile(&heights, options.ground_percentile), off)
    };
    Some(Level { height, spread: spread(&heights), unsure, line: Vec::new() })
}

/// The height of `surface` along the outline, where a point of it lies within `reach` metres: where none does, along party
/// walls or where a neighbour stands, it would be made up. Without any such place, all of them.
fn line(polygon: &MultiPolygon<f64>, surface: &Surface, reach: f64) -> Vec<[f64; 3]> {
    let places = outline::places(polygon);
    let raised = |place: &[f64; 2]| [place[0], place[1], surface.at(*place)];
    let near: Vec<_> = places.iter().filter(|place| surface.distance(**place) <= reach).map(raised).collect();
    if near.is_empty() { places.iter().map(raised).collect() } else { near }
}

/// The heights of points, sorted.
fn sorted(points: &[[f64; 3]]) -> Vec<f64> {
    let mut heights: Vec<f64> = points.iter().map(|p| p[2]).collect();
    heights.sort_unstable_by(f64::total_cmp);
    heights
}

/// The interquartile range of sorted heights.
fn spread(heights: &[f64]) -> f64 {
    percentile(heights, 75.0) - percentile(heights, 25.0)
}

/// The points of `thinned` (local metres) within `width` metres of the footprint and outside it, those
/// inside other footprints excluded.
fn points_around(index: usize, place: &Place, all: &Neighbourhood, thinned: &Thinned, width: f64) -> Vec<[f64; 3]> {
    let Some((low, high)) = place.surroundings(width) else { return Vec::new() };
    let points = thinned.within(low, high);
    if points.is_empty() {
        return Vec::new();
    }
    let (frame, prepared) = (&place.frame, place.prepared());
    let kept = points.into_iter().filter_map(|position| {
        let [x, y, z] = to_local(frame, position);
        let is_wanted = !prepared.contains([x, y])
            && prepared.boundary_distance([x, y], width) <= width
            && !all.is_inside_another(position, index);
        is_wanted.then_some([x, y, z])
    });
    kept.collect()
}
