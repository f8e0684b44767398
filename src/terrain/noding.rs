//! Outlines that touch, made to meet in vertices and edges only.
//!
//! Footprints of neighbours share walls to the millimetre, not to the tenth of it, and some overlap. Vertices within
//! [`SNAP`] of each other become one, an edge is bent to a vertex within that distance of it, and where edges cross both get a
//! vertex. Vertices that near to the border of a tile move onto it. No vertex moves farther than that, and what comes out
//! depends on the outlines alone: every tile that a group reaches into gets the same.

use std::collections::HashMap;

use foldhash::fast::FixedState;

use super::grid::{Grid, Place, SNAP};
use super::outlines::{Outline, Vertex, crosses, off, turn};
use crate::geometry::Boxes;

/// So often edges are cut; each round bends them by no more than the tolerance, and two or three are usual.
const MOST_ROUNDS: usize = 16;

/// An edge of an outline.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Edge {
    /// Its ends.
    pub ends: [Place; 2],
    /// The heights of its outline there.
    pub z: [i64; 2],
    /// Which outline of the group.
    pub polygon: usize,
}

/// The edges of a group of outlines, which meet in their ends only.
pub(super) fn noded(outlines: &[Outline], grid: &Grid) -> Vec<Edge> {
    let anchors = Anchors::of(outlines, grid);
    let mut edges = Vec::new();
    for (polygon, outline) in outlines.iter().enumerate() {
        for ring in &outline.rings {
            for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                edges.push(Edge { ends: [anchors.of_vertex(a), anchors.of_vertex(b)], z: [a[2], b[2]], polygon });
            }
        }
    }
    edges.retain(|edge| edge.ends[0] != edge.ends[1]);
    for _ in 0..MOST_ROUNDS {
        let segments = segments(&edges);
        let mut cuts = near(&segments, grid);
        if cuts.is_empty() {
            cuts = crossings(&segments, grid);
        }
        if cuts.is_empty() {
            break;
        }
        edges = edges.into_iter().flat_map(|edge| cut(edge, &cuts, grid)).collect();
    }
    edges
}

/// The place that each vertex moves to.
struct Anchors<'a> {
    grid: &'a Grid,
    of_place: HashMap<Place, Place, FixedState>,
}

impl<'a> Anchors<'a> {
    fn of(outlines: &[Outline], grid: &'a Grid) -> Self {
        let vertices = outlines.iter().flat_map(|outline| outline.rings.iter().flatten());
        let mut places: Vec<(bool, Place)> = vertices.map(|v| on_line([v[0], v[1]], grid)).collect();
        // Those on the border of a tile stay; of all others the south-western ones.
        places.sort_unstable_by_key(|(is_on_line, place)| (!is_on_line, *place));
        places.dedup();
        let reach = grid.steps(SNAP);
        let square = |place: Place| [0, 1].map(|axis| place[axis].div_euclid(2 * reach[axis]));
        let mut known: HashMap<[i64; 2], Vec<Place>, FixedState> = HashMap::default();
        let mut of_place = HashMap::default();
        for (_, place) in places {
            let [column, row] = square(place);
            let around = (-1..=1).flat_map(|i| (-1..=1).map(move |j| [column + i, row + j]));
            let near = around.filter_map(|key| known.get(&key)).flatten();
            let near = near.map(|other| (grid.distance(place, *other), *other)).filter(|(d, _)| *d <= SNAP);
            let nearest = near.min_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
            if nearest.is_none() {
                known.entry(square(place)).or_default().push(place);
            }
            of_place.entry(place).or_insert(nearest.map_or(place, |(_, other)| other));
        }
        Self { grid, of_place }
    }

    fn of_vertex(&self, vertex: &Vertex) -> Place {
        let (_, place) = on_line([vertex[0], vertex[1]], self.grid);
        self.of_place.get(&place).copied().unwrap_or(place)
    }
}

/// A place that is moved onto the border of a tile where it is within [`SNAP`] of it, and whether it is on one.
fn on_line(place: Place, grid: &Grid) -> (bool, Place) {
    let mut is_on_line = false;
    let moved = [0, 1].map(|axis| {
        let side = grid.tile[axis];
        let line = (place[axis] + side / 2).div_euclid(side) * side;
        let is_near = (place[axis] - line).abs() as f64 * grid.step[axis] <= SNAP;
        is_on_line |= is_near;
        if is_near { line } else { place[axis] }
    });
    (is_on_line, moved)
}

