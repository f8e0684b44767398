//! Polygons of grid points: what is wrong once rounded, and how it is mended.
//!
//! The simple-feature rules let a hole touch the exterior at a point; extruded, that point becomes an edge with four
//! walls, which no valid shell may have. And rounding can make rings touch or cross that did not.

use geo::{BooleanOps, LineString, MultiPolygon, Polygon};

use super::clearance::are_apart;
use super::ring::{Point, Side, angle, clean, distance, distance_to_segment, doubled_area, orient, side};
use crate::geometry::Boxes;
use crate::solid::FootprintPolygon;

/// How often a polygon may be mended before what is still wrong is left out.
const ROUNDS: usize = 12;

/// How often corners that are merely close are cut off before they are left as they are.
const CLOSE_ROUNDS: usize = 3;

/// From so many edges on, a tree of their boxes is faster than all pairs.
const FEW: usize = 64;

/// How far from a corner that touches something its edges are cut, in multiples of the snapping distance.
const CUT: f64 = 10.0;

/// A polygon and what has been done to it.
struct Patient {
    rings: FootprintPolygon,
    rounds: usize,
}

/// Two places of a polygon that should be apart.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Conflict {
    /// Two edges cross, or run along each other.
    Crossing { rings: [usize; 2] },
    /// A vertex lies on another edge, or closer to it than the snapping distance.
    Touch { vertex: Place, edge: Place, exact: bool },
}

impl Conflict {
    /// Whether the two places truly share a point, which no valid polygon may have.
    fn is_exact(&self) -> bool {
        !matches!(self, Self::Touch { exact: false, .. })
    }
}

/// A vertex of a polygon, or the edge that starts there.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    ring: usize,
    index: usize,
}

/// Mends a polygon: every ring of the result is simple, exteriors are counter-clockwise and holes clockwise, and no two
/// rings share a point. A polygon that is in order comes back as it is, but for vertices that are no corners.
///
/// `snap` is the distance in steps below which two places are taken for one. What was done is told in `notes`.
pub(super) fn mend(polygon: FootprintPolygon, snap: f64, notes: &mut Vec<String>) -> Vec<FootprintPolygon> {
    let mut done = Vec::new();
    let mut waiting = vec![Patient { rings: polygon, rounds: 0 }];
    while let Some(Patient { rings, rounds }) = waiting.pop() {
        let is_remnant = rounds > 0;
        let Some(rings) = orderly(rings, snap, is_remnant, notes) else { continue };
        let conflicts = conflicts(&rings, snap);
        if conflicts.is_empty() {
            done.extend(without_misplaced_holes(rings, notes));
        } else if rounds == ROUNDS || (rounds >= CLOSE_ROUNDS && !conflicts.iter().any(Conflict::is_exact)) {
            done.extend(without_culprits(rings, snap, notes));
        } else if conflicts.iter().any(|c| matches!(c, Conflict::Crossing { .. })) {
            note(notes, "the footprint crosses itself once rounded to the output grid: repaired");
            let parts = uncrossed(&rings);
            waiting.extend(parts.into_iter().rev().map(|rings| Patient { rings, rounds: rounds + 1 }));
        } else {
            if conflicts.iter().any(Conflict::is_exact) {
                note(notes, "the footprint touches itself at a point: the tip of a corner there was cut off");
            }
            waiting.push(Patient { rings: cut(&rings, &conflicts, snap), rounds: rounds + 1 });
        }
    }
    done
}

/// The points that two rings of a polygon, or two parts of one, share; sorted.
pub(super) fn touches(polygon: &FootprintPolygon, snap: f64) -> Vec<Point> {
    let rings = orderly(polygon.clone(), snap, true, &mut Vec::new()).unwrap_or_default();
    let shared = |conflict: Conflict| match conflict {
        Conflict::Touch { vertex, exact: true, .. } => Some(rings[vertex.ring][vertex.index]),
        _ => None,
    };
    let mut points: Vec<Point> = conflicts(&rings, snap).into_iter().filter_map(shared).collect();
    points.sort_unstable();
    points.dedup();
    points
}

