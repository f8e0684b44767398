//! The ground around a building.
//!
//! Ground points are thinned while they stream by ([`super::thinned`]), which gives every part of the ring the same
//! weight whatever the overlap of strips. What is left is taken for a [surface](surface::Surface) with noise: the floor is
//! where this surface meets the outline, not some low point of the ring.

mod fit;
mod outline;
mod surface;

use surface::Surface;

use super::neighbourhood::{Neighbourhood, to_local};
use super::options::{GroundLevel, SegmentOptions};
use super::thinned::Thinned;
use crate::site::{Frame, Ground, GroundSource, Site};
use geo::{Centroid, MultiPolygon};

/// Side of the cells of the ground, metres.
pub(super) const GROUND_CELL: f64 = 1.0;
/// Side of the cells of the ground inside footprints, metres; of open ground every part counts, so they are small.
pub(super) const OPEN_CELL: f64 = 0.5;
/// Side of the cells of the lowest points, metres; wide, so that a cell under a tree sees the ground somewhere.
pub(super) const LOWEST_CELL: f64 = 2.0;
/// Fewer cells than this say nothing of the ground.
const FEWEST_CELLS: usize = 4;
/// Where the floors of more than this share of the buildings are guessed, it is told for the run as a whole.
const MANY_GUESSES: f64 = 0.1;

/// The ground around footprint `index`, in its local frame, with its line along the outline.
///
/// From ground points in a ring outside the footprint and outside all others, widened until there is enough of it; then
/// from the lowest points of any class inside the footprint and in the ring; then from `lowest_point`, the height of the
/// lowest building point (or 0 without any).
pub(super) fn estimate(
    index: usize,
    all: &Neighbourhood,
    ground: &Thinned,
    lowest: &Thinned,
    lowest_point: Option<f64>,
    options: &SegmentOptions,
) -> (Ground, Vec<[f64; 3]>) {
    let mut width = options.ring_width;
    loop {
        let points = points_around(index, all, ground, width, false);
        let is_enough = points.len() >= options.ring_area as usize;
        if is_enough || (width >= options.ring_limit && points.len() >= FEWEST_CELLS) {
            if let Some(found) = along_outline(&all.polygons[index], points, width, options) {
                return found;
            }
        }
        if is_enough || width >= options.ring_limit {
            break;
        }
        width = (2.0 * width).min(options.ring_limit);
    }
    let mut heights: Vec<f64> =
        points_around(index, all, lowest, options.ring_width, true).into_iter().map(|p| p[2]).collect();
    heights.sort_unstable_by(f64::total_cmp);
    if heights.len() >= FEWEST_CELLS {
        let height = percentile(&heights, options.ground_percentile);
        return (Ground { height, spread: spread(&heights), source: GroundSource::LowestPoints }, Vec::new());
    }
    let height = heights.into_iter().chain(lowest_point).reduce(f64::min).unwrap_or(0.0);
    (Ground { height, spread: 0.0, source: GroundSource::BoundingBox }, Vec::new())
}

/// The ground that `points` (local metres, at most `width` from the outline of `polygon`) show where they come near it.
fn along_outline(
    polygon: &MultiPolygon<f64>,
    points: Vec<[f64; 3]>,
    width: f64,
    options: &SegmentOptions,
) -> Option<(Ground, Vec<[f64; 3]>)> {
    let mut heights: Vec<f64> = points.iter().map(|p| p[2]).collect();
    heights.sort_unstable_by(f64::total_cmp);
    let surface = Surface::of(points)?;
    let line = line(polygon, &surface, width + GROUND_CELL);
    let height = match options.ground {
        GroundLevel::Lowest => percentile(&sorted_heights(&line), options.ground_percentile),
        GroundLevel::Median => percentile(&sorted_heights(&line), 50.0),
        GroundLevel::Plane => {
            let centre = polygon.centroid()?;
            surface.plane_at([centre.x(), centre.y()])
        }
    };
    Some((Ground { height, spread: spread(&heights), source: GroundSource::GroundPoints }, line))
}

