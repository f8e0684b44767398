//! Dormers, chimneys, eaves.

use nalgebra::Point2;

use super::convex::{Convex, above, below, slope, wall};
use super::draft::{Draft, Host, tangent, tenth};
use super::plan::{Axis, Edge, Plan, Rectangle, Side};
use super::principal::{Class, one_of};
use super::roof::RoofKind;
use crate::geometry::Random;

/// The top of a dormer stays so far below the crest of the roof, metres.
const BELOW_CREST: f64 = 0.25;
/// Nothing of a roof hangs lower, metres above the ground.
const HEADROOM: f64 = 2.1;

/// Adds what a building of this class has at times.
pub(super) fn add(random: &mut Random, draft: &mut Draft, host: &Host, class: Class, party: &[Side]) {
    let often = match class {
        Class::House | Class::Court => 0.3,
        Class::Town => 0.4,
        _ => 0.0,
    };
    if random.chance(often) {
        dormers(random, draft, host);
    }
    let often = match class {
        Class::House => 0.45,
        Class::Town | Class::Court => 0.45,
        Class::Hall => 0.2,
        Class::Garage | Class::Round => 0.03,
    };
    if random.chance(often) {
        chimneys(random, draft, host, class, party);
    }
    if random.chance(0.14) {
        eaves(random, draft, host, party);
    }
}

/// Dormers over one or two eaves to which nothing is attached.
fn dormers(random: &mut Random, draft: &mut Draft, host: &Host) {
    let kind = random.weighted([(RoofKind::Flat, 0.35), (RoofKind::Shed, 0.25), (RoofKind::Gable, 0.4)]);
    let roof = &host.block.roof;
    let steep = |edge: &Edge| {
        let i = usize::from(roof.kind == RoofKind::Gable && edge.side == Side::Back);
        roof.tangents[i] >= 0.5 && roof.has_eave(edge.side) && edge.side.axis() == Axis::U
    };
    if matches!(roof.kind, RoofKind::Shed | RoofKind::Pyramid | RoofKind::Dome) {
        return;
    }
    let edges: Vec<Edge> = host.block.plan.edges().filter(|edge| draft.is_bare(edge.side) && steep(edge)).collect();
    let both = random.chance(0.4);
    for edge in edges.into_iter().take(if both { 2 } else { 1 }) {
        let width = random.between(1.1, 3.2).min(0.4 * edge.length());
        let setback = if random.chance(0.25) { 0.0 } else { random.between(0.2, 1.2) };
        let face = random.between(0.9, 1.8);
        let tangent = match kind {
            RoofKind::Shed => tangent(random, 4.0, 14.0),
            RoofKind::Gable => tangent(random, 20.0, 45.0),
            _ => 0.0,
        };
        let most = ((edge.length() - 1.0) / (width + 1.2)).floor().clamp(1.0, 5.0) as usize;
        let count = 1 + random.below(most);
        let pitch = edge.length() / count as f64;
        for i in 0..count {
            let from = pitch * i as f64 + (pitch - width) / 2.0;
            if let Some(dormer) = dormer(host, &edge, [from, from + width], setback, face, (kind, tangent)) {
                draft.add(dormer);
                draft.shape.dormers += 1;
            }
        }
    }
}

/// A dormer between two places along an eave whose face stands `setback` metres behind it and is `face` metres high;
/// `None` where the roof is not high enough for it.
fn dormer(
    host: &Host,
    edge: &Edge,
    along: [f64; 2],
    setback: f64,
    face: f64,
    (kind, tangent): (RoofKind, f64),
) -> Option<Convex> {
    let width = along[1] - along[0];
    let depth = host.rectangle.length(edge.side.across());
    // Where both its sides are highest under the roof of the host.
    let lower = |inward: f64| {
        let tops = along.map(|place| host.body.top_at(edge.at(place, inward)));
        tops[0].min(tops[1])
    };
    let steps = ((depth - setback) / 0.1).floor() as u32;
    let (back, crest) = (1..=steps)
        .map(|i| setback + 0.1 * f64::from(i))
        .map(|inward| (inward, lower(inward)))
        .fold((setback, f64::NEG_INFINITY), |best, next| if next.1 > best.1 + 1e-9 { next } else { best });
    let foot = along.map(|place| host.body.top_at(edge.at(place, setback)));
    let height = foot[0].max(foot[1]) + face;
    let top = match kind {
        RoofKind::Shed => height + tangent * (back - setback),
        RoofKind::Gable => height + tangent * width / 2.0,
        _ => height,
    };
    if top > crest - BELOW_CREST || back < setback + 0.5 {
        return None;
    }
    let corner = |place: usize, inward: f64| edge.at(along[place], inward);
    let [a, b, c, d] = [corner(0, setback), corner(1, setback), corner(1, back), corner(0, back)];
    let walls = [(a, b), (b, c), (c, d), (d, a)].map(|(from, to)| wall(from, to, 0.0));
    let roof = match kind {
        RoofKind::Shed => vec![slope(a, b, height, tangent)],
        RoofKind::Gable => vec![slope(b, c, height, tangent), slope(d, a, height, tangent)],
        _ => vec![below(height)],
    };
    // Not at the eave itself, where four planes would all but meet.
    let eave = host.block.roof.eaves[usize::from(edge.side == Side::Back)];
    let floor = eave.min(foot[0]).min(foot[1]) - 0.3;
    Some(Convex::new(walls).and(roof).and([above(floor)]))
}

