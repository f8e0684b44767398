//! A cell in two, with all that hangs on it.

use std::cmp::Ordering;
use std::collections::HashMap;

use super::tree::{NodeId, Tree};
use super::{Cell, CellId, Complex, Facet, FacetId, IntegerPlane, OUTSIDE, PlaneId, Vertex, VertexId};
use crate::geometry::Plane;

/// A complex under construction.
pub(super) struct Partition {
    pub(super) complex: Complex,
    pub(super) tree: Tree,
    /// [`Complex::planes`] in floating point.
    pub(super) float_planes: Vec<Plane>,
    plane_ids: HashMap<IntegerPlane, PlaneId>,
    vertex_ids: HashMap<[i128; 4], VertexId>,
    /// For each vertex, the last plane that it was compared with, and its side of it.
    sides: Vec<(PlaneId, Ordering)>,
    /// Where the edges cut by the present plane are cut: each belongs to several facets.
    cuts: HashMap<(VertexId, VertexId), VertexId>,
    /// Scratch for the rim of a cap: for each vertex, the next one and the plane that they share with the cap.
    rim: Vec<(VertexId, PlaneId)>,
}

/// A piece of the rim of a cap: from one vertex to the next along a plane.
#[derive(Clone, Copy)]
struct RimEdge {
    from: VertexId,
    to: VertexId,
    along: PlaneId,
}

/// The corners and edges of one half of a facet.
#[derive(Default)]
struct Loop {
    corners: Vec<VertexId>,
    edges: Vec<PlaneId>,
}

impl Loop {
    fn with_capacity(capacity: usize) -> Self {
        Self { corners: Vec::with_capacity(capacity), edges: Vec::with_capacity(capacity) }
    }

    fn push(&mut self, corner: VertexId, edge: PlaneId) {
        self.corners.push(corner);
        self.edges.push(edge);
    }
}

impl Partition {
    /// The partition that has only these planes and no cell yet.
    pub(super) fn new(planes: &[IntegerPlane]) -> Self {
        let mut partition = Self {
            complex: Complex::default(),
            tree: Tree::new(0),
            float_planes: Vec::new(),
            plane_ids: HashMap::new(),
            vertex_ids: HashMap::new(),
            sides: Vec::new(),
            cuts: HashMap::new(),
            rim: Vec::new(),
        };
        for plane in planes {
            partition.plane_id(*plane);
        }
        partition
    }

    /// A complex that is cut further, cell by cell: what its tree was is not known any more.
    pub(super) fn reopened(complex: Complex) -> Self {
        let planes = complex.planes.iter().zip(0..);
        let vertices = complex.vertices.iter().zip(0..);
        Self {
            tree: Tree::new(0),
            float_planes: complex.planes.iter().map(IntegerPlane::to_plane).collect(),
            plane_ids: planes.map(|(plane, id)| (*plane, id)).collect(),
            vertex_ids: vertices.map(|(vertex, id)| (vertex.homogeneous, id)).collect(),
            sides: vec![(PlaneId::MAX, Ordering::Equal); complex.vertices.len()],
            cuts: HashMap::new(),
            rim: vec![(VertexId::MAX, PlaneId::MAX); complex.vertices.len()],
            complex,
        }
    }

    /// The id of a plane, new or known.
    pub(super) fn plane_id(&mut self, plane: IntegerPlane) -> PlaneId {
        *self.plane_ids.entry(plane).or_insert_with(|| {
            self.complex.planes.push(plane);
            self.float_planes.push(plane.to_plane());
            (self.complex.planes.len() - 1) as PlaneId
        })
    }

    /// The id of a vertex, new or known.
    pub(super) fn vertex_id(&mut self, vertex: Vertex) -> VertexId {
        *self.vertex_ids.entry(vertex.homogeneous).or_insert_with(|| {
            self.complex.vertices.push(vertex);
            self.sides.push((PlaneId::MAX, Ordering::Equal));
            self.rim.push((VertexId::MAX, PlaneId::MAX));
            (self.complex.vertices.len() - 1) as VertexId
        })
    }

    /// Forgets what is only valid for the plane before this one.
    pub(super) fn begin_plane(&mut self) {
        self.cuts.clear();
    }

