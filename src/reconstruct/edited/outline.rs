//! What edits do to a footprint.

use std::borrow::Cow;

use geo::buffer::{BufferStyle, LineJoin};
use geo::{Area, BooleanOps, Buffer, Coord, Distance, Euclidean, LineString, MultiPolygon, Polygon, Validation, coord};
use nalgebra::{Point2, Vector2};

use super::{Tally, local, picked};
use crate::edits::{Action, PlanPlace};
use crate::reconstruct::primitives::PrimitiveKind;
use crate::reconstruct::primitives::trace::Trace;
use crate::site::{Frame, Site};

/// An edge of a footprint is the one that is meant if its ends are so near to where they were, metres: footprints are
/// drawn anew, and seldom differ by more.
const SAME_EDGE: f64 = 0.5;
/// No edge is moved farther than this, metres.
const FARTHEST: f64 = 50.0;
/// Edges whose directions differ by less than this (the sine of the angle) have no corner where their lines meet.
const PARALLEL: f64 = 0.1;
/// Half the width of the gap that parts what is split, metres: that of [what touches](crate::reconstruct::footprint).
const GAP: f64 = 0.02;
/// The line of a split reaches so far beyond its ends, metres, to part what it was drawn across.
const BEYOND: f64 = 0.5;
/// The widest gap between parts that are one, metres.
const WIDEST: f64 = 10.0;
/// What is nearer than this touches, metres: rounding makes no more.
const TOUCHING: f64 = 1e-4;
/// What is smaller than this is none of a gap, square metres.
const SMALLEST: f64 = 1e-3;

/// A place of the plan in the local frame.
fn flat(frame: &Frame, [x, y]: PlanPlace) -> Result<Coord<f64>, String> {
    local(frame, [x, y, frame.origin[2]]).map(|p| coord! { x: p.x, y: p.y })
}

/// A footprint that was drawn, in the local frame.
pub fn redrawn(frame: &Frame, polygons: &[Vec<Vec<PlanPlace>>]) -> Result<MultiPolygon<f64>, String> {
    let ring =
        |ring: &Vec<PlanPlace>| ring.iter().map(|place| flat(frame, *place)).collect::<Result<LineString<f64>, _>>();
    let polygon = |rings: &Vec<Vec<PlanPlace>>| {
        let mut rings = rings.iter().map(ring).collect::<Result<Vec<_>, _>>()?.into_iter();
        let exterior = rings.next().ok_or_else(|| "a polygon without a ring".to_owned())?;
        Ok(Polygon::new(exterior, rings.collect()))
    };
    checked(polygons.iter().map(polygon).collect::<Result<_, String>>()?)
}

/// The footprint, if it is one.
fn checked(footprint: MultiPolygon<f64>) -> Result<MultiPolygon<f64>, String> {
    if footprint.unsigned_area() <= 0.0 {
        return Err("the footprint would have no area".to_owned());
    }
    let is_valid = footprint.check_validation().map_err(|fault| format!("the footprint would be invalid: {fault}"));
    is_valid.map(|()| footprint)
}

fn of_site(site: &Site) -> Result<&MultiPolygon<f64>, String> {
    site.footprint.as_ref().ok_or_else(|| "the building has no footprint".to_owned())
}

/// The footprint of a site with one edge moved outwards, parallel to where it was; the edges beside it become longer or shorter.
pub fn offset(site: &Site, edge: [PlanPlace; 2], distance: f64) -> Result<MultiPolygon<f64>, String> {
    let footprint = of_site(site)?;
    if !(distance.abs() > 0.0 && distance.abs() <= FARTHEST) {
        return Err(format!("a distance of {distance} m, up to {FARTHEST} m is expected"));
    }
    let [a, b] = [flat(&site.frame, edge[0])?, flat(&site.frame, edge[1])?];
    let far = |p: Coord<f64>, q: Coord<f64>| (p.x - q.x).hypot(p.y - q.y);
    let mut best: Option<(f64, [usize; 3])> = None;
    for (number, polygon) in footprint.iter().enumerate() {
        for (hole, ring) in std::iter::once(polygon.exterior()).chain(polygon.interiors()).enumerate() {
            for (at, line) in ring.lines().enumerate() {
                let same = far(line.start, a).max(far(line.end, b));
                let turned = far(line.start, b).max(far(line.end, a));
                let off = same.min(turned);
                if off <= SAME_EDGE && best.is_none_or(|(least, _)| off < least) {
                    best = Some((off, [number, hole, at]));
                }
            }
        }
    }
    let (_, [number, hole, at]) =
        best.ok_or_else(|| format!("no edge of the footprint has its ends within {SAME_EDGE} m of the places"))?;
    let mut polygons = footprint.0.clone();
    let (exterior, mut interiors) = polygons[number].clone().into_inner();
    let mut rings = vec![exterior];
    rings.append(&mut interiors);
    rings[hole] = moved(&rings[hole], at, distance);
    let exterior = rings.remove(0);
    polygons[number] = Polygon::new(exterior, rings);
    checked(MultiPolygon(polygons))
}

