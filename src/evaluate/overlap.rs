//! Overlap of two volumes and distance between two roofs, by vertical rays.
//!
//! A ray stands on every cell of a fine grid over both shapes. The faces cut it into intervals, and the length of the
//! intervals that lie in both shapes over the length of those that lie in either is the intersection over union of the
//! volumes, up to the size of a cell. Nothing is random.

use nalgebra::Point3;
use serde::Serialize;

use super::shape::Shape;
use super::summary::DistanceSummary;
use crate::geometry::{Aabb, projected_area};
use crate::solid::SurfaceType;

/// How two closed shapes overlap.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Overlap {
    /// Volume of the intersection over the volume of the union, 0 to 1.
    pub volume_iou: f64,
    /// Volume of the shape by the same rays, cubic metres.
    pub volume: f64,
    /// Volume of the reference by the same rays, cubic metres.
    pub reference_volume: f64,
    /// Distance of the highest roof of the shape over that of the reference, where both have one; metres.
    pub roofs: Option<DistanceSummary>,
    /// Share of the rays that left some shell open and were not counted, 0 to 1.
    pub open_rays: f64,
}

/// Measures the overlap with about `rays` rays. `None` when a shape is empty, when more than 1 % of the rays find a shell
/// open (no volume to speak of), or when the union has no volume.
pub fn overlap(shape: &Shape, reference: &Shape, rays: usize) -> Option<Overlap> {
    let turned = [shape, reference].map(turned);
    let grid = Grid::over(&turned, rays)?;
    let [ours, theirs] = turned.map(|faces| grid.crossings(&faces));
    let (mut both, mut either, mut open, mut used) = (0.0, 0.0, 0_usize, 0_usize);
    let mut volumes = [0.0, 0.0];
    let mut roofs = Vec::new();
    for (a, b) in grid.rays(&ours).zip(grid.rays(&theirs)) {
        if let (Some(a), Some(b)) = (highest_roof(a), highest_roof(b)) {
            roofs.push((a - b) as f32);
        }
        if a.is_empty() && b.is_empty() {
            continue;
        }
        used += 1;
        let (Some(a), Some(b)) = (inside(a), inside(b)) else {
            open += 1;
            continue;
        };
        let shared = shared_length(&a, &b);
        let lengths = [&a, &b].map(|intervals| intervals.iter().map(|[low, high]| high - low).sum::<f64>());
        both += shared;
        either += lengths[0] + lengths[1] - shared;
        volumes = [volumes[0] + lengths[0], volumes[1] + lengths[1]];
    }
    let open_rays = open as f64 / used.max(1) as f64;
    (either > 0.0 && open_rays <= 0.01).then(|| Overlap {
        volume_iou: both / either,
        volume: volumes[0] * grid.cell * grid.cell,
        reference_volume: volumes[1] * grid.cell * grid.cell,
        roofs: DistanceSummary::of(roofs),
        open_rays,
    })
}

/// Cosine and sine of the angle between the grid and the axes of the CRS. A wall that runs along a row of rays would be
/// off by half a cell along its whole length; hardly any wall runs along this direction.
const TURN: [f64; 2] = [0.848_048_096_156_426, 0.529_919_264_233_205];

/// A triangle in the axes of the grid, and whether it is roof.
type Turned = ([Point3<f64>; 3], bool);

/// The triangles of a shape in the axes of the grid.
fn turned(shape: &Shape) -> Vec<Turned> {
    let [cos, sin] = TURN;
    let turn = |p: Point3<f64>| Point3::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y, p.z);
    shape.triangles.iter().map(|(t, face)| (t.map(turn), shape.kind(*face) == SurfaceType::Roof)).collect()
}

/// Where a ray passes through a face.
#[derive(Debug, Clone, Copy)]
struct Crossing {
    ray: u32,
    z: f64,
    /// +1 where the ray, going up, enters through a face that looks down; −1 where it leaves.
    enters: i8,
    roof: bool,
}

/// The rays: a square grid over both shapes, each ray through the centre of its cell.
struct Grid {
    min: [f64; 2],
    cell: f64,
    columns: u32,
    rows: u32,
}

