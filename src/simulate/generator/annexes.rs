//! Further blocks: wings, annexes, extensions, towers, setbacks.

use nalgebra::Point2;

use super::draft::{Draft, Host, tangent, tenth};
use super::plan::{Axis, Plan, Rectangle, Side};
use super::principal::one_of;
use super::roof::{Block, Roof, RoofKind};
use crate::geometry::Random;

/// How many places are tried for a block.
const TRIES: u32 = 6;
/// How far a block reaches into the host where their walls meet, metres.
const GRIP: f64 = 1.0;
/// How far the ridge of a wing stays below that of the host, metres: where they met, so would too many planes.
const BELOW_RIDGE: f64 = 0.2;

#[derive(Debug, Clone, Copy)]
enum Kind {
    Wing,
    Annex,
    Extension,
    Tower,
    Setback,
}

/// Attaches so many blocks to the host, as far as there is place.
pub(super) fn attach(random: &mut Random, draft: &mut Draft, host: &Host, count: u32) {
    for _ in 0..count {
        for _ in 0..TRIES {
            if one(random, draft, host) {
                break;
            }
        }
    }
}

/// Tries to attach a block; whether there was place.
fn one(random: &mut Random, draft: &mut Draft, host: &Host) -> bool {
    let roof = host.block.roof.kind;
    let round = matches!(roof, RoofKind::Dome | RoofKind::Pyramid);
    let depth = host.rectangle.length(Axis::V);
    let kind = random.weighted([
        (Kind::Wing, if !round && depth >= 5.0 { 0.4 } else { 0.0 }),
        (Kind::Annex, 0.36),
        (Kind::Extension, if round { 0.0 } else { 0.16 }),
        (Kind::Tower, if round { 0.0 } else { 0.08 }),
        (Kind::Setback, if roof == RoofKind::Flat && depth > 6.0 { 0.5 } else { 0.0 }),
    ]);
    match kind {
        Kind::Wing => wing(random, draft, host),
        Kind::Annex => annex(random, draft, host),
        Kind::Extension => extension(random, draft, host),
        Kind::Tower => tower(random, draft, host),
        Kind::Setback => setback(random, draft, host),
    }
}

/// A stretch of a side of this length: at one of its ends, or anywhere.
fn place(random: &mut Random, host: &Host, side: Side, length: f64, at_end: f64) -> [f64; 2] {
    let [low, high] = host.rectangle.range(side.axis());
    let from = if !random.chance(at_end) {
        tenth(random.between(low, high - length))
    } else if random.chance(0.5) {
        low
    } else {
        high - length
    };
    [from, from + length]
}

/// A wing across the host: L, T and U shapes.
fn wing(random: &mut Random, draft: &mut Draft, host: &Host) -> bool {
    let Some(side) = one_of(random, &[Side::Front, Side::Back]) else { return false };
    let whole = host.rectangle.length(Axis::U);
    let width = tenth((random.between(0.28, 0.6) * whole).clamp(3.0, 14.0));
    if width > 0.8 * whole {
        return false;
    }
    let along = place(random, host, side, width, 0.65);
    if !draft.is_free(side, along) {
        return false;
    }
    let (inward, top) = host.crest(side, along);
    let flat = host.block.roof.kind == RoofKind::Flat;
    let inward = if flat { host.rectangle.length(Axis::V) / 2.0 } else { inward };
    let outward = tenth(random.between(2.0, 4.0) + random.unit() * 0.9 * host.rectangle.length(Axis::V));
    let lower = if random.chance(0.55) { 0.0 } else { random.between(0.4, 2.5) };
    let eave = tenth((host.eave() - lower).max(2.2)).min(host.eave());
    let rectangle = host.rectangle.beside(side, along, inward, outward);
    // Lower than the host, under whose ridge it ends.
    let steepest = (top - BELOW_RIDGE - eave) / (width / 2.0);
    let tangent = host.block.roof.tangents[0].max(host.block.roof.tangents[1]).min(tangent(random, 25.0, 50.0));
    let tangent = tangent.min(steepest);
    let roof = if flat || tangent < 0.09 {
        Roof::flat(eave)
    } else {
        let kind = random.weighted([
            (RoofKind::Gable, 0.55),
            (RoofKind::Hip, 0.25),
            (RoofKind::HalfHip, 0.1),
            (RoofKind::Shed, 0.1),
        ]);
        let outer = usize::from(side == Side::Back);
        let mut hipped = [false; 2];
        hipped[outer] = true;
        let tangents = match kind {
            RoofKind::Shed if random.chance(0.5) => [tangent / 2.0, 0.0],
            RoofKind::Shed => [0.0, tangent / 2.0],
            _ => [tangent; 2],
        };
        let rise = tangent * width / 2.0 * random.between(0.4, 0.7);
        Roof { kind, ridge: Axis::V, tangents, rise, hipped, ..Roof::flat(eave) }
    };
    add(draft, Plan::rectangle(rectangle), roof);
    draft.taken.push((side, along));
    true
}

