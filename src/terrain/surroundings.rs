//! The outlines in and around one tile, cut at its border.
//!
//! Places are counted from the south-western corner of the tile from here on.

use std::collections::{BTreeMap, HashMap};

use foldhash::fast::FixedState;
use rstar::primitives::{GeomWithData, Line};
use rstar::{AABB, RTree};

use super::grid::{Grid, Place, SNAP, TileKey};
use super::noding::{Edge, noded, rounded, split};
use super::outlines::{Grouped, Inside, Outline, off};

/// The outlines in and around a tile.
pub(super) struct Surroundings {
    /// The edges, which meet in their ends only and do not cross the border of the tile.
    pub edges: Vec<Edge>,
    outlines: Vec<Extents>,
    /// The heights that outlines have at each of their vertices, ascending.
    heights: HashMap<Place, Vec<i64>, FixedState>,
    tree: RTree<GeomWithData<Line<[f64; 2]>, usize>>,
    /// The edges between two places, the smaller one first.
    by_ends: HashMap<[Place; 2], Vec<usize>, FixedState>,
    grid: Grid,
}

/// An outline as far as it must be known to tell what is inside.
struct Extents {
    inside: Inside,
    /// Its edges among all.
    first: usize,
    end: usize,
    low: Place,
    high: Place,
}

impl Surroundings {
    /// The outlines that count for a tile.
    pub fn of(outlines: &Grouped, grid: &Grid, key: TileKey) -> Self {
        let corner = grid.corner(key);
        let low = [0, 1].map(|axis| corner[axis] - grid.margin[axis]);
        let high = [0, 1].map(|axis| corner[axis] + grid.tile[axis] + grid.margin[axis]);
        let mut all = Vec::new();
        let mut edges = Vec::new();
        let mut heights = HashMap::default();
        for group in outlines.near([low, high]) {
            let local = |edge: Edge| Edge { ends: edge.ends.map(|p| [p[0] - corner[0], p[1] - corner[1]]), ..edge };
            let own: Vec<Edge> = noded(&group, grid).into_iter().map(local).collect();
            // The terrain at a vertex is the same for all tiles: it is told before they cut anything.
            gather_heights(&own, &mut heights);
            add_group(&group, own, (&mut all, &mut edges));
        }
        Self::cut_at_border(all, &edges, heights, grid)
    }

    fn cut_at_border(
        mut outlines: Vec<Extents>,
        edges: &[Edge],
        mut heights: HashMap<Place, Vec<i64>, FixedState>,
        grid: &Grid,
    ) -> Self {
        let cuts = cuts(edges, &heights, grid);
        let mut pieces = Vec::with_capacity(edges.len());
        let mut starts = Vec::with_capacity(edges.len() + 1);
        for edge in edges {
            starts.push(pieces.len());
            let Some(places) = cuts.get(&edge.ends) else {
                pieces.push(*edge);
                continue;
            };
            // From the smaller end, so that both tiles round alike.
            let is_turned = edge.ends[0] > edge.ends[1];
            let turned = |[a, b]: [Place; 2]| if is_turned { [b, a] } else { [a, b] };
            let terrain =
                edge.ends.map(|end| heights.get(&end).and_then(|all| all.first()).copied().unwrap_or_default());
            let flip = |z: [i64; 2]| if is_turned { [z[1], z[0]] } else { z };
            for (ends, [z, _]) in split(turned(edge.ends), flip(terrain), places, grid).into_iter().skip(1) {
                heights.entry(ends[0]).or_default().push(z);
            }
            let own = split(turned(edge.ends), flip(edge.z), places, grid);
            pieces.extend(own.into_iter().map(|(ends, z)| Edge { ends: turned(ends), z: flip(z), ..*edge }));
        }
        starts.push(pieces.len());
        for piece in &pieces {
            for (end, z) in piece.ends.iter().zip(piece.z) {
                heights.entry(*end).or_default().push(z);
            }
        }
        for all in heights.values_mut() {
            all.sort_unstable();
            all.dedup();
        }
        for outline in &mut outlines {
            (outline.first, outline.end) = (starts[outline.first], starts[outline.end]);
        }
        let line = |edge: &Edge| Line::new(edge.ends[0].map(|c| c as f64), edge.ends[1].map(|c| c as f64));
        let tree =
            RTree::bulk_load(pieces.iter().map(line).zip(0..).map(|(line, i)| GeomWithData::new(line, i)).collect());
        let mut by_ends: HashMap<[Place; 2], Vec<usize>, FixedState> = HashMap::default();
        for (piece, i) in pieces.iter().zip(0..) {
            by_ends.entry(ascending(piece.ends)).or_default().push(i);
        }
        Self { edges: pieces, outlines, heights, tree, by_ends, grid: *grid }
    }

    /// The edges between two places, whichever way they run.
    pub fn between(&self, ends: [Place; 2]) -> impl Iterator<Item = &Edge> {
        let found = self.by_ends.get(&ascending(ends)).into_iter().flatten();
        found.filter_map(|i| self.edges.get(*i))
    }

