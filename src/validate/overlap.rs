//! How deep two solids overlap.
//!
//! Both are closed and sound. The plan of what their boxes have in common is cut into slabs between the corners and
//! crossings of the edges, and each slab into trapezoids between the edges, so that above a trapezoid the same faces
//! follow each other everywhere; there, the heights between which both solids are is a matter of planes. In floating point,
//! to a tenth of a micrometre: what is asked is whether the overlap is wider and deeper than a tolerance. Whether there is any
//! at all, which is what a tolerance below that asks, is decided exactly.

use super::interiors;
use super::predicates::edges;
use super::triangles::triangles_of;
use crate::solid::Solid;

/// An overlap of two solids.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overlap {
    /// A lower bound of its thickness, metres.
    pub depth: f64,
    /// A place inside, in metres of the local frame.
    pub at: [f64; 3],
}

/// A triangle that is not upright, in metres.
struct Slope {
    /// Which of the two solids has it.
    solid: usize,
    corners: [[f64; 2]; 3],
    /// Height over x and y: `z = plane[0] x + plane[1] y + plane[2]`.
    plane: [f64; 3],
}

impl Slope {
    fn height(&self, [x, y]: [f64; 2]) -> f64 {
        self.plane[0] * x + self.plane[1] * y + self.plane[2]
    }

    /// Vertical distances become distances along the normal.
    fn cosine(&self) -> f64 {
        1.0 / (1.0 + self.plane[0] * self.plane[0] + self.plane[1] * self.plane[1]).sqrt()
    }

    /// Swaps x and y.
    fn turn(&mut self) {
        self.corners.iter_mut().for_each(|p| p.swap(0, 1));
        self.plane.swap(0, 1);
    }

    fn holds(&self, p: [f64; 2]) -> bool {
        let hands = edges(&self.corners).map(|(a, b)| hand(a, b, p));
        let (mut left, mut right) = (true, true);
        hands.for_each(|h| {
            left &= h >= 0.0;
            right &= h <= 0.0;
        });
        left || right
    }
}

fn hand(a: [f64; 2], b: [f64; 2], p: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
}

type Bounds = [[f64; 2]; 3];

/// The deepest overlap found of two solids, each its shells on one and the same grid, if it is thicker than `tolerance`
/// metres.
pub(super) fn overlap(a: &[Solid], b: &[Solid], tolerance: f64) -> Option<Overlap> {
    deepest(a, b, tolerance + NARROW).or_else(|| {
        // Of solids apart every pair of triangles would be looked at.
        let is_asked = tolerance < NARROW && near(a, b, 0.0);
        let at = if is_asked { interiors::shared_place(a, b) } else { None }?;
        Some(Overlap { depth: 0.0, at })
    })
}

/// The deepest overlap found that is thicker than `tolerance` metres, which is no less than [`NARROW`].
fn deepest(a: &[Solid], b: &[Solid], tolerance: f64) -> Option<Overlap> {
    let (of_a, of_b) = (bounds(a)?, bounds(b)?);
    let common: Bounds = std::array::from_fn(|i| [of_a[i][0].max(of_b[i][0]), of_a[i][1].min(of_b[i][1])]);
    if common.iter().any(|[low, high]| high - low <= tolerance) {
        return None;
    }
    // Numbers are small near the place that matters.
    let origin = common.map(|[low, _]| low);
    let size: [f64; 3] = std::array::from_fn(|i| common[i][1] - common[i][0]);
    let mut slopes = Vec::new();
    for (solid, shells) in [a, b].into_iter().enumerate() {
        slopes.extend(shells.iter().flat_map(|shell| slopes_of(shell, solid, origin, size)));
    }
    // Thinness across the slabs shows only when they are cut the other way.
    let [along_x, along_y] = [false, true].map(|turned| {
        if turned {
            slopes.iter_mut().for_each(Slope::turn);
        }
        let size = if turned { [size[1], size[0]] } else { [size[0], size[1]] };
        swept(&slopes, size, tolerance)
    });
    let (found, other) = (along_x?, along_y?);
    Some(Overlap { at: std::array::from_fn(|i| found.at[i] + origin[i]), depth: found.depth.min(other.depth) })
}

