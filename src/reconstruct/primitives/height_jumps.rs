//! Wall planes between roofs: along the lines where the roof map jumps in height (method, section 9).
//!
//! The borders of the map's regions are staircases of pixel edges. Lines are found in them by voting for offsets, first
//! along the main directions of the building and then along any direction, strongest first, so that most walls come out
//! parallel or perpendicular to the footprint and one wall serves all regions along it.

use std::collections::HashMap;

use foldhash::fast::FixedState;
use nalgebra::{Point2, Rotation2, Unit, Vector2};

use super::roof_map::{NOTHING, RoofMap};
use super::trace::Trace;
use super::{Primitive, PrimitiveKind};

/// Directions closer than this are one direction (cosine of 7°).
const SAME_DIRECTION: f64 = 0.9925;
/// At most so many main directions are taken from the footprint.
const MAIN_DIRECTIONS: usize = 6;
/// Directions tried for what the main directions leave over.
const FREE_DIRECTIONS: usize = 24;
/// No building gets more jump lines than this.
const MAX_LINES: usize = 200;

/// What counts as a height jump.
#[derive(Debug, Clone, Copy)]
pub struct JumpOptions {
    /// Smallest difference in height, metres.
    pub min_height: f64,
    /// Shortest line along a main direction, metres; free directions need twice as much.
    pub min_length: f64,
    /// Height that stands for "no building" where the map ends, metres; only used without a footprint.
    pub ground: Option<f64>,
}

/// A pixel edge across which the roof height jumps: its midpoint.
type JumpEdge = Point2<f64>;

/// The traces along which the roof map jumps in height. `main` gives the directions to prefer, most important first.
pub fn traces(map: &RoofMap, primitives: &[Primitive], main: &[Vector2<f64>], options: &JumpOptions) -> Vec<Trace> {
    let mut edges = jump_edges(map, primitives, options);
    let tolerance = 0.75 * map.pixel() + 0.05;
    let mut found = Vec::new();
    vote(&mut edges, main, options.min_length, map.pixel(), tolerance, &mut found);
    let free: Vec<Vector2<f64>> = (0..FREE_DIRECTIONS)
        .map(|k| Rotation2::new(std::f64::consts::PI * k as f64 / FREE_DIRECTIONS as f64) * Vector2::x())
        .collect();
    vote(&mut edges, &free, 2.0 * options.min_length, map.pixel(), tolerance, &mut found);
    found
}

/// The main directions of a building: those of its longest footprint edges and their perpendiculars.
pub fn main_directions(edges: &[Trace]) -> Vec<Vector2<f64>> {
    let mut order: Vec<&Trace> = edges.iter().collect();
    order.sort_by(|a, b| b.length().total_cmp(&a.length()));
    let mut main: Vec<Vector2<f64>> = Vec::new();
    for trace in order {
        let direction = trace.direction();
        for candidate in [direction, Vector2::new(-direction.y, direction.x)] {
            if main.len() < MAIN_DIRECTIONS && main.iter().all(|m| m.dot(&candidate).abs() < SAME_DIRECTION) {
                main.push(candidate);
            }
        }
    }
    main
}

fn jump_edges(map: &RoofMap, primitives: &[Primitive], options: &JumpOptions) -> Vec<JumpEdge> {
    let [columns, rows] = map.size();
    let mut edges = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let (here, label) = (map.centre(column, row), map.label(column, row));
            for (c, r) in [(column + 1, row), (column, row + 1)] {
                if c >= columns || r >= rows || map.label(c, r) == label {
                    continue;
                }
                let middle = nalgebra::center(&here, &map.centre(c, r));
                if is_jump(label, map.label(c, r), &middle, primitives, map.pixel(), options) {
                    edges.push(middle);
                }
            }
        }
    }
    edges
}

/// Whether the heights of two labels differ at `p`, and do so because of a step and not because the border of the map
/// runs beside the line where the two planes meet.
fn is_jump(a: u32, b: u32, p: &Point2<f64>, primitives: &[Primitive], pixel: f64, options: &JumpOptions) -> bool {
    let surface = |label: u32| -> Option<(f64, Vector2<f64>)> {
        if label == NOTHING {
            return options.ground.map(|height| (height, Vector2::zeros()));
        }
        let plane = &primitives.get(label as usize)?.plane;
        let n = plane.normal;
        Some((plane.height_at(p.x, p.y)?, Vector2::new(-n.x / n.z, -n.y / n.z)))
    };
    let (Some((height_a, slope_a)), Some((height_b, slope_b))) = (surface(a), surface(b)) else { return false };
    let step = (height_a - height_b).abs();
    let convergence = (slope_a - slope_b).norm();
    step > options.min_height && step > convergence * (1.5 * pixel).max(0.6)
}

