//! Walls on the footprint's outline: few lines, none of which leaves the footprint.
//!
//! Every building is modelled on its own, and neighbours draw the wall that they share with different vertices. If each
//! may leave its outline to both sides where that makes it simpler, neighbours cross. So a wall may only stand back: an
//! edge of the simplified outline is moved inwards until all vertices that it replaces are on its line or outside, and
//! edges on almost the same line share the innermost. What stands in its footprint overlaps with nothing that the
//! footprint does not overlap with.

use geo::{Area, BooleanOps, Coord, Euclidean, Length, LineString, MultiPolygon, Polygon};
use nalgebra::{Point2, Unit, Vector2};

use super::PrimitiveKind;
use super::footprint_edges;
use super::trace::Trace;
use crate::geometry::{Linked, validity};

/// Edges share a line only if the angle between them has at least this cosine: 30°.
const PARALLEL: f64 = 0.866;
/// Lines that meet at an angle with less than this sine have no corner to speak of.
const LEAST_SINE: f64 = 1e-3;
/// Edges shorter than this, metres, are gone; lines that miss a corner by less than a thousandth of it go through it.
const NOTHING: f64 = 1e-6;
/// A corner may move by this many times the distance that a wall may stand back.
const MOST_MOVED: f64 = 5.0;
/// The walls keep at least this share of the footprint's area.
const LEAST_AREA: f64 = 0.9;
/// Where walls cannot stand back that far, a half is tried, and so on, this many times in all.
const ATTEMPTS: usize = 5;
/// The sine of the sharpest angle that is no needle: 20°.
const SHARP: f64 = 0.342;
/// A slit narrower than this, metres, is none: no valid solid can have it, and nothing stands in it.
const HAIRLINE: f64 = 0.003;
/// An outline with more vertices than this is not left as it is where its walls cannot stand back as a whole: its vertices do
/// one by one.
const MANY: usize = 500;
/// More edges than this share no lines: that takes time with the square of them, and no model can have so many walls.
const MOST_EDGES: usize = 2_000;
/// Walls that leave the footprint in strips thinner than this, metres, do so by rounding only.
const ROUNDING: f64 = 1e-5;

/// The outline that the walls of a building stand on.
#[derive(Debug, Clone, PartialEq)]
pub struct Walls {
    /// The outline, in local metres; nowhere outside the footprint, but that slits narrower than 3 mm are closed.
    pub outline: MultiPolygon<f64>,
    /// One trace per edge of the outline. Edges on one line give the very same plane.
    pub traces: Vec<Trace>,
}

impl Walls {
    /// Walls for a footprint (local metres, valid) that stand back from its outline by at most `reach` metres where that
    /// makes them fewer. The footprint as it is where they cannot.
    pub fn new(footprint: &MultiPolygon<f64>, reach: f64) -> Self {
        let footprint = &without_hairlines(footprint);
        let halved = |reach: &f64| Some(reach / 2.0);
        std::iter::successors(Some(reach), halved)
            .take(ATTEMPTS)
            .filter(|reach| *reach > 0.0)
            .find_map(|reach| standing_back(footprint, reach))
            .unwrap_or_else(|| {
                let outline = footprint.iter().map(|polygon| pared(polygon, reach)).collect();
                Self { traces: footprint_edges::traces(&outline), outline }
            })
    }
}

/// The footprint with its slits narrower than [`HAIRLINE`] closed.
fn without_hairlines(footprint: &MultiPolygon<f64>) -> MultiPolygon<f64> {
    let closed = |polygon: &Polygon<f64>| {
        let mut rings = rings(polygon);
        let before: usize = rings.iter().map(Vec::len).sum();
        for ring in &mut rings {
            drop_needles(ring, f64::NEG_INFINITY, HAIRLINE);
        }
        if rings.iter().map(Vec::len).sum::<usize>() == before {
            return polygon.clone();
        }
        let closed = of_rings(rings);
        if validity::is_valid_polygon(&closed) { closed } else { polygon.clone() }
    };
    MultiPolygon(footprint.iter().map(closed).collect())
}