    /// The height of the terrain at a vertex of an outline: the lowest of those that meet there.
    pub fn height(&self, vertex: Place) -> Option<i64> {
        self.heights.get(&vertex).and_then(|all| all.first()).copied()
    }

    /// The heights of all outlines that meet at a vertex, ascending.
    pub fn heights(&self, vertex: Place) -> &[i64] {
        self.heights.get(&vertex).map_or(&[], Vec::as_slice)
    }

    /// The vertices of outlines, in order.
    pub fn vertices(&self) -> Vec<Place> {
        let mut vertices: Vec<Place> = self.heights.keys().copied().collect();
        vertices.sort_unstable();
        vertices
    }

    /// What the outlines say of a place, which is given in parts of a step so that the middle of a triangle is exact; a hole
    /// goes before a pad.
    pub fn inside(&self, numerator: Place, denominator: i64) -> Option<Inside> {
        let mut found = None;
        for outline in &self.outlines {
            let is_apart = (0..2).any(|axis| {
                numerator[axis] < outline.low[axis] * denominator || numerator[axis] > outline.high[axis] * denominator
            });
            if is_apart || found == Some(outline.inside) {
                continue;
            }
            let crossed =
                self.edges[outline.first..outline.end].iter().filter(|e| is_right_of(e, numerator, denominator));
            if crossed.count() % 2 == 1 {
                found = Some(outline.inside);
                if outline.inside == Inside::Hole {
                    break;
                }
            }
        }
        found
    }

    /// The edges within so many metres of a place, with the distance and the height of the terrain at the nearest point.
    pub fn near(&self, place: Place, metres: f64) -> impl Iterator<Item = (f64, f64)> + '_ {
        let reach = self.grid.steps(metres);
        let envelope = AABB::from_corners(
            [0, 1].map(|axis| (place[axis] - reach[axis]) as f64),
            [0, 1].map(|axis| (place[axis] + reach[axis]) as f64),
        );
        let found = self.tree.locate_in_envelope_intersecting(&envelope);
        found.filter_map(move |line| {
            let edge = &self.edges[line.data];
            let (distance, share) = off(place, &edge.ends, &self.grid);
            let z = edge.ends.map(|end| self.height(end).unwrap_or_default() as f64);
            (distance <= metres).then_some((distance, z[0] + share * (z[1] - z[0])))
        })
    }

    /// What the outline of an edge has inside.
    pub fn kind(&self, edge: &Edge) -> Inside {
        self.outlines.get(edge.polygon).map_or(Inside::Pad, |outline| outline.inside)
    }
}

fn ascending([a, b]: [Place; 2]) -> [Place; 2] {
    if a <= b { [a, b] } else { [b, a] }
}

/// Notes the heights of outlines at their vertices.
fn gather_heights(edges: &[Edge], heights: &mut HashMap<Place, Vec<i64>, FixedState>) {
    for edge in edges {
        for (end, z) in edge.ends.iter().zip(edge.z) {
            let known: &mut Vec<i64> = heights.entry(*end).or_default();
            if let Err(at) = known.binary_search(&z) {
                known.insert(at, z);
            }
        }
    }
}

/// Adds the outlines of a group, each with its own edges one behind the other.
fn add_group(group: &[Outline], mut own: Vec<Edge>, (all, edges): (&mut Vec<Extents>, &mut Vec<Edge>)) {
    own.sort_by_key(|edge| edge.polygon);
    let base = all.len();
    for (polygon, outline) in group.iter().enumerate() {
        let of_outline =
            own.iter().filter(|edge| edge.polygon == polygon).map(|edge| Edge { polygon: base + polygon, ..*edge });
        let first = edges.len();
        edges.extend(of_outline);
        let places = || edges[first..].iter().flat_map(|edge| edge.ends);
        let start = places().next().unwrap_or_default();
        let low = places().fold(start, |low, p| [low[0].min(p[0]), low[1].min(p[1])]);
        let high = places().fold(start, |high, p| [high[0].max(p[0]), high[1].max(p[1])]);
        all.push(Extents { inside: outline.inside, first, end: edges.len(), low, high });
    }
}

