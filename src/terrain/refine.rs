//! Refining the triangulation until it fits the ground points (Garland and Heckbert 1995, greedy insertion): the point that is
//! farthest off becomes a vertex, until none is off by more than the tolerance.

use std::cmp::Ordering;
use std::collections::{BinaryHeap, HashMap};

use foldhash::fast::FixedState;
use spade::Triangulation;
use spade::handles::{FixedFaceHandle, FixedVertexHandle, InnerTag};

use super::border::Setting;
use super::grid::Place;
use super::ground::{Ground, State};
use super::mesh::{Corner, Kind, Mesh};
use super::outlines::off;

/// Vertices keep this distance from each other, metres …
const APART: f64 = 0.02;
/// … and from the outlines, the border and the edge of what is covered.
const ASIDE: f64 = 0.01;

/// How well a tile fits its ground points.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Fit {
    /// Ground points over the terrain, those left out in the collar of outlines not among them.
    pub points: u64,
    /// Sum of squares of how far they are off, square metres.
    pub squares: f64,
    /// How far the farthest is off, metres.
    pub largest: f64,
}

/// A triangle whose farthest point is off by more than the tolerance.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Waiting {
    off: f64,
    sample: usize,
    face: FixedFaceHandle<InnerTag>,
    version: u32,
}

impl Eq for Waiting {}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Waiting {
    fn cmp(&self, other: &Self) -> Ordering {
        let rest = |waiting: &Self| (waiting.sample, waiting.face.index(), waiting.version);
        self.off.total_cmp(&other.off).then_with(|| rest(other).cmp(&rest(self)))
    }
}

/// Refines the ground of a tile; `states` says which ground points may become vertices.
pub(super) fn refine(mesh: &mut Mesh, setting: &Setting<'_>, states: &mut [State]) -> Fit {
    let mut refiner = Refiner {
        ground: setting.ground,
        tolerance: setting.tolerance,
        versions: vec![0; mesh.kinds.len()],
        queue: BinaryHeap::new(),
        near: Near::of(mesh, setting.ground),
        states,
    };
    let faces: Vec<FixedFaceHandle<InnerTag>> = mesh.cdt.inner_faces().map(|face| face.fix()).collect();
    for face in &faces {
        refiner.look(mesh, *face);
    }
    while let Some(waiting) = refiner.queue.pop() {
        if refiner.versions[waiting.face.index()] == waiting.version {
            refiner.insert(mesh, waiting);
        }
    }
    fit(mesh, setting.ground, refiner.states)
}

struct Refiner<'a> {
    ground: &'a Ground,
    tolerance: f64,
    /// How often each triangle has changed, by the index of its face.
    versions: Vec<u32>,
    queue: BinaryHeap<Waiting>,
    near: Near,
    states: &'a mut [State],
}

impl Refiner<'_> {
    /// Puts a triangle in the queue if a point of it is off by more than the tolerance.
    fn look(&mut self, mesh: &Mesh, face: FixedFaceHandle<InnerTag>) {
        if mesh.kinds[face.index()] != Kind::Ground {
            return;
        }
        let plane = Plane::of(mesh.corners(face));
        let mut worst: Option<(f64, usize)> = None;
        each_point(self.ground, &plane, |sample, place, z| {
            if self.states[sample] == State::Free {
                let off = (z as f64 - plane.height(place)).abs();
                if off > self.tolerance && worst.is_none_or(|(most, _)| off > most) {
                    worst = Some((off, sample));
                }
            }
        });
        if let Some((off, sample)) = worst {
            self.queue.push(Waiting { off, sample, face, version: self.versions[face.index()] });
        }
    }

    /// Makes the farthest point of a triangle a vertex, or leaves it out where there is no room for one.
    fn insert(&mut self, mesh: &mut Mesh, waiting: Waiting) {
        let Some((place, z)) = self.ground.point(waiting.sample) else { return };
        let hint = mesh.cdt.face(waiting.face).vertices()[0].fix();
        let has_room = self.near.is_free(place, self.ground) && self.is_aside(mesh, waiting.face, place);
        let inserted = if has_room { mesh.cdt.insert_with_hint(Corner { place, z }, hint).ok() } else { None };
        let Some(vertex) = inserted else {
            self.states[waiting.sample] = State::Crowded;
            self.look(mesh, waiting.face);
            return;
        };
        self.states[waiting.sample] = State::Vertex;
        self.near.add(place, self.ground);
        // Every triangle that changed has the new vertex for a corner.
        mesh.kinds.resize(mesh.cdt.num_all_faces(), Kind::Ground);
        self.versions.resize(mesh.cdt.num_all_faces(), 0);
        for face in around(mesh, vertex) {
            mesh.kinds[face.index()] = Kind::Ground;
            self.versions[face.index()] += 1;
            self.look(mesh, face);
        }
    }

    /// Whether a place in a triangle is far enough from those of its sides that must stay.
    fn is_aside(&self, mesh: &Mesh, face: FixedFaceHandle<InnerTag>, place: Place) -> bool {
        mesh.cdt.face(face).adjacent_edges().iter().filter(|edge| edge.is_constraint_edge()).all(|edge| {
            let ends = [edge.from().data().place, edge.to().data().place];
            off(place, &ends, &self.ground.grid).0 >= ASIDE
        })
    }
}