/// A polygon of very many vertices without those that it can do without if it stands back by up to `reach` metres, spikes
/// narrower than that included.
fn pared(polygon: &Polygon<f64>, reach: f64) -> Polygon<f64> {
    let given = rings(polygon);
    if given.iter().map(Vec::len).sum::<usize>() <= MANY {
        return polygon.clone();
    }
    let pared = |reach: f64| {
        let mut rings = given.clone();
        for ring in &mut rings {
            drop_needles(ring, reach, f64::NEG_INFINITY);
            *ring = footprint_edges::needed_within(ring, reach).into_iter().map(|i| ring[i]).collect();
        }
        Some(of_rings(rings)).filter(|pared| validity::is_valid_polygon(pared) && pared.unsigned_area() > 0.0)
    };
    // The farther, the sooner two stretches of the outline cross.
    let halved = std::iter::successors(Some(reach), |reach| Some(reach / 2.0));
    halved.take(ATTEMPTS).find_map(pared).unwrap_or_else(|| polygon.clone())
}

/// The polygon of rings that are not closed.
fn of_rings(rings: Vec<Vec<Coord<f64>>>) -> Polygon<f64> {
    let mut rings = rings.into_iter().map(|ring| {
        let mut line = LineString(ring);
        line.close();
        line
    });
    let exterior = rings.next().unwrap_or_else(|| LineString(Vec::new()));
    Polygon::new(exterior, rings.collect())
}

/// The rings of a polygon, exterior first, not closed, with the interior on their left.
fn rings(polygon: &Polygon<f64>) -> Vec<Vec<Coord<f64>>> {
    let ring = |(index, ring): (usize, &LineString<f64>)| {
        let mut coords: Vec<Coord<f64>> = ring.coords().copied().collect();
        coords.pop();
        let counterclockwise = Polygon::new(ring.clone(), Vec::new()).signed_area() > 0.0;
        if counterclockwise != (index == 0) {
            coords.reverse();
        }
        coords
    };
    std::iter::once(polygon.exterior()).chain(polygon.interiors()).enumerate().map(ring).collect()
}

/// Drops the tips of needles from a ring with the interior on its left: of spikes up to `spike` metres wide and of slits
/// up to `slit`.
fn drop_needles(ring: &mut Vec<Coord<f64>>, spike: f64, slit: f64) {
    let point = |c: Coord<f64>| Vector2::new(c.x, c.y);
    let mut left = Linked::new(ring.len());
    let (mut at, mut settled) = (0, 0);
    while left.len() > 3 && settled < left.len() {
        let tip = point(ring[at]);
        let [before, after] = left.around(at);
        let (there, back) = (point(ring[before]) - tip, point(ring[after]) - tip);
        // From the end of the shorter edge to the longer one.
        let width = there.perp(&back).abs() / there.norm().max(back.norm()).max(f64::MIN_POSITIVE);
        let is_sharp = there.dot(&back) > 0.0 && width <= SHARP * there.norm().min(back.norm());
        let most = if back.perp(&there) > 0.0 { spike } else { slit };
        if is_sharp && width <= most {
            left.remove(at);
            [at, _] = left.around(before);
            settled = 0;
        } else {
            at = after;
            settled += 1;
        }
    }
    *ring = left.left().into_iter().map(|i| ring[i]).collect();
}

/// An edge of the simplified outline, with the interior on its left.
struct Edge {
    /// The vertices of the footprint that it replaces, from its start to its end.
    chain: Vec<Point2<f64>>,
    /// Unit vector to the left.
    inward: Vector2<f64>,
    /// The line that it shall be on.
    line: usize,
}

impl Edge {
    fn start(&self) -> Point2<f64> {
        self.chain.first().copied().unwrap_or_default()
    }

    fn end(&self) -> Point2<f64> {
        self.chain.last().copied().unwrap_or_default()
    }

    fn length(&self) -> f64 {
        (self.end() - self.start()).norm()
    }

    /// Whether the inside of the edge is the positive side of a line with this normal.
    fn faces(&self, normal: &Vector2<f64>) -> bool {
        self.inward.dot(normal) > 0.0
    }