    /// Cuts a cell by a plane if it has vertices strictly on both sides, which is when both parts have a volume.
    pub(super) fn cut_cell(&mut self, leaf: NodeId, cell: CellId, plane: PlaneId) {
        if !self.crosses(cell, plane) {
            return;
        }
        // The negative part keeps the id, so that only facets of the positive part get a new neighbour.
        let positive_cell = self.complex.cells.len() as CellId;
        let old = std::mem::take(&mut self.complex.cells[cell as usize].facets);
        let (mut negative, mut positive) = (Vec::with_capacity(old.len() + 1), Vec::with_capacity(old.len() + 1));
        let mut rim = Vec::new();
        for facet in old {
            let corners = &self.complex.facets[facet as usize].corners;
            let (mut below, mut above) = (false, false);
            for &corner in corners {
                match self.sides[corner as usize].1 {
                    Ordering::Less => below = true,
                    Ordering::Equal => {}
                    Ordering::Greater => above = true,
                }
            }
            if !above {
                negative.push(facet);
                continue;
            }
            if below {
                let (half, edge) = self.cut_facet(facet, plane);
                rim.push(Self::seen_from_outside(cell, &self.complex.facets[facet as usize], edge));
                self.complex.facets.push(half);
                let half = (self.complex.facets.len() - 1) as FacetId;
                let neighbour = self.complex.facets[facet as usize].cells.into_iter().find(|&c| c != cell);
                if let Some(neighbour) = neighbour.filter(|&c| c != OUTSIDE) {
                    self.complex.cells[neighbour as usize].facets.push(half);
                }
                negative.push(facet);
                positive.push(half);
                self.hand_over(half, cell, positive_cell);
            } else {
                if let Some(edge) = self.edge_on_plane(facet) {
                    rim.push(Self::seen_from_outside(cell, &self.complex.facets[facet as usize], edge));
                }
                positive.push(facet);
                self.hand_over(facet, cell, positive_cell);
            }
        }
        let cap = self.cap(plane, &rim, [cell, positive_cell]);
        self.complex.facets.push(cap);
        let cap = (self.complex.facets.len() - 1) as FacetId;
        negative.push(cap);
        positive.push(cap);
        self.complex.cells[cell as usize].facets = negative;
        self.complex.cells.push(Cell { facets: positive });
        self.tree.cut(leaf, plane, [cell, positive_cell]);
    }

    /// Whether a cell has vertices strictly on both sides of a plane. All its vertices are classified afterwards if so.
    fn crosses(&mut self, cell: CellId, plane: PlaneId) -> bool {
        let Self { complex, sides, .. } = self;
        let equation = &complex.planes[plane as usize];
        let (mut below, mut above) = (false, false);
        for &facet in &complex.cells[cell as usize].facets {
            for &corner in &complex.facets[facet as usize].corners {
                let known = &mut sides[corner as usize];
                if known.0 != plane {
                    *known = (plane, equation.side(&complex.vertices[corner as usize]));
                }
                below |= known.1.is_lt();
                above |= known.1.is_gt();
            }
        }
        below && above
    }