/// Takes line after line out of `edges`, the longest first, until none is as long as `min_length`.
fn vote(
    edges: &mut Vec<JumpEdge>,
    directions: &[Vector2<f64>],
    min_length: f64,
    pixel: f64,
    tolerance: f64,
    found: &mut Vec<Trace>,
) {
    let all = edges.clone();
    let mut is_left = vec![true; all.len()];
    let mut views: Vec<View> = directions.iter().filter_map(|direction| View::along(direction, &all)).collect();
    while found.len() < MAX_LINES {
        let best = views
            .iter_mut()
            .filter_map(|view| view.longest_run(&all, &is_left, pixel, tolerance))
            .filter(|run| run.length() >= min_length)
            .max_by(|a, b| a.length().total_cmp(&b.length()));
        let Some(run) = best else { break };
        let refined = refine(edges, &run, tolerance);
        let margin = pixel + tolerance;
        let stays = |edge: &JumpEdge| {
            let t = refined.direction().dot(&edge.coords);
            refined.distance(edge).abs() > tolerance || t < refined.span[0] - margin || t > refined.span[1] + margin
        };
        for (is_left, edge) in is_left.iter_mut().zip(&all) {
            *is_left = *is_left && stays(edge);
        }
        let before = edges.len();
        edges.clear();
        edges.extend(all.iter().zip(&is_left).filter(|(_, is_left)| **is_left).map(|(edge, _)| *edge));
        if edges.len() == before {
            break;
        }
        found.push(refined);
    }
}

/// The edges as they lie across a direction. They are sorted once, and of what no line was taken out of, the longest run is
/// remembered: a hall of saw teeth has a hundred lines to be taken out of a hundred thousand edges.
struct View {
    normal: Unit<Vector2<f64>>,
    along: Vector2<f64>,
    /// The edges by their offset from the line through the origin, then by their place along it.
    order: Vec<u32>,
    /// The longest run of the edges from one in the order to another, with their number: edges only ever go, so the same
    /// number of them are the same.
    known: HashMap<[u32; 2], (usize, [f64; 2]), FixedState>,
}

impl View {
    fn along(direction: &Vector2<f64>, edges: &[JumpEdge]) -> Option<Self> {
        let normal = Unit::try_new(Vector2::new(direction.y, -direction.x), 1e-9)?;
        let along = Vector2::new(-normal.y, normal.x);
        let mut view = Self { normal, along, order: Vec::new(), known: HashMap::default() };
        let mut projected: Vec<_> = (0..).zip(edges).map(|(index, edge)| (view.project(edge), index)).collect();
        projected.sort_unstable_by(|((a, s), i), ((b, t), j)| a.total_cmp(b).then(s.total_cmp(t)).then(i.cmp(j)));
        view.order = projected.into_iter().map(|(_, index)| index).collect();
        Some(view)
    }

    /// Offset and place along the line of an edge.
    fn project(&self, edge: &JumpEdge) -> (f64, f64) {
        (self.normal.dot(&edge.coords), self.along.dot(&edge.coords))
    }

    /// The longest unbroken stretch of the edges that are left within `tolerance` of one line.
    fn longest_run(&mut self, edges: &[JumpEdge], is_left: &[bool], pixel: f64, tolerance: f64) -> Option<Trace> {
        self.order.retain(|&index| is_left[index as usize]);
        let normal = self.normal;
        let projected: Vec<(f64, f64)> = self.order.iter().map(|&index| self.project(&edges[index as usize])).collect();
        let mut best: Option<Trace> = None;
        let (mut first, mut last) = (0, 0);
        let mut stretch = Vec::new();
        let mut next_offset = f64::NEG_INFINITY;
        for i in 0..projected.len() {
            let offset = projected[i].0;
            // Lines closer together than a third of the tolerance see the same edges.
            if offset < next_offset {
                continue;
            }
            next_offset = offset + tolerance / 3.0;
            let centre = offset + tolerance;
            while first < projected.len() && projected[first].0 < centre - tolerance {
                first += 1;
            }
            while last < projected.len() && projected[last].0 <= centre + tolerance {
                last += 1;
            }
            let window = &self.order[first..last];
            let (Some(&from), Some(&to)) = (window.first(), window.last()) else { continue };
            let known = self.known.entry([from, to]).or_default();
            if known.0 != last - first {
                stretch.clear();
                stretch.extend(projected[first..last].iter().map(|p| p.1));
                stretch.sort_unstable_by(f64::total_cmp);
                let runs = stretch.chunk_by(|a, b| b - a <= 2.0 * pixel + 0.3);
                let spans = runs.filter_map(|run| Some([*run.first()?, *run.last()?]));
                // The first of those that are as long.
                let longest = spans.reduce(|a, b| if b[1] - b[0] > a[1] - a[0] { b } else { a });
                *known = (last - first, longest.unwrap_or_default());
            }
            let span = known.1;
            if best.is_none_or(|b| span[1] - span[0] > b.length()) {
                best = Some(Trace { normal, offset: centre, span, kind: PrimitiveKind::HeightJump });
            }
        }
        best
    }
}

