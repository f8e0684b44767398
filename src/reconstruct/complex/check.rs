//! The invariants of a complex, checked one by one: for tests, and for whoever changes a complex.

use std::cmp::Ordering;
use std::collections::{BTreeMap, HashSet};

use super::exact::orientation;
use super::{CellId, Complex, FacetId, OUTSIDE, PlaneId, VertexId};

/// How far the volumes of the cells may miss that of the box, relative to it.
const VOLUME_TOLERANCE: f64 = 1e-9;

/// An invariant that does not hold.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Fault {
    /// Two planes or two vertices are equal.
    #[error("{0} stand twice in the list")]
    Duplicate(&'static str),
    /// A corner of a facet, or an edge, is not on a plane that it is said to be on.
    #[error("corner {corner} of facet {facet} is not on its planes")]
    NotOnPlane {
        /// The facet.
        facet: FacetId,
        /// Position of the corner in its loop.
        corner: usize,
    },
    /// A facet is not strictly convex and counter-clockwise.
    #[error("facet {facet} is not a strictly convex, counter-clockwise polygon")]
    NotConvex {
        /// The facet.
        facet: FacetId,
    },
    /// A facet and its cells do not name each other exactly once.
    #[error("facet {facet} and its cells do not agree")]
    Neighbours {
        /// The facet.
        facet: FacetId,
    },
    /// A facet is at the box but not on a plane of the box, or the reverse.
    #[error("facet {facet} is at the box without lying on it, or the reverse")]
    Box {
        /// The facet.
        facet: FacetId,
    },
    /// A vertex of a cell is on the wrong side of one of its facets.
    #[error("cell {cell} is not convex at its facet {facet}")]
    CellNotConvex {
        /// The cell.
        cell: CellId,
        /// The facet.
        facet: FacetId,
    },
    /// The facets of a cell do not close.
    #[error("cell {cell} is open between vertices {from} and {to}")]
    Open {
        /// The cell.
        cell: CellId,
        /// Where an unmatched edge begins.
        from: VertexId,
        /// Where it ends.
        to: VertexId,
    },
    /// Vertices − edges + faces of a cell is not 2.
    #[error("cell {cell} has {vertices} vertices, {edges} edges and {faces} faces")]
    Euler {
        /// The cell.
        cell: CellId,
        /// True vertices.
        vertices: usize,
        /// Edges between them.
        edges: usize,
        /// Distinct planes of its facets.
        faces: usize,
    },
    /// The cells do not fill the box.
    #[error("the cells fill {cells} m³ of a box of {bounds} m³")]
    Volume {
        /// Sum of the volumes of the cells.
        cells: f64,
        /// Volume of the box.
        bounds: f64,
    },
}

impl Complex {
    /// Checks everything that a partition promises; all but the volume exactly.
    ///
    /// # Errors
    /// The first invariant that does not hold.
    pub fn check(&self) -> Result<(), Fault> {
        self.check_distinct()?;
        for facet in 0..self.facets.len() as FacetId {
            self.check_facet(facet)?;
            self.check_sides(facet)?;
        }
        for cell in 0..self.cells.len() as CellId {
            self.check_convex(cell)?;
            self.check_closed(cell)?;
            self.check_euler(cell)?;
        }
        self.check_volume()
    }

    fn check_distinct(&self) -> Result<(), Fault> {
        let planes: HashSet<_> = self.planes.iter().collect();
        let vertices: HashSet<_> = self.vertices.iter().map(|v| v.homogeneous).collect();
        if planes.len() < self.planes.len() {
            return Err(Fault::Duplicate("planes"));
        }
        if vertices.len() < self.vertices.len() {
            return Err(Fault::Duplicate("vertices"));
        }
        Ok(())
    }

    /// A facet is planar, its edges are on their planes, and it is strictly convex and counter-clockwise.
    ///
    /// With `m`, `m'` the planes of two successive edges, oriented towards the inside, and `n` that of the facet: the
    /// loop turns left when `det(m, m', n) > 0`. So winding is decided without coordinates.
    fn check_facet(&self, id: FacetId) -> Result<(), Fault> {
        let facet = &self.facets[id as usize];
        let count = facet.corners.len();
        let not_convex = Err(Fault::NotConvex { facet: id });
        if count < 3 || facet.edges.len() != count {
            return not_convex;
        }
        let mut inner_sides = Vec::with_capacity(count);
        for i in 0..count {
            let ends = [facet.corners[i], facet.corners[(i + 1) % count]];
            let (edge, corner) = (facet.edges[i], facet.corners[i]);
            if !self.side(facet.plane, corner).is_eq() || ends.iter().any(|&end| !self.side(edge, end).is_eq()) {
                return Err(Fault::NotOnPlane { facet: id, corner: i });
            }
            let mut others = facet.corners.iter().filter(|corner| !ends.contains(corner));
            let inner = others.next().map_or(Ordering::Equal, |&other| self.side(edge, other));
            if inner.is_eq() || others.any(|&other| self.side(edge, other) != inner) {
                return not_convex;
            }
            inner_sides.push(inner);
        }
        for i in 0..count {
            let next = (i + 1) % count;
            let planes = [facet.edges[i], facet.edges[next], facet.plane].map(|p| &self.planes[p as usize]);
            let turn = orientation(planes);
            let oriented = if inner_sides[i] == inner_sides[next] { turn } else { turn.reverse() };
            if oriented.is_le() {
                return not_convex;
            }
        }
        Ok(())
    }

