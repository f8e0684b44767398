//! The surface of a tile: the triangles of the ground, and upright ones where neighbours' floors differ.
//!
//! The terrain is at one height at each place. Where the outlines of two buildings with different floors meet, it is at the
//! lower one; below the higher floor an upright triangle stands on the wall, from the edge of the terrain up to that floor. So the
//! terrain reaches every outline, and the model is closed.

use std::collections::HashMap;

use foldhash::fast::FixedState;
use spade::Triangulation;

use super::grid::{Place, SNAP};
use super::mesh::{Kind, Mesh};
use super::outlines::Inside;
use super::surroundings::Surroundings;

/// A surface of triangles, which look up or stand upright.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Surface {
    /// Vertices in steps from the corner of the tile.
    pub vertices: Vec<[i64; 3]>,
    /// Triangles, counter-clockwise seen from above.
    pub triangles: Vec<[u32; 3]>,
    /// How many of them stand upright.
    pub upright: usize,
    /// Vertices of outlines along the terrain that it does not reach.
    pub missed: usize,
}

impl Surface {
    /// The surface of a triangulation. `step` is the size of a step of height in metres.
    pub fn of(mesh: &Mesh, outlines: &Surroundings, step: f64) -> Self {
        let mut surface = Self::default();
        let mut known: HashMap<[i64; 3], u32, FixedState> = HashMap::default();
        let is_terrain = |kind: Kind| matches!(kind, Kind::Ground | Kind::Pad);
        for face in mesh.cdt.inner_faces().filter(|face| is_terrain(mesh.kinds[face.index()])) {
            let corners = face.vertices().map(|vertex| *vertex.data());
            let triangle = corners.map(|corner| [corner.place[0], corner.place[1], corner.z]);
            surface.add(triangle, &mut known);
        }
        for edge in mesh.cdt.directed_edges().filter(|edge| edge.is_constraint_edge()) {
            let kind = |face: spade::handles::FaceHandle<'_, spade::handles::PossiblyOuterTag, _, _, _, _>| {
                face.as_inner().map(|face| mesh.kinds[face.index()])
            };
            let (own, beyond) = (kind(edge.face()), kind(edge.rev().face()));
            if own.is_some_and(is_terrain) && beyond == Some(Kind::Hole) {
                let [a, b] = [edge.from(), edge.to()].map(|vertex| *vertex.data());
                let strip = strip(outlines, [(a.place, a.z), (b.place, b.z)], step);
                surface.upright += strip.triangles.len();
                surface.missed += strip.missed;
                strip.triangles.into_iter().for_each(|triangle| surface.add(triangle, &mut known));
            }
        }
        surface
    }

    fn add(&mut self, triangle: [[i64; 3]; 3], known: &mut HashMap<[i64; 3], u32, FixedState>) {
        let index = triangle.map(|vertex| {
            *known.entry(vertex).or_insert_with(|| {
                self.vertices.push(vertex);
                self.vertices.len() as u32 - 1
            })
        });
        self.triangles.push(index);
    }
}

/// The upright triangles on an edge of the terrain.
#[derive(Debug, Default)]
struct Strip {
    triangles: Vec<[[i64; 3]; 3]>,
    missed: usize,
}

/// The triangles between an edge of the terrain, which lies to its left, and the floors of the buildings to its right.
fn strip(outlines: &Surroundings, [(a, low_a), (b, low_b)]: [(Place, i64); 2], step: f64) -> Strip {
    let holes = outlines.between([a, b]).filter(|edge| outlines.kind(edge) == Inside::Hole);
    let mut floors: Vec<[i64; 2]> =
        holes.map(|edge| if edge.ends == [a, b] { edge.z } else { [edge.z[1], edge.z[0]] }).collect();
    floors.sort_unstable();
    let mut strip = Strip::default();
    let levels = [(a, low_a), (b, low_b)].map(|(place, low)| levels(outlines.heights(place), low, step));
    let mut base = [0, 0];
    if floors.is_empty() {
        // Where an outline could not be kept because it crosses another: nothing tells the floor.
        strip.missed = 1;
    }
    for floor in floors {
        let top = [0, 1].map(|side| level_of(&levels[side], floor[side]));
        if top[0] < base[0] || top[1] < base[1] {
            strip.missed += 1;
            continue;
        }
        let at = |side: usize, level: usize| {
            let place = [a, b][side];
            [place[0], place[1], levels[side][level]]
        };
        // Up on both sides, in turns.
        while base != top {
            let side = usize::from(base[0] == top[0] || (base[1] < top[1] && base[1] < base[0]));
            let mut higher = base;
            higher[side] += 1;
            strip.triangles.push([at(1, base[1]), at(0, base[0]), at(side, higher[side])]);
            base = higher;
        }
    }
    strip
}

/// The heights at a place from that of the terrain up, those no farther apart than what every validator takes for one place
/// being one.
fn levels(heights: &[i64], low: i64, step: f64) -> Vec<i64> {
    let mut levels = vec![low];
    for &height in heights {
        if levels.last().is_some_and(|last| (height - last) as f64 * step > SNAP) {
            levels.push(height);
        }
    }
    levels
}

/// The level at which a floor is: the highest that is not above it.
fn level_of(levels: &[i64], floor: i64) -> usize {
    levels.partition_point(|level| *level <= floor).saturating_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_closer_than_a_millimetre_are_one() {
        let heights = levels(&[100, 105, 111, 4000], 100, 1e-4);
        assert_eq!(heights, [100, 111, 4000]);
        assert_eq!([100, 105, 111, 3999, 4000].map(|floor| level_of(&heights, floor)), [0, 0, 1, 1, 2]);
    }
}