/// Where the border of the tile cuts edges. Places on it that are within [`SNAP`] of each other become one, as where two edges
/// leave a vertex beside it.
fn cuts(
    edges: &[Edge],
    vertices: &HashMap<Place, Vec<i64>, FixedState>,
    grid: &Grid,
) -> HashMap<[Place; 2], Vec<Place>, FixedState> {
    let mut cuts: HashMap<[Place; 2], Vec<Place>, FixedState> = HashMap::default();
    for (axis, line) in [(0, 0), (0, grid.tile[0]), (1, 0), (1, grid.tile[1])] {
        let other = 1 - axis;
        let reach = grid.steps(SNAP)[other];
        let on_border =
            |place: Place| place[axis] == line && (-reach..=grid.tile[other] + reach).contains(&place[other]);
        // Places along the line, and whether something else than a cut is there: that stays.
        let mut known: BTreeMap<i64, bool> = BTreeMap::from([(0, true), (grid.tile[other], true)]);
        known.extend(vertices.keys().filter(|place| on_border(**place)).map(|place| (place[other], true)));
        let mut found = Vec::new();
        for edge in edges {
            let [a, b] = edge.ends;
            if (a[axis] - line).signum() * (b[axis] - line).signum() >= 0 {
                continue;
            }
            let run = i128::from(b[axis] - a[axis]);
            let rise = i128::from(b[other] - a[other]) * i128::from(line - a[axis]);
            let at = a[other] + rounded(rise, run) as i64;
            if (-reach..=grid.tile[other] + reach).contains(&at) {
                found.push((at, edge.ends));
            }
        }
        found.sort_unstable();
        for (at, ends) in found {
            let near =
                known.range(at - reach..=at + reach).min_by_key(|(place, is_fast)| (!**is_fast, (**place - at).abs()));
            let at = near.map_or(at, |(place, _)| *place);
            known.entry(at).or_insert(false);
            let place = if axis == 0 { [line, at] } else { [at, line] };
            if !ends.contains(&place) {
                cuts.entry(ends).or_default().push(place);
            }
        }
    }
    cuts
}

/// Whether a ray to the east from a place crosses an edge; a vertex belongs to what is above it.
fn is_right_of(edge: &Edge, numerator: Place, denominator: i64) -> bool {
    let [a, b] = edge.ends.map(|end| end.map(|c| i128::from(c) * i128::from(denominator)));
    let [x, y] = numerator.map(i128::from);
    if (a[1] > y) == (b[1] > y) {
        return false;
    }
    let side = (b[0] - a[0]) * (y - a[1]) - (x - a[0]) * (b[1] - a[1]);
    (side > 0) == (b[1] > a[1])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::terrain::TerrainOptions;
    use crate::terrain::outlines::Outlines;

    fn grid() -> Grid {
        Grid::new(&TerrainOptions::default(), [1.0; 3])
    }

    /// Outlines with heights, as they are found in a tile.
    fn around(outlines: &[(Inside, &[[i64; 3]])], key: TileKey) -> Surroundings {
        let mut all = Outlines::default();
        for (inside, ring) in outlines {
            all.polygon(*inside, [0; 3], &[ring.to_vec()]);
        }
        Surroundings::of(&all.close(&grid()), &grid(), key)
    }

    #[test]
    fn both_tiles_cut_a_building_on_their_border_alike() {
        let side = grid().tile[0];
        let ring = [[side - 70_001, 30_003, 11], [side + 50_007, 90_011, 47], [side - 20_000, 170_001, 11]];
        let [west, east] = [[0, 0], [1, 0]].map(|key| around(&[(Inside::Hole, &ring)], key));
        let on_border = |tile: &Surroundings, line: i64| -> Vec<(i64, Vec<i64>)> {
            let places = tile.vertices().into_iter().filter(|place| place[0] == line);
            places.map(|place| (place[1], tile.heights(place).to_vec())).collect()
        };
        let found = on_border(&west, side);
        assert_eq!((found.len(), found == on_border(&east, 0)), (2, true));
        assert_eq!(found[0].0, 30_003 + ((90_011.0 - 30_003.0) * 70_001.0_f64 / 120_008.0).round() as i64);
        assert_eq!(west.edges.len(), 5);
        for (tile, place, expected) in [
            (&west, [side - 1000, 100_000], Some(Inside::Hole)),
            (&east, [1000, 100_000], Some(Inside::Hole)),
            (&east, [40_000, 40_000], None),
        ] {
            assert_eq!(tile.inside(place, 1), expected);
            assert_eq!(tile.inside(place.map(|c| 3 * c), 3), expected);
        }
    }

    #[test]
    fn the_terrain_is_at_the_lower_of_two_floors_and_a_hole_goes_before_a_pad() {
        let pad = [[0, 0, 7], [100_000, 0, 7], [100_000, 100_000, 7], [0, 100_000, 7]];
        let hole = [[100_000, 0, 3], [200_000, 0, 3], [200_000, 50_000, 3], [60_000, 50_000, 3], [60_000, 20_000, 3]];
        let tile = around(&[(Inside::Pad, &pad), (Inside::Hole, &hole)], [0, 0]);
        assert_eq!((tile.height([100_000, 0]), tile.heights([100_000, 0])), (Some(3), &[3, 7][..]));
        assert_eq!(tile.inside([70_000, 40_000], 1), Some(Inside::Hole));
        assert_eq!(tile.inside([10_000, 40_000], 1), Some(Inside::Pad));
        let near: Vec<f64> = tile.near([-10_000, 50_000], 1.5).map(|(distance, _)| distance).collect();
        assert_eq!(near, [1.0]);
    }
}