    /// Takes the positive half off a facet that crosses the plane. The new edge comes with it, as it runs in the
    /// positive half.
    fn cut_facet(&mut self, facet: FacetId, plane: PlaneId) -> (Facet, RimEdge) {
        let whole = &mut self.complex.facets[facet as usize];
        let (own, cells) = (whole.plane, whole.cells);
        let corners = std::mem::take(&mut whole.corners);
        let edges = std::mem::take(&mut whole.edges);
        let count = corners.len();
        let (mut negative, mut positive) = (Loop::with_capacity(count + 1), Loop::with_capacity(count + 1));
        let mut new_edge = RimEdge { from: VertexId::MAX, to: VertexId::MAX, along: own };
        for i in 0..count {
            let (corner, edge) = (corners[i], edges[i]);
            let next = corners[if i + 1 == count { 0 } else { i + 1 }];
            let (side, next_side) = (self.sides[corner as usize].1, self.sides[next as usize].1);
            // A facet on both sides has no edge on the plane, as it is convex and without corners in line. So from a
            // corner on the plane one half goes on along the old edge and the other along the new one.
            match (side, next_side) {
                (Ordering::Greater, Ordering::Less) => {
                    let cut = self.cut_edge(corner, next, [own, edge, plane]);
                    positive.push(corner, edge);
                    positive.push(cut, plane);
                    negative.push(cut, edge);
                    new_edge.from = cut;
                }
                (Ordering::Less, Ordering::Greater) => {
                    let cut = self.cut_edge(corner, next, [own, edge, plane]);
                    negative.push(corner, edge);
                    negative.push(cut, plane);
                    positive.push(cut, edge);
                    new_edge.to = cut;
                }
                (Ordering::Equal, Ordering::Less) => {
                    positive.push(corner, plane);
                    negative.push(corner, edge);
                    new_edge.from = corner;
                }
                (Ordering::Equal, _) => {
                    negative.push(corner, plane);
                    positive.push(corner, edge);
                    new_edge.to = corner;
                }
                (Ordering::Greater, _) => positive.push(corner, edge),
                (Ordering::Less, _) => negative.push(corner, edge),
            }
        }
        let whole = &mut self.complex.facets[facet as usize];
        whole.corners = negative.corners;
        whole.edges = negative.edges;
        (Facet { plane: own, corners: positive.corners, edges: positive.edges, cells }, new_edge)
    }

    /// The vertex at which the last of these planes cuts the edge that lies on the other two.
    fn cut_edge(&mut self, from: VertexId, to: VertexId, planes: [PlaneId; 3]) -> VertexId {
        let key = (from.min(to), from.max(to));
        if let Some(&known) = self.cuts.get(&key) {
            return known;
        }
        let met = Vertex::meet(planes.map(|plane| &self.complex.planes[plane as usize]));
        #[expect(
            clippy::expect_used,
            reason = "the ends of the edge are strictly on different sides of the last plane"
        )]
        let vertex = self.vertex_id(met.expect("a plane between the ends of an edge meets it in a point"));
        self.sides[vertex as usize] = (planes[2], Ordering::Equal);
        self.cuts.insert(key, vertex);
        vertex
    }

    /// The edge of a facet on the positive side that lies on the present plane, if there is one.
    fn edge_on_plane(&self, facet: FacetId) -> Option<RimEdge> {
        let Facet { plane, corners, .. } = &self.complex.facets[facet as usize];
        let on = |corner: VertexId| self.sides[corner as usize].1.is_eq();
        let ends = corners.iter().zip(corners.iter().cycle().skip(1));
        ends.filter(|&(&from, &to)| on(from) && on(to)).map(|(&from, &to)| RimEdge { from, to, along: *plane }).next()
    }

    /// An edge of a facet in the direction in which it runs seen from outside of `cell`.
    fn seen_from_outside(cell: CellId, facet: &Facet, edge: RimEdge) -> RimEdge {
        if facet.cells[0] == cell { edge } else { RimEdge { from: edge.to, to: edge.from, ..edge } }
    }

    /// Gives a facet's side in cell `from` to cell `to`.
    fn hand_over(&mut self, facet: FacetId, from: CellId, to: CellId) {
        for cell in &mut self.complex.facets[facet as usize].cells {
            if *cell == from {
                *cell = to;
            }
        }
    }

    /// The new facet between the two parts of a cell.
    ///
    /// `rim` holds the edges on the plane of all facets of the positive part, seen from outside of it. As these facets
    /// close that part but for the cap, their edges on the plane are the rim of the cap, each piece once, and end to
    /// end. Pieces along the same plane are on one line: the corner between them is none of the cap.
    fn cap(&mut self, plane: PlaneId, rim: &[RimEdge], cells: [CellId; 2]) -> Facet {
        for edge in rim {
            self.rim[edge.from as usize] = (edge.to, edge.along);
        }
        let mut cap = Loop::with_capacity(rim.len());
        if let Some(first) = rim.first() {
            let (mut at, mut along) = (first.to, first.along);
            for _ in rim {
                let (next, next_along) = self.rim[at as usize];
                if next_along != along {
                    cap.push(at, next_along);
                }
                (at, along) = (next, next_along);
            }
            debug_assert_eq!(at, first.to, "the rim of a cap is one loop");
        }
        Facet { plane, corners: cap.corners, edges: cap.edges, cells }
    }
}