/// Adds a note unless it is there.
fn note(notes: &mut Vec<String>, text: impl Into<String>) {
    let text = text.into();
    if !notes.contains(&text) {
        notes.push(text);
    }
}

/// The polygon with clean rings of the right orientation; `None` when its exterior collapses. What collapses is told,
/// unless it is a remnant of a repair.
fn orderly(rings: FootprintPolygon, snap: f64, is_remnant: bool, notes: &mut Vec<String>) -> Option<FootprintPolygon> {
    let mut out = FootprintPolygon::new();
    let mut spikes = 0;
    for (index, ring) in rings.into_iter().enumerate() {
        let Some(cleaned) = clean(&ring, snap) else {
            if !is_remnant {
                let what = if index == 0 { "part" } else { "hole" };
                note(notes, format!("a {what} of the footprint is narrower than 1 mm: left out"));
            }
            if index == 0 {
                return None;
            }
            continue;
        };
        spikes += cleaned.spikes;
        let mut ring = cleaned.ring;
        if (doubled_area(&ring) > 0) != (index == 0) {
            ring.reverse();
        }
        out.push(ring);
    }
    if spikes > 0 && !is_remnant {
        note(notes, format!("{spikes} spike(s) of the footprint narrower than 1 mm removed"));
    }
    (!out.is_empty()).then_some(out)
}

/// The end points of the edge that starts at `place`.
fn edge(rings: &FootprintPolygon, place: Place) -> [Point; 2] {
    let ring = &rings[place.ring];
    [ring[place.index], ring[(place.index + 1) % ring.len()]]
}

/// All pairs of places that should be apart. Rings must be clean.
fn conflicts(rings: &FootprintPolygon, snap: f64) -> Vec<Conflict> {
    let edges = rings.iter().map(Vec::len).sum::<usize>();
    if edges > FEW && are_apart(rings, snap) { Vec::new() } else { all_conflicts(rings, snap) }
}

/// The same, by comparing edges.
pub(super) fn all_conflicts(rings: &FootprintPolygon, snap: f64) -> Vec<Conflict> {
    let margin = snap.ceil() as i64;
    let mut edges: Vec<(Place, [Point; 2])> = Vec::new();
    for (ring, points) in rings.iter().enumerate() {
        for index in 0..points.len() {
            let place = Place { ring, index };
            edges.push((place, edge(rings, place)));
        }
    }
    let mut found: Vec<([usize; 2], Conflict)> = Vec::new();
    let mut compare = |i: usize, j: usize| {
        let ((here, e), (there, f)) = (edges[i], edges[j]);
        let n = rings[here.ring].len();
        let is_neighbour =
            here.ring == there.ring && ((here.index + 1) % n == there.index || (there.index + 1) % n == here.index);
        if !is_neighbour && !is_apart(e, f, snap) {
            found.extend(between(rings, (here, e), (there, f), snap).into_iter().map(|conflict| ([i, j], conflict)));
        }
    };
    if edges.len() > FEW {
        let boxes = |margin| Boxes::of_segments(edges.iter().map(|(_, edge)| *edge), margin);
        let (wide, narrow) = (boxes(margin), boxes(0));
        wide.meeting(&narrow).filter(|(i, j)| i < j).for_each(|(i, j)| compare(i, j));
    } else {
        (0..edges.len()).for_each(|i| (i + 1..edges.len()).for_each(|j| compare(i, j)));
    }
    // The tree has an order of its own.
    found.sort_by_key(|(pair, _)| *pair);
    found.into_iter().map(|(_, conflict)| conflict).collect()
}