/// The triangles around a vertex.
fn around(mesh: &Mesh, vertex: FixedVertexHandle) -> Vec<FixedFaceHandle<InnerTag>> {
    let edges = mesh.cdt.vertex(vertex).out_edges();
    edges.filter_map(|edge| edge.face().as_inner().map(|face| face.fix())).collect()
}

/// A triangle and the plane through it.
struct Plane {
    corners: [Corner; 3],
    /// Rise per step along x and y.
    slope: [f64; 2],
}

impl Plane {
    fn of(corners: [Corner; 3]) -> Self {
        let [a, b, c] = corners;
        let from = |p: Corner| [(p.place[0] - a.place[0]) as f64, (p.place[1] - a.place[1]) as f64, (p.z - a.z) as f64];
        let (u, v) = (from(b), from(c));
        let area = u[0] * v[1] - u[1] * v[0];
        Self { corners, slope: [(u[2] * v[1] - v[2] * u[1]) / area, (u[0] * v[2] - v[0] * u[2]) / area] }
    }

    fn height(&self, place: Place) -> f64 {
        let [a, ..] = self.corners;
        let along = |axis: usize| (place[axis] - a.place[axis]) as f64 * self.slope[axis];
        a.z as f64 + along(0) + along(1)
    }

    fn holds(&self, p: Place) -> bool {
        let [a, b, c] = self.corners.map(|corner| corner.place);
        let left = |a: Place, b: Place| (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) >= 0;
        left(a, b) && left(b, c) && left(c, a)
    }

    /// The smallest and largest x of the triangle between two y.
    fn span(&self, low: i64, high: i64) -> Option<[i64; 2]> {
        let mut span: Option<[f64; 2]> = None;
        let mut take = |x: f64| span = Some(span.map_or([x; 2], |[a, b]| [a.min(x), b.max(x)]));
        for i in 0..3 {
            let (p, q) = (self.corners[i].place, self.corners[(i + 1) % 3].place);
            if (low..=high).contains(&p[1]) {
                take(p[0] as f64);
            }
            for line in [low, high] {
                if (p[1] - line).signum() * (q[1] - line).signum() < 0 {
                    take(p[0] as f64 + (q[0] - p[0]) as f64 * (line - p[1]) as f64 / (q[1] - p[1]) as f64);
                }
            }
        }
        span.map(|[a, b]| [a.floor() as i64, b.ceil() as i64])
    }
}

/// Calls `visit` with each ground point in a triangle: its number, place and height.
fn each_point(ground: &Ground, plane: &Plane, mut visit: impl FnMut(usize, Place, i64)) {
    let ys = plane.corners.map(|corner| corner.place[1]);
    let (low, high) = (ys.into_iter().min().unwrap_or_default(), ys.into_iter().max().unwrap_or_default());
    for row in ground.row_of(low)..=ground.row_of(high) {
        let Some([from, to]) = plane.span(ground.row_start(row), ground.row_start(row + 1)) else { continue };
        for sample in ground.row(row, from, to) {
            if let Some((place, z)) = ground.point(sample).filter(|(place, _)| plane.holds(*place)) {
                visit(sample, place, z);
            }
        }
    }
}

/// How well the triangulation fits the points that may be vertices of it, or are.
fn fit(mesh: &Mesh, ground: &Ground, states: &[State]) -> Fit {
    let mut fit = Fit::default();
    // A point on an edge is one of both triangles: it counts once.
    let mut is_counted = vec![false; states.len()];
    for face in mesh.cdt.inner_faces().filter(|face| mesh.kinds[face.index()] == Kind::Ground) {
        let plane = Plane::of(mesh.corners(face.fix()));
        each_point(ground, &plane, |sample, place, z| {
            let counts = matches!(states[sample], State::Free | State::Vertex | State::Crowded);
            if counts && !std::mem::replace(&mut is_counted[sample], true) {
                let off = (z as f64 - plane.height(place)).abs() * ground.grid.step[2];
                fit.points += 1;
                fit.squares += off * off;
                fit.largest = fit.largest.max(off);
            }
        });
    }
    fit
}

/// The vertices by the cells of the ground points.
struct Near(HashMap<[i64; 2], Vec<Place>, FixedState>);

impl Near {
    fn of(mesh: &Mesh, ground: &Ground) -> Self {
        let mut near = Self(HashMap::default());
        mesh.cdt.vertices().for_each(|vertex| near.add(vertex.data().place, ground));
        near
    }

    fn add(&mut self, place: Place, ground: &Ground) {
        self.0.entry(ground.grid.cell(place)).or_default().push(place);
    }

    /// Whether no vertex is too near to a place.
    fn is_free(&self, place: Place, ground: &Ground) -> bool {
        let [column, row] = ground.grid.cell(place);
        let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [column + i, row + j]));
        let mut vertices = around.filter_map(|cell| self.0.get(&cell)).flatten();
        vertices.all(|other| ground.grid.distance(place, *other) >= APART)
    }
}
