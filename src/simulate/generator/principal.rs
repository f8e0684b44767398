//! The main block: what kind of building it is, how large, and under which roof.

use nalgebra::Point2;

use super::draft::{Draft, Host, tangent, tenth};
use super::plan::{Axis, Plan, Rectangle, Side};
use super::roof::{Roof, RoofKind};
use super::{annexes, court, details, openings, party};
use crate::geometry::Random;

/// What a building is used for: its size and its roofs follow.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Class {
    Garage,
    House,
    /// A town house or a block of flats.
    Town,
    Hall,
    /// A large building around a courtyard.
    Court,
    /// A chapel, a tower, a pavilion on a regular polygon.
    Round,
}

/// The shapes that are no height field.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Unusual {
    Arcade,
    Overhang,
}

/// Draws a building.
pub(super) fn draw(random: &mut Random) -> Draft {
    let unusual = random.weighted([(None, 0.864), (Some(Unusual::Arcade), 0.068), (Some(Unusual::Overhang), 0.068)]);
    let class = if unusual.is_some() {
        random.weighted([(Class::House, 0.46), (Class::Town, 0.34), (Class::Hall, 0.1), (Class::Court, 0.1)])
    } else {
        random.weighted([
            (Class::Garage, 0.08),
            (Class::House, 0.5),
            (Class::Town, 0.17),
            (Class::Hall, 0.12),
            (Class::Court, 0.06),
            (Class::Round, 0.07),
        ])
    };
    match class {
        Class::Court => court::draw(random, unusual),
        Class::Round => round(random),
        _ => ordinary(random, class, unusual),
    }
}

/// A building on a rectangle, more or less.
fn ordinary(random: &mut Random, class: Class, unusual: Option<Unusual>) -> Draft {
    let kind = roof_kind(random, class);
    let rectangle = rectangle(random, class, kind);
    let eave = eave(random, class, unusual.is_some());
    let roof = roof(random, class, kind, rectangle, eave);
    let may_join = matches!(class, Class::House | Class::Town) && kind != RoofKind::Pyramid;
    let party = if may_join && random.chance(0.34) { party::sides(random) } else { Vec::new() };

    let mut recess = 0.0;
    let plan = if party.is_empty() && unusual.is_none() && !matches!(class, Class::Garage) && random.chance(0.2) {
        let [length, width] = [Axis::U, Axis::V].map(|axis| rectangle.length(axis));
        if random.chance(0.6) {
            recess = tenth(random.between(0.05, 0.22) * length.min(1.5 * width)).max(0.3);
            let by = if random.chance(0.5) { recess } else { -recess };
            Plan::trapezium(rectangle, by)
        } else {
            let [along, across] = [length, width].map(|side| tenth(random.between(0.12, 0.4) * side).max(0.8));
            recess = along.max(across);
            Plan::chamfered(rectangle, along, across)
        }
    } else {
        Plan::rectangle(rectangle)
    };
    let shear = if random.chance(0.1) { random.between(-0.3, 0.3) } else { 0.0 };

    let mut draft = Draft::new(random, kind, shear);
    let host = Host::new(plan, roof, rectangle, recess);
    draft.add_block(host.body.clone(), host.block.plan.clone());
    for side in &party {
        draft.reserve(*side);
    }
    match unusual {
        Some(Unusual::Arcade) => openings::arcade(random, &mut draft, &host, &party),
        Some(Unusual::Overhang) => openings::overhang(random, &mut draft, &host, class),
        None => {}
    }
    let further = random.weighted([(0, 0.42), (1, 0.27), (2, 0.17), (3, 0.09), (4, 0.05)]);
    annexes::attach(random, &mut draft, &host, if class == Class::Garage { further / 2 } else { further });
    details::add(random, &mut draft, &host, class, &party);
    party::add(random, &mut draft, &host, &party);
    draft
}

