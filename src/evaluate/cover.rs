//! What lies over a point of the map: triangles indexed by their projection.

use nalgebra::Point3;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};

/// Triangles that are not vertical, indexed by their projection on the xy-plane.
#[derive(Debug, Clone)]
pub struct Cover {
    tree: RTree<Projected>,
}

/// A triangle with the rectangle around its projection.
type Projected = GeomWithData<Rectangle<[f64; 2]>, [Point3<f64>; 3]>;

impl Cover {
    /// Indexes the triangles; those whose projection has no area are left out, since they lie over no point.
    pub fn new(triangles: impl IntoIterator<Item = [Point3<f64>; 3]>) -> Self {
        let items = triangles
            .into_iter()
            .filter(|t| projected_area(t).abs() > 1e-12)
            .map(|t| {
                let corners = t.map(|p| [p.x, p.y]);
                let aabb = AABB::from_points(corners.iter());
                GeomWithData::new(Rectangle::from_aabb(aabb), t)
            })
            .collect();
        Self { tree: RTree::bulk_load(items) }
    }

    /// Whether there is no triangle.
    pub fn is_empty(&self) -> bool {
        self.tree.size() == 0
    }

    /// Whether some triangle lies over `(x, y)`; borders count.
    pub fn contains(&self, x: f64, y: f64) -> bool {
        self.heights(x, y).next().is_some()
    }

    /// Heights of the triangles over `(x, y)`, in no order; borders count, so a point on a shared edge appears twice.
    pub fn heights(&self, x: f64, y: f64) -> impl Iterator<Item = f64> + '_ {
        self.tree.locate_all_at_point(&[x, y]).filter_map(move |item| height_over(&item.data, x, y))
    }

    /// Height of the triangle over `(x, y)` that is nearest to `z`; the lower of two that are equally near.
    pub fn nearest_height(&self, x: f64, y: f64, z: f64) -> Option<f64> {
        self.heights(x, y).min_by(|a, b| (a - z).abs().total_cmp(&(b - z).abs()).then(a.total_cmp(b)))
    }
}

/// Signed area of the projection on the xy-plane; positive when the triangle looks up.
pub fn projected_area(t: &[Point3<f64>; 3]) -> f64 {
    let [a, b, c] = t;
    ((b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x)) / 2.0
}

/// Height of the triangle over `(x, y)`, `None` beside it. A point is beside it when a barycentric coordinate is below
/// −1e-9: laser points lie on the millimetre grid of the outlines, and one on a shared edge must not fall between.
fn height_over(t: &[Point3<f64>; 3], x: f64, y: f64) -> Option<f64> {
    let [a, b, c] = t;
    let double = 2.0 * projected_area(t);
    let wb = ((x - a.x) * (c.y - a.y) - (y - a.y) * (c.x - a.x)) / double;
    let wc = ((b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x)) / double;
    let wa = 1.0 - wb - wc;
    (wa >= -1e-9 && wb >= -1e-9 && wc >= -1e-9).then(|| wa * a.z + wb * b.z + wc * c.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_of_two_storeys_is_found_and_nothing_beside_them() {
        let sloped = [Point3::new(0.0, 0.0, 3.0), Point3::new(4.0, 0.0, 5.0), Point3::new(0.0, 4.0, 3.0)];
        let low = sloped.map(|p| Point3::new(p.x, p.y, 0.0));
        let wall = [Point3::new(0.0, 0.0, 0.0), Point3::new(4.0, 0.0, 0.0), Point3::new(4.0, 0.0, 9.0)];
        let cover = Cover::new([sloped, low, wall]);
        // On the slope z = 3 + x/2.
        assert!((cover.nearest_height(1.0, 1.0, 3.0).unwrap() - 3.5).abs() < 1e-12);
        assert_eq!(cover.nearest_height(1.0, 1.0, 1.0), Some(0.0));
        assert_eq!(cover.nearest_height(3.0, 3.0, 1.0), None);
        assert!(cover.contains(2.0, 0.0) && cover.contains(0.0, 0.0) && !cover.contains(2.0, -0.001));
    }
}