/// The line through the middle of the edges of a run, in the direction of the run.
fn refine(edges: &[JumpEdge], run: &Trace, tolerance: f64) -> Trace {
    let direction = run.direction();
    let mut offsets: Vec<f64> = edges
        .iter()
        .filter(|edge| {
            let t = direction.dot(&edge.coords);
            run.distance(edge).abs() <= tolerance && t >= run.span[0] && t <= run.span[1]
        })
        .map(|edge| run.normal.dot(&edge.coords))
        .collect();
    offsets.sort_by(f64::total_cmp);
    let (Some(low), Some(high)) = (offsets.first(), offsets.last()) else { return *run };
    // The median follows the line and the middle of the extremes the staircase; their mean does both.
    let median = offsets[offsets.len() / 2];
    Trace { offset: f64::midpoint(median, f64::midpoint(*low, *high)), ..*run }
}

#[cfg(test)]
mod tests {
    use geo::{MultiPolygon, polygon};
    use nalgebra::Point3;

    use super::*;
    use crate::geometry::Plane;
    use crate::reconstruct::primitives::Extent;

    /// Two flat roofs, 4 m and 7 m high, that meet at x = 4.1 in a house of 10 m × 8 m turned by `angle`.
    fn step_house(angle: f64) -> (Vec<Point3<f64>>, Vec<Primitive>, MultiPolygon<f64>) {
        let turn = Rotation2::new(angle);
        let (mut points, mut inliers) = (Vec::new(), [Vec::new(), Vec::new()]);
        for i in 0..33 {
            for j in 0..27 {
                let (x, y) = (0.15 + 0.3 * f64::from(i), 0.1 + 0.3 * f64::from(j));
                let low = x < 4.1;
                let p = turn * Point2::new(x, y);
                inliers[usize::from(!low)].push(points.len() as u32);
                points.push(Point3::new(p.x, p.y, if low { 4.0 } else { 7.0 }));
            }
        }
        let primitives = inliers
            .into_iter()
            .zip([4.0, 7.0])
            .map(|(inliers, height)| Primitive {
                kind: PrimitiveKind::Detected,
                plane: Plane::through(&Point3::new(0.0, 0.0, height), nalgebra::Vector3::z_axis()),
                inliers,
                residual: 0.0,
                extent: Extent::Everywhere,
            })
            .collect();
        let corner = |x, y| {
            let p = turn * Point2::new(x, y);
            (p.x, p.y)
        };
        let ring: Vec<(f64, f64)> = vec![corner(0.0, 0.0), corner(10.0, 0.0), corner(10.0, 8.0), corner(0.0, 8.0)];
        let mut footprint = polygon![];
        footprint.exterior_mut(|e| *e = ring.into());
        (points, primitives, MultiPolygon(vec![footprint]))
    }

    #[test]
    fn a_step_gives_one_wall_where_it_is_whatever_the_orientation() {
        for angle in [0.0, 0.3, 1.1] {
            let (points, primitives, footprint) = step_house(angle);
            let map = RoofMap::new(&points, &primitives, Some(&footprint), 0.9).unwrap();
            let edges = crate::reconstruct::primitives::footprint_edges::traces(&footprint);
            let options = JumpOptions { min_height: 0.3, min_length: 1.0, ground: None };
            let walls = traces(&map, &primitives, &main_directions(&edges), &options);
            assert_eq!(walls.len(), 1, "{angle}: {walls:?}");
            let middle = Rotation2::new(angle) * Point2::new(4.1, 4.0);
            assert!(walls[0].distance(&middle).abs() < 0.2, "{angle}: {}", walls[0].distance(&middle));
            assert!(walls[0].length() > 7.0);
        }
    }
}
