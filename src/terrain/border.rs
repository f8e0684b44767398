//! The border of a tile, which it shares with its neighbours vertex by vertex.
//!
//! Both tiles find the same vertices from the same ground points: corners, crossings of outlines, ends of what is covered, and
//! between them as many as the ground needs. So there is no gap, whichever is made first, and by whom.

use std::collections::BTreeMap;

use super::coverage::Coverage;
use super::grid::Place;
use super::ground::{Ground, is_too_steep};
use super::surroundings::Surroundings;

/// Vertices that the ground needs keep this distance from those that are there anyway, metres.
const APART: f64 = 0.25;

/// What a tile knows of its place.
pub(super) struct Setting<'a> {
    pub ground: &'a Ground,
    pub outlines: &'a Surroundings,
    pub coverage: &'a Coverage,
    /// How far the terrain may be off, in steps of height.
    pub tolerance: f64,
    /// How far points count for the height of a place, metres.
    pub reach: f64,
}

impl Setting<'_> {
    /// The height of the terrain at a place that has no ground point of its own: that of outlines there, of the ground points
    /// around, or of the nearest outline.
    pub fn height(&self, place: Place) -> i64 {
        let of_outline = || {
            let near = self.outlines.near(place, self.reach);
            near.min_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.total_cmp(&b.1))).map(|(_, z)| z)
        };
        let found = || self.ground.height(place, self.reach).or_else(of_outline).unwrap_or_default();
        self.outlines.height(place).unwrap_or_else(|| found().round() as i64)
    }
}

/// The vertices along the border of a tile with their heights, side by side: south, north, west, east.
pub(super) fn sides(setting: &Setting<'_>) -> [Vec<(Place, i64)>; 4] {
    let tile = setting.ground.grid.tile;
    [(1, 0), (1, tile[1]), (0, 0), (0, tile[0])].map(|(axis, line)| side(setting, axis, line))
}

/// The vertices of the side at `line` along `axis`.
fn side(setting: &Setting<'_>, axis: usize, line: i64) -> Vec<(Place, i64)> {
    let Setting { ground, outlines, coverage, .. } = setting;
    let grid = &ground.grid;
    let other = 1 - axis;
    let length = grid.tile[other];
    let place = |at: i64| if axis == 0 { [line, at] } else { [at, line] };
    let mut fast: BTreeMap<i64, i64> = BTreeMap::new();
    let on_side = |p: &Place| p[axis] == line && (0..=length).contains(&p[other]);
    for vertex in outlines.vertices().into_iter().filter(on_side) {
        fast.insert(vertex[other], setting.height(vertex));
    }
    for at in [0, length] {
        fast.entry(at).or_insert_with(|| setting.height(place(at)));
    }
    // What is covered on either side of the border, part by part.
    let part = |index: i64, side: i64| {
        let across = if line == 0 { side } else { grid.parts[axis] + side };
        if axis == 0 { [across, index] } else { [index, across] }
    };
    let both = |index: i64| [-1, 0].map(|side| coverage.is_covered(part(index, side)));
    for index in 1..grid.parts[other] {
        if both(index - 1) != both(index) {
            let at = grid.part_start(other, index);
            fast.entry(at).or_insert_with(|| setting.height(place(at)));
        }
    }
    let known: Vec<(i64, i64)> = fast.iter().map(|(at, z)| (*at, *z)).collect();
    let mut all = Vec::new();
    for pair in known.windows(2) {
        let [(a, low), (b, high)] = [pair[0], pair[1]];
        all.push((place(a), low));
        let twice_middle = if axis == 0 { [2 * line, a + b] } else { [a + b, 2 * line] };
        let index = grid.part_of(place(i64::midpoint(a, b)))[other];
        let is_edge = outlines.between([place(a), place(b)]).next().is_some();
        let is_free = !is_edge && outlines.inside(twice_middle, 2).is_none() && both(index).contains(&true);
        if is_free {
            all.extend(profile(setting, &place, (axis, [a, b]), [low, high]));
        }
    }
    all.extend(known.last().map(|(at, z)| (place(*at), *z)));
    all
}

/// The vertices that the ground needs between two along a side: the farthest off first, until none is off by more than the
/// tolerance.
fn profile(
    setting: &Setting<'_>,
    place: &dyn Fn(i64) -> Place,
    (axis, [a, b]): (usize, [i64; 2]),
    [low, high]: [i64; 2],
) -> Vec<(Place, i64)> {
    let grid = &setting.ground.grid;
    let other = 1 - axis;
    let (step, apart) = (grid.sample[other], grid.steps(APART)[other]);
    let mut heights = Vec::new();
    let mut at = (a + apart + step - 1).div_euclid(step) * step;
    while at <= b - apart {
        if let Some(z) = setting.ground.height(place(at), setting.reach)
            && !is_too_steep(setting.outlines, place(at), z, grid)
        {
            heights.push((at, z.round()));
        }
        at += step;
    }
    let mut chosen = BTreeMap::from([(a, low as f64), (b, high as f64)]);
    let mut spans = vec![(a, b, 0, heights.len())];
    while let Some((from, to, first, end)) = spans.pop() {
        let (start, rise) = (chosen[&from], chosen[&to] - chosen[&from]);
        let off = |(at, z): &(i64, f64)| (z - (start + rise * (at - from) as f64 / (to - from) as f64)).abs();
        let worst = (first..end).map(|i| (off(&heights[i]), i)).max_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
        let Some((_, i)) = worst.filter(|(off, _)| *off > setting.tolerance) else { continue };
        let (at, z) = heights[i];
        chosen.insert(at, z);
        spans.extend([(from, at, first, i), (at, to, i + 1, end)]);
    }
    chosen.into_iter().filter(|(at, _)| *at != a && *at != b).map(|(at, z)| (place(at), z as i64)).collect()
}
