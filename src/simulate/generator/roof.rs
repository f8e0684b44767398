//! Roofs: the half-spaces under them.

use serde::{Deserialize, Serialize};

use super::convex::{Convex, above, below};
use super::plan::{Axis, Edge, Plan, Side};
use crate::geometry::Plane;

/// The shape of the roof of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RoofKind {
    /// One horizontal plane.
    Flat,
    /// One sloped plane.
    Shed,
    /// Two planes that meet in a ridge.
    Gable,
    /// A gable whose ends slope as well.
    Hip,
    /// A gable with ends that slope in their upper part.
    HalfHip,
    /// A steep lower and a shallow or flat upper part on all sides.
    Mansard,
    /// A gable with a steep lower and a shallow upper part.
    Gambrel,
    /// All sides meet in a point.
    Pyramid,
    /// A dome of facets.
    Dome,
}

impl RoofKind {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Flat,
        Self::Shed,
        Self::Gable,
        Self::Hip,
        Self::HalfHip,
        Self::Mansard,
        Self::Gambrel,
        Self::Pyramid,
        Self::Dome,
    ];
}

/// Facets of a dome from its foot to its top.
const DOME_RINGS: u32 = 3;

/// A roof. Heights are metres above the ground.
#[derive(Debug, Clone, Copy)]
pub(super) struct Roof {
    pub(super) kind: RoofKind,
    /// Along the ridge; the eaves of a shed run along it too.
    pub(super) ridge: Axis,
    /// Height of the eaves at the front (at the left, with a ridge along v) and opposite. A roof with eaves all around has
    /// the first everywhere.
    pub(super) eaves: [f64; 2],
    /// Tangents of the slopes: of gable and shed those of the two sides (0 at the high side of a shed); of hip and half-hip those of the sides and of
    /// the ends; of mansard and gambrel those of the lower and of the upper part.
    pub(super) tangents: [f64; 2],
    /// Height above the eaves: of mansard and gambrel where the slope changes, of half-hip where the ends begin to slope,
    /// of pyramid and dome that of the top.
    pub(super) rise: f64,
    /// Whether the ends of hip and half-hip at the left (front) and at the right (back) are sloped.
    pub(super) hipped: [bool; 2],
}

/// What an edge of a plan carries.
enum Role {
    Eave(usize),
    End(usize),
    Other,
}

impl Roof {
    /// A flat roof.
    pub(super) fn flat(height: f64) -> Self {
        Self {
            kind: RoofKind::Flat,
            ridge: Axis::U,
            eaves: [height; 2],
            tangents: [0.0; 2],
            rise: 0.0,
            hipped: [true; 2],
        }
    }

    fn role(&self, side: Side) -> Role {
        match (self.ridge, side) {
            (Axis::U, Side::Front) | (Axis::V, Side::Left) => Role::Eave(0),
            (Axis::U, Side::Back) | (Axis::V, Side::Right) => Role::Eave(1),
            (Axis::U, Side::Left) | (Axis::V, Side::Front) => Role::End(0),
            (Axis::U, Side::Right) | (Axis::V, Side::Back) => Role::End(1),
            (_, Side::Other) => Role::Other,
        }
    }

    /// Whether the roof slopes down to this side.
    pub(super) fn has_eave(&self, side: Side) -> bool {
        match (self.kind, self.role(side)) {
            (RoofKind::Flat, _) => false,
            (RoofKind::Shed, role) => matches!(role, Role::Eave(i) if self.tangents[i] > 0.0),
            (RoofKind::Gable | RoofKind::Gambrel | RoofKind::HalfHip, role) => matches!(role, Role::Eave(_)),
            (RoofKind::Hip, Role::End(end)) => self.hipped[end],
            (RoofKind::Hip, role) => matches!(role, Role::Eave(_)),
            (RoofKind::Mansard | RoofKind::Pyramid | RoofKind::Dome, _) => true,
        }
    }

