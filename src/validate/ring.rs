//! Rings by themselves: codes 101, 102 and 104.

use super::predicates::{Meeting, Point2, Projection, edges, meet, newell};
use super::snap::Snap;
use super::{Fault, Place, Tolerances};
use crate::solid::{Face, Solid};

/// The faults of the rings of a face:
/// 101 fewer than three vertices, 102 repeated vertices, 104 self-intersection or collapse.
///
/// Self-intersection is decided in the projection of the face along the axis nearest to its normal, which is exact.
pub fn check(solid: &Solid, id: u32, face: &Face, tolerances: &Tolerances) -> Vec<Fault> {
    let mut faults = Vec::new();
    let projection = face.rings.first().and_then(|exterior| Projection::along(newell(solid, exterior)));
    for (r, ring) in face.rings.iter().enumerate() {
        let place = Place::Ring(id, r as u32);
        if ring.len() < 3 {
            faults.push(Fault::new(101, place, format!("{} vertices; a ring needs three", ring.len())));
        } else if let Some(message) = repeated(solid, ring, tolerances.snap) {
            faults.push(Fault::new(102, place, message));
        } else if let Some(message) = projection.map_or(Some(COLLAPSED.into()), |p| intersection(solid, ring, p)) {
            faults.push(Fault::new(104, place, message));
        }
    }
    faults
}

const COLLAPSED: &str = "the ring has no area";

/// Neighbouring vertices that are no farther apart than `snap` metres.
fn repeated(solid: &Solid, ring: &[u32], snap: f64) -> Option<String> {
    let on_grid = Snap::new(solid.step, snap);
    edges(ring)
        .find(|&(a, b)| on_grid.joins(solid.vertices[a as usize], solid.vertices[b as usize]).is_some())
        .map(|(a, b)| format!("vertices {a} and {b} are the same or no farther apart than {snap} m"))
}

/// Edges that meet elsewhere than at the vertex that they share.
fn intersection(solid: &Solid, ring: &[u32], projection: Projection) -> Option<String> {
    let points = projection.ring(solid, ring);
    let n = points.len();
    let area: i128 =
        edges(&points).map(|(a, b)| i128::from(a[0]) * i128::from(b[1]) - i128::from(a[1]) * i128::from(b[0])).sum();
    if area == 0 || edges(&points).any(|(a, b)| a == b) {
        return Some(COLLAPSED.into());
    }
    let edge = |i: usize| [points[i], points[(i + 1) % n]];
    let faulty = |i: usize, j: usize| {
        // Consecutive edges always touch, at the vertex between them; anything more is a spike.
        let consecutive = j == i + 1 || (i == 0 && j == n - 1);
        match meet(edge(i), edge(j)) {
            Meeting::Apart => false,
            Meeting::Touch(_) => !consecutive,
            Meeting::Cross | Meeting::Overlap => true,
        }
    };
    let pair = if n > SWEPT {
        sweep(n, edge, faulty)
    } else {
        (0..n).find_map(|i| (i + 1..n).find(|&j| faulty(i, j)).map(|j| (i, j)))
    };
    let name = |i: usize| format!("{}-{}", ring[i], ring[(i + 1) % n]);
    pair.map(|(i, j)| format!("edges {} and {} intersect", name(i), name(j)))
}

/// From so many edges on, a sweep is faster than all pairs.
const SWEPT: usize = 64;

/// The first faulty pair of edges, lower index first, by a sweep along x.
fn sweep(
    n: usize,
    edge: impl Fn(usize) -> [Point2; 2],
    faulty: impl Fn(usize, usize) -> bool,
) -> Option<(usize, usize)> {
    let ends = |i: usize| {
        let [a, b] = edge(i);
        (a[0].min(b[0]), a[0].max(b[0]))
    };
    let mut order: Vec<(i64, i64, usize)> = (0..n).map(|i| (ends(i).0, ends(i).1, i)).collect();
    order.sort_unstable();
    let mut first = None;
    for (k, &(_, end, i)) in order.iter().enumerate() {
        for &(.., j) in order[k + 1..].iter().take_while(|other| other.0 <= end) {
            let pair = (i.min(j), i.max(j));
            if first.is_none_or(|f| pair < f) && faulty(pair.0, pair.1) {
                first = Some(pair);
            }
        }
    }
    first
}
