//! What is no height field: passages under a building, and storeys, bays, balconies and canopies beyond its walls.

use super::draft::{Draft, Host, tenth};
use super::plan::{Axis, Plan, Rectangle, Side};
use super::principal::{Class, one_of};
use crate::geometry::Random;

/// At least so much of a building stands over an arcade, metres.
const LEAST_ABOVE: f64 = 1.0;

/// Height of a passage under the host.
fn height(random: &mut Random, host: &Host) -> f64 {
    tenth(random.between(2.4, 4.2).min(host.eave() - LEAST_ABOVE))
}

/// Takes a box out from under the host.
fn hollow(draft: &mut Draft, rectangle: Rectangle, height: f64) {
    draft.expression.removed.push(rectangle.prism(None, height));
}

/// A stretch of a range, between two shares of its length; at times at one of its ends.
fn stretch(random: &mut Random, [low, high]: [f64; 2], shares: [f64; 2]) -> [f64; 2] {
    let length = tenth(random.between(shares[0], shares[1]) * (high - low));
    let room = high - low - length;
    let from = match random.weighted([(0, 0.2), (1, 0.2), (2, 0.6)]) {
        0 => low,
        1 => high - length,
        _ => tenth(low + room * random.between(0.2, 0.8)),
    };
    [from, from + length]
}

/// An arcade: a recess in the front, an open corner, or a passage at one end, between the building and its neighbour if
/// it has one there. The ground under the building stays in one piece.
pub(super) fn arcade(random: &mut Random, draft: &mut Draft, host: &Host, party: &[Side]) {
    let room = host.rectangle.length(Axis::U) >= 7.5;
    match random.weighted([(0, 0.4), (1, 0.2), (2, if room { 0.4 } else { 0.0 })]) {
        0 => recess(random, draft, host),
        1 => {
            let height = height(random, host);
            let [u, v] = [Axis::U, Axis::V].map(|axis| tenth(random.between(0.2, 0.45) * host.rectangle.length(axis)));
            let end = one_of(random, &[Side::Left, Side::Right]).unwrap_or(Side::Left);
            let strip = host.rectangle.beside(end, host.rectangle.v, u, 0.0);
            hollow(draft, Rectangle { u: strip.u, v: [strip.v[0], strip.v[0] + v] }, height);
            draft.reserve(Side::Front);
            draft.reserve(end);
            draft.shape.arcade = true;
        }
        _ => {
            let height = height(random, host);
            let ends = [Side::Left, Side::Right];
            // Where there is a neighbour, its wall is the other wall of the passage.
            let end = party.first().copied().or_else(|| one_of(random, &ends)).unwrap_or(Side::Left);
            let width = tenth(random.between(2.6, 4.5).min(0.45 * host.rectangle.length(Axis::U)));
            let strip = host.rectangle.beside(end, host.rectangle.v, width, 0.0);
            hollow(draft, strip, height);
            for side in [Side::Front, Side::Back] {
                draft.taken.push((side, strip.u));
            }
            draft.reserve(end);
            draft.shape.arcade = true;
        }
    }
}

/// A recess in the front, over a part or all of its length.
pub(super) fn recess(random: &mut Random, draft: &mut Draft, host: &Host) {
    let height = height(random, host);
    let depth = tenth(random.between(1.5, 3.6).min(0.4 * host.rectangle.length(Axis::V)));
    let along = if random.chance(0.4) { host.rectangle.u } else { stretch(random, host.rectangle.u, [0.3, 0.75]) };
    hollow(draft, host.rectangle.beside(Side::Front, along, depth, 0.0), height);
    draft.reserve(Side::Front);
    draft.shape.arcade = true;
}

/// A gateway through the front wing of a building into its courtyard.
pub(super) fn gateway(random: &mut Random, draft: &mut Draft, host: &Host) {
    let height = height(random, host);
    let depth = host.rectangle.length(Axis::V);
    let [left, right] = host.rectangle.u;
    // Not under the side wings.
    let inner = [left + depth + 0.5, right - depth - 0.5];
    let width = tenth(random.between(2.8, 5.0).min(0.8 * (inner[1] - inner[0])));
    let from = tenth(random.between(inner[0], inner[1] - width));
    hollow(draft, host.rectangle.beside(Side::Front, [from, from + width], depth, 0.0), height);
    draft.reserve(Side::Front);
    draft.shape.arcade = true;
}

