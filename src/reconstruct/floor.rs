//! The floor of a building around which no ground was scanned: from what was scanned of the building itself.
//!
//! Faces of the bounding box complete what is missing only (paper, section 4). A floor that was scanned is a plane like
//! any other, and the building ends there, not at the lowest point, which is noise. Failing that, the walls tell where
//! they begin.

use std::borrow::Cow;

use geo::{Area, ConvexHull, MultiPoint};
use nalgebra::Point3;

use super::Parameters;
use super::hypotheses::WALL_VERTICALITY;
use super::means::Means;
use super::primitives::Primitive;
use super::primitives::undersides::Tops;
use crate::geometry::seed_of;
use crate::site::{Ground, GroundSource, Site};

/// The floor has at least this share of the building's extent in the plan; a soffit has less.
const LEAST_SHARE: f64 = 0.25;
/// A floor is not steeper than this, degrees.
const STEEPEST: f64 = 20.0;
/// Not more than this share of the points may lie below the floor by more than noise.
const MOST_BELOW: f64 = 0.01;
/// Points so far below the lowest roof are on walls, metres.
const UNDER_EAVES: f64 = 0.5;
/// Fewer points on walls than this say nothing.
const FEWEST: usize = 5;
/// The walls begin no lower than this below their lowest point, metres: what was not seen of them may be hidden for any
/// reason.
const MOST_HIDDEN: f64 = 3.0;

/// A site without a footprint on the floor that its points show, where its ground is only guessed.
pub(super) fn found<'a>(
    site: &'a Site,
    parameters: &Parameters,
    means: Means,
    notes: &mut Vec<String>,
) -> Cow<'a, Site> {
    let is_own = matches!(site.ground.source, GroundSource::LowestPoints | GroundSource::BoundingBox);
    if !(is_own || site.ground.source == GroundSource::Neighbours) || site.footprint.is_some() || site.points.is_empty()
    {
        return Cow::Borrowed(site);
    }
    let detection = means.detect(&site.points, parameters, seed_of(&site.id));
    let level: Vec<Primitive> =
        detection.primitives.iter().filter(|p| p.plane.verticality() <= WALL_VERTICALITY).cloned().collect();
    let tops = Tops::new(&site.points, &level);
    let (below, roofs): (Vec<_>, Vec<_>) = (0..).zip(&level).partition(|(label, plane)| tops.cover(plane, *label));
    let [below, roofs] = [below, roofs].map(|planes| planes.into_iter().map(|(_, plane)| plane).collect::<Vec<_>>());
    if let Some(height) = scanned(&site.points, &below, detection.noise) {
        notes.push("the floor was scanned: the building stands on it".to_owned());
        let ground = Ground { height, spread: 0.0, source: GroundSource::ScannedFloor };
        return Cow::Owned(Site { ground, ..site.clone() });
    }
    let from = if is_own { "the lowest points" } else { "those of its neighbours" };
    notes.push(format!("neither ground nor floor was scanned: the height of the floor was guessed from {from}"));
    if !is_own {
        return Cow::Borrowed(site);
    }
    let Some(height) = wall_feet(&wall_heights(&site.points, &roofs), detection.noise) else {
        return Cow::Borrowed(site);
    };
    let ground = Ground { height, spread: 0.0, source: GroundSource::LowestPoints };
    Cow::Owned(Site { ground, ..site.clone() })
}

/// The height of the floor among planes that lie under others: the lowest, if it is as wide as a floor and nothing lies
/// below it.
fn scanned(points: &[Point3<f64>], below: &[&Primitive], noise: f64) -> Option<f64> {
    let plan = |indices: &mut dyn Iterator<Item = &Point3<f64>>| -> f64 {
        indices.map(|p| (p.x, p.y)).collect::<MultiPoint<f64>>().convex_hull().unsigned_area()
    };
    let whole = plan(&mut points.iter());
    let height = |floor: &Primitive| {
        // A floor that is not level ends at its low side: the box has a level bottom.
        let corners = floor.inliers.iter().filter_map(|&i| points.get(i as usize));
        corners.filter_map(|p| floor.plane.height_at(p.x, p.y)).fold(f64::INFINITY, f64::min)
    };
    let lowest = below
        .iter()
        .filter(|floor| floor.plane.slope_degrees() <= STEEPEST)
        .filter(|floor| plan(&mut floor.inliers.iter().filter_map(|&i| points.get(i as usize))) >= LEAST_SHARE * whole)
        .map(|floor| height(floor))
        .fold(f64::INFINITY, f64::min);
    let lower = points.iter().filter(|p| p.z < lowest - 3.0 * noise).count();
    (lowest.is_finite() && lower as f64 <= MOST_BELOW * points.len() as f64).then_some(lowest)
}

