//! Buildings around a courtyard.

use super::draft::{Draft, Host, tangent, tenth};
use super::plan::{Axis, Plan, Rectangle, Side};
use super::principal::{Class, Unusual};
use super::roof::{Roof, RoofKind};
use super::{details, openings, party};
use crate::geometry::Random;

/// Draws one: a block with a court cut out of it, or four wings whose roofs meet over the corners.
pub(super) fn draw(random: &mut Random, unusual: Option<Unusual>) -> Draft {
    let kind = random.weighted([(RoofKind::Flat, 0.4), (RoofKind::Hip, 0.36), (RoofKind::Mansard, 0.24)]);
    let [u, v] = [random.between(11.0, 22.0) + 8.0 * random.unit().powi(3), random.between(10.0, 18.0)].map(tenth);
    let whole = Rectangle { u: [-u, u], v: [-v, v] };
    let depth = tenth(random.between(0.28, 0.35) * 2.0 * v.min(u)).min(12.0);
    let storeys = 2.0 + (-random.between(0.01, 1.0).ln() * 1.2).floor();
    let eave = tenth(storeys * random.between(2.7, 3.8));
    let party = if random.chance(0.3) { party::sides(random) } else { Vec::new() };
    let shear = if random.chance(0.15) { random.between(-0.25, 0.25) } else { 0.0 };
    let mut draft = Draft::new(random, kind, shear);
    draft.shape.courtyard = true;

    let inner = Rectangle { u: [whole.u[0] + depth, whole.u[1] - depth], v: [whole.v[0] + depth, whole.v[1] - depth] };
    let front = whole.beside(Side::Front, whole.u, depth, 0.0);
    let host = if kind == RoofKind::Hip {
        // Equal slopes and eaves: the hip of each wing is the outer slope of the next.
        let slope = tangent(random, 18.0, 42.0);
        let wings = Side::ALL.map(|side| {
            let along = if side.axis() == Axis::U { whole.u } else { whole.v };
            let rectangle = whole.beside(side, along, depth, 0.0);
            let roof = Roof { kind, ridge: side.axis(), tangents: [slope; 2], ..Roof::flat(eave) };
            Host::new(Plan::rectangle(rectangle), roof, rectangle, 0.0)
        });
        for wing in &wings {
            draft.add_block(wing.body.clone(), wing.block.plan.clone());
        }
        let [wing, ..] = wings;
        wing
    } else {
        let roof = match kind {
            RoofKind::Mansard => {
                let lower = tangent(random, 52.0, 65.0);
                Roof { kind, tangents: [lower, 0.0], rise: random.between(1.8, 3.0), ..Roof::flat(eave) }
            }
            _ => Roof::flat(eave),
        };
        // Wings need not be equally deep here.
        let deeper = |random: &mut Random| if random.chance(0.4) { tenth(random.between(0.0, 0.06) * v) } else { 0.0 };
        let inner = Rectangle {
            u: [inner.u[0] + deeper(random), inner.u[1] - deeper(random)],
            v: [inner.v[0], inner.v[1] - deeper(random)],
        };
        let host = Host { rectangle: front, ..Host::new(Plan::rectangle(whole), roof, whole, 0.0) };
        draft.add_block(host.body.clone(), host.block.plan.clone());
        draft.expression.removed.push(inner.prism(None, eave + 50.0));
        draft.courts.push(Plan::rectangle(inner));
        host
    };
    draft.reserve(Side::Back);
    for side in &party {
        draft.reserve(*side);
    }
    match unusual {
        Some(Unusual::Arcade) if random.chance(0.6) => openings::gateway(random, &mut draft, &host),
        Some(Unusual::Arcade) => openings::recess(random, &mut draft, &host),
        Some(Unusual::Overhang) => openings::overhang(random, &mut draft, &host, Class::Court),
        None => {}
    }
    details::add(random, &mut draft, &host, Class::Court, &party);
    let joined = Host { rectangle: whole, ..host };
    party::add(random, &mut draft, &joined, &party);
    draft
}