/// An upper storey, a bay, balconies or a canopy at the front.
pub(super) fn overhang(random: &mut Random, draft: &mut Draft, host: &Host, class: Class) {
    let canopies = if class == Class::Hall { 0.5 } else { 0.06 };
    match random.weighted([(0, 0.34), (1, 0.18), (2, 0.26), (3, 0.22), (4, canopies)]) {
        0 => jetty(random, draft, host, [0.3, 1.4]),
        1 => jetty(random, draft, host, [1.4, 4.0]),
        2 => balconies(random, draft, host),
        3 => bay(random, draft, host),
        _ => {
            let along = stretch(random, host.rectangle.u, [0.2, 0.9]);
            let rectangle = host.rectangle.beside(Side::Front, along, 0.5, tenth(random.between(1.5, 5.0)));
            let low = tenth(random.between(2.6, 4.5).min(host.eave() - LEAST_ABOVE));
            draft.add(rectangle.prism(Some(low), low + tenth(random.between(0.3, 0.7))));
            draft.outline.push(Plan::rectangle(rectangle));
        }
    }
    draft.reserve(Side::Front);
    draft.shape.overhang = true;
}

/// The storeys above the first one stand out over the front, and at times over an end.
fn jetty(random: &mut Random, draft: &mut Draft, host: &Host, depths: [f64; 2]) {
    let height = height(random, host);
    let mut sides = vec![Side::Front];
    sides.extend([Side::Left, Side::Right].into_iter().filter(|end| draft.is_bare(*end) && random.chance(0.25)));
    for side in sides {
        let most = 0.3 * host.rectangle.length(side.across());
        let depth = tenth(random.between(depths[0], depths[1]).min(most)).max(0.3);
        let along = host.rectangle.range(side.axis());
        hollow(draft, host.rectangle.beside(side, along, depth, 0.0), height);
        draft.reserve(side);
    }
}

/// Balconies, one above the other: a slab with its parapet.
fn balconies(random: &mut Random, draft: &mut Draft, host: &Host) {
    let storey = tenth(random.between(2.6, 3.2));
    let parapet = tenth(random.between(0.9, 1.2));
    let depth = tenth(random.between(0.9, 2.0));
    let width = tenth(random.between(2.0, 5.0).min(0.6 * host.rectangle.length(Axis::U)));
    let columns = ((host.rectangle.length(Axis::U) / (width + 1.5)) as usize).clamp(1, 4);
    let columns = 1 + random.below(columns);
    let pitch = host.rectangle.length(Axis::U) / columns as f64;
    let mut floor = storey;
    while floor + parapet <= host.eave() {
        for column in 0..columns {
            let from = tenth(host.rectangle.u[0] + pitch * column as f64 + (pitch - width) / 2.0);
            let rectangle = host.rectangle.beside(Side::Front, [from, from + width], 0.5, depth);
            draft.add(rectangle.prism(Some(floor), floor + parapet));
            draft.outline.push(Plan::rectangle(rectangle));
        }
        floor = tenth(floor + storey);
    }
}

/// A bay that begins above the ground.
fn bay(random: &mut Random, draft: &mut Draft, host: &Host) {
    let low = tenth(random.between(0.6, 3.2).min(host.eave() - 2.0));
    let high = if random.chance(0.4) { host.eave() } else { tenth(random.between(low + 1.8, host.eave())) };
    let width = tenth(random.between(1.4, 4.0).min(0.5 * host.rectangle.length(Axis::U)));
    let along = host.rectangle.u;
    let from = tenth(random.between(along[0], along[1] - width));
    let rectangle = host.rectangle.beside(Side::Front, [from, from + width], 0.5, tenth(random.between(0.5, 1.6)));
    draft.add(rectangle.prism(Some(low), high));
    draft.outline.push(Plan::rectangle(rectangle));
}
