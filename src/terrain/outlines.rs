//! The outlines of all buildings on the ground, and which of them touch.

use super::grid::{Grid, Place, SNAP, STEPS_PER_UNIT};
use crate::building::{Building, Reason};
use crate::geometry::Boxes;
use crate::site::GroundSource;
use crate::solid::SurfaceType;

/// A vertex of an outline: its place and height in steps.
pub(super) type Vertex = [i64; 3];

/// What the terrain does inside an outline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Inside {
    /// Nothing: a solid stands there.
    Hole,
    /// It lies level at the height of the outline: nothing but a footprint was made of the building.
    Pad,
}

/// The outlines of the buildings of a run.
#[derive(Debug, Default)]
pub struct Outlines {
    polygons: Vec<Polygon>,
    /// Vertices of all rings from the origin of their polygon.
    vertices: Vec<[i32; 3]>,
    /// Where each ring ends in `vertices`.
    rings: Vec<usize>,
    /// Outlines that reach too far to be kept.
    left_out: usize,
}

#[derive(Debug)]
struct Polygon {
    inside: Inside,
    origin: Vertex,
    /// Where its rings end in `Outlines::rings`.
    end: usize,
    /// Smallest and largest place.
    extent: [Place; 2],
}

impl Outlines {
    /// Takes the outlines of a building: where its finest solids stand on the ground. Where there is none, the footprint, if
    /// the ground was seen around it and it is not known to be open ground itself.
    pub fn add(&mut self, building: &Building) {
        let origin = building.frame.origin.map(|c| c.round() as i64 * STEPS_PER_UNIT);
        let parts = building.model.parts.iter();
        let solids: Vec<_> =
            parts.filter_map(|part| part.lod22.as_ref().or(part.lod13.as_ref()).or(part.lod12.as_ref())).collect();
        for solid in &solids {
            for face in solid.faces.iter().filter(|face| solid.kind(face) == SurfaceType::Ground) {
                let vertex = |v: &u32| solid.vertices.get(*v as usize).copied().unwrap_or_default();
                let rings: Vec<Vec<Vertex>> = face.rings.iter().map(|ring| ring.iter().map(vertex).collect()).collect();
                self.polygon(Inside::Hole, origin, &rings);
            }
        }
        let is_seen = |source| matches!(source, GroundSource::GroundPoints | GroundSource::TerrainModel);
        let ground = building.measures.ground.as_ref();
        // Of open ground the points tell what it is like.
        let is_open = building.outcome.reason().is_some_and(|(reason, _)| reason == Reason::OpenGround);
        if solids.is_empty() && !is_open && ground.is_some_and(|ground| is_seen(ground.source)) {
            for polygon in &building.model.footprint {
                let vertex = |p: &[i64; 2]| [p[0], p[1], building.model.ground];
                let rings: Vec<Vec<Vertex>> = polygon.iter().map(|ring| ring.iter().map(vertex).collect()).collect();
                self.polygon(Inside::Pad, origin, &rings);
            }
        }
    }

    pub(super) fn polygon(&mut self, inside: Inside, origin: Vertex, rings: &[Vec<Vertex>]) {
        let small: Option<Vec<Vec<[i32; 3]>>> = rings.iter().map(|ring| ring.iter().map(narrow).collect()).collect();
        let places = || rings.iter().flatten().map(|v| [0, 1].map(|axis| origin[axis] + v[axis]));
        let (Some(small), Some(first)) = (small, places().next()) else {
            self.left_out += 1;
            return;
        };
        let extent = places().fold([first; 2], |[low, high], p| {
            [[low[0].min(p[0]), low[1].min(p[1])], [high[0].max(p[0]), high[1].max(p[1])]]
        });
        for ring in small {
            self.vertices.extend(ring);
            self.rings.push(self.vertices.len());
        }
        self.polygons.push(Polygon { inside, origin, end: self.rings.len(), extent });
    }

    fn rings(&self, polygon: usize) -> Vec<Vec<Vertex>> {
        let Some(found) = self.polygons.get(polygon) else { return Vec::new() };
        let first = polygon.checked_sub(1).map_or(0, |before| self.polygons[before].end);
        let ring = |ring: usize| {
            let start = ring.checked_sub(1).map_or(0, |before| self.rings[before]);
            let place = |v: &[i32; 3]| std::array::from_fn(|i| found.origin[i] + i64::from(v[i]));
            self.vertices[start..self.rings[ring]].iter().map(place).collect()
        };
        (first..found.end).map(ring).collect()
    }

