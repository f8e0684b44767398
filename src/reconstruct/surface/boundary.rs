//! The boundary of one component of the inside: oriented facets, with edges cut at every vertex that lies on them.

use std::ops::Range;

use super::SurfaceError;
use super::incidence::{line, sort_along};
use crate::geometry::Scattered;
use crate::reconstruct::complex::{Complex, FacetId, OUTSIDE, PlaneId, VertexId};

/// Twin of a half-edge on a non-manifold edge.
const NO_TWIN: u32 = u32::MAX;

/// A facet of the boundary.
#[derive(Debug, Clone)]
pub(super) struct BoundaryFacet {
    pub(super) plane: PlaneId,
    /// Whether the outside is on the positive side of the plane.
    pub(super) positive: bool,
    /// Its half-edges, counter-clockwise seen from outside.
    pub(super) halves: Range<u32>,
}

/// An elementary edge as one facet sees it: no vertex of the boundary lies between its ends.
#[derive(Debug, Clone, Copy)]
pub(super) struct HalfEdge {
    pub(super) from: VertexId,
    pub(super) to: VertexId,
    /// Index into [`Boundary::facets`].
    pub(super) facet: u32,
    /// The same edge in the other direction, on the neighbouring facet.
    pub(super) twin: u32,
}

/// Where a boundary is not a 2-manifold.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Spot {
    /// More than two facets meet along the edge.
    Edge(VertexId, VertexId),
    /// More than one fan of facets meets at the vertex.
    Vertex(VertexId),
}

impl Spot {
    /// The vertices of the spot: twice the same for a vertex.
    pub(super) fn ends(self) -> [VertexId; 2] {
        match self {
            Self::Edge(a, b) => [a, b],
            Self::Vertex(v) => [v, v],
        }
    }
}

/// The boundary of a set of cells.
#[derive(Debug)]
pub(super) struct Boundary {
    pub(super) facets: Vec<BoundaryFacet>,
    pub(super) halves: Vec<HalfEdge>,
    /// Where it is not a 2-manifold, in order.
    pub(super) spots: Vec<Spot>,
}

impl Boundary {
    /// The half-edge that follows in the same facet.
    pub(super) fn next(&self, half: u32) -> u32 {
        let range = &self.facets[self.halves[half as usize].facet as usize].halves;
        if half + 1 == range.end { range.start } else { half + 1 }
    }

    /// The boundary of the cells for which `member` is true, `facets` being all facets that have exactly one of them.
    pub(super) fn new(
        complex: &Complex,
        facets: &[FacetId],
        member: impl Fn(u32) -> bool,
    ) -> Result<Self, SurfaceError> {
        let edges = Edges::new(complex, facets);
        let mut boundary = Self { facets: Vec::with_capacity(facets.len()), halves: Vec::new(), spots: Vec::new() };
        for &id in facets {
            let facet = &complex.facets[id as usize];
            // The normal points from the negative to the positive cell, so it points outwards if the inside is below.
            let positive = facet.cells[0] != OUTSIDE && member(facet.cells[0]);
            let start = boundary.halves.len() as u32;
            let count = facet.corners.len();
            for i in 0..count {
                let (edge, from, to) = if positive {
                    (i, facet.corners[i], facet.corners[(i + 1) % count])
                } else {
                    let i = count - 1 - i;
                    (i, facet.corners[(i + 1) % count], facet.corners[i])
                };
                let chain = edges.chain((facet.plane, facet.edges[edge]), from, to);
                for pair in chain.ok_or(SurfaceError::Inconsistent { facet: id })?.windows(2) {
                    let facet = boundary.facets.len() as u32;
                    boundary.halves.push(HalfEdge { from: pair[0], to: pair[1], facet, twin: NO_TWIN });
                }
            }
            let halves = start..boundary.halves.len() as u32;
            boundary.facets.push(BoundaryFacet { plane: facet.plane, positive, halves });
        }
        boundary.pair_twins();
        boundary.find_pinched_vertices();
        Ok(boundary)
    }