/// A building on a regular polygon, under a dome as a rule.
fn round(random: &mut Random) -> Draft {
    let kind = random.weighted([(RoofKind::Dome, 0.86), (RoofKind::Pyramid, 0.14)]);
    let apothem = tenth(random.between(2.0, 5.0) + 5.0 * random.unit().powi(3));
    let corners = random.weighted([(6, 0.2), (8, 0.45), (10, 0.15), (12, 0.2)]);
    let height = tenth(random.between(2.5, 5.0) + 8.0 * random.unit().powi(2));
    let rise = match kind {
        RoofKind::Dome => apothem * random.between(0.4, 0.8),
        _ => apothem * tangent(random, 20.0, 60.0),
    };
    let plan = Plan::regular(Point2::origin(), apothem, corners);
    let rectangle = Rectangle { u: [-apothem, apothem], v: [-apothem, apothem] };
    let roof = Roof { kind, rise, ..Roof::flat(height) };
    let mut draft = Draft::new(random, kind, 0.0);
    let host = Host::new(plan, roof, rectangle, apothem);
    draft.add_block(host.body.clone(), host.block.plan.clone());
    let further = random.weighted([(0, 0.45), (1, 0.35), (2, 0.2)]);
    annexes::attach(random, &mut draft, &host, further);
    details::add(random, &mut draft, &host, Class::Round, &[]);
    draft
}

fn roof_kind(random: &mut Random, class: Class) -> RoofKind {
    use RoofKind::{Flat, Gable, Gambrel, HalfHip, Hip, Mansard, Pyramid, Shed};
    match class {
        Class::Garage => random.weighted([(Flat, 0.5), (Shed, 0.2), (Gable, 0.22), (Pyramid, 0.08)]),
        Class::House | Class::Round => random.weighted([
            (Flat, 0.1),
            (Shed, 0.07),
            (Gable, 0.29),
            (Hip, 0.12),
            (HalfHip, 0.12),
            (Mansard, 0.07),
            (Gambrel, 0.12),
            (Pyramid, 0.11),
        ]),
        Class::Town | Class::Court => random.weighted([
            (Flat, 0.4),
            (Shed, 0.05),
            (Gable, 0.17),
            (Hip, 0.11),
            (HalfHip, 0.04),
            (Mansard, 0.17),
            (Gambrel, 0.06),
        ]),
        Class::Hall => random.weighted([(Flat, 0.4), (Shed, 0.13), (Gable, 0.4), (Hip, 0.07)]),
    }
}

/// The rectangle, its longer side along the front, around the origin; metres.
fn rectangle(random: &mut Random, class: Class, kind: RoofKind) -> Rectangle {
    let [mut length, width] = match class {
        Class::Garage => [random.between(3.5, 8.0), random.between(2.6, 6.0)],
        Class::House | Class::Round => {
            [random.between(6.0, 14.0) + 6.0 * random.unit().powi(4), random.between(5.0, 11.0)]
        }
        Class::Town | Class::Court => {
            [random.between(7.0, 22.0) + 24.0 * random.unit().powi(4), random.between(7.5, 15.0)]
        }
        Class::Hall => [18.0 + 62.0 * random.unit().powi(2), 10.0 + 28.0 * random.unit().powi(2)],
    };
    if kind == RoofKind::Pyramid {
        length = width * random.between(1.0, 1.25);
    }
    // A ridge along the short side, as on town houses that stand side by side.
    let (along, across) = if random.chance(0.2) { (width, length) } else { (length.max(width), length.min(width)) };
    let [u, v] = [along, across].map(|side| tenth(side / 2.0));
    Rectangle { u: [-u, u], v: [-v, v] }
}

