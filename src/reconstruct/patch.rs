//! Distances to a face, which may have very many edges.

use nalgebra::{Point3, Vector3};
use rstar::primitives::Line;
use rstar::{AABB, PointDistance, RTree, RTreeObject};

use crate::geometry::{Aabb, PreparedPolygon};
use crate::solid::{Face, Solid};

/// From so many edges on, those near a point are looked up.
const FEW: usize = 32;

/// A face, made ready to measure distances to it.
pub(super) struct Patch {
    bounds: Aabb,
    normal: Vector3<f64>,
    /// The axis to project along: the largest component of the normal.
    dropped: usize,
    edges: Vec<[Point3<f64>; 2]>,
    lookup: Option<Lookup>,
}

/// The edges of a face that has many.
struct Lookup {
    projected: PreparedPolygon,
    tree: RTree<Line<[f64; 3]>>,
}

impl Patch {
    /// A face of a solid; `None` if it has no area.
    pub fn of(solid: &Solid, face: &Face) -> Option<Self> {
        let normal = solid.newell(face.rings.first()?).try_normalize(0.0)?;
        let edges: Vec<[Point3<f64>; 2]> = face
            .rings
            .iter()
            .flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)))
            .map(|(&a, &b)| [solid.point(a), solid.point(b)])
            .collect();
        let bounds = Aabb::of(edges.iter().map(|[a, _]| a))?;
        let dropped = normal.iamax();
        let lookup = (edges.len() >= FEW).then(|| Lookup {
            projected: PreparedPolygon::of_edges(edges.iter().map(|edge| edge.map(|end| projected(&end, dropped)))),
            tree: RTree::bulk_load(edges.iter().map(|[a, b]| Line::new((*a).into(), (*b).into())).collect()),
        });
        Some(Self { bounds, normal, dropped, edges, lookup })
    }

    /// The squared distance of a point.
    fn squared_distance(&self, p: &Point3<f64>) -> f64 {
        let Some([anchor, _]) = self.edges.first() else { return f64::INFINITY };
        let distance = self.normal.dot(&(p - anchor));
        if self.holds(&(p - self.normal * distance)) {
            return distance * distance;
        }
        if let Some(Lookup { tree, .. }) = &self.lookup {
            let place = [p.x, p.y, p.z];
            return tree.nearest_neighbor(&place).map_or(f64::INFINITY, |edge| edge.distance_2(&place));
        }
        let to_edge = |[a, b]: &[Point3<f64>; 2]| {
            let along = b - a;
            let t = (along.dot(&(p - a)) / along.norm_squared()).clamp(0.0, 1.0);
            (a + along * t - p).norm_squared()
        };
        self.edges.iter().map(to_edge).fold(f64::INFINITY, f64::min)
    }

    /// Whether a point of the plane lies in the face (even-odd rule, seen along the largest axis of the normal).
    fn holds(&self, p: &Point3<f64>) -> bool {
        let [u, v] = projected(p, self.dropped);
        if let Some(Lookup { projected, .. }) = &self.lookup {
            return projected.contains([u, v]);
        }
        let crossings = self.edges.iter().filter(|edge| {
            let [a, b] = edge.map(|end| projected(&end, self.dropped));
            (a[1] > v) != (b[1] > v) && u < a[0] + (v - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
        });
        crossings.count() % 2 == 1
    }
}

/// The other two coordinates.
fn projected(p: &Point3<f64>, dropped: usize) -> [f64; 2] {
    [p[(dropped + 1) % 3], p[(dropped + 2) % 3]]
}

impl RTreeObject for Patch {
    type Envelope = AABB<[f64; 3]>;

    fn envelope(&self) -> Self::Envelope {
        AABB::from_corners(self.bounds.min, self.bounds.max)
    }
}

impl PointDistance for Patch {
    fn distance_2(&self, point: &[f64; 3]) -> f64 {
        self.squared_distance(&Point3::from(*point))
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::solid::{Surface, SurfaceType};

    /// A star of so many corners, 10 m and 8 m from its centre, on a plane that rises with x.
    fn star(corners: u32) -> Patch {
        let corner = |i: u32| {
            let angle = TAU * f64::from(i) / f64::from(corners);
            let reach = if i.is_multiple_of(2) { 10.0 } else { 8.0 };
            let [x, y] = [reach * angle.cos(), reach * angle.sin()];
            [x, y, 0.5 * x].map(|c| (c * 1e4).round() as i64)
        };
        let vertices = (0..corners).map(corner).collect();
        let face = Face { rings: vec![(0..corners).collect()], surface: 0 };
        let surfaces = vec![Surface::of(SurfaceType::Roof)];
        let solid = Solid { step: [1e-4; 3], vertices, faces: vec![face.clone()], surfaces };
        Patch::of(&solid, &face).unwrap()
    }

    #[test]
    fn many_edges_are_as_far_as_they_are_one_by_one() {
        let quick = star(400);
        let mut plain = star(400);
        assert!(plain.lookup.take().is_some() && star(20).lookup.is_none());
        for i in -24..=24 {
            for j in -24..=24 {
                let p = [f64::from(i) * 0.51, f64::from(j) * 0.49, 1.3];
                let [a, b] = [&quick, &plain].map(|patch| patch.distance_2(&p));
                assert!((a - b).abs() < 1e-9, "{p:?}: {a} {b}");
            }
        }
        assert!(quick.distance_2(&[0.0, 0.0, 1.0]) < 0.81 && quick.distance_2(&[11.0, 0.0, 5.0]) > 0.99);
    }
}
