//! Open ground inside a footprint: courtyards that nobody drew, halves that were torn down, garages below the street.
//!
//! Ground points with nothing above them say that no solid stands there. One such point says little: points under a
//! gateway or an overhang are ground too, classifications err, and along the outline footprint and scan do not quite fit.
//! So the ground must be seen over an area, with points all over it, that is wide and stands back from the outline.

mod pixels;
mod straighten;

use std::collections::BTreeMap;

use geo::{Area, BooleanOps, MultiPolygon};
use nalgebra::{Point2, Point3};

use super::primitives::footprint_edges;
use super::primitives::height_jumps::main_directions;
use crate::geometry::PreparedPolygon;
use crate::site::Site;
use pixels::Pixels;

/// A building point at least this much higher than a ground point stands over it, metres …
const HEADROOM: f64 = 1.0;
/// … if it is this near in plan, metres, or as near as the points of the building are to each other …
const NEAR: f64 = 0.7;
/// … which does not count beyond this, metres.
const FARTHEST: f64 = 1.5;
/// Ground this high above that around the building is a roof or a deck that was taken for ground, metres.
const RISE: f64 = 2.0;
/// Ground points this near to the outline say nothing alone, metres.
const MARGIN: f64 = 0.6;
/// Open ground reaches so far from a ground point at most, metres.
const REACH: f64 = 1.0;
/// Open ground is nowhere narrower than this, metres.
const NARROWEST: f64 = 1.5;
/// Open ground has at least so many ground points per square metre (of which there are four at most) …
const DENSITY: f64 = 0.5;
/// … and so many in all.
const FEWEST: usize = 4;

/// The open ground of a site, in pieces of at least `smallest` square metres; empty without a footprint. It may reach
/// beyond the outline.
pub(super) fn open_ground(site: &Site, smallest: f64) -> MultiPolygon<f64> {
    let nothing = MultiPolygon(Vec::new());
    let Some(footprint) = site.footprint.as_ref().filter(|_| site.ground_points.len() >= FEWEST) else {
        return nothing;
    };
    let open = open_points(site, footprint);
    if open.len() < FEWEST {
        return nothing;
    }
    let prepared = PreparedPolygon::new(footprint);
    let sure: Vec<Point2<f64>> =
        open.iter().filter(|p| prepared.boundary_distance([p.x, p.y], MARGIN) > MARGIN).copied().collect();
    if sure.len() < FEWEST {
        return nothing;
    }
    let Some(mut pixels) = Pixels::around(&open, REACH) else { return nothing };
    let built = site.points.iter().filter(|p| p.z > site.ground.height + HEADROOM).map(Point3::xy);
    pixels.set_nearer(&beside(&open, site), built, REACH);
    let pieces = pixels.pieces(NARROWEST, |p| prepared.contains([p.x, p.y]));
    let outlines = pieces.into_iter().filter_map(|piece| {
        let inside = piece.area_where(&pixels, |p| prepared.contains([p.x, p.y]));
        let count = sure.iter().filter(|p| piece.holds(&pixels, p)).count();
        let is_seen = count >= FEWEST && count as f64 >= DENSITY * inside;
        (is_seen && inside >= smallest).then(|| piece.outline(&pixels))
    });
    let main = main_directions(&footprint_edges::traces(footprint));
    let straight: Vec<_> = outlines.flat_map(|outline| straighten::straightened(&outline, &main)).collect();
    let mut found = geo::unary_union(&straight);
    found.0.retain(|piece| footprint.intersection(&MultiPolygon(vec![piece.clone()])).unsigned_area() >= smallest);
    found
}

/// The open points, and the ground points beside them that are near a roof: open ground goes on to halfway between the two.
fn beside(open: &[Point2<f64>], site: &Site) -> Vec<Point2<f64>> {
    let cell = |p: &Point2<f64>| [p.x, p.y].map(|c| (c / REACH).floor() as i64);
    let mut cells: BTreeMap<[i64; 2], Vec<&Point2<f64>>> = BTreeMap::new();
    for point in open {
        cells.entry(cell(point)).or_default().push(point);
    }
    let most = highest(site);
    let is_beside = |p: &Point2<f64>| {
        let [column, row] = cell(p);
        let mut around = (column - 1..=column + 1).flat_map(|c| (row - 1..=row + 1).map(move |r| [c, r]));
        around.any(|key| cells.get(&key).is_some_and(|near| near.iter().any(|q| (*q - p).norm() <= REACH)))
    };
    site.ground_points.iter().filter(|p| p.z <= most).map(Point3::xy).filter(is_beside).collect()
}

/// How high ground may be, local metres.
fn highest(site: &Site) -> f64 {
    site.ground.height + site.ground.spread + RISE
}

/// The ground points with nothing above them, in the plan.
fn open_points(site: &Site, footprint: &MultiPolygon<f64>) -> Vec<Point2<f64>> {
    let spacing = (footprint.unsigned_area() / site.points.len().max(1) as f64).sqrt();
    let near = spacing.clamp(NEAR, FARTHEST);
    let cell = |p: &Point3<f64>| [p.x, p.y].map(|c| (c / FARTHEST).floor() as i64);
    let mut cells: BTreeMap<[i64; 2], Vec<&Point3<f64>>> = BTreeMap::new();
    for point in &site.points {
        cells.entry(cell(point)).or_default().push(point);
    }
    let most = highest(site);
    let is_open = |p: &Point3<f64>| {
        let [column, row] = cell(p);
        let around = (column - 1..=column + 1).flat_map(|c| (row - 1..=row + 1).map(move |r| [c, r]));
        let stands_over = |q: &Point3<f64>| q.z >= p.z + HEADROOM && (q.xy() - p.xy()).norm() <= near;
        p.z <= most && !around.filter_map(|key| cells.get(&key)).flatten().any(|q| stands_over(q))
    };
    site.ground_points.iter().filter(|p| is_open(p)).map(Point3::xy).collect()
}

#[cfg(test)]
mod tests;