/// The deepest overlap above the slabs of a rectangle, if it is thicker than the tolerance.
fn swept(slopes: &[Slope], size: [f64; 2], tolerance: f64) -> Option<Overlap> {
    let cuts = cuts(slopes, size[0]);
    let slabs = cuts.windows(2).filter(|slab| slab[1] - slab[0] > NARROW);
    let found = slabs.filter_map(|slab| in_slab(slopes, [slab[0], slab[1]], size[1], tolerance));
    found.max_by(|a, b| a.depth.total_cmp(&b.depth))
}

/// Less than this is rounding of floating point, metres.
pub(super) const NARROW: f64 = 1e-7;

/// Whether the boxes of two solids are no farther apart than the tolerance.
pub(super) fn near(a: &[Solid], b: &[Solid], tolerance: f64) -> bool {
    let (Some(a), Some(b)) = (bounds(a), bounds(b)) else { return false };
    (0..3).all(|i| a[i][0].max(b[i][0]) - a[i][1].min(b[i][1]) <= tolerance + NARROW)
}

fn bounds(shells: &[Solid]) -> Option<Bounds> {
    let exterior = shells.first()?;
    let mut bounds = [[f64::INFINITY, f64::NEG_INFINITY]; 3];
    for v in 0..exterior.vertices.len() as u32 {
        for (bound, c) in bounds.iter_mut().zip(exterior.point(v).iter()) {
            *bound = [bound[0].min(*c), bound[1].max(*c)];
        }
    }
    Some(bounds)
}

/// The triangles of a shell over the rectangle that starts at `origin`.
fn slopes_of(shell: &Solid, solid: usize, origin: [f64; 3], size: [f64; 3]) -> Vec<Slope> {
    let local = |v: [i64; 3]| -> [f64; 3] { std::array::from_fn(|i| v[i] as f64 * shell.step[i] - origin[i]) };
    let slope = |[a, b, c]: [[f64; 3]; 3]| {
        let corners = [a, b, c].map(|p| [p[0], p[1]]);
        let out = (0..2).any(|i| corners.iter().all(|p| p[i] < 0.0) || corners.iter().all(|p| p[i] > size[i]));
        let twice = hand(corners[0], corners[1], corners[2]);
        if out || twice.abs() < f64::MIN_POSITIVE {
            return None;
        }
        let [u, v]: [[f64; 3]; 2] = [b, c].map(|p| std::array::from_fn(|i| p[i] - a[i]));
        let along = [(u[2] * v[1] - v[2] * u[1]) / twice, (v[2] * u[0] - u[2] * v[0]) / twice];
        let plane = [along[0], along[1], a[2] - along[0] * a[0] - along[1] * a[1]];
        Some(Slope { solid, corners, plane })
    };
    triangles_of(shell).into_iter().filter_map(|t| slope(t.corners.map(local))).collect()
}

/// Where the slabs begin and end: the ends of the rectangle, the corners and the crossings of the edges.
fn cuts(slopes: &[Slope], length: f64) -> Vec<f64> {
    let mut sides: Vec<[[f64; 2]; 2]> =
        slopes.iter().flat_map(|s| edges(&s.corners).map(|(a, b)| if a < b { [a, b] } else { [b, a] })).collect();
    sides.sort_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    sides.dedup();
    let mut cuts = vec![0.0, length];
    cuts.extend(sides.iter().flatten().map(|p| p[0]));
    for (i, &[a, b]) in sides.iter().enumerate() {
        for &[c, d] in sides[i + 1..].iter().take_while(|s| s[0][0] < b[0]) {
            let (of_c, of_d) = (hand(a, b, c), hand(a, b, d));
            if of_c * of_d < 0.0 && hand(c, d, a) * hand(c, d, b) < 0.0 {
                cuts.push(c[0] + of_c / (of_c - of_d) * (d[0] - c[0]));
            }
        }
    }
    cuts.retain(|x| (0.0..=length).contains(x));
    cuts.sort_by(f64::total_cmp);
    cuts
}