    /// All outlines, with those that touch in groups.
    pub fn close(self, grid: &Grid) -> Grouped {
        let reach = grid.steps(SNAP);
        let margin = reach[0].max(reach[1]);
        let extents = self.polygons.iter().map(|polygon| polygon.extent);
        let boxes = Boxes::of_segments(extents, margin);
        let mut pairs: Vec<(usize, usize)> = boxes.meeting(&boxes).filter(|(a, b)| a < b).collect();
        pairs.sort_unstable();
        let mut set: Vec<usize> = (0..self.polygons.len()).collect();
        let mut sides: (usize, Vec<[Place; 2]>) = (usize::MAX, Vec::new());
        for (a, b) in pairs {
            let (first, second) = (root(&mut set, a), root(&mut set, b));
            if first == second {
                continue;
            }
            if sides.0 != a {
                sides = (a, edges(&self.rings(a)));
            }
            if touch(&sides.1, &edges(&self.rings(b)), grid) {
                set[first.max(second)] = first.min(second);
            }
        }
        let group: Vec<usize> = (0..set.len()).map(|i| root(&mut set, i)).collect();
        let mut members: Vec<usize> = (0..group.len()).collect();
        members.sort_by_key(|&i| (group[i], i));
        Grouped { outlines: self, boxes, group, members }
    }
}

/// Outlines that know with which others they touch.
pub struct Grouped {
    outlines: Outlines,
    boxes: Boxes,
    /// The first polygon of the group of each.
    group: Vec<usize>,
    /// All polygons in the order of their groups.
    members: Vec<usize>,
}

/// The rings of one polygon.
#[derive(Debug, Clone)]
pub(super) struct Outline {
    pub inside: Inside,
    pub rings: Vec<Vec<Vertex>>,
}

impl Grouped {
    /// Outlines that reach too far to be kept.
    pub fn left_out(&self) -> usize {
        self.outlines.left_out
    }

    /// The rectangles of all outlines.
    pub(super) fn extents(&self) -> impl Iterator<Item = [Place; 2]> + '_ {
        self.outlines.polygons.iter().map(|polygon| polygon.extent)
    }

    /// The groups of which an outline lies in a rectangle, each whole.
    pub(super) fn near(&self, [low, high]: [Place; 2]) -> Vec<Vec<Outline>> {
        let rectangle = [low, high].map(|place| place.map(|c| c as f64));
        let mut groups: Vec<usize> = self.boxes.at(rectangle).into_iter().map(|i| self.group[i]).collect();
        groups.sort_unstable();
        groups.dedup();
        let of_group = |group: &usize| {
            let first = self.members.partition_point(|&i| self.group[i] < *group);
            let own = self.members[first..].iter().take_while(|&&i| self.group[i] == *group);
            let outline =
                |&i: &usize| Outline { inside: self.outlines.polygons[i].inside, rings: self.outlines.rings(i) };
            own.map(outline).collect()
        };
        groups.iter().map(of_group).collect()
    }
}

fn narrow(vertex: &Vertex) -> Option<[i32; 3]> {
    let [x, y, z] = vertex.map(|c| i32::try_from(c).ok());
    Some([x?, y?, z?])
}

fn root(set: &mut [usize], mut i: usize) -> usize {
    while set[i] != i {
        set[i] = set[set[i]];
        i = set[i];
    }
    i
}

fn edges(rings: &[Vec<Vertex>]) -> Vec<[Place; 2]> {
    let flat = |v: &Vertex| [v[0], v[1]];
    let edges = rings.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
    edges.map(|(a, b)| [flat(a), flat(b)]).collect()
}