/// The segments of all edges, each once with its smaller end first, in order.
fn segments(edges: &[Edge]) -> Vec<[Place; 2]> {
    let mut segments: Vec<[Place; 2]> = edges.iter().map(|edge| directed(edge.ends).0).collect();
    segments.sort_unstable();
    segments.dedup();
    segments
}

/// A segment with its smaller end first, and whether that is not how it came.
fn directed([a, b]: [Place; 2]) -> ([Place; 2], bool) {
    if a <= b { ([a, b], false) } else { ([b, a], true) }
}

/// Places at which segments are cut, by segment.
type Cuts = HashMap<[Place; 2], Vec<Place>, FixedState>;

/// The vertices that are within the tolerance of a segment of which they are no end.
fn near(segments: &[[Place; 2]], grid: &Grid) -> Cuts {
    let mut places: Vec<Place> = segments.iter().flatten().copied().collect();
    places.sort_unstable();
    places.dedup();
    let reach = grid.steps(SNAP);
    let boxes = Boxes::of_segments(segments.iter().copied(), reach[0].max(reach[1]));
    let points = Boxes::of_segments(places.iter().map(|p| [*p, *p]), 0);
    let mut cuts = Cuts::default();
    for (s, p) in boxes.meeting(&points) {
        let (segment, place) = (segments[s], places[p]);
        if !segment.contains(&place) && off(place, &segment, grid).0 <= SNAP {
            cuts.entry(segment).or_default().push(place);
        }
    }
    cuts
}

/// The places where segments cross.
fn crossings(segments: &[[Place; 2]], grid: &Grid) -> Cuts {
    let boxes = Boxes::of_segments(segments.iter().copied(), 0);
    let mut pairs: Vec<(usize, usize)> = boxes.meeting(&boxes).filter(|(a, b)| a < b).collect();
    pairs.sort_unstable();
    let mut cuts = Cuts::default();
    let mut made: Vec<Place> = Vec::new();
    for (a, b) in pairs {
        let (one, other) = (segments[a], segments[b]);
        if !crosses(&one, &other) {
            continue;
        }
        let place = crossing(one, other);
        // Two crossings at one place, as where a third edge runs through, are one.
        let ends = one.into_iter().chain(other);
        let known = made.iter().copied().chain(ends).find(|known| grid.distance(*known, place) <= SNAP);
        let place = known.unwrap_or(place);
        made.push(place);
        for segment in [one, other].into_iter().filter(|segment| !segment.contains(&place)) {
            cuts.entry(segment).or_default().push(place);
        }
    }
    cuts
}

/// The step nearest to where two segments cross.
fn crossing([a, b]: [Place; 2], [c, d]: [Place; 2]) -> Place {
    let (from, to) = (turn(c, d, a), turn(c, d, b));
    let whole = from - to;
    [0, 1].map(|axis| a[axis] + rounded(i128::from(b[axis] - a[axis]) * from, whole) as i64)
}

/// The whole number nearest to a fraction; halves go up, whatever the signs.
pub(super) fn rounded(numerator: i128, denominator: i128) -> i128 {
    let (n, d) = if denominator < 0 { (-numerator, -denominator) } else { (numerator, denominator) };
    (2 * n + d).div_euclid(2 * d.max(1))
}

/// An edge in the pieces between its cuts.
fn cut(edge: Edge, cuts: &Cuts, grid: &Grid) -> Vec<Edge> {
    let (segment, is_turned) = directed(edge.ends);
    let Some(places) = cuts.get(&segment) else { return vec![edge] };
    let z = if is_turned { [edge.z[1], edge.z[0]] } else { edge.z };
    let mut pieces = split(segment, z, places, grid);
    if is_turned {
        pieces.reverse();
        for (ends, z) in &mut pieces {
            ends.reverse();
            z.reverse();
        }
    }
    pieces.into_iter().map(|(ends, z)| Edge { ends, z, ..edge }).collect()
}

