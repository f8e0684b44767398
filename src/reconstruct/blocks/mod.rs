//! LoD 0 and LoD 1.2: the footprint on the grid of the output, and the block over it.
//!
//! These are what every building has, and what it falls back to. They are valid by construction: the footprint's rings
//! neither cross nor touch on the grid (integer predicates), and a block over such a polygon is a closed, oriented
//! 2-manifold whose walls are exactly vertical and planar.

mod clearance;
mod repair;
mod ring;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use geo::MultiPolygon;

use crate::solid::{Face, FootprintPolygon, Solid, Surface, SurfaceType, quantise_footprint};
use ring::Point;

/// Two places closer than this, in metres, are one: what validators snap together (val3dity: 1 mm), and a hair, for they
/// compare distances in floating point.
const SNAP: f64 = 1.01e-3;

/// A footprint in local metres as LoD 0: in grid steps of size `step` metres. What had to be changed to put it there is
/// told in `notes`.
///
/// Polygons of a `MultiPolygon` stay apart, even if they share an edge. Within a polygon no two rings share a point;
/// repeated and collinear vertices and spikes narrower than 1 mm are gone. A part or hole that cannot be had on the grid
/// is left out.
pub fn footprint(footprint: &MultiPolygon<f64>, step: [f64; 3], notes: &mut Vec<String>) -> Vec<FootprintPolygon> {
    let quantised = quantise_footprint(footprint, step);
    let collapsed = footprint.0.len() - quantised.len();
    if collapsed > 0 {
        notes.push(format!("{collapsed} part(s) of the footprint collapse on the output grid: left out"));
    }
    mend(quantised, step, notes)
}

/// Where the footprint touches itself once on the grid, in local metres: places where two of a polygon's rings, or two
/// parts of one, share a point.
pub(super) fn touches(footprint: &MultiPolygon<f64>, step: [f64; 3]) -> Vec<[f64; 2]> {
    let quantised = quantise_footprint(footprint, step);
    let places = quantised.iter().flat_map(|polygon| repair::touches(polygon, snap_in_steps(step)));
    places.map(|place| [0, 1].map(|axis| place[axis] as f64 * step[axis])).collect()
}

/// Polygons on the grid with every fault that rounding made taken out, as [`footprint`] returns them.
pub fn mend(polygons: Vec<FootprintPolygon>, step: [f64; 3], notes: &mut Vec<String>) -> Vec<FootprintPolygon> {
    let snap = snap_in_steps(step);
    polygons.into_iter().flat_map(|polygon| repair::mend(polygon, snap, notes)).collect()
}

/// [`SNAP`] in grid steps, at least one.
fn snap_in_steps(step: [f64; 3]) -> f64 {
    (SNAP / step[0].min(step[1])).max(1.0)
}

/// The LoD 1.2 block over a polygon, from `ground` to `top` (grid steps); `None` when it is not at least 1 mm high, or
/// the polygon has no area.
///
/// `polygon` is one of [`footprint`]'s: exterior counter-clockwise, holes clockwise, no two rings sharing a point. `step`
/// is the size of a grid step in metres. All walls on one line share a semantic surface.
pub fn block(polygon: &FootprintPolygon, ground: i64, top: i64, step: [f64; 3]) -> Option<Solid> {
    if ((top - ground) as f64) * step[2] < SNAP {
        return None;
    }
    let rings: Vec<Vec<Point>> = polygon.iter().filter_map(|ring| corners(ring)).collect();
    if polygon.first().is_none_or(|exterior| corners(exterior).is_none()) {
        return None;
    }
    let roof = Surface { slope: Some(0.0), heights: Some([top as f64 * step[2]; 2]), ..Surface::of(SurfaceType::Roof) };
    let mut solid = Solid {
        step,
        vertices: Vec::new(),
        faces: vec![Face { rings: Vec::new(), surface: 0 }, Face { rings: Vec::new(), surface: 1 }],
        surfaces: vec![Surface::of(SurfaceType::Ground), roof],
    };
    let mut walls: BTreeMap<Line, u32> = BTreeMap::new();
    for ring in &rings {
        let base = solid.vertices.len() as u32;
        let n = ring.len() as u32;
        solid.vertices.extend(ring.iter().map(|p| [p[0], p[1], ground]));
        solid.vertices.extend(ring.iter().map(|p| [p[0], p[1], top]));
        solid.faces[0].rings.push((base..base + n).rev().collect());
        solid.faces[1].rings.push((base + n..base + 2 * n).collect());
        for i in 0..n {
            let next = (i + 1) % n;
            let surface = *walls.entry(Line::through(ring[i as usize], ring[next as usize])).or_insert_with(|| {
                solid.surfaces.push(Surface { on_footprint_edge: Some(true), ..Surface::of(SurfaceType::Wall) });
                solid.surfaces.len() as u32 - 1
            });
            let quad = vec![base + i, base + next, base + n + next, base + n + i];
            solid.faces.push(Face { rings: vec![quad], surface });
        }
    }
    Some(solid)
}

/// A ring without exactly collinear or repeated vertices; `None` when nothing is left.
fn corners(ring: &[Point]) -> Option<Vec<Point>> {
    let n = ring.len();
    let is_corner = |&i: &usize| ring::orient(ring[(i + n - 1) % n], ring[i], ring[(i + 1) % n]) != 0;
    if (0..n).all(|i| is_corner(&i)) {
        return (n >= 3).then(|| ring.to_vec());
    }
    ring::clean(ring, 0.0).map(|cleaned| cleaned.ring)
}

/// The directed line through two grid points in lowest terms: edges on the same line in the same direction are equal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Line {
    direction: [i64; 2],
    offset: i128,
}

impl Line {
    fn through(a: Point, b: Point) -> Self {
        let delta = [b[0] - a[0], b[1] - a[1]];
        let divisor = gcd(delta[0].unsigned_abs(), delta[1].unsigned_abs()).max(1) as i64;
        let direction = [delta[0] / divisor, delta[1] / divisor];
        let offset = i128::from(direction[0]) * i128::from(a[1]) - i128::from(direction[1]) * i128::from(a[0]);
        Self { direction, offset }
    }
}

/// The greatest common divisor.
fn gcd(mut a: u64, mut b: u64) -> u64 {
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}