/// The deepest overlap above a slab: no deeper than the neighbouring trapezoids with overlap are wide together.
fn in_slab(slopes: &[Slope], [from, to]: [f64; 2], depth: f64, tolerance: f64) -> Option<Overlap> {
    let middle = f64::midpoint(from, to);
    let spans = |s: &&Slope| s.corners.iter().any(|p| p[0] < middle) && s.corners.iter().any(|p| p[0] > middle);
    let active: Vec<&Slope> = slopes.iter().filter(spans).collect();
    if (0..2).any(|solid| active.iter().all(|s| s.solid != solid)) {
        return None;
    }
    // Each line as its heights at the beginning, in the middle and at the end of the slab.
    let at = |x: f64, a: [f64; 2], b: [f64; 2]| a[1] + (x - a[0]) / (b[0] - a[0]) * (b[1] - a[1]);
    let mut lines: Vec<[f64; 3]> = vec![[0.0; 3], [depth; 3]];
    for (a, b) in active.iter().flat_map(|s| edges(&s.corners)) {
        if (a[0] < middle) != (b[0] < middle) {
            lines.push([at(from, a, b), at(middle, a, b), at(to, a, b)]);
        }
    }
    lines.retain(|line| (0.0..=depth).contains(&line[1]));
    lines.sort_by(|a, b| a[1].total_cmp(&b[1]));
    let mut best: Option<Overlap> = None;
    let mut run: Option<(f64, Overlap)> = None;
    for pair in lines.windows(2).filter(|pair| pair[1][1] - pair[0][1] > NARROW) {
        let centre = [middle, f64::midpoint(pair[0][1], pair[1][1])];
        // Towards the corners, but not onto them.
        let corner = |x: f64, y: f64| [0.9 * x + 0.1 * centre[0], 0.9 * y + 0.1 * centre[1]];
        let ends = [(from, 0, 0), (from, 1, 0), (to, 0, 2), (to, 1, 2)];
        let corners = ends.map(|(x, line, end): (f64, usize, usize)| corner(x, pair[line][end]));
        let steepest = pair.iter().map(|line| (line[2] - line[0]).abs() / (to - from)).fold(0.0, f64::max);
        let width = (pair[1][1] - pair[0][1]) / steepest.hypot(1.0);
        run = match (above(&active, centre, corners).filter(|found| found.depth > tolerance), run) {
            (None, _) => None,
            (Some(found), None) => Some((width, found)),
            (Some(found), Some((before, known))) => {
                Some((before + width, if found.depth > known.depth { found } else { known }))
            }
        };
        let thick = run.map(|(width, found)| Overlap { depth: found.depth.min(width), ..found });
        best = [best, thick].into_iter().flatten().max_by(|a, b| a.depth.total_cmp(&b.depth));
    }
    best.filter(|found| found.depth > tolerance)
}

/// The deepest overlap above the centre and the corners of a trapezoid.
fn above(active: &[&Slope], centre: [f64; 2], corners: [[f64; 2]; 4]) -> Option<Overlap> {
    let [ours, theirs] = [0, 1].map(|solid| {
        let mut over: Vec<&Slope> = active.iter().copied().filter(|s| s.solid == solid && s.holds(centre)).collect();
        over.sort_by(|a, b| a.height(centre).total_cmp(&b.height(centre)));
        over
    });
    // A ray that hits an edge of a triangle enters or leaves twice.
    if ours.len() % 2 == 1 || theirs.len() % 2 == 1 {
        return None;
    }
    let mut deepest: Option<Overlap> = None;
    for a in ours.chunks_exact(2) {
        for b in theirs.chunks_exact(2) {
            let cosine = a.iter().chain(b).map(|s| s.cosine()).fold(1.0, f64::min);
            for p in std::iter::once(centre).chain(corners) {
                let bottom = a[0].height(p).max(b[0].height(p));
                let depth = (a[1].height(p).min(b[1].height(p)) - bottom) * cosine;
                if depth > deepest.map_or(0.0, |d| d.depth) {
                    deepest = Some(Overlap { depth, at: [p[0], p[1], bottom + depth / 2.0] });
                }
            }
        }
    }
    deepest
}