/// The heights of the points on walls, ascending: those below all roofs.
fn wall_heights(points: &[Point3<f64>], roofs: &[&Primitive]) -> Vec<f64> {
    let eaves = roofs
        .iter()
        .filter_map(|roof| {
            let mut heights: Vec<f64> =
                roof.inliers.iter().filter_map(|&i| points.get(i as usize)).map(|p| p.z).collect();
            let rank = heights.len() / 50;
            (rank < heights.len()).then(|| *heights.select_nth_unstable_by(rank, f64::total_cmp).1)
        })
        .fold(f64::INFINITY, f64::min);
    let mut heights: Vec<f64> = points.iter().map(|p| p.z).filter(|z| *z < eaves - UNDER_EAVES).collect();
    heights.sort_by(f64::total_cmp);
    heights
}

/// Where walls begin, from the ascending heights of points on them.
///
/// Points lie evenly over the height of a wall, a mean spacing `s` apart: the first is `s` above the foot on average, the
/// n-th `n s`. Of the points that noise has not carried over the foot the lowest tells the most; `s` is measured above
/// it. Points far below the others are strays and counted for nothing.
fn wall_feet(heights: &[f64], noise: f64) -> Option<f64> {
    let count = heights.len();
    if count < FEWEST {
        return None;
    }
    // A first look at the middle of the wall, where neither noise nor strays matter.
    let (low, high) = (count / 5, count * 4 / 5);
    let spacing = (heights[high] - heights[low]) / (high - low) as f64;
    let (foot, error) = (heights[low] - low as f64 * spacing, 2.0 * spacing * (low as f64 + 1.0).sqrt());
    let strays = heights.partition_point(|z| *z < foot - error - 3.0 * noise).min((MOST_BELOW * count as f64) as usize);
    let first = heights.partition_point(|z| *z < foot - error + 2.0 * noise).max(strays).min(count - 2);
    let last = (first + (first - strays).max(10)).min(count - 1);
    let spacing = (heights[last] - heights[first]) / (last - first) as f64;
    let foot = heights[first] - (first - strays + 1) as f64 * spacing;
    Some(foot.max(heights[strays] - MOST_HIDDEN))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Random;
    use crate::site::Frame;

    /// A box of 12 × 9 × 6 m that stands at 0, scanned with this noise (all-round, or without its bottom), under a ground
    /// that was guessed too low.
    fn house(noise: f64, has_floor: bool) -> Site {
        let mut random = Random::new(9);
        let mut points = Vec::new();
        while points.len() < 12_000 {
            let mut at = [12.0 * random.unit(), 9.0 * random.unit(), 6.0 * random.unit()];
            let axis = [0, 0, 1, 1, 2, 2, 2][random.below(7)];
            let low = random.unit() < 0.5;
            if axis == 2 && low && !has_floor {
                continue;
            }
            at[axis] = if low { 0.0 } else { [12.0, 9.0, 6.0][axis] };
            points.push(Point3::from(at.map(|value| value + noise * random.bell())));
        }
        let frame = Frame { origin: [0.0; 3], metres_per_unit: [1.0; 3] };
        let mut site = Site::new("house", frame, points, -2.0);
        site.ground.source = GroundSource::BoundingBox;
        site
    }

    fn floor(site: &Site) -> (f64, GroundSource) {
        let found = found(site, &Parameters::default(), Means::plain(), &mut Vec::new()).into_owned();
        (found.ground.height, found.ground.source)
    }

    #[test]
    fn a_floor_that_was_scanned_is_a_plane_and_not_the_lowest_point() {
        for noise in [0.0, 0.03, 0.2, 0.5] {
            let (height, source) = floor(&house(noise, true));
            assert_eq!(source, GroundSource::ScannedFloor, "noise {noise}");
            assert!(height.abs() < 0.01 + 0.3 * noise, "noise {noise}: {height}");
        }
    }

    #[test]
    fn walls_tell_where_they_begin_through_noise() {
        for noise in [0.0, 0.03, 0.2] {
            let (height, source) = floor(&house(noise, false));
            assert_eq!(source, GroundSource::LowestPoints, "noise {noise}");
            assert!(height.abs() < 0.05 + 0.3 * noise, "noise {noise}: {height}");
        }
    }

    #[test]
    fn a_ground_that_is_known_stays() {
        let mut site = house(0.03, true);
        site.ground.source = GroundSource::GroundPoints;
        assert_eq!(floor(&site), (-2.0, GroundSource::GroundPoints));
    }

    #[test]
    fn strays_below_are_no_foot() {
        let heights: Vec<f64> = [-5.0, -3.0].into_iter().chain((0..600).map(|i| f64::from(i) * 0.01)).collect();
        assert!(wall_feet(&heights, 0.02).unwrap().abs() < 0.1);
        assert_eq!(wall_feet(&[1.0, 2.0], 0.02), None);
    }
}
