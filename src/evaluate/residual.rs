//! How far points lie from a model, and on which side.

use nalgebra::Point3;

use super::hausdorff::NearestFace;
use super::shape::Shape;
use crate::geometry::Cover;

/// Whether a point is inside is asked this far beside it, metres: on a border between two triangles both would count.
const BESIDE: [f64; 2] = [1.3e-5, 0.7e-5];

/// The closed surface of a building, searchable for how far outside of it a point lies.
pub struct Residuals {
    nearest: NearestFace,
    cover: Cover,
}

impl Residuals {
    /// Those from the faces of `shape`, which are closed; `None` when it has none.
    pub fn new(shape: &Shape) -> Option<Self> {
        let cover = Cover::new(shape.triangles.iter().map(|(triangle, _)| *triangle));
        NearestFace::new(shape).map(|nearest| Self { nearest, cover })
    }

    /// Distance of a point to the nearest face, metres; negative inside.
    pub fn of(&self, p: &Point3<f64>) -> f64 {
        let above = self.cover.heights(p.x + BESIDE[0], p.y + BESIDE[1]).filter(|height| *height > p.z).count();
        let distance = self.nearest.distance(p);
        if above % 2 == 1 { -distance } else { distance }
    }
}

#[cfg(test)]
mod tests {
    use super::super::shape::tests::block;
    use super::*;

    #[test]
    fn what_lies_in_a_block_is_negative() {
        let residuals = Residuals::new(&block("a", [0.0; 3], [10.0, 8.0, 6.0])).unwrap();
        // On the diagonal of the roof, where two triangles meet, too.
        for (p, expected) in
            [([5.0, 4.0, 6.5], 0.5), ([5.0, 4.0, 5.5], -0.5), ([5.0, 4.0, -1.0], 1.0), ([12.0, 4.0, 3.0], 2.0)]
        {
            assert!((residuals.of(&Point3::from(p)) - expected).abs() < 1e-9, "{p:?}");
        }
    }
}
