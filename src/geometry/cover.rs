//! What lies over a point of the map: triangles indexed by their projection.

use nalgebra::Point3;

/// Squares of the index per triangle.
const SQUARES: f64 = 4.0;
/// Most squares along one side of the index.
const LONGEST: f64 = 1024.0;
/// A triangle is entered this far beyond its borders, metres, so that a point on a border finds it.
const SLACK: f64 = 1e-6;

/// Triangles that are not vertical, indexed by their projection on the xy-plane.
///
/// Each square of a grid lists the triangles that reach into it, found row by row: the long, thin triangles of a large
/// roof stand only in the squares that they cross, not in all of the box around them.
#[derive(Debug, Clone)]
pub struct Cover {
    triangles: Vec<[Point3<f64>; 3]>,
    min: [f64; 2],
    /// Side of a square, metres.
    side: f64,
    /// Columns and rows.
    size: [usize; 2],
    /// Where the list of each square begins in `listed`, and at the end its length.
    starts: Vec<u32>,
    listed: Vec<u32>,
}

impl Cover {
    /// Indexes the triangles; those whose projection has no area are left out, since they lie over no point.
    pub fn new(triangles: impl IntoIterator<Item = [Point3<f64>; 3]>) -> Self {
        let triangles: Vec<_> = triangles.into_iter().filter(|t| projected_area(t).abs() > 1e-12).collect();
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in triangles.iter().flatten() {
            for axis in 0..2 {
                min[axis] = min[axis].min(p[axis]);
                max[axis] = max[axis].max(p[axis]);
            }
        }
        if triangles.is_empty() {
            (min, max) = ([0.0; 2], [0.0; 2]);
        }
        let extent = [max[0] - min[0], max[1] - min[1]];
        let even = (extent[0] * extent[1] / (SQUARES * triangles.len().max(1) as f64)).sqrt();
        let side = even.max(extent[0] / LONGEST).max(extent[1] / LONGEST).max(SLACK);
        let size = extent.map(|length| ((length / side) as usize + 1).min(LONGEST as usize + 1));
        let mut cover = Self { triangles, min, side, size, starts: Vec::new(), listed: Vec::new() };
        let mut entries: Vec<(u32, u32)> = Vec::new();
        for (triangle, index) in cover.triangles.iter().zip(0_u32..) {
            cover.each_square(triangle, |square| entries.push((square as u32, index)));
        }
        entries.sort_unstable();
        let squares = cover.size[0] * cover.size[1];
        cover.starts = vec![0; squares + 1];
        for (square, _) in &entries {
            if let Some(start) = cover.starts.get_mut(*square as usize + 1) {
                *start += 1;
            }
        }
        for square in 0..squares {
            cover.starts[square + 1] += cover.starts[square];
        }
        cover.listed = entries.into_iter().map(|(_, index)| index).collect();
        cover
    }

    /// Whether there is no triangle.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Whether some triangle lies over `(x, y)`; borders count.
    pub fn contains(&self, x: f64, y: f64) -> bool {
        self.heights(x, y).next().is_some()
    }