/// Whether an edge of one comes within the snap tolerance of an edge of the other.
fn touch(one: &[[Place; 2]], other: &[[Place; 2]], grid: &Grid) -> bool {
    let reach = grid.steps(SNAP);
    let boxes_meet = |a: &[Place; 2], b: &[Place; 2]| {
        (0..2).all(|axis| {
            let (low, high) = (a[0][axis].min(a[1][axis]), a[0][axis].max(a[1][axis]));
            let (from, to) = (b[0][axis].min(b[1][axis]), b[0][axis].max(b[1][axis]));
            low <= to + reach[axis] && from <= high + reach[axis]
        })
    };
    one.iter().any(|a| {
        other.iter().filter(|b| boxes_meet(a, b)).any(|b| {
            crosses(a, b)
                || a.iter().any(|end| off(*end, b, grid).0 <= 2.0 * SNAP)
                || b.iter().any(|end| off(*end, a, grid).0 <= 2.0 * SNAP)
        })
    })
}

/// Twice the area of a triangle, positive where it turns left.
pub(super) fn turn(a: Place, b: Place, c: Place) -> i128 {
    let d = |p: Place, axis: usize| i128::from(p[axis] - a[axis]);
    d(b, 0) * d(c, 1) - d(b, 1) * d(c, 0)
}

/// Whether two segments cross in a point that is an end of neither.
pub(super) fn crosses([a, b]: &[Place; 2], [c, d]: &[Place; 2]) -> bool {
    let opposite = |p: i128, q: i128| p.signum() * q.signum() < 0;
    opposite(turn(*a, *b, *c), turn(*a, *b, *d)) && opposite(turn(*c, *d, *a), turn(*c, *d, *b))
}

/// How far a place is from a segment, metres, and where the nearest point of it is: 0 at its beginning, 1 at its end.
pub(super) fn off(place: Place, [a, b]: &[Place; 2], grid: &Grid) -> (f64, f64) {
    let along = grid.metres([b[0] - a[0], b[1] - a[1]]);
    let from = grid.metres([place[0] - a[0], place[1] - a[1]]);
    let squared = along[0] * along[0] + along[1] * along[1];
    let share = if squared > 0.0 { ((from[0] * along[0] + from[1] * along[1]) / squared).clamp(0.0, 1.0) } else { 0.0 };
    ((from[0] - share * along[0]).hypot(from[1] - share * along[1]), share)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terrain::TerrainOptions;

    fn square(x: i64, y: i64, side: i64, z: i64) -> Vec<Vertex> {
        vec![[x, y, z], [x + side, y, z], [x + side, y + side, z], [x, y + side, z]]
    }

    #[test]
    fn those_that_touch_are_one_group_and_those_beside_each_other_are_not() {
        let grid = Grid::new(&TerrainOptions::default(), [1.0; 3]);
        let mut outlines = Outlines::default();
        let origin = [850_000_000, 4_470_000_000, 0];
        for (x, y) in [(0, 0), (100_005, 20_000), (300_000, 0), (200_100, 0)] {
            outlines.polygon(Inside::Hole, origin, &[square(x, y, 100_000, 12_345)]);
        }
        // In the middle of the first one, and turned so that the boxes meet but not the edges.
        outlines.polygon(Inside::Pad, origin, &[square(40_000, 40_000, 1000, 0)]);
        outlines.polygon(Inside::Pad, origin, &[vec![[i64::from(i32::MAX) + 1, 0, 0], [0, 1, 0], [0, 0, 0]]]);
        let grouped = outlines.close(&grid);
        assert_eq!(grouped.group, [0, 0, 2, 2, 4]);
        assert_eq!(grouped.left_out(), 1);
        let near = grouped.near([[850_150_000, 4_470_050_000], [850_160_000, 4_470_050_000]]);
        assert_eq!(near.iter().map(Vec::len).collect::<Vec<_>>(), [2]);
        assert_eq!(near[0][0].rings[0][2], [850_100_000, 4_470_100_000, 12_345]);
    }

    #[test]
    fn distances_end_at_the_ends() {
        let grid = Grid::new(&TerrainOptions::default(), [1.0; 3]);
        let edge = [[0, 0], [100_000, 0]];
        assert_eq!(off([50_000, 30_000], &edge, &grid), (3.0, 0.5));
        assert_eq!(off([140_000, 30_000], &edge, &grid), (5.0, 1.0));
        assert!(crosses(&edge, &[[5, -5], [5, 5]]) && !crosses(&edge, &[[5, 0], [5, 5]]));
    }
}