/// A ring with its edge `at` moved to its right, which is outwards for rings with the interior on their left.
fn moved(ring: &LineString<f64>, at: usize, distance: f64) -> LineString<f64> {
    let mut corners: Vec<Point2<f64>> = ring.coords().map(|c| Point2::new(c.x, c.y)).collect();
    corners.pop();
    let count = corners.len();
    let corner = |i: usize| corners[i % count];
    let (start, end) = (corner(at), corner(at + 1));
    let Some(along) = (end - start).try_normalize(1e-9) else { return ring.clone() };
    let shift = Vector2::new(along.y, -along.x) * distance;
    // Where the line of the moved edge meets that of the one beside it; without such a corner the edge gets a side of its own.
    let meet = |own: Point2<f64>, beside: Point2<f64>| {
        let other = (beside - own).try_normalize(1e-9)?;
        let sine = along.perp(&other);
        (sine.abs() >= PARALLEL).then(|| {
            let t = along.perp(&shift) / along.perp(&other);
            own + other * t
        })
    };
    let before = corner(at + count - 1);
    let after = corner(at + 2);
    let at_start = meet(start, before).map_or_else(|| vec![start, start + shift], |p| vec![p]);
    let at_end = meet(end, after).map_or_else(|| vec![end + shift, end], |p| vec![p]);
    let mut out = at_start;
    out.extend(at_end);
    out.extend((2..count).map(|k| corner(at + k)));
    let mut ring: LineString<f64> = out.iter().map(|p| (p.x, p.y)).collect();
    ring.close();
    ring
}

/// The footprint of a site with the gaps between its parts closed, as far as they are not wider than `gap` metres.
pub fn merged(site: &Site, gap: f64) -> Result<MultiPolygon<f64>, String> {
    let footprint = of_site(site)?;
    if !(gap > 0.0 && gap <= WIDEST) {
        return Err(format!("a gap of {gap} m, up to {WIDEST} m is expected"));
    }
    if footprint.0.len() < 2 {
        return Err("the footprint has one part".to_owned());
    }
    let style = |distance: f64| BufferStyle::new(distance).line_join(LineJoin::Miter(10.0));
    let closed = footprint.buffer_with_style(style(gap / 2.0)).buffer_with_style(style(-gap / 2.0));
    let is_bridge = |piece: &Polygon<f64>| {
        let near = footprint.iter().filter(|part| Euclidean.distance(*part, piece) < TOUCHING);
        piece.unsigned_area() > SMALLEST && near.count() > 1
    };
    // All else stays as it is, to the last bit.
    let bridges: Vec<Polygon<f64>> = closed.difference(footprint).0.into_iter().filter(is_bridge).collect();
    if bridges.is_empty() {
        return Err(format!("no parts of the footprint are within {gap} m of each other"));
    }
    let merged = bridges.iter().fold(footprint.clone(), |all, bridge| {
        // A hair wider, or rounding keeps them apart.
        all.union(&bridge.buffer_with_style(style(TOUCHING)))
    });
    checked(merged)
}

/// A site whose solids part at the lines that split it.
pub fn parts<'a>(site: Cow<'a, Site>, tally: &mut Tally) -> Cow<'a, Site> {
    let lines: Vec<(usize, Vec<PlanPlace>)> = picked(&site.edits, |edit| match &edit.action {
        Action::SplitParts { line } => Some(line.clone()),
        _ => None,
    })
    .collect();
    lines.into_iter().fold(site, |site, (index, line)| match split(&site, &line) {
        Ok(footprint) => {
            tally.note(index, Ok(()));
            Cow::Owned(site.into_owned().with_footprint(&footprint))
        }
        Err(why) => {
            tally.note(index, Err(why));
            site
        }
    })
}

fn split(site: &Site, line: &[PlanPlace]) -> Result<MultiPolygon<f64>, String> {
    let footprint = of_site(site)?;
    let places = line.iter().map(|place| flat(&site.frame, *place)).collect::<Result<Vec<_>, _>>()?;
    let point = |c: Coord<f64>| Point2::new(c.x, c.y);
    let strips: Vec<Polygon<f64>> = places
        .windows(2)
        .filter_map(|ends| {
            let trace = Trace::between(point(ends[0]), point(ends[1]), PrimitiveKind::FootprintEdge)?;
            let [from, to] = [trace.at(trace.span[0] - BEYOND), trace.at(trace.span[1] + BEYOND)];
            let side = trace.normal.into_inner() * GAP;
            let corners = [from - side, to - side, to + side, from + side];
            Some(Polygon::new(corners.iter().map(|p| (p.x, p.y)).collect(), Vec::new()))
        })
        .collect();
    if strips.is_empty() {
        return Err("the line has no length".to_owned());
    }
    let parted = footprint.difference(&geo::unary_union(&strips));
    if parted.0.len() <= footprint.0.len() {
        return Err("the line does not part the footprint".to_owned());
    }
    checked(parted)
}