/// Height of the eaves, metres; at least two storeys for what has something under or beyond the upper ones.
fn eave(random: &mut Random, class: Class, upper: bool) -> f64 {
    let storeys = match class {
        Class::Garage => 1,
        Class::House | Class::Round => random.weighted([(1, 0.35), (2, 0.5), (3, 0.15)]),
        Class::Town | Class::Court => {
            let tail = (-random.between(0.001, 1.0).ln() * 1.8) as u32;
            2 + tail.min(10)
        }
        Class::Hall => random.weighted([(1, 0.65), (2, 0.35)]),
    };
    let height = match class {
        Class::Garage => random.between(2.2, 3.2),
        Class::House | Class::Round => random.between(2.5, 3.2),
        Class::Town | Class::Court => random.between(2.6, 4.0),
        Class::Hall => random.between(3.5, 6.0),
    };
    let storeys = if upper { storeys.max(2) } else { storeys };
    let knee = if class == Class::House { random.between(0.0, 0.9) } else { 0.0 };
    tenth(f64::from(storeys) * height + knee)
}

/// A roof of this kind with its ridge along u.
pub(super) fn roof(random: &mut Random, class: Class, kind: RoofKind, rectangle: Rectangle, eave: f64) -> Roof {
    let [length, width] = [Axis::U, Axis::V].map(|axis| rectangle.length(axis));
    let half = width / 2.0;
    let highest = match class {
        Class::Garage => 3.0,
        Class::House | Class::Round => 6.5,
        Class::Town | Class::Court => 7.5,
        Class::Hall => 7.0,
    };
    let shallow = matches!(class, Class::Garage | Class::Hall);
    let plain = Roof { kind, ..Roof::flat(eave) };
    // Not steeper than `highest` metres over `run` metres.
    let limited = |tangent: f64, run: f64| tangent.min(highest / run).max(0.09);
    match kind {
        RoofKind::Flat | RoofKind::Dome => plain,
        RoofKind::Shed => {
            let tangent = limited(tangent(random, 5.0, if shallow { 15.0 } else { 32.0 }), width);
            let low_front = random.chance(0.5);
            Roof { tangents: if low_front { [tangent, 0.0] } else { [0.0, tangent] }, ..plain }
        }
        RoofKind::Gable => {
            let steep = if random.chance(0.07) { 65.0 } else { 55.0 };
            let first = if shallow { tangent(random, 5.0, 25.0) } else { tangent(random, 22.0, steep) };
            let first = limited(first, half);
            let mut roof = Roof { tangents: [first; 2], ..plain };
            if random.chance(0.15) {
                // The ridge stays between 30 and 70 % of the width.
                let most = (0.4 * width * first).min(eave - 2.2);
                let lower = usize::from(random.chance(0.5));
                if most > 0.4 {
                    roof.eaves[lower] = tenth(eave - random.between(0.3, most));
                }
            } else if random.chance(0.12) {
                roof.tangents[1] = limited(first * random.between(0.6, 1.5), half).min(2.1);
            }
            roof
        }
        RoofKind::Hip => {
            let first = limited(if shallow { tangent(random, 6.0, 25.0) } else { tangent(random, 18.0, 48.0) }, half);
            let ends = if random.chance(0.6) { first } else { (first * random.between(0.9, 1.6)).min(2.1) };
            Roof { tangents: [first, ends], ..plain }
        }
        RoofKind::HalfHip => {
            let first = limited(tangent(random, 33.0, 57.0), half);
            Roof {
                tangents: [first, tangent(random, 35.0, 60.0)],
                rise: first * half * random.between(0.35, 0.75),
                ..plain
            }
        }
        RoofKind::Mansard | RoofKind::Gambrel => {
            let lower = tangent(random, 52.0, 65.0);
            let most = 0.75 * lower * half.min(length / 2.0);
            let rise = random.between(1.6, 3.0).min(most);
            let flat = kind == RoofKind::Mansard && random.chance(0.4);
            let upper = if flat { 0.0 } else { tangent(random, 8.0, 33.0).min(4.0 / half) };
            Roof { tangents: [lower, upper], rise, ..plain }
        }
        RoofKind::Pyramid => {
            let steep = if random.chance(0.15) { 64.0 } else { 50.0 };
            Roof { rise: limited(tangent(random, 18.0, steep), half) * half, ..plain }
        }
    }
}

/// One of some sides.
pub(super) fn one_of(random: &mut Random, sides: &[Side]) -> Option<Side> {
    sides.get(random.below(sides.len())).copied()
}