    /// The half-spaces under it.
    pub(super) fn sides(&self, plan: &Plan) -> Vec<Plane> {
        let [first, second] = self.tangents;
        // The upper of two slopes seen from the eave that it would start at.
        let upper = |edge: &Edge, eave: f64| edge.slope(eave + self.rise * (1.0 - second / first), second);
        let mut sides = Vec::new();
        match self.kind {
            RoofKind::Flat => sides.push(below(self.eaves[0])),
            RoofKind::Dome => {
                let centre = plan.centre();
                let radius = plan.edges().map(|edge| edge.inward(centre)).fold(f64::INFINITY, f64::min);
                sides.extend(plan.edges().flat_map(|edge| self.dome(edge, radius)));
            }
            RoofKind::Pyramid => {
                let apex = plan.centre();
                sides.extend(plan.edges().map(|edge| edge.slope(self.eaves[0], self.rise / edge.inward(apex))));
            }
            RoofKind::Mansard => {
                let parts = |edge: Edge| [edge.slope(self.eaves[0], first), upper(&edge, self.eaves[0])];
                sides.extend(plan.edges().filter(|edge| edge.side != Side::Other).flat_map(parts));
            }
            RoofKind::Shed | RoofKind::Gable | RoofKind::Hip | RoofKind::HalfHip | RoofKind::Gambrel => {
                for edge in plan.edges() {
                    match (self.kind, self.role(edge.side)) {
                        (RoofKind::Shed, Role::Eave(i)) if self.tangents[i] <= 0.0 => {}
                        (RoofKind::Shed | RoofKind::Gable, Role::Eave(i)) => {
                            sides.push(edge.slope(self.eaves[i], self.tangents[i]));
                        }
                        (RoofKind::Hip | RoofKind::HalfHip, Role::Eave(_)) => {
                            sides.push(edge.slope(self.eaves[0], first));
                        }
                        (RoofKind::Hip, Role::End(i)) if self.hipped[i] => {
                            sides.push(edge.slope(self.eaves[0], second))
                        }
                        (RoofKind::HalfHip, Role::End(i)) if self.hipped[i] => {
                            sides.push(edge.slope(self.eaves[0] + self.rise, second));
                        }
                        (RoofKind::Gambrel, Role::Eave(_)) => {
                            sides.extend([edge.slope(self.eaves[0], first), upper(&edge, self.eaves[0])]);
                        }
                        _ => {}
                    }
                }
            }
        }
        sides
    }

    /// The facets over one edge of a dome: chords of a quarter of an ellipse.
    fn dome(&self, edge: Edge, radius: f64) -> impl Iterator<Item = Plane> {
        let step = std::f64::consts::FRAC_PI_2 / f64::from(DOME_RINGS);
        (0..DOME_RINGS).map(move |ring| {
            let [low, high] = [ring, ring + 1].map(|i| {
                let (sin, cos) = (step * f64::from(i)).sin_cos();
                [radius * (1.0 - cos), self.rise * sin]
            });
            let tangent = (high[1] - low[1]) / (high[0] - low[0]);
            edge.slope(self.eaves[0] + low[1] - tangent * low[0], tangent)
        })
    }
}

/// A part of a building on one plan under one roof.
#[derive(Debug, Clone)]
pub(super) struct Block {
    pub(super) plan: Plan,
    pub(super) roof: Roof,
}

impl Block {
    /// From the ground to the roof.
    pub(super) fn body(&self) -> Convex {
        Convex::new(self.plan.walls(|_| 0.0)).and(self.roof.sides(&self.plan))
    }

    /// A roof of this thickness that reaches beyond the walls as `beyond` says for each side, metres: for each plane of
    /// the roof the part that is near to it.
    pub(super) fn overhang(&self, thickness: f64, beyond: impl Fn(Side) -> f64) -> Vec<Convex> {
        let whole = Convex::new(self.plan.walls(beyond)).and(self.roof.sides(&self.plan));
        let slab = |side: &Plane| {
            let under = Plane { normal: -side.normal, offset: -side.offset - thickness };
            whole.clone().and([under])
        };
        if self.roof.kind == RoofKind::Flat {
            return vec![whole.and([above(self.roof.eaves[0] - thickness)])];
        }
        self.roof.sides(&self.plan).iter().map(slab).collect()
    }
}