    /// Lowest and highest offset that a line with this normal may have to carry the edge.
    fn allowed(&self, normal: &Vector2<f64>, reach: f64) -> [f64; 2] {
        let offsets = self.chain.iter().map(|p| normal.dot(&p.coords));
        let (low, high) = offsets.fold((f64::MAX, f64::MIN), |(low, high), o| (low.min(o), high.max(o)));
        if self.faces(normal) { [high, low + reach] } else { [high - reach, low] }
    }
}

/// A line that carries edges: `normal · p = offset`.
struct Line {
    normal: Vector2<f64>,
    offset: f64,
    /// Lowest and highest offset that all its edges allow.
    allowed: [f64; 2],
}

/// The walls, unless they leave the footprint or lose much of it.
fn standing_back(footprint: &MultiPolygon<f64>, reach: f64) -> Option<Walls> {
    // An edge leaves the vertices that it replaces by half as much to either side, and is then moved inwards.
    let mut rings: Vec<Vec<Vec<Edge>>> = footprint.iter().map(|polygon| edges(polygon, reach, reach / 2.0)).collect();
    if rings.iter().flatten().map(Vec::len).sum::<usize>() > MOST_EDGES {
        return None;
    }
    let lines = share_lines(rings.iter_mut().flatten().flatten().collect(), reach)?;
    let mut walls = Walls { outline: MultiPolygon(Vec::new()), traces: Vec::new() };
    for polygon in rings {
        let mut outlines = Vec::with_capacity(polygon.len());
        for ring in polygon {
            let (corners, carriers) = corners(ring, &lines, MOST_MOVED * reach)?;
            for (i, &line) in carriers.iter().enumerate() {
                walls.traces.push(trace(&lines[line], corners[i], corners[(i + 1) % corners.len()]));
            }
            let mut outline = LineString(corners.into_iter().map(|p| Coord { x: p.x, y: p.y }).collect());
            outline.close();
            outlines.push(outline);
        }
        let exterior = outlines.remove(0);
        walls.outline.0.push(Polygon::new(exterior, outlines));
    }
    let keeps = walls.outline.unsigned_area() >= LEAST_AREA * footprint.unsigned_area();
    (keeps && validity::is_valid(&walls.outline) && is_within(&walls.outline, footprint)).then_some(walls)
}

/// Whether one footprint is within another but for what rounding makes.
fn is_within(inner: &MultiPolygon<f64>, outer: &MultiPolygon<f64>) -> bool {
    let thin = |polygon: &Polygon<f64>| {
        let around: f64 =
            std::iter::once(polygon.exterior()).chain(polygon.interiors()).map(|ring| Euclidean.length(ring)).sum();
        2.0 * polygon.unsigned_area() <= ROUNDING * around
    };
    inner.difference(outer).iter().all(thin)
}

/// The edges of a polygon's rings without spikes narrower than `spike` metres, simplified to within `tolerance` metres,
/// exterior first.
fn edges(polygon: &Polygon<f64>, spike: f64, tolerance: f64) -> Vec<Vec<Edge>> {
    let simpler = |mut coords: Vec<Coord<f64>>| {
        drop_needles(&mut coords, spike, f64::NEG_INFINITY);
        let kept = footprint_edges::needed(&coords, tolerance);
        let n = coords.len();
        (0..kept.len())
            .filter_map(|i| {
                let (from, to) = (kept[i], kept[(i + 1) % kept.len()]);
                let count = (to + n - from - 1) % n + 2;
                let chain: Vec<Point2<f64>> =
                    (0..count).map(|k| coords[(from + k) % n]).map(|c| Point2::new(c.x, c.y)).collect();
                let along = (chain[count - 1] - chain[0]).try_normalize(NOTHING)?;
                Some(Edge { chain, inward: Vector2::new(-along.y, along.x), line: 0 })
            })
            .collect()
    };
    rings(polygon).into_iter().map(simpler).collect()
}