/// A lower annex under a flat roof, a roof that falls away from the host, or a gable.
fn annex(random: &mut Random, draft: &mut Draft, host: &Host) -> bool {
    let Some(side) = one_of(random, &Side::ALL) else { return false };
    let whole = host.rectangle.length(side.axis());
    let width = tenth((random.between(0.25, 0.95) * whole).clamp(1.5, 16.0)).min(whole);
    let along = place(random, host, side, width, 0.4);
    if !draft.is_free(side, along) {
        return false;
    }
    let outward = tenth(random.between(1.2, 4.0) + 4.0 * random.unit().powi(2));
    let inward = host.rectangle.length(side.across()) / 2.0;
    let rectangle = host.rectangle.beside(side, along, inward, outward);
    let top = tenth((host.eave() - 0.3).max(2.0)).min(host.eave());
    let tall = random.between(2.2, 3.6) + if random.chance(0.3) { random.between(0.0, 4.0) } else { 0.0 };
    let eave = tenth(tall).min(top);
    let plan = Plan::rectangle(rectangle);
    let tangent = tangent(random, 6.0, 28.0);
    let kind = random.weighted([(RoofKind::Flat, 0.42), (RoofKind::Shed, 0.4), (RoofKind::Gable, 0.18)]);
    let roof = match kind {
        // Its high side is at the host.
        RoofKind::Shed => {
            let low = tenth((eave - outward * tangent).max(1.9)).min(eave);
            let tangent = ((top - low) / outward).min(tangent).max(0.05);
            let outer = usize::from(matches!(side, Side::Back | Side::Right));
            let mut roof = Roof { kind, ridge: side.axis(), ..Roof::flat(low) };
            roof.tangents[outer] = tangent;
            roof
        }
        RoofKind::Gable => {
            let tangent = ((top - eave) / (width / 2.0)).min(2.0 * tangent);
            if tangent < 0.09 {
                Roof::flat(eave)
            } else {
                Roof { kind, ridge: side.across(), tangents: [tangent; 2], ..Roof::flat(eave) }
            }
        }
        _ => Roof::flat(eave),
    };
    let body = Block { plan: plan.clone(), roof }.body().and([super::convex::below(top)]);
    draft.add_block(body, plan);
    draft.taken.push((side, along));
    true
}

/// A block in line with the host at one end, narrower, lower or higher.
fn extension(random: &mut Random, draft: &mut Draft, host: &Host) -> bool {
    let Some(side) = one_of(random, &[Side::Left, Side::Right]) else { return false };
    if !draft.is_bare(side) {
        return false;
    }
    let [front, back] = host.rectangle.v;
    let inset = |random: &mut Random| {
        if random.chance(0.4) { 0.0 } else { tenth(random.between(0.3, 0.22 * (back - front).max(2.0))) }
    };
    let along = [front + inset(random), back - inset(random)];
    let outward = tenth(random.between(2.0, 9.0));
    let rectangle = host.rectangle.beside(side, along, GRIP + host.recess, outward);
    let difference = if random.chance(0.75) { random.between(-3.0, -0.5) } else { random.between(0.5, 3.0) };
    let eave = tenth((host.eave() + difference).max(2.2));
    let hosts = host.block.roof;
    let roof = match hosts.kind {
        RoofKind::Flat | RoofKind::Shed => Roof::flat(eave),
        kind => {
            let kind = if matches!(kind, RoofKind::Hip | RoofKind::Mansard) { RoofKind::Hip } else { RoofKind::Gable };
            let slope = hosts.tangents[0].min(tangent(random, 25.0, 45.0)).max(0.09);
            let mut hipped = [false; 2];
            hipped[usize::from(side == Side::Right)] = true;
            Roof { kind, tangents: [slope; 2], hipped, ..Roof::flat(eave) }
        }
    };
    add(draft, Plan::rectangle(rectangle), roof);
    draft.taken.push((side, along));
    true
}