/// Whether two edges are certainly farther from each other than `snap`: their boxes are, or one of them is on one side of
/// the line of the other.
fn is_apart(e: [Point; 2], f: [Point; 2], snap: f64) -> bool {
    let margin = snap.ceil() as i64;
    let are_boxes_apart = (0..2).any(|axis| {
        e[0][axis].min(e[1][axis]) > f[0][axis].max(f[1][axis]) + margin
            || f[0][axis].min(f[1][axis]) > e[0][axis].max(e[1][axis]) + margin
    });
    let is_beside = |[a, b]: [Point; 2], ends: [Point; 2]| {
        let [c, d] = ends.map(|end| orient(a, b, end) as f64);
        // A hair more, for all that is compared here is rounded.
        c * d > 0.0 && c.abs().min(d.abs()) > 1.001 * snap * distance(a, b)
    };
    are_boxes_apart || is_beside(e, f) || is_beside(f, e)
}

/// What is wrong between two edges that are not neighbours in a ring.
fn between(
    rings: &FootprintPolygon,
    (here, e): (Place, [Point; 2]),
    (there, f): (Place, [Point; 2]),
    snap: f64,
) -> Vec<Conflict> {
    let [to_f, to_e] = [f.map(|p| orient(e[0], e[1], p).signum()), e.map(|p| orient(f[0], f[1], p).signum())];
    let crossing = Conflict::Crossing { rings: [here.ring, there.ring] };
    if to_f[0] * to_f[1] < 0 && to_e[0] * to_e[1] < 0 {
        return vec![crossing];
    }
    let axis = usize::from(e[0][0] == e[1][0]);
    let overlap = e[0][axis].max(e[1][axis]).min(f[0][axis].max(f[1][axis]))
        - e[0][axis].min(e[1][axis]).max(f[0][axis].min(f[1][axis]));
    if to_f == [0, 0] && overlap > 0 {
        return vec![crossing];
    }
    let ends = |place: Place| [place.index, (place.index + 1) % rings[place.ring].len()];
    let mut found = Vec::new();
    for (from, onto, points, segment) in [(here, there, e, f), (there, here, f, e)] {
        for (index, point) in ends(from).into_iter().zip(points) {
            if distance_to_segment(point, segment[0], segment[1]) < snap {
                let on_line = orient(segment[0], segment[1], point) == 0;
                let exact = on_line && distance_to_segment(point, segment[0], segment[1]) == 0.0;
                found.push(Conflict::Touch { vertex: Place { ring: from.ring, index }, edge: onto, exact });
            }
        }
    }
    found
}

/// The polygon with the sharper corner of every touching pair cut off: of two corners that touch without crossing, the
/// sharper never holds the other, so that its cut meets nothing.
fn cut(rings: &FootprintPolygon, conflicts: &[Conflict], snap: f64) -> FootprintPolygon {
    let sharpness = |place: Place| {
        let ring = &rings[place.ring];
        let n = ring.len();
        angle(ring[(place.index + n - 1) % n], ring[place.index], ring[(place.index + 1) % n])
    };
    let mut corners: Vec<Place> = Vec::new();
    for conflict in conflicts {
        let Conflict::Touch { vertex, edge: onto, .. } = *conflict else { continue };
        let point = rings[vertex.ring][vertex.index];
        let n = rings[onto.ring].len();
        let ends = [onto.index, (onto.index + 1) % n].map(|index| Place { ring: onto.ring, index });
        let rival = ends.into_iter().find(|p| distance(rings[p.ring][p.index], point) < snap);
        // Among equals the hole gives way: the outline of the building stays.
        corners.push(match rival {
            Some(rival) if (sharpness(rival), vertex) < (sharpness(vertex), rival) => rival,
            _ => vertex,
        });
    }
    corners.sort_unstable();
    corners.dedup();
    let mut out = rings.clone();
    for (index, ring) in out.iter_mut().enumerate() {
        let original = &rings[index];
        let n = original.len();
        *ring = (0..n)
            .flat_map(|at| {
                let tip = original[at];
                if corners.binary_search(&Place { ring: index, index: at }).is_err() {
                    return vec![tip];
                }
                let [before, after] = [original[(at + n - 1) % n], original[(at + 1) % n]];
                // The sharper the corner, the longer the cut: its ends must stay apart by twice the snapping distance.
                let reach = snap * CUT.max(1.0 / (angle(before, tip, after) / 2.0).sin());
                [before, after].into_iter().filter_map(|end| towards(tip, end, reach, snap)).collect()
            })
            .collect();
    }
    out
}

