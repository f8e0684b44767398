//! Traces: vertical planes seen from above.

use nalgebra::{Point2, Point3, Unit, Vector2, Vector3};

use super::{Extent, Primitive, PrimitiveKind};
use crate::geometry::Plane;

/// A vertical plane seen from above: the line `normal · p = offset` and the stretch of it that was seen.
///
/// Walls are hardly scanned from the air; their planes come from lines in the plan (method, section 9).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Trace {
    /// Unit normal in the plan.
    pub normal: Unit<Vector2<f64>>,
    /// Distance of the line from the origin along the normal, metres.
    pub offset: f64,
    /// Where the stretch begins and ends along [`Self::direction`], metres; `from <= to`.
    pub span: [f64; 2],
    /// What it is a trace of.
    pub kind: PrimitiveKind,
}

impl Trace {
    /// The trace from `a` to `b`; `None` when they are closer than a micrometre.
    pub fn between(a: Point2<f64>, b: Point2<f64>, kind: PrimitiveKind) -> Option<Self> {
        let along = Unit::try_new(b - a, 1e-6)?;
        let normal = Unit::new_unchecked(Vector2::new(along.y, -along.x));
        let direction = direction(&normal);
        let (s, t) = (direction.dot(&a.coords), direction.dot(&b.coords));
        Some(Self { normal, offset: normal.dot(&a.coords), span: [s.min(t), s.max(t)], kind })
    }

    /// Unit vector along the line: the normal turned left.
    pub fn direction(&self) -> Vector2<f64> {
        direction(&self.normal)
    }

    /// Length of the stretch in metres.
    pub fn length(&self) -> f64 {
        self.span[1] - self.span[0]
    }

    /// The point of the line at `t` along its direction.
    pub fn at(&self, t: f64) -> Point2<f64> {
        Point2::from(self.normal.into_inner() * self.offset + self.direction() * t)
    }

    /// Signed distance of a point in the plan from the line, metres.
    pub fn distance(&self, p: &Point2<f64>) -> f64 {
        self.normal.dot(&p.coords) - self.offset
    }

    /// How far `other` leaves this line at most, over the stretch of `other`.
    pub fn deviation(&self, other: &Self) -> f64 {
        other.span.map(|t| self.distance(&other.at(t)).abs()).into_iter().fold(0.0, f64::max)
    }

    /// The same stretch moved onto the line of `carrier`, so that both give the very same plane.
    #[must_use]
    pub fn onto(&self, carrier: &Self) -> Self {
        let direction = carrier.direction();
        let [a, b] = self.span.map(|t| direction.dot(&self.at(t).coords));
        Self { span: [a.min(b), a.max(b)], kind: self.kind, ..*carrier }
    }

    /// The primitive of this trace: its vertical plane, reaching over the stretch lengthened by `margin` metres at both
    /// ends and from `heights[0]` to `heights[1]`.
    pub fn primitive(&self, heights: [f64; 2], margin: f64) -> Primitive {
        let normal = Unit::new_unchecked(Vector3::new(self.normal.x, self.normal.y, 0.0));
        let (a, b) = (self.at(self.span[0] - margin), self.at(self.span[1] + margin));
        let [low, high] = heights;
        Primitive {
            kind: self.kind,
            plane: Plane { normal, offset: -self.offset },
            inliers: Vec::new(),
            residual: 0.0,
            extent: Extent::Patch(vec![
                Point3::new(a.x, a.y, low),
                Point3::new(b.x, b.y, low),
                Point3::new(b.x, b.y, high),
                Point3::new(a.x, a.y, high),
            ]),
        }
    }
}

fn direction(normal: &Unit<Vector2<f64>>) -> Vector2<f64> {
    Vector2::new(-normal.y, normal.x)
}

/// Moves `traces` that leave the line of a more important one by at most `tolerance` metres onto it, so that almost
/// coincident planes, which would cut slivers, become one. The `carriers` come first and stay; among the traces longer
/// ones do.
pub fn regularise(traces: &mut [Trace], carriers: &[Trace], tolerance: f64) {
    let mut order: Vec<usize> = (0..traces.len()).collect();
    order.sort_by(|&a, &b| traces[b].length().total_cmp(&traces[a].length()).then(a.cmp(&b)));
    let mut carriers = carriers.to_vec();
    for index in order {
        let trace = traces[index];
        let nearest = carriers
            .iter()
            .map(|carrier| (carrier.deviation(&trace), carrier))
            .filter(|(deviation, _)| *deviation <= tolerance)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        match nearest {
            Some((_, carrier)) => traces[index] = trace.onto(carrier),
            None => carriers.push(trace),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn edge(a: [f64; 2], b: [f64; 2]) -> Trace {
        Trace::between(Point2::from(a), Point2::from(b), PrimitiveKind::FootprintEdge).unwrap()
    }

    #[test]
    fn a_trace_knows_its_ends_and_its_plane() {
        let trace = edge([1.0, 2.0], [4.0, 6.0]);
        assert!((trace.length() - 5.0).abs() < 1e-12);
        let ends = trace.span.map(|t| trace.at(t));
        assert!(ends.iter().any(|p| (p - Point2::new(1.0, 2.0)).norm() < 1e-12));
        assert!(ends.iter().any(|p| (p - Point2::new(4.0, 6.0)).norm() < 1e-12));
        let primitive = trace.primitive([0.0, 9.0], 0.5);
        assert!(primitive.plane.distance(&Point3::new(4.0, 6.0, 3.0)).abs() < 1e-12);
        assert!(primitive.plane.verticality() > 0.999);
    }

    #[test]
    fn almost_collinear_traces_share_one_plane_and_others_do_not() {
        let carrier = edge([0.0, 0.0], [10.0, 0.0]);
        let mut traces =
            [edge([14.0, 0.04], [12.0, 0.05]), edge([0.0, 0.3], [2.0, 0.3]), edge([0.0, 0.33], [5.0, 0.33])];
        regularise(&mut traces, &[carrier], 0.1);
        assert_eq!((traces[0].normal, traces[0].offset), (carrier.normal, carrier.offset));
        assert!((traces[0].length() - 2.0).abs() < 1e-3);
        // The longer one of the others carries the shorter.
        assert!(traces[1].offset == traces[2].offset && (traces[1].offset.abs() - 0.33).abs() < 1e-12);
    }
}