/// Chimneys on the roof or at an end; on large flat roofs boxes for lifts and fans.
fn chimneys(random: &mut Random, draft: &mut Draft, host: &Host, class: Class, party: &[Side]) {
    let large = matches!(class, Class::Town | Class::Hall | Class::Court);
    let count =
        if large { random.weighted([(1, 0.5), (2, 0.3), (4, 0.2)]) } else { random.weighted([(1, 0.8), (2, 0.2)]) };
    let flat = host.block.roof.kind == RoofKind::Flat;
    for _ in 0..count {
        let [u, v] = if flat && large {
            [random.between(1.0, 4.0), random.between(1.0, 4.0)]
        } else {
            [random.between(0.4, 1.3), random.between(0.4, 0.9)]
        };
        let height = if flat && large { random.between(0.8, 3.0) } else { random.between(0.5, 1.8) };
        let end = one_of(random, &[Side::Left, Side::Right]).filter(|end| draft.is_bare(*end) && !party.contains(end));
        let ridge = host.crest(Side::Front, host.rectangle.u);
        match end {
            Some(end) if !large && host.recess == 0.0 && random.chance(0.2) => {
                let room = host.rectangle.length(Axis::V) / 2.0 - u;
                let middle = random.between(-room, room) * 0.7 + host.rectangle.centre().y;
                let rectangle =
                    host.rectangle.beside(end, [middle - u / 2.0, middle + u / 2.0], 0.3, tenth(v).min(0.6));
                draft.add(rectangle.prism(None, ridge.1 + height));
                draft.outline.push(Plan::rectangle(rectangle));
                draft.taken.push((end, [middle - u / 2.0, middle + u / 2.0]));
            }
            _ => {
                let place = |random: &mut Random, axis: Axis| {
                    let [low, high] = host.rectangle.range(axis);
                    random.between(low, high)
                };
                let mut centre = Point2::new(place(random, Axis::U), place(random, Axis::V));
                if !flat && random.chance(0.5) {
                    centre.y = host.rectangle.v[0] + ridge.0 + random.between(-0.4, 0.4);
                }
                let rectangle = Rectangle {
                    u: [centre.x - u / 2.0, centre.x + u / 2.0],
                    v: [centre.y - v / 2.0, centre.y + v / 2.0],
                };
                let corners = rectangle.u.into_iter().flat_map(|x| rectangle.v.map(|y| Point2::new(x, y)));
                let inside = corners.clone().all(|corner| host.covers(corner, 0.3));
                let lowest = corners.map(|corner| host.body.top_at(corner)).fold(f64::INFINITY, f64::min);
                if !inside {
                    continue;
                }
                draft.add(rectangle.prism(Some(lowest - 0.4), host.body.top_at(centre).max(lowest + 0.3) + height));
            }
        }
        draft.shape.chimneys += 1;
    }
}

/// Lets the roof of the host reach beyond its walls, where there is no neighbour.
fn eaves(random: &mut Random, draft: &mut Draft, host: &Host, party: &[Side]) {
    let roof = &host.block.roof;
    let kinds = [RoofKind::Flat, RoofKind::Shed, RoofKind::Gable, RoofKind::Hip, RoofKind::HalfHip, RoofKind::Pyramid];
    if !kinds.contains(&roof.kind) || draft.shape.courtyard {
        return;
    }
    let thickness = random.between(0.15, 0.4);
    let beyond = random.between(0.2, 1.0);
    let at_ends = if roof.kind == RoofKind::Gable { random.between(0.1, 0.6) } else { beyond };
    let reach = |side: Side| match side {
        side if party.contains(&side) => 0.0,
        side if roof.has_eave(side) => beyond,
        _ => at_ends,
    };
    let pieces = host.block.overhang(thickness, reach);
    let lowest = pieces
        .iter()
        .flat_map(|piece| piece.faces(0.0))
        .flat_map(|(_, corners)| corners)
        .map(|corner| corner.z)
        .fold(f64::INFINITY, f64::min);
    if lowest < HEADROOM {
        return;
    }
    for piece in pieces {
        draft.add(piece);
    }
    draft.shape.eaves = true;
}