impl Grid {
    fn over(shapes: &[Vec<Turned>; 2], rays: usize) -> Option<Self> {
        if shapes.iter().any(Vec::is_empty) {
            return None;
        }
        let aabb = Aabb::of(shapes.iter().flatten().flat_map(|(triangle, _)| triangle))?;
        let ([min @ .., _], [width, depth, _]) = (aabb.min, aabb.extent());
        let size = [width, depth];
        let cell = (size[0] * size[1] / rays.max(1) as f64).sqrt();
        if !(cell.is_finite() && cell > 0.0) {
            return None;
        }
        // A long, thin pair may ask for many rays along one side; its cells grow until the grid is small again.
        let cell = cell.max(size[0].max(size[1]) / 20_000.0);
        let [columns, rows] = size.map(|s| (s / cell).ceil().max(1.0) as u32);
        Some(Self { min, cell, columns, rows })
    }

    fn centre(&self, axis: usize, index: u32) -> f64 {
        self.min[axis] + (f64::from(index) + 0.5) * self.cell
    }

    /// Indices along an axis of the rays between two coordinates.
    fn span(&self, axis: usize, low: f64, high: f64) -> std::ops::Range<u32> {
        let count = if axis == 0 { self.columns } else { self.rows };
        let index = |v: f64| ((v - self.min[axis]) / self.cell - 0.5).ceil().clamp(0.0, f64::from(count)) as u32;
        index(low)..index(high).saturating_add(1).min(count)
    }

    /// All crossings of a shape, sorted by ray and height.
    fn crossings(&self, faces: &[Turned]) -> Vec<Crossing> {
        let mut found = Vec::new();
        for (triangle, roof) in faces {
            let area = projected_area(triangle);
            if area == 0.0 {
                continue;
            }
            let enters = if area > 0.0 { -1 } else { 1 };
            let range = |axis: usize| {
                let [a, b, c] = triangle.map(|p| p[axis]);
                (a.min(b).min(c), a.max(b).max(c))
            };
            let ((x0, x1), (y0, y1)) = (range(0), range(1));
            for row in self.span(1, y0, y1) {
                for column in self.span(0, x0, x1) {
                    let p = [self.centre(0, column), self.centre(1, row)];
                    if let Some(z) = height_on(triangle, area, p) {
                        found.push(Crossing { ray: row * self.columns + column, z, enters, roof: *roof });
                    }
                }
            }
        }
        found.sort_by(|a, b| a.ray.cmp(&b.ray).then(a.z.total_cmp(&b.z)).then(b.enters.cmp(&a.enters)));
        found
    }

    /// The crossings ray by ray, in the order of the rays.
    fn rays<'a>(&self, crossings: &'a [Crossing]) -> impl Iterator<Item = &'a [Crossing]> {
        let mut rest = crossings;
        (0..self.columns * self.rows).map(move |ray| {
            let (here, after) = rest.split_at(rest.iter().take_while(|c| c.ray == ray).count());
            rest = after;
            here
        })
    }
}

/// Height of the triangle over `p`, `None` beside it. Each edge is judged from its lexicographically smaller end, so that
/// two triangles that share an edge agree on which of them has `p`, and a closed surface is met an even number of times.
fn height_on(triangle: &[Point3<f64>; 3], area: f64, p: [f64; 2]) -> Option<f64> {
    let [a, b, c] = triangle;
    let left_of = |from: &Point3<f64>, to: &Point3<f64>| {
        let swapped = (from.x, from.y) > (to.x, to.y);
        let (s, t) = if swapped { (to, from) } else { (from, to) };
        ((t.x - s.x) * (p[1] - s.y) - (t.y - s.y) * (p[0] - s.x) >= 0.0) != swapped
    };
    let left = area > 0.0;
    if left_of(a, b) != left || left_of(b, c) != left || left_of(c, a) != left {
        return None;
    }
    let wb = ((p[0] - a.x) * (c.y - a.y) - (p[1] - a.y) * (c.x - a.x)) / (2.0 * area);
    let wc = ((b.x - a.x) * (p[1] - a.y) - (b.y - a.y) * (p[0] - a.x)) / (2.0 * area);
    let z = a.z + wb * (b.z - a.z) + wc * (c.z - a.z);
    // The quotient of a sliver may be anything, but its height is between those of its corners.
    Some(z.clamp(a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z)))
}