    /// Heights of the triangles over `(x, y)`, in no order; borders count, so a point on a shared edge appears twice.
    pub fn heights(&self, x: f64, y: f64) -> impl Iterator<Item = f64> + '_ {
        let square = self.band(1, y) * self.size[0] + self.band(0, x);
        let ends = self.starts.get(square).zip(self.starts.get(square + 1));
        let listed = ends.and_then(|(&from, &to)| self.listed.get(from as usize..to as usize)).unwrap_or_default();
        listed.iter().filter_map(move |&index| height_over(self.triangles.get(index as usize)?, x, y))
    }

    /// Height of the triangle over `(x, y)` that is nearest to `z`; the lower of two that are equally near.
    pub fn nearest_height(&self, x: f64, y: f64, z: f64) -> Option<f64> {
        self.heights(x, y).min_by(|a, b| (a - z).abs().total_cmp(&(b - z).abs()).then(a.total_cmp(b)))
    }

    /// Height of the highest triangle over `(x, y)`.
    pub fn highest(&self, x: f64, y: f64) -> Option<f64> {
        self.heights(x, y).max_by(f64::total_cmp)
    }

    /// Tells `visit` each square that the triangle reaches into, once.
    fn each_square(&self, triangle: &[Point3<f64>; 3], mut visit: impl FnMut(usize)) {
        let ys = triangle.map(|p| p.y);
        let (low, high) =
            (ys.into_iter().fold(f64::INFINITY, f64::min), ys.into_iter().fold(f64::NEG_INFINITY, f64::max));
        for row in self.band(1, low - SLACK)..=self.band(1, high + SLACK) {
            let bottom = self.min[1] + row as f64 * self.side - SLACK;
            let top = bottom + self.side + 2.0 * SLACK;
            let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
            for (a, b) in [(0, 1), (1, 2), (2, 0)] {
                let (a, b) = (&triangle[a], &triangle[b]);
                let (a, b) = if a.y <= b.y { (a, b) } else { (b, a) };
                if b.y < bottom || a.y > top {
                    continue;
                }
                let at = |y: f64| if b.y > a.y { a.x + (y - a.y) / (b.y - a.y) * (b.x - a.x) } else { a.x };
                let ends = [at(a.y.max(bottom)), if b.y > top { at(top) } else { b.x }];
                left = ends.into_iter().fold(left, f64::min);
                right = ends.into_iter().fold(right, f64::max);
            }
            if left <= right {
                for column in self.band(0, left - SLACK)..=self.band(0, right + SLACK) {
                    visit(row * self.size[0] + column);
                }
            }
        }
    }

    /// The column (`axis` 0) or row (1) of a coordinate; the first or last of one beside the grid.
    fn band(&self, axis: usize, value: f64) -> usize {
        // A cast from float to integer saturates, so what lies before the grid gives 0.
        (((value - self.min[axis]) / self.side) as usize).min(self.size[axis] - 1)
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
    use crate::geometry::Random;

    #[test]
    fn the_nearest_of_two_storeys_is_found_and_nothing_beside_them() {
        let sloped = [Point3::new(0.0, 0.0, 3.0), Point3::new(4.0, 0.0, 5.0), Point3::new(0.0, 4.0, 3.0)];
        let low = sloped.map(|p| Point3::new(p.x, p.y, 0.0));
        let wall = [Point3::new(0.0, 0.0, 0.0), Point3::new(4.0, 0.0, 0.0), Point3::new(4.0, 0.0, 9.0)];
        let cover = Cover::new([sloped, low, wall]);
        // On the slope z = 3 + x/2.
        assert!((cover.nearest_height(1.0, 1.0, 3.0).unwrap() - 3.5).abs() < 1e-12);
        assert_eq!(cover.nearest_height(1.0, 1.0, 1.0), Some(0.0));
        assert!((cover.highest(1.0, 1.0).unwrap() - 3.5).abs() < 1e-12);
        assert_eq!(cover.nearest_height(3.0, 3.0, 1.0), None);
        assert!(cover.contains(2.0, 0.0) && cover.contains(0.0, 0.0) && !cover.contains(2.0, -0.001));
        assert!(Cover::new([wall]).is_empty() && !Cover::new([]).contains(0.0, 0.0));
    }

    #[test]
    fn the_index_finds_what_a_search_through_all_triangles_finds() {
        let mut random = Random::new(7);
        let mut corner = |reach: f64| Point3::new(random.between(0.0, reach), random.between(-5.0, 5.0), 1.0);
        // Slivers, among them some across the whole, and small ones.
        let triangles: Vec<_> = (0..300)
            .map(|i| {
                let a = corner(60.0);
                let b = if i % 3 == 0 { corner(60.0) } else { corner(0.5) + a.coords * 0.9 };
                [a, b, a + (b - a) * 0.5 + (corner(1.0).coords - corner(1.0).coords) * 0.1]
            })
            .collect();
        let cover = Cover::new(triangles.iter().copied());
        let seen: Vec<_> = triangles.iter().filter(|t| projected_area(t).abs() > 1e-12).collect();
        for (i, t) in seen.iter().enumerate() {
            let centre = t[0] + ((t[1] - t[0]) + (t[2] - t[0])) / 3.0;
            for p in [centre, t[0], t[1], corner(60.0)] {
                let expected = seen.iter().filter(|t| height_over(t, p.x, p.y).is_some()).count();
                assert_eq!(cover.heights(p.x, p.y).count(), expected, "triangle {i}");
            }
        }
    }
}
