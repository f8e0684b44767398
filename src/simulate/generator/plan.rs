//! Plans: convex polygons whose edges know on which side of the building they are.

use geo::{Coord, LineString, Polygon};
use nalgebra::{Point2, Vector2};

use super::convex::{Convex, Placement, above, below, outward, slope, wall};
use crate::geometry::Plane;

/// An axis of the frame in which a building is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Axis {
    /// Along the front.
    U,
    /// From the front to the back.
    V,
}

/// A side of a building; the front is that of the lowest v.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Side {
    Front,
    Right,
    Back,
    Left,
    /// A cut corner, or an edge of a round building.
    Other,
}

impl Side {
    /// The four sides of a rectangle, counter-clockwise.
    pub(super) const ALL: [Self; 4] = [Self::Front, Self::Right, Self::Back, Self::Left];

    /// The axis along which it runs.
    pub(super) fn axis(self) -> Axis {
        if matches!(self, Self::Left | Self::Right) { Axis::V } else { Axis::U }
    }

    /// The axis across it.
    pub(super) fn across(self) -> Axis {
        if matches!(self, Self::Left | Self::Right) { Axis::U } else { Axis::V }
    }
}

/// A rectangle in the plan, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rectangle {
    /// From the left to the right.
    pub(super) u: [f64; 2],
    /// From the front to the back.
    pub(super) v: [f64; 2],
}

impl Rectangle {
    /// Its extent along an axis.
    pub(super) fn length(&self, axis: Axis) -> f64 {
        let [low, high] = self.range(axis);
        high - low
    }

    /// Where it lies along an axis.
    pub(super) fn range(&self, axis: Axis) -> [f64; 2] {
        match axis {
            Axis::U => self.u,
            Axis::V => self.v,
        }
    }

    /// Its centre.
    pub(super) fn centre(&self) -> Point2<f64> {
        Point2::new(f64::midpoint(self.u[0], self.u[1]), f64::midpoint(self.v[0], self.v[1]))
    }

    /// The rectangle that reaches `outward` metres beyond a side of this one and `inward` metres behind it, between two
    /// places along that side (coordinates of its axis).
    pub(super) fn beside(&self, side: Side, along: [f64; 2], inward: f64, outward: f64) -> Self {
        match side {
            Side::Front | Side::Other => Self { u: along, v: [self.v[0] - outward, self.v[0] + inward] },
            Side::Right => Self { u: [self.u[1] - inward, self.u[1] + outward], v: along },
            Side::Back => Self { u: along, v: [self.v[1] - inward, self.v[1] + outward] },
            Side::Left => Self { u: [self.u[0] - outward, self.u[0] + inward], v: along },
        }
    }

    /// The box on it between two heights; without a lower one it stands on the ground.
    pub(super) fn prism(&self, low: Option<f64>, high: f64) -> Convex {
        Convex::new(Plan::rectangle(*self).walls(|_| 0.0)).and(low.map(above)).and([below(high)])
    }
}

/// An edge of a plan, with the building on its left.
#[derive(Debug, Clone, Copy)]
pub(super) struct Edge {
    pub(super) from: Point2<f64>,
    pub(super) to: Point2<f64>,
    pub(super) side: Side,
}

impl Edge {
    /// The half-space under a roof that has this height over the edge and rises inwards with this tangent.
    pub(super) fn slope(&self, height: f64, tangent: f64) -> Plane {
        slope(self.from, self.to, height, tangent)
    }

    /// How far inside of the edge a place is, metres.
    pub(super) fn inward(&self, place: Point2<f64>) -> f64 {
        outward(self.from, self.to).dot(&(self.from - place))
    }

    /// Its length, metres.
    pub(super) fn length(&self) -> f64 {
        (self.to - self.from).norm()
    }

    /// The place so far along the edge and inside of it, metres.
    pub(super) fn at(&self, along: f64, inward: f64) -> Point2<f64> {
        self.from + (self.to - self.from).normalize() * along - outward(self.from, self.to) * inward
    }
}

/// A convex polygon, counter-clockwise.
#[derive(Debug, Clone)]
pub(super) struct Plan {
    corners: Vec<(Point2<f64>, Side)>,
}

impl Plan {
    /// A rectangle.
    pub(super) fn rectangle(Rectangle { u, v }: Rectangle) -> Self {
        let corners = [[u[0], v[0]], [u[1], v[0]], [u[1], v[1]], [u[0], v[1]]];
        Self { corners: corners.into_iter().map(Point2::from).zip(Side::ALL).collect() }
    }

    /// A rectangle whose right wall is turned: its corner at the back (at the front, if negative) moves inwards by
    /// `by` metres.
    pub(super) fn trapezium(rectangle: Rectangle, by: f64) -> Self {
        let mut plan = Self::rectangle(rectangle);
        if let Some((corner, _)) = plan.corners.get_mut(if by > 0.0 { 2 } else { 1 }) {
            corner.x -= by.abs();
        }
        plan
    }

    /// A rectangle whose front right corner is cut off, `along` metres from the front and `across` from the right wall.
    pub(super) fn chamfered(rectangle: Rectangle, along: f64, across: f64) -> Self {
        let mut plan = Self::rectangle(rectangle);
        let corner = Point2::new(rectangle.u[1], rectangle.v[0]);
        if let Some(right) = plan.corners.get_mut(1) {
            right.0 = corner + Vector2::y() * across;
        }
        plan.corners.insert(1, (corner - Vector2::x() * along, Side::Other));
        plan
    }

    /// A regular polygon whose edges are `apothem` metres from its centre; the first one is the front.
    pub(super) fn regular(centre: Point2<f64>, apothem: f64, count: u32) -> Self {
        let turn = std::f64::consts::TAU / f64::from(count);
        let radius = apothem / (turn / 2.0).cos();
        let corner = |i: u32| {
            let angle = turn * (f64::from(i) - 0.5) - std::f64::consts::FRAC_PI_2;
            centre + Vector2::new(angle.cos(), angle.sin()) * radius
        };
        Self { corners: (0..count).map(|i| (corner(i), Side::Other)).collect() }
    }

    /// Its edges, counter-clockwise.
    pub(super) fn edges(&self) -> impl Iterator<Item = Edge> {
        let next = self.corners.iter().cycle().skip(1);
        self.corners.iter().zip(next).map(|(&(from, side), &(to, _))| Edge { from, to, side })
    }

    /// The half-spaces of its walls, each moved outwards by what `beyond` says for its side, metres.
    pub(super) fn walls(&self, beyond: impl Fn(Side) -> f64) -> Vec<Plane> {
        self.edges().map(|edge| wall(edge.from, edge.to, beyond(edge.side))).collect()
    }

    /// The mean of its corners.
    pub(super) fn centre(&self) -> Point2<f64> {
        let sum: Vector2<f64> = self.corners.iter().map(|(corner, _)| corner.coords).sum();
        Point2::from(sum / self.corners.len().max(1) as f64)
    }

    /// The polygon in the local frame.
    pub(super) fn polygon(&self, placement: &Placement) -> Polygon<f64> {
        let corners = self.corners.iter().map(|(corner, _)| placement.place(*corner));
        let ring: Vec<Coord<f64>> = corners.map(|p| Coord { x: p.x, y: p.y }).collect();
        Polygon::new(LineString::new(ring), Vec::new())
    }
}
