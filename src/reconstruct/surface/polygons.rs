//! Coplanar facets merged into polygons with holes, reduced to their corners.

use super::boundary::Boundary;
use super::collapse::simple_rings;
use crate::reconstruct::complex::{Complex, PlaneId, VertexId};

/// A polygon of the surface.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Polygon {
    pub(super) plane: PlaneId,
    /// Whether the outside is on the positive side of the plane.
    pub(super) positive: bool,
    /// Simple rings: the exterior first, counter-clockwise seen from outside, then the holes, clockwise.
    pub(super) rings: Vec<Vec<VertexId>>,
}

/// Merges the facets of a manifold boundary that lie on the same side of the same plane and share an edge.
///
/// A vertex is kept where at least three planes meet on the surface; elsewhere its two planes make a straight edge
/// through it, in every polygon that has it. So an edge has the same vertices in both its polygons.
pub(super) fn merge(complex: &Complex, boundary: &Boundary) -> Vec<Polygon> {
    let key = |half: u32| {
        let facet = &boundary.facets[boundary.halves[half as usize].facet as usize];
        (facet.plane, facet.positive)
    };
    let twin = |half: u32| boundary.halves[half as usize].twin;
    let count = boundary.halves.len() as u32;
    let on_border: Vec<bool> = (0..count).map(|half| key(half) != key(twin(half))).collect();

    let mut region: Vec<u32> = (0..boundary.facets.len() as u32).collect();
    for half in (0..count).filter(|&half| !on_border[half as usize]) {
        let [a, b] = [half, twin(half)].map(|h| root(&region, boundary.halves[h as usize].facet));
        region[a.max(b) as usize] = a.min(b);
    }

    let corners = corners(complex, boundary, &on_border);
    let mut rings: Vec<(u32, Vec<VertexId>)> = Vec::new();
    let mut visited = vec![false; boundary.halves.len()];
    for start in (0..count).filter(|&half| on_border[half as usize]) {
        let mut ring = Vec::new();
        let mut half = start;
        while !std::mem::replace(&mut visited[half as usize], true) {
            let from = boundary.halves[half as usize].from;
            if corners[from as usize] {
                ring.push(from);
            }
            // Around the end vertex through the facets of this region: where a region touches itself at a vertex, the
            // ring stays on its own side.
            half = boundary.next(half);
            while !on_border[half as usize] {
                half = boundary.next(twin(half));
            }
        }
        if !ring.is_empty() {
            let region = root(&region, boundary.halves[start as usize].facet);
            rings.extend(simple_rings(&ring).into_iter().map(|ring| (region, ring)));
        }
    }
    rings.sort_by_key(|(region, _)| *region);
    rings
        .chunk_by(|a, b| a.0 == b.0)
        .map(|group| {
            let facet = &boundary.facets[group[0].0 as usize];
            let mut rings: Vec<Vec<VertexId>> = group.iter().map(|(_, ring)| ring.clone()).collect();
            // The facets of a region hang together, so one ring surrounds all others: the one of largest area.
            let exterior = (0..rings.len()).max_by(|&a, &b| {
                twice_area(complex, &rings[a]).total_cmp(&twice_area(complex, &rings[b])).then(b.cmp(&a))
            });
            rings[..=exterior.unwrap_or(0)].rotate_right(1);
            Polygon { plane: facet.plane, positive: facet.positive, rings }
        })
        .collect()
}

fn root(region: &[u32], mut i: u32) -> u32 {
    while region[i as usize] != i {
        i = region[i as usize];
    }
    i
}

/// Per vertex of the complex, whether at least three planes meet there on the surface.
fn corners(complex: &Complex, boundary: &Boundary, on_border: &[bool]) -> Vec<bool> {
    let mut meets: Vec<(VertexId, PlaneId)> = Vec::new();
    for (half, _) in boundary.halves.iter().zip(on_border).filter(|(_, border)| **border) {
        let plane = boundary.facets[half.facet as usize].plane;
        meets.extend([(half.from, plane), (half.to, plane)]);
    }
    meets.sort_unstable();
    meets.dedup();
    let mut corners = vec![false; complex.vertices.len()];
    for planes in meets.chunk_by(|a, b| a.0 == b.0) {
        corners[planes[0].0 as usize] = planes.len() >= 3;
    }
    corners
}

fn twice_area(complex: &Complex, ring: &[VertexId]) -> f64 {
    let position = |v: VertexId| complex.vertices[v as usize].position;
    let anchor = position(ring[0]);
    let sum: nalgebra::Vector3<f64> =
        ring.windows(2).map(|e| (position(e[0]) - anchor).cross(&(position(e[1]) - anchor))).sum();
    sum.norm()
}
