//! Distance to the footprint's outline.

use geo::MultiPolygon;
use nalgebra::Point2;

/// The edges of a footprint.
#[derive(Debug)]
pub(crate) struct Outline {
    edges: Vec<[Point2<f64>; 2]>,
}

impl Outline {
    pub fn new(footprint: &MultiPolygon<f64>) -> Self {
        let edges = footprint
            .iter()
            .flat_map(|polygon| std::iter::once(polygon.exterior()).chain(polygon.interiors()))
            .flat_map(geo::LineString::lines)
            .map(|line| [Point2::new(line.start.x, line.start.y), Point2::new(line.end.x, line.end.y)])
            .collect();
        Self { edges }
    }

    /// Distance of a point of the plan to the outline, metres: positive inside the footprint.
    pub fn distance(&self, p: &Point2<f64>) -> f64 {
        let (mut nearest, mut inside) = (f64::INFINITY, false);
        for [a, b] in &self.edges {
            let (along, to) = (b - a, p - a);
            let length = along.norm_squared();
            let t = if length > 0.0 { (to.dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
            nearest = nearest.min((to - along * t).norm_squared());
            if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x) {
                inside = !inside;
            }
        }
        if inside { nearest.sqrt() } else { -nearest.sqrt() }
    }
}
