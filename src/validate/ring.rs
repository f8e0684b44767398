//! Rings by themselves: codes 101, 102 and 104.

use super::polygon::off_plane;
use super::predicates::{Meeting, Point2, Projection, edges, meet, newell};
use super::snap::Snap;
use super::{Fault, Place, Tolerances};
use crate::geometry::Boxes;
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
        } else if let Some(message) = projection.map_or(Some(COLLAPSED.into()), |p| intersection(solid, ring, p))
            && (message != COLLAPSED || !is_twisted(solid, face, tolerances))
        {
            faults.push(Fault::new(104, place, message));
        }
    }
    faults
}

const COLLAPSED: &str = "the ring has no area";

/// Whether a face is so far off its plane (203) that an edge may stand on the projection, or the areas of its parts cancel.
fn is_twisted(solid: &Solid, face: &Face, tolerances: &Tolerances) -> bool {
    off_plane(solid, face).is_some_and(|off| off > tolerances.planarity)
}

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
    let pair = if n > FEW {
        by_tree(n, edge, faulty)
    } else {
        (0..n).find_map(|i| (i + 1..n).find(|&j| faulty(i, j)).map(|j| (i, j)))
    };
    let name = |i: usize| format!("{}-{}", ring[i], ring[(i + 1) % n]);
    pair.map(|(i, j)| format!("edges {} and {} intersect", name(i), name(j)))
}

/// From so many edges on, a tree of their boxes is faster than all pairs.
const FEW: usize = 64;

/// The first faulty pair of edges, lower index first, by a tree of boxes.
fn by_tree(
    n: usize,
    edge: impl Fn(usize) -> [Point2; 2],
    faulty: impl Fn(usize, usize) -> bool,
) -> Option<(usize, usize)> {
    let boxes = Boxes::of_segments((0..n).map(edge), 0);
    let mut first: Option<(usize, usize)> = None;
    for pair in boxes.meeting(&boxes).filter(|(i, j)| i < j) {
        if first.is_none_or(|first| pair < first) && faulty(pair.0, pair.1) {
            first = Some(pair);
        }
    }
    first
}
