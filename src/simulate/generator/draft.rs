//! What is drawn of a building, and from it to the solid.

use geo::{Area, BooleanOps, MultiPolygon, Validation};
use nalgebra::{Point2, Vector3};

use super::convex::{Convex, Placement};
use super::error::Flaw;
use super::expression::Expression;
use super::plan::{Plan, Rectangle, Side};
use super::roof::{Block, Roof, RoofKind};
use super::{Generated, Shape};
use crate::geometry::Random;
use crate::reconstruct::primitives::footprint_edges::simplify;
use crate::site::Frame;

/// Vertices of the outline that are not needed to stay this near to it are left out, metres.
const OUTLINE_TOLERANCE: f64 = 5e-4;
/// An outline of less is none, m².
const LEAST_OUTLINE: f64 = 1.0;

/// The block that all others are attached to.
#[derive(Debug, Clone)]
pub(super) struct Host {
    pub(super) block: Block,
    /// From the ground to the roof.
    pub(super) body: Convex,
    /// The rectangle that its plan was cut from, or what of it is open to the sky.
    pub(super) rectangle: Rectangle,
    /// By how much a wall may lie inside of the rectangle, metres.
    pub(super) recess: f64,
}

impl Host {
    /// The host on a plan that was cut from `rectangle`.
    pub(super) fn new(plan: Plan, roof: Roof, rectangle: Rectangle, recess: f64) -> Self {
        let block = Block { plan, roof };
        Self { body: block.body(), block, rectangle, recess }
    }

    /// Height of the lowest eave.
    pub(super) fn eave(&self) -> f64 {
        self.block.roof.eaves[0].min(self.block.roof.eaves[1])
    }

    /// How far inside of the middle of a side (between two places along it) the roof is highest, and how high, metres.
    pub(super) fn crest(&self, side: Side, along: [f64; 2]) -> (f64, f64) {
        let depth = self.rectangle.length(side.across());
        let middle = f64::midpoint(along[0], along[1]);
        let steps = (depth / STEP).floor() as u32;
        (0..=steps)
            .map(|i| f64::from(i) * STEP)
            .map(|inward| {
                (inward, self.body.top_at(self.rectangle.beside(side, [middle; 2], inward, -inward).centre()))
            })
            .fold((0.0, f64::NEG_INFINITY), |best, next| if next.1 > best.1 + 1e-9 { next } else { best })
    }

    /// Whether a place is in its plan, at least `margin` metres from all walls.
    pub(super) fn covers(&self, place: Point2<f64>, margin: f64) -> bool {
        self.block.plan.edges().all(|edge| edge.inward(place) >= margin)
    }
}

/// Distance of the places at which the crest of a roof is looked for, metres.
const STEP: f64 = 0.1;

/// A building in the frame in which it is drawn: the main ridge along x, the front at the lowest y, the ground at 0.
#[derive(Debug, Clone)]
pub(super) struct Draft {
    pub(super) shape: Shape,
    pub(super) expression: Expression,
    /// What is drawn into the outline.
    pub(super) outline: Vec<Plan>,
    /// What is cut out of it.
    pub(super) courts: Vec<Plan>,
    pub(super) neighbours: Vec<Expression>,
    /// Stretches of the sides of the host that are no longer free (coordinates along the side's axis).
    pub(super) taken: Vec<(Side, [f64; 2])>,
    pub(super) placement: Placement,
    pub(super) frame: Frame,
    pub(super) ground: f64,
}