/// The pieces of a segment between places along it, with the heights there.
pub(super) fn split(segment: [Place; 2], z: [i64; 2], places: &[Place], grid: &Grid) -> Vec<([Place; 2], [i64; 2])> {
    let mut along: Vec<(f64, Place)> = places.iter().map(|p| (off(*p, &segment, grid).1, *p)).collect();
    along.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
    along.dedup_by_key(|(_, place)| *place);
    let height = |share: f64| z[0] + ((z[1] - z[0]) as f64 * share).round() as i64;
    let (mut last, mut pieces) = ((segment[0], z[0]), Vec::new());
    let ends = along.into_iter().map(|(share, place)| (place, height(share)));
    for (place, z) in ends.chain([(segment[1], z[1])]) {
        if place != last.0 {
            pieces.push(([last.0, place], [last.1, z]));
        }
        last = (place, z);
    }
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Random;
    use crate::terrain::TerrainOptions;
    use crate::terrain::outlines::Inside;

    fn outline(vertices: &[[i64; 2]], z: i64) -> Outline {
        Outline { inside: Inside::Hole, rings: vec![vertices.iter().map(|p| [p[0], p[1], z]).collect()] }
    }

    fn grid() -> Grid {
        Grid::new(&TerrainOptions::default(), [1.0; 3])
    }

    /// That edges meet in their ends only, and are no nearer elsewhere than the tolerance.
    fn assert_noded(edges: &[Edge]) {
        let all = segments(edges);
        for (i, a) in all.iter().enumerate() {
            for b in &all[..i] {
                assert!(!crosses(a, b), "{a:?} {b:?}");
                for (end, other) in a.iter().map(|p| (p, b)).chain(b.iter().map(|p| (p, a))) {
                    assert!(other.contains(end) || off(*end, other, &grid()).0 > SNAP, "{end:?} {other:?}");
                }
            }
        }
    }

    #[test]
    fn neighbours_that_share_a_wall_to_half_a_millimetre_share_it() {
        let one = outline(&[[10, 10], [100_010, 10], [100_010, 80_010], [10, 80_010]], 5);
        let other = outline(&[[100_014, 20_012], [180_000, 20_000], [180_000, 60_000], [100_007, 60_003]], 9);
        let edges = noded(&[one, other], &grid());
        assert_noded(&edges);
        let shared: Vec<&Edge> = edges.iter().filter(|e| e.ends.iter().all(|p| (p[0] - 100_010).abs() < 9)).collect();
        assert_eq!(shared.len(), 4, "three of the one and one of the other: {shared:?}");
        let twice = shared
            .iter()
            .filter(|a| shared.iter().any(|b| a.polygon != b.polygon && directed(a.ends).0 == directed(b.ends).0));
        assert_eq!(twice.count(), 2);
        assert!(edges.iter().all(|edge| edge.z == [5 + 4 * edge.polygon as i64; 2]));
    }

    #[test]
    fn vertices_beside_the_border_of_a_tile_move_onto_it() {
        let side = grid().tile[0];
        let edges = noded(&[outline(&[[side - 9, 50_000], [side + 90_000, 3], [side + 80_000, 90_000]], 0)], &grid());
        let places: Vec<Place> = edges.iter().map(|edge| edge.ends[0]).collect();
        assert_eq!(places, [[side, 50_000], [side + 90_000, 0], [side + 80_000, 90_000]]);
    }

    #[test]
    fn whatever_overlaps_is_cut() {
        for seed in 0..200 {
            let mut random = Random::new(seed);
            let outlines: Vec<Outline> = (0..6)
                .map(|_| {
                    let [x, y] = [0; 2].map(|_| random.below(300) as i64 * 1000);
                    let [w, h] = [0; 2].map(|_| 20_000 + random.below(9) as i64 * 10_000);
                    let mut near = |c: i64| c + random.below(19) as i64 - 9;
                    let corners = [[x, y], [x + w, y + h / 9], [x + w, y + h], [x - w / 7, y + h]];
                    outline(&corners.map(|p| p.map(&mut near)), 0)
                })
                .collect();
            let edges = noded(&outlines, &grid());
            assert_noded(&edges);
            // Every outline is closed still.
            for polygon in 0..outlines.len() {
                let own = || edges.iter().filter(|edge| edge.polygon == polygon);
                let mut starts: Vec<Place> = own().map(|edge| edge.ends[0]).collect();
                let mut ends: Vec<Place> = own().map(|edge| edge.ends[1]).collect();
                starts.sort_unstable();
                ends.sort_unstable();
                assert_eq!(starts, ends);
            }
        }
    }

    #[test]
    fn crossings_are_rounded_the_same_from_all_sides() {
        let (a, b, c, d) = ([-7, -3], [100, 41], [3, 60], [50, -11]);
        let expected = crossing([a, b], [c, d]);
        assert_eq!([crossing([b, a], [c, d]), crossing([c, d], [a, b]), crossing([d, c], [b, a])], [expected; 3]);
        assert_eq!((rounded(-1, 2), rounded(1, -2), rounded(3, 2), rounded(-5, 3)), (0, 0, 2, -2));
    }
}