/// Finds few lines for the edges, longer ones first. `None` where an edge finds no line.
fn share_lines(mut edges: Vec<&mut Edge>, reach: f64) -> Option<Vec<Line>> {
    edges.sort_by(|a, b| b.length().total_cmp(&a.length()));
    let mut lines: Vec<Line> = Vec::new();
    for edge in edges {
        let nearest = lines
            .iter()
            .enumerate()
            .filter(|(_, line)| line.normal.dot(&edge.inward).abs() >= PARALLEL)
            .filter_map(|(i, line)| {
                let [low, high] = edge.allowed(&line.normal, reach);
                let allowed = [low.max(line.allowed[0]), high.min(line.allowed[1])];
                let moved = if edge.faces(&line.normal) { line.offset - low } else { high - line.offset };
                (allowed[0] <= allowed[1]).then_some((moved.abs(), i, allowed))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, i, allowed)) = nearest {
            let line = &mut lines[i];
            (line.allowed, line.offset) = (allowed, line.offset.clamp(allowed[0], allowed[1]));
            edge.line = i;
        } else {
            let normal = edge.inward;
            let allowed = edge.allowed(&normal, reach);
            if allowed[0] > allowed[1] {
                return None;
            }
            edge.line = lines.len();
            lines.push(Line { normal, offset: allowed[0], allowed });
        }
    }
    Some(lines)
}

/// The corners where the lines of consecutive edges meet, each with the line that starts there. Edges between two on one
/// line, and those that vanish as the walls stand back, are gone. `None` where nothing is left, or a corner would move by
/// more than `most` metres.
fn corners(mut ring: Vec<Edge>, lines: &[Line], most: f64) -> Option<(Vec<Point2<f64>>, Vec<usize>)> {
    loop {
        let mut i = 0;
        while i < ring.len() && ring.len() > 1 {
            let next = (i + 1) % ring.len();
            let normal = &lines[ring[i].line].normal;
            if ring[i].line != ring[next].line {
                i += 1;
            } else if ring[i].faces(normal) == ring[next].faces(normal) {
                let tail = ring.remove(next);
                let i_now = if next < i { i - 1 } else { i };
                ring[i_now].chain.extend(tail.chain);
                i = i_now;
            } else {
                return None;
            }
        }
        if ring.len() < 3 {
            return None;
        }
        let count = ring.len();
        let before = |i: usize| &ring[(i + count - 1) % count];
        let corners: Vec<Point2<f64>> =
            (0..count).map(|i| corner(before(i), &ring[i], lines, most)).collect::<Option<_>>()?;
        // How far an edge still goes forward, measured along its line.
        let forward = |i: usize| {
            let line = &lines[ring[i].line];
            let along = Vector2::new(line.normal.y, -line.normal.x);
            let along = if ring[i].faces(&line.normal) { along } else { -along };
            along.dot(&(corners[(i + 1) % count] - corners[i]))
        };
        match (0..count).map(|i| (forward(i), i)).min_by(|a, b| a.0.total_cmp(&b.0)) {
            Some((length, i)) if length <= NOTHING => {
                ring.remove(i);
            }
            _ => return Some((corners, ring.iter().map(|edge| edge.line).collect())),
        }
    }
}

/// Where the lines of two consecutive edges meet.
fn corner(one: &Edge, two: &Edge, lines: &[Line], most: f64) -> Option<Point2<f64>> {
    let (a, b) = (&lines[one.line], &lines[two.line]);
    let given = two.start();
    let misses = |line: &Line| (line.normal.dot(&given.coords) - line.offset).abs();
    if one.end() == given && misses(a).max(misses(b)) <= 1e-3 * NOTHING {
        return Some(given);
    }
    let sine = a.normal.perp(&b.normal);
    if sine.abs() < LEAST_SINE {
        return None;
    }
    let meet = Point2::new(
        (a.offset * b.normal.y - b.offset * a.normal.y) / sine,
        (b.offset * a.normal.x - a.offset * b.normal.x) / sine,
    );
    let moved = (meet - given).norm().min((meet - one.end()).norm());
    (moved <= most).then_some(meet)
}

/// The trace of an edge of the outline.
fn trace(line: &Line, from: Point2<f64>, to: Point2<f64>) -> Trace {
    let normal = Unit::new_unchecked(line.normal);
    let mut trace = Trace { normal, offset: line.offset, span: [0.0; 2], kind: PrimitiveKind::FootprintEdge };
    let direction = trace.direction();
    let (s, t) = (direction.dot(&from.coords), direction.dot(&to.coords));
    trace.span = [s.min(t), s.max(t)];
    trace
}

#[cfg(test)]
mod tests;