/// Height of the highest roof that a ray passes.
fn highest_roof(ray: &[Crossing]) -> Option<f64> {
    ray.iter().filter(|c| c.roof).map(|c| c.z).max_by(f64::total_cmp)
}

/// The intervals of a ray that lie inside (in at least one of overlapping shells), from low to high; `None` when the
/// shell is open along it.
fn inside(ray: &[Crossing]) -> Option<Vec<[f64; 2]>> {
    let mut depth = 0_i32;
    let mut start = 0.0;
    let mut intervals = Vec::new();
    for crossing in ray {
        let before = depth;
        depth += i32::from(crossing.enters);
        match (before, depth) {
            (0, 1) => start = crossing.z,
            (1, 0) => intervals.push([start, crossing.z]),
            (_, after) if after < 0 => return None,
            _ => {}
        }
    }
    (depth == 0).then_some(intervals)
}

/// Length that two lists of intervals share; each is sorted and free of overlaps.
fn shared_length(a: &[[f64; 2]], b: &[[f64; 2]]) -> f64 {
    a.iter().flat_map(|[l, h]| b.iter().map(move |[m, i]| (h.min(*i) - l.max(*m)).max(0.0))).sum()
}

#[cfg(test)]
mod tests {
    use super::super::shape::tests::block;
    use super::super::shape::{Shape, ShapeFace};
    use super::*;

    #[test]
    fn blocks_shifted_by_half_share_a_third() {
        let a = block("a", [0.0, 0.0, 0.0], [10.0, 8.0, 6.0]);
        let b = block("b", [5.0, 0.0, 0.0], [15.0, 8.0, 6.5]);
        let found = overlap(&a, &b, 40_000).unwrap();
        // 5·8·6 = 240 shared; 480 + 520 − 240 = 760 in all.
        assert!((found.volume_iou - 240.0 / 760.0).abs() < 2e-3, "{found:?}");
        assert!((found.volume - 480.0).abs() < 3.0 && (found.reference_volume - 520.0).abs() < 3.0);
        assert_eq!(found.open_rays, 0.0);
        let roofs = found.roofs.unwrap();
        assert!((roofs.median - 0.5).abs() < 1e-6 && (roofs.offset + 0.5).abs() < 1e-6);
    }

    #[test]
    fn the_same_shape_overlaps_wholly_and_a_turned_one_by_its_octagon() {
        let square = |angle: f64| -> Vec<Point3<f64>> {
            (0..4)
                .map(|i| {
                    let turn = angle + f64::from(i) * std::f64::consts::FRAC_PI_2;
                    Point3::new(turn.cos() * 5.0, turn.sin() * 5.0, 0.0)
                })
                .collect()
        };
        let prism = |angle: f64| {
            let low = square(angle);
            let high: Vec<_> = low.iter().map(|p| Point3::new(p.x, p.y, 4.0)).collect();
            let mut rings: Vec<_> =
                (0..4).map(|i| vec![low[i], low[(i + 1) % 4], high[(i + 1) % 4], high[i]]).collect();
            rings.push(high);
            rings.push(low.into_iter().rev().collect());
            let faces = rings.into_iter().map(|ring| ShapeFace { rings: vec![ring], kind: None, solid: 0 });
            Shape::new("prism", faces.collect(), &[])
        };
        let turned = prism(std::f64::consts::FRAC_PI_4);
        assert!((overlap(&turned, &turned, 20_000).unwrap().volume_iou - 1.0).abs() < 1e-12);
        // Two squares of side s turned by 45° share the octagon 2(√2 − 1)s².
        let octagon = 2.0 * (2.0_f64.sqrt() - 1.0);
        let found = overlap(&prism(0.0), &turned, 90_000).unwrap();
        assert!((found.volume_iou - octagon / (2.0 - octagon)).abs() < 2e-3, "{found:?}");
    }

    #[test]
    fn an_open_shell_has_no_volume() {
        let mut open = block("a", [0.0; 3], [4.0; 3]);
        let closed = open.clone();
        open = Shape::new("a", open.faces.into_iter().skip(1).collect(), &[]);
        assert!(overlap(&open, &closed, 1000).is_none());
    }
}