/// The height of `surface` along the outline, where a point of it lies within `reach` metres: where none does, along party
/// walls or where a neighbour stands, it would be made up. Without any such place, all of them.
fn line(polygon: &MultiPolygon<f64>, surface: &Surface, reach: f64) -> Vec<[f64; 3]> {
    let places = outline::places(polygon);
    let raised = |place: &[f64; 2]| [place[0], place[1], surface.at(*place)];
    let near: Vec<_> = places.iter().filter(|place| surface.distance(**place) <= reach).map(raised).collect();
    if near.is_empty() { places.iter().map(raised).collect() } else { near }
}

fn sorted_heights(line: &[[f64; 3]]) -> Vec<f64> {
    let mut heights: Vec<f64> = line.iter().map(|p| p[2]).collect();
    heights.sort_unstable_by(f64::total_cmp);
    heights
}

/// The interquartile range of sorted heights.
fn spread(heights: &[f64]) -> f64 {
    percentile(heights, 75.0) - percentile(heights, 25.0)
}

/// What is said of a building whose floor was guessed; `None` for others.
pub(super) fn guess(site: &Site) -> Option<String> {
    let from = match site.ground.source {
        _ if site.points.is_empty() => return None,
        GroundSource::GroundPoints => return None,
        GroundSource::LowestPoints => "the lowest points in and around it",
        GroundSource::BoundingBox => "its lowest point",
    };
    Some(format!("no ground points around it: the height of its floor was guessed from {from}"))
}

/// What is said of many such buildings; `None` where they are few.
pub(super) fn guesses(sites: &[Site], options: &SegmentOptions) -> Option<String> {
    let with_points = sites.iter().filter(|site| !site.points.is_empty()).count();
    let guessed = sites.iter().filter(|site| guess(site).is_some()).count();
    if guessed as f64 <= MANY_GUESSES * with_points as f64 {
        return None;
    }
    let classes: Vec<String> = options.ground_classes.iter().map(u8::to_string).collect();
    Some(format!(
        "the floors of {guessed} of {with_points} buildings were guessed from their lowest points, for want of points of \
         ground class {} around them: they may be too high, and heights and volumes too small; --ground-class says which \
         classes are ground",
        classes.join(",")
    ))
}

/// The ground points inside a footprint, in its local frame, sorted by x, y, z.
pub(super) fn inside(frame: &Frame, ground: Option<&Thinned>) -> Vec<[f64; 3]> {
    let kept = ground.map_or_else(Vec::new, |ground| ground.points().collect());
    let mut points: Vec<_> = kept.into_iter().map(|position| to_local(frame, position)).collect();
    points.sort_unstable_by(super::lexicographic);
    points
}

/// The points of `thinned` (local metres) within `width` metres of the footprint, those inside it included
/// or not, those inside other footprints excluded.
fn points_around(index: usize, all: &Neighbourhood, thinned: &Thinned, width: f64, inside: bool) -> Vec<[f64; 3]> {
    let Some((low, high)) = all.surroundings(index, width) else { return Vec::new() };
    let points = thinned.within(low, high);
    if points.is_empty() {
        return Vec::new();
    }
    let (frame, prepared) = (&all.frames[index], all.prepared(index));
    let kept = points.into_iter().filter_map(|position| {
        let [x, y, z] = to_local(frame, position);
        let wanted = if prepared.contains([x, y]) {
            inside
        } else {
            prepared.boundary_distance([x, y], width) <= width && !all.is_inside_another(position, index)
        };
        wanted.then_some([x, y, z])
    });
    kept.collect()
}

/// The percentile of sorted values, interpolated between neighbours; 0 of none.
fn percentile(sorted: &[f64], percent: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return 0.0 };
    let place = percent.clamp(0.0, 100.0) / 100.0 * last as f64;
    let below = (place.floor() as usize).min(last);
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::percentile;

    #[test]
    fn percentiles_are_interpolated() {
        let heights = [1.0, 2.0, 3.0, 7.0];
        assert_eq!(percentile(&heights, 0.0), 1.0);
        assert_eq!(percentile(&heights, 50.0), 2.5);
        assert_eq!(percentile(&heights, 100.0), 7.0);
        assert_eq!(percentile(&[], 50.0), 0.0);
    }
}