/// The point on the way from `tip` to `end` at `reach` steps, or at a third of the way if that is nearer; `None` when the
/// edge is too short for it.
fn towards(tip: Point, end: Point, reach: f64, snap: f64) -> Option<Point> {
    let length = distance(tip, end);
    let share = (reach / length).min(1.0 / 3.0);
    (share * length >= snap)
        .then(|| std::array::from_fn(|axis| tip[axis] + ((end[axis] - tip[axis]) as f64 * share).round() as i64))
}

/// The polygon as one or several without crossings (even-odd rule), rounded to the grid again.
fn uncrossed(rings: &FootprintPolygon) -> Vec<FootprintPolygon> {
    let line = |ring: &Vec<Point>| -> LineString<f64> { ring.iter().map(|p| (p[0] as f64, p[1] as f64)).collect() };
    let mut lines = rings.iter().map(line);
    let Some(exterior) = lines.next() else { return Vec::new() };
    // A union with nothing, since `MakeValid` loses area where edges run along each other.
    let valid = Polygon::new(exterior, lines.collect()).union(&MultiPolygon::new(Vec::new()));
    crate::solid::quantise_footprint(&valid, [1.0; 3])
}

/// The polygon without the holes that are not inside its exterior, or are inside another hole. No two rings may meet.
fn without_misplaced_holes(mut rings: FootprintPolygon, notes: &mut Vec<String>) -> Option<FootprintPolygon> {
    if rings.is_empty() {
        return None;
    }
    let is_misplaced = |index: usize| {
        let Some(&probe) = rings[index].first() else { return true };
        index > 0
            && (side(probe, &rings[0]) != Side::Inside
                || (1..rings.len()).any(|other| other != index && side(probe, &rings[other]) != Side::Outside))
    };
    let misplaced: Vec<bool> = (0..rings.len()).map(is_misplaced).collect();
    if misplaced.contains(&true) {
        note(notes, "a hole outside the footprint or inside another hole: left out");
        let mut verdicts = misplaced.into_iter();
        rings.retain(|_| !verdicts.next().unwrap_or(false));
    }
    Some(rings)
}

/// The last resort: the polygon without the holes that take part in a conflict; `None` when the exterior meets itself.
/// Places that are merely close stay.
fn without_culprits(mut rings: FootprintPolygon, snap: f64, notes: &mut Vec<String>) -> Option<FootprintPolygon> {
    let mut culprits: Vec<usize> = Vec::new();
    for conflict in conflicts(&rings, snap) {
        let pair = match conflict {
            Conflict::Crossing { rings } => rings,
            Conflict::Touch { vertex, edge, exact: true } => [vertex.ring, edge.ring],
            Conflict::Touch { .. } => continue,
        };
        // Of a hole and the exterior the hole goes; of two holes the later one.
        culprits.push(pair[0].max(pair[1]));
    }
    if culprits.contains(&0) {
        note(notes, "a part of the footprint meets itself on the output grid beyond repair: left out");
        return None;
    }
    if !culprits.is_empty() {
        note(notes, "a hole of the footprint meets another ring beyond repair: left out");
        let mut index = 0;
        rings.retain(|_| {
            index += 1;
            !culprits.contains(&(index - 1))
        });
    }
    without_misplaced_holes(rings, notes)
}
