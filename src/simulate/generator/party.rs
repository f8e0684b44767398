//! Neighbours that share a wall.

use super::draft::{Draft, Host, tenth};
use super::expression::Expression;
use super::plan::{Plan, Rectangle, Side};
use super::principal::{Class, one_of, roof};
use super::roof::{Block, Roof, RoofKind};
use crate::geometry::Random;

/// The sides on which a building has neighbours: one end or both.
pub(super) fn sides(random: &mut Random) -> Vec<Side> {
    let ends = [Side::Left, Side::Right];
    if random.chance(0.4) { ends.to_vec() } else { one_of(random, &ends).into_iter().collect() }
}

/// Draws a neighbour beside each of these sides of the host.
pub(super) fn add(random: &mut Random, draft: &mut Draft, host: &Host, sides: &[Side]) {
    for side in sides {
        let [front, back] = host.rectangle.v;
        let shift = |random: &mut Random, most: f64| {
            if random.chance(0.5) { 0.0 } else { tenth(random.between(-most, most)) }
        };
        let most = (0.25 * (back - front)).min(2.5);
        let along = [front + shift(random, most), back + shift(random, most)];
        let rectangle = host.rectangle.beside(*side, along, 0.0, tenth(random.between(4.0, 12.0)));
        let like = random.chance(0.4);
        let roof = if like { Roof { hipped: [true; 2], ..host.block.roof } } else { other(random, host, rectangle) };
        let plan = Plan::rectangle(rectangle);
        let body = Block { plan, roof }.body();
        draft.neighbours.push(Expression { added: vec![body], ..Expression::default() });
        draft.shape.party_walls += 1;
    }
}

/// A roof that has nothing to do with that of the host.
fn other(random: &mut Random, host: &Host, rectangle: Rectangle) -> Roof {
    let eave = tenth((host.eave() + random.between(-3.0, 3.5)).max(2.4));
    let kind = random.weighted([
        (RoofKind::Flat, 0.35),
        (RoofKind::Gable, 0.35),
        (RoofKind::Hip, 0.1),
        (RoofKind::Mansard, 0.12),
        (RoofKind::Shed, 0.08),
    ]);
    roof(random, Class::House, kind, rectangle, eave)
}