impl Draft {
    /// An empty draft somewhere.
    pub(super) fn new(random: &mut Random, roof: RoofKind, shear: f64) -> Self {
        let ground = hundredth(random.between(-4.0, 60.0));
        let shift = Vector3::new(random.between(-2.0, 2.0), random.between(-2.0, 2.0), ground);
        let angle = random.between(0.0, std::f64::consts::TAU);
        let origin = [100_000.0 + random.below(100_000) as f64, 400_000.0 + random.below(100_000) as f64, 0.0];
        Self {
            shape: Shape {
                roof,
                blocks: 0,
                dormers: 0,
                chimneys: 0,
                courtyard: false,
                overhang: false,
                arcade: false,
                eaves: false,
                party_walls: 0,
            },
            expression: Expression::default(),
            outline: Vec::new(),
            courts: Vec::new(),
            neighbours: Vec::new(),
            taken: Vec::new(),
            placement: Placement::new(shear, angle, shift),
            frame: Frame { origin, metres_per_unit: [1.0; 3] },
            ground,
        }
    }

    /// Adds a piece that is not part of the outline.
    pub(super) fn add(&mut self, piece: Convex) {
        self.expression.added.push(piece);
    }

    /// Adds a block.
    pub(super) fn add_block(&mut self, body: Convex, plan: Plan) {
        self.add(body);
        self.outline.push(plan);
        self.shape.blocks += 1;
    }

    /// Whether a stretch of a side is free, with a metre to spare on both ends.
    pub(super) fn is_free(&self, side: Side, along: [f64; 2]) -> bool {
        self.taken.iter().all(|(taken, [low, high])| *taken != side || along[1] + 1.0 < *low || along[0] - 1.0 > *high)
    }

    /// Whether nothing is attached to a side.
    pub(super) fn is_bare(&self, side: Side) -> bool {
        self.taken.iter().all(|(taken, _)| *taken != side)
    }

    /// Reserves a whole side.
    pub(super) fn reserve(&mut self, side: Side) {
        self.taken.push((side, [f64::NEG_INFINITY, f64::INFINITY]));
    }

    /// The building, if the draft is a valid solid.
    pub(super) fn finish(self) -> Result<Generated, Flaw> {
        let footprint = self.footprint()?;
        let step = self.frame.step();
        let solid = self.placed(&self.expression).solid(step, &footprint)?;
        let neighbours = self.neighbours.iter().map(|neighbour| self.placed(neighbour).solid(step, &footprint));
        let neighbours = neighbours.collect::<Result<Vec<_>, Flaw>>()?;
        let Self { shape, frame, ground, .. } = self;
        Ok(Generated { solid, frame, footprint, ground, neighbours, shape })
    }

    /// An expression in the local frame.
    pub(super) fn placed(&self, expression: &Expression) -> Expression {
        let place = |pieces: &[Convex]| pieces.iter().map(|piece| piece.placed(&self.placement)).collect();
        Expression { added: place(&expression.added), removed: place(&expression.removed), ground: self.ground }
    }

    fn footprint(&self) -> Result<MultiPolygon<f64>, Flaw> {
        let polygons = |plans: &[Plan]| -> MultiPolygon<f64> {
            let polygons = plans.iter().map(|plan| MultiPolygon::from(plan.polygon(&self.placement)));
            polygons.reduce(|all, next| all.union(&next)).unwrap_or(MultiPolygon(Vec::new()))
        };
        let whole = polygons(&self.outline);
        let whole = if self.courts.is_empty() { whole } else { whole.difference(&polygons(&self.courts)) };
        let outline = simplify(&whole, OUTLINE_TOLERANCE);
        let sound = outline.0.len() == 1 && outline.is_valid() && outline.unsigned_area() > LEAST_OUTLINE;
        if sound { Ok(outline) } else { Err(Flaw::Outline) }
    }
}

/// To decimetres: two walls are flush or apart, and never nearly flush.
pub(super) fn tenth(metres: f64) -> f64 {
    (metres * 10.0).round() / 10.0
}

fn hundredth(metres: f64) -> f64 {
    (metres * 100.0).round() / 100.0
}

/// The tangent of an angle between two angles in degrees.
pub(super) fn tangent(random: &mut Random, low: f64, high: f64) -> f64 {
    random.between(low, high).to_radians().tan()
}
