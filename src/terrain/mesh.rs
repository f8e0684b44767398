//! The triangulation of a tile, with the outlines, the border and the edge of what is covered as edges of it.
//!
//! All places are whole numbers of steps of the output, and the triangulation decides by exact signs: no triangle turns over
//! or collapses when it is written.

use std::collections::HashMap;

use foldhash::fast::FixedState;
use spade::handles::{FixedFaceHandle, FixedVertexHandle, InnerTag};
use spade::{ConstrainedDelaunayTriangulation, HasPosition, Point2, Triangulation};

use super::border::{Setting, sides};
use super::grid::Place;
use super::outlines::Inside;

/// A vertex: its place and height in steps from the corner of the tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Corner {
    pub place: Place,
    pub z: i64,
}

impl HasPosition for Corner {
    type Scalar = f64;

    fn position(&self) -> Point2<f64> {
        Point2::new(self.place[0] as f64, self.place[1] as f64)
    }
}

/// What a triangle is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// The ground.
    Ground,
    /// The ground under a footprint on which nothing stands: level, and never refined.
    Pad,
    /// Where a building stands.
    Hole,
    /// Where nothing is known.
    Unknown,
}

pub(super) type Cdt = ConstrainedDelaunayTriangulation<Corner>;

/// The triangulation of a tile.
pub(super) struct Mesh {
    pub cdt: Cdt,
    /// What each triangle is, by the index of its face.
    pub kinds: Vec<Kind>,
    /// Edges that could not be kept because they cross others.
    pub crossed: usize,
}

impl Mesh {
    /// The coarsest triangulation of a tile: the vertices that must be, and no other. `None` where none of it is terrain.
    pub fn coarse(setting: &Setting<'_>) -> Option<Self> {
        if !setting.coverage.of_tile().any(|part| setting.coverage.is_covered(part)) {
            return None;
        }
        let mut builder = Builder { cdt: Cdt::new(), known: HashMap::default(), crossed: 0 };
        let tile = setting.ground.grid.tile;
        let sides = sides(setting);
        for corner in [[0, 0], [tile[0], 0], tile, [0, tile[1]]] {
            let height = sides.iter().flatten().find(|(place, _)| *place == corner).map_or(0, |(_, z)| *z);
            builder.vertex(corner, height)?;
        }
        for side in &sides {
            for pair in side.windows(2) {
                builder.edge(pair[0], pair[1])?;
            }
        }
        let is_in_tile = |place: &Place| (0..2).all(|axis| (0..=tile[axis]).contains(&place[axis]));
        for edge in setting.outlines.edges.iter().filter(|edge| edge.ends.iter().all(is_in_tile)) {
            let [a, b] = edge.ends.map(|end| (end, setting.height(end)));
            builder.edge(a, b)?;
        }
        builder.edge_of_covered(setting)?;
        let Builder { cdt, crossed, .. } = builder;
        let mut mesh = Self { kinds: vec![Kind::Unknown; cdt.num_all_faces()], cdt, crossed };
        mesh.name_triangles(setting);
        Some(mesh)
    }

    /// The corners of a triangle, counter-clockwise.
    pub fn corners(&self, face: FixedFaceHandle<InnerTag>) -> [Corner; 3] {
        self.cdt.face(face).vertices().map(|vertex| *vertex.data())
    }

    /// Says what the triangles are: all that hang together without an edge between them are alike.
    fn name_triangles(&mut self, setting: &Setting<'_>) {
        let mut is_done = vec![false; self.kinds.len()];
        let faces: Vec<FixedFaceHandle<InnerTag>> = self.cdt.inner_faces().map(|face| face.fix()).collect();
        for start in faces {
            if is_done[start.index()] {
                continue;
            }
            is_done[start.index()] = true;
            let (mut found, mut next) = (vec![start], 0);
            while let Some(face) = found.get(next).copied() {
                next += 1;
                for edge in self.cdt.face(face).adjacent_edges() {
                    let Some(beside) = edge.rev().face().as_inner().filter(|_| !edge.is_constraint_edge()) else {
                        continue;
                    };
                    if !std::mem::replace(&mut is_done[beside.index()], true) {
                        found.push(beside.fix());
                    }
                }
            }
            let kind = kind(self.corners(start), setting);
            for face in &found {
                self.kinds[face.index()] = kind;
            }
        }
    }
}

/// What a triangle is that no edge of anything runs through.
fn kind(corners: [Corner; 3], setting: &Setting<'_>) -> Kind {
    let sum = [0, 1].map(|axis| corners.iter().map(|corner| corner.place[axis]).sum::<i64>());
    let inside = setting.outlines.inside(sum, 3);
    let part = setting.ground.grid.part_of(sum.map(|c| c.div_euclid(3)));
    match inside {
        Some(Inside::Hole) => Kind::Hole,
        _ if !setting.coverage.is_covered(part) => Kind::Unknown,
        Some(Inside::Pad) => Kind::Pad,
        None => Kind::Ground,
    }
}

struct Builder {
    cdt: Cdt,
    known: HashMap<Place, FixedVertexHandle, FixedState>,
    crossed: usize,
}

impl Builder {
    /// The vertex at a place, made where there is none; `None` never in practice: coordinates are small whole numbers.
    fn vertex(&mut self, place: Place, z: i64) -> Option<FixedVertexHandle> {
        if let Some(known) = self.known.get(&place) {
            return Some(*known);
        }
        let vertex = self.cdt.insert(Corner { place, z }).ok()?;
        self.known.insert(place, vertex);
        Some(vertex)
    }

    fn edge(&mut self, a: (Place, i64), b: (Place, i64)) -> Option<()> {
        let (a, b) = (self.vertex(a.0, a.1)?, self.vertex(b.0, b.1)?);
        if a != b && self.cdt.try_add_constraint(a, b).is_empty() && !self.cdt.exists_constraint(a, b) {
            self.crossed += 1;
        }
        Some(())
    }

    /// The edges between what is covered and what is not.
    fn edge_of_covered(&mut self, setting: &Setting<'_>) -> Option<()> {
        let grid = &setting.ground.grid;
        let coverage = setting.coverage;
        for [column, row] in coverage.of_tile() {
            let start = |axis: usize, index: i64| grid.part_start(axis, index);
            let own = coverage.is_covered([column, row]);
            let (west, south) = (start(0, column), start(1, row));
            let (east, north) = (start(0, column + 1), start(1, row + 1));
            let corner = |place: Place| (place, setting.height(place));
            if column + 1 < grid.parts[0] && coverage.is_covered([column + 1, row]) != own {
                self.edge(corner([east, south]), corner([east, north]))?;
            }
            if row + 1 < grid.parts[1] && coverage.is_covered([column, row + 1]) != own {
                self.edge(corner([west, north]), corner([east, north]))?;
            }
        }
        Some(())
    }
}