/// A tower at a corner of the host that rises above its roof.
fn tower(random: &mut Random, draft: &mut Draft, host: &Host) -> bool {
    let (Some(side), Some(end)) =
        (one_of(random, &[Side::Front, Side::Back]), one_of(random, &[Side::Left, Side::Right]))
    else {
        return false;
    };
    let size = tenth(random.between(2.4, 6.0).min(0.6 * host.rectangle.length(Axis::V)));
    let reach = host.recess + size;
    let [u, v] = [end, side].map(|side| {
        let low = matches!(side, Side::Front | Side::Left);
        let [from, to] = host.rectangle.range(side.across());
        (if low { from } else { to }, if low { 1.0 } else { -1.0 })
    });
    let bare = |side: Side, corner: (f64, f64)| {
        let far = corner.0 + corner.1 * reach;
        draft.is_free(side, [corner.0.min(far), corner.0.max(far)])
    };
    if host.recess > 0.0 || !bare(side, u) || !bare(end, v) {
        return false;
    }
    let out = tenth(random.between(-0.2, 0.45) * size);
    let centre = Point2::new(u.0 + u.1 * (size / 2.0 - out), v.0 + v.1 * (size / 2.0 - out));
    let top = tenth(host.crest(Side::Front, host.rectangle.u).1 + random.between(0.8, 5.0));
    let kind = random.weighted([(RoofKind::Pyramid, 0.5), (RoofKind::Flat, 0.3), (RoofKind::Dome, 0.2)]);
    let plan = if kind == RoofKind::Dome || random.chance(0.25) {
        Plan::regular(centre, size / 2.0, 8)
    } else {
        let [a, b] = [centre.x, centre.y].map(|middle| [tenth(middle - size / 2.0), tenth(middle + size / 2.0)]);
        Plan::rectangle(Rectangle { u: a, v: b })
    };
    let rise = match kind {
        RoofKind::Dome => size / 2.0 * random.between(0.5, 0.8),
        _ => size / 2.0 * tangent(random, 25.0, 64.0),
    };
    add(draft, plan, Roof { kind, rise, ..Roof::flat(top) });
    let stretch = |corner: (f64, f64)| {
        let far = corner.0 + corner.1 * size;
        [corner.0.min(far), corner.0.max(far)]
    };
    draft.taken.extend([(side, stretch(u)), (end, stretch(v))]);
    true
}

/// A smaller storey or two on a flat roof.
fn setback(random: &mut Random, draft: &mut Draft, host: &Host) -> bool {
    let margin = |random: &mut Random, length: f64| {
        if random.chance(0.15) { 0.0 } else { tenth(random.between(0.08, 0.35) * length).max(0.8) }
    };
    let [u, v] = [Axis::U, Axis::V].map(|axis| {
        let [low, high] = host.rectangle.range(axis);
        let length = high - low;
        let recess = host.recess;
        [low + recess.max(margin(random, length)), high - recess.max(margin(random, length))]
    });
    let rectangle = Rectangle { u, v };
    let stacked = draft.expression.added.iter().map(|piece| piece.top_at(rectangle.centre())).filter(|z| z.is_finite());
    let under = stacked.fold(host.eave(), |high, z| if z < host.eave() + 12.0 { high.max(z) } else { high });
    if rectangle.length(Axis::U) < 3.0 || rectangle.length(Axis::V) < 3.0 || under > host.eave() + 0.1 {
        return false;
    }
    let storeys = random.weighted([(1.0, 0.7), (2.0, 0.3)]);
    let top = tenth(host.eave() + storeys * random.between(2.6, 3.6));
    add(draft, Plan::rectangle(rectangle), Roof::flat(top));
    true
}

fn add(draft: &mut Draft, plan: Plan, roof: Roof) {
    let block = Block { plan, roof };
    draft.add_block(block.body(), block.plan);
}