    /// A facet and its cells name each other, once, and facets to the outside are those on the box.
    fn check_sides(&self, id: FacetId) -> Result<(), Fault> {
        let facet = &self.facets[id as usize];
        let [negative, positive] = facet.cells;
        let named = |cell: CellId| {
            let facets = self.cells.get(cell as usize).map_or(&[][..], |cell| &cell.facets);
            cell == OUTSIDE || facets.iter().filter(|&&f| f == id).count() == 1
        };
        if negative == positive || !named(negative) || !named(positive) {
            return Err(Fault::Neighbours { facet: id });
        }
        // The negative side of x min, y min, z min is outside, and the positive side of x max, y max, z max.
        let outside = [negative, positive].map(|cell| cell == OUTSIDE);
        let expected =
            if facet.plane < 6 { [facet.plane.is_multiple_of(2), !facet.plane.is_multiple_of(2)] } else { [false; 2] };
        if outside == expected { Ok(()) } else { Err(Fault::Box { facet: id }) }
    }

    /// Every facet of a cell has the whole cell on the side where it says that the cell is.
    fn check_convex(&self, cell: CellId) -> Result<(), Fault> {
        let vertices = self.cell_vertices(cell);
        for &id in &self.cells[cell as usize].facets {
            let facet = &self.facets[id as usize];
            let wrong = if facet.cells[0] == cell { Ordering::Greater } else { Ordering::Less };
            if !facet.cells.contains(&cell) || vertices.iter().any(|&v| self.side(facet.plane, v) == wrong) {
                return Err(Fault::CellNotConvex { cell, facet: id });
            }
        }
        Ok(())
    }

    /// Every piece of every edge is used once in each direction, where edges are pieces between the vertices of the
    /// cell that lie on them.
    fn check_closed(&self, cell: CellId) -> Result<(), Fault> {
        let vertices = self.cell_vertices(cell);
        let mut balance: BTreeMap<(VertexId, VertexId), i32> = BTreeMap::new();
        for &id in &self.cells[cell as usize].facets {
            let facet = &self.facets[id as usize];
            for (i, (&edge, &from)) in facet.edges.iter().zip(&facet.corners).enumerate() {
                let to = facet.corners[(i + 1) % facet.corners.len()];
                let (first, last) = if self.order(from, to).is_le() { (from, to) } else { (to, from) };
                let forwards = (first == from) == (facet.cells[0] == cell);
                let mut on_edge: Vec<_> = vertices
                    .iter()
                    .copied()
                    .filter(|&v| self.side(facet.plane, v).is_eq() && self.side(edge, v).is_eq())
                    .filter(|&v| self.order(first, v).is_le() && self.order(v, last).is_le())
                    .collect();
                on_edge.sort_by(|&a, &b| self.order(a, b));
                for piece in on_edge.windows(2) {
                    *balance.entry((piece[0], piece[1])).or_default() += if forwards { 1 } else { -1 };
                }
            }
        }
        match balance.into_iter().find(|&(_, balance)| balance != 0) {
            Some(((from, to), _)) => Err(Fault::Open { cell, from, to }),
            None => Ok(()),
        }
    }

    /// Euler's formula, on the true vertices of a cell (on at least three of its planes) and the pairs of planes that
    /// share two of them.
    fn check_euler(&self, cell: CellId) -> Result<(), Fault> {
        let facets = &self.cells[cell as usize].facets;
        let mut planes: Vec<_> = facets.iter().map(|&f| self.facets[f as usize].plane).collect();
        planes.sort_unstable();
        planes.dedup();
        let mut shared: BTreeMap<(PlaneId, PlaneId), usize> = BTreeMap::new();
        let mut vertices = 0;
        for vertex in self.cell_vertices(cell) {
            let on: Vec<_> = planes.iter().copied().filter(|&p| self.side(p, vertex).is_eq()).collect();
            if on.len() < 3 {
                continue;
            }
            vertices += 1;
            for (i, &a) in on.iter().enumerate() {
                for &b in &on[i + 1..] {
                    *shared.entry((a, b)).or_default() += 1;
                }
            }
        }
        let edges = shared.values().filter(|&&count| count == 2).count();
        let faces = planes.len();
        if vertices + faces == edges + 2 { Ok(()) } else { Err(Fault::Euler { cell, vertices, edges, faces }) }
    }

    fn check_volume(&self) -> Result<(), Fault> {
        let distance = |plane: usize| self.planes[plane].to_plane().offset;
        let bounds: f64 = (0..3).map(|axis| distance(2 * axis) - distance(2 * axis + 1)).product();
        let cells: f64 = (0..self.cells.len() as CellId).map(|cell| self.cell_volume(cell)).sum();
        let full = (cells - bounds).abs() <= VOLUME_TOLERANCE * bounds;
        if full { Ok(()) } else { Err(Fault::Volume { cells, bounds }) }
    }

    fn side(&self, plane: PlaneId, vertex: VertexId) -> Ordering {
        self.planes[plane as usize].side(&self.vertices[vertex as usize])
    }

    fn order(&self, a: VertexId, b: VertexId) -> Ordering {
        self.vertices[a as usize].order(&self.vertices[b as usize])
    }
}