    /// Joins the two half-edges of each edge; edges with more are spots.
    fn pair_twins(&mut self) {
        let mut order: Vec<(VertexId, VertexId, u32)> = self
            .halves
            .iter()
            .enumerate()
            .map(|(i, half)| (half.from.min(half.to), half.from.max(half.to), i as u32))
            .collect();
        order.sort_unstable();
        for edge in order.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
            // A boundary is closed: as many facets see the edge in one direction as in the other.
            if let [(.., a), (.., b)] = *edge {
                self.halves[a as usize].twin = b;
                self.halves[b as usize].twin = a;
            } else {
                self.spots.push(Spot::Edge(edge[0].0, edge[0].1));
            }
        }
    }

    /// Vertices whose facets form more than one fan are spots, unless they end an edge that already is one.
    fn find_pinched_vertices(&mut self) {
        let mut previous = vec![0; self.halves.len()];
        for half in 0..self.halves.len() as u32 {
            previous[self.next(half) as usize] = half;
        }
        let mut order: Vec<(VertexId, u32)> =
            self.halves.iter().enumerate().map(|(i, half)| (half.from, i as u32)).collect();
        order.sort_unstable();
        let mut pinched = Vec::new();
        for fan in order.chunk_by(|a, b| a.0 == b.0) {
            let mut half = fan[0].1;
            let mut turned = 0;
            let whole = loop {
                turned += 1;
                half = self.halves[previous[half as usize] as usize].twin;
                if half == NO_TWIN {
                    break true;
                }
                if half == fan[0].1 || turned > fan.len() {
                    break turned == fan.len();
                }
            };
            if !whole {
                pinched.push(Spot::Vertex(fan[0].0));
            }
        }
        self.spots.extend(pinched);
        self.spots.sort_unstable();
    }
}

/// The two planes of an edge and its ends, lower first.
type Edge = ((PlaneId, PlaneId), [VertexId; 2]);

/// The lines that carry the edges of some facets, each with the facets' vertices on these edges in order.
struct Edges {
    /// Pairs of planes, ascending, with the index of their line; sorted.
    pairs: Vec<((PlaneId, PlaneId), u32)>,
    lines: Vec<Vec<VertexId>>,
}

impl Edges {
    fn new(complex: &Complex, facets: &[FacetId]) -> Self {
        let mut vertices: Vec<VertexId> = Vec::new();
        let mut edges: Vec<Edge> = Vec::new();
        for &facet in facets {
            let facet = &complex.facets[facet as usize];
            vertices.extend(&facet.corners);
            for (i, &edge) in facet.edges.iter().enumerate() {
                let (a, b) = (facet.corners[i], facet.corners[(i + 1) % facet.corners.len()]);
                edges.push(((facet.plane.min(edge), facet.plane.max(edge)), [a.min(b), a.max(b)]));
            }
        }
        vertices.sort_unstable();
        vertices.dedup();
        edges.sort_unstable();
        edges.dedup();
        let of_pairs: Vec<&[Edge]> = edges.chunk_by(|a, b| a.0 == b.0).collect();
        let mut pairs: Vec<_> = of_pairs.iter().map(|edges| (edges[0].0, u32::MAX)).collect();

        // Three planes may share a line: the pairs are brought together by the line itself.
        let mut keyed: Vec<([i128; 6], usize)> = Vec::with_capacity(pairs.len());
        for (i, ((p, q), _)) in pairs.iter().enumerate() {
            if let Some(key) = line(&complex.planes[*p as usize], &complex.planes[*q as usize]) {
                keyed.push((key, i));
            }
        }
        keyed.sort_unstable();
        let plan = |vertex: VertexId| {
            let position = complex.vertices[vertex as usize].position;
            [position.x, position.y]
        };
        let places = Scattered::new(&vertices.iter().map(|&vertex| plan(vertex)).collect::<Vec<_>>());
        let mut lines = Vec::new();
        for group in keyed.chunk_by(|a, b| a.0 == b.0) {
            let (p, q) = pairs[group[0].1].0;
            let [p, q] = [p, q].map(|plane| &complex.planes[plane as usize]);
            let mut found = Vec::new();
            for &(_, pair) in group {
                pairs[pair].1 = lines.len() as u32;
                for (_, ends) in of_pairs[pair] {
                    places.near(ends.map(plan), |place| {
                        let vertex = vertices[place as usize];
                        let position = &complex.vertices[vertex as usize];
                        if p.side(position).is_eq() && q.side(position).is_eq() {
                            found.push(vertex);
                        }
                    });
                }
            }
            sort_along(complex, &group[0].0, &mut found);
            lines.push(found);
        }
        Self { pairs, lines }
    }

    /// All vertices from `from` to `to` along the line of two planes; `None` if they are not on that line.
    fn chain(&self, (p, q): (PlaneId, PlaneId), from: VertexId, to: VertexId) -> Option<Vec<VertexId>> {
        let pair = self.pairs.binary_search_by_key(&(p.min(q), p.max(q)), |entry| entry.0).ok()?;
        let line = self.lines.get(self.pairs[pair].1 as usize)?;
        let start = line.iter().position(|&v| v == from)?;
        let end = line.iter().position(|&v| v == to)?;
        Some(if start <= end { line[start..=end].to_vec() } else { line[end..=start].iter().rev().copied().collect() })
    }
}
