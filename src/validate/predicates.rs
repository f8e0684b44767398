//! Exact predicates on integer coordinates.
//!
//! Coordinates are below 2⁴⁰ grid steps (100 000 km), so a 2-D determinant is below 2⁸³ and a 3-D one below 2¹²⁵.

use crate::solid::Solid;

pub(super) type Point2 = [i64; 2];
pub(super) type Point3 = [i64; 3];

/// A projection along a coordinate axis that keeps the orientation of what faces the viewer.
#[derive(Debug, Clone, Copy)]
pub(super) struct Projection {
    axes: [usize; 2],
}

impl Projection {
    /// Along the axis in which the normal is longest, so that counter-clockwise stays counter-clockwise; `None` for a
    /// normal of length zero.
    pub(super) fn along(normal: [i128; 3]) -> Option<Self> {
        let axis = (0..3).max_by_key(|&axis| (normal[axis].unsigned_abs(), 2 - axis))?;
        let axes = [(axis + 1) % 3, (axis + 2) % 3];
        match normal[axis].signum() {
            0 => None,
            1 => Some(Self { axes }),
            _ => Some(Self { axes: [axes[1], axes[0]] }),
        }
    }

    pub(super) fn ring(self, solid: &Solid, ring: &[u32]) -> Vec<Point2> {
        ring.iter().map(|&v| self.point(solid.vertices[v as usize])).collect()
    }

    pub(super) fn point(self, p: Point3) -> Point2 {
        self.axes.map(|axis| p[axis])
    }
}

/// Twice the vector area of a ring in grid steps (Newell).
pub(super) fn newell(solid: &Solid, ring: &[u32]) -> [i128; 3] {
    let mut sum = [0i128; 3];
    let Some(&first) = ring.first() else { return sum };
    let anchor = solid.vertices[first as usize];
    for pair in ring.windows(2) {
        let [a, b] = [pair[0], pair[1]].map(|v| subtract(solid.vertices[v as usize], anchor));
        let c = cross(a, b);
        sum.iter_mut().zip(c).for_each(|(s, c)| *s += c);
    }
    sum
}

pub(super) fn subtract(a: Point3, b: Point3) -> [i128; 3] {
    std::array::from_fn(|i| i128::from(a[i]) - i128::from(b[i]))
}

pub(super) fn cross(a: [i128; 3], b: [i128; 3]) -> [i128; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn dot(a: [i128; 3], b: [i128; 3]) -> i128 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// 1 if `c` is to the left of the line from `a` to `b`, −1 to the right, 0 on it.
pub(super) fn orient2(a: Point2, b: Point2, c: Point2) -> i32 {
    let [a, b, c] = [a, b, c].map(|p| p.map(i128::from));
    ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).signum() as i32
}

/// 1 if `d` is on the side of the triangle from which `a`, `b`, `c` are counter-clockwise, −1 on the other, 0 on the
/// plane.
pub(super) fn orient3(a: Point3, b: Point3, c: Point3, d: Point3) -> i32 {
    dot(cross(subtract(b, a), subtract(c, a)), subtract(d, a)).signum() as i32
}

/// Whether `p`, known to be on the line through `a` and `b`, is between them or one of them.
fn between(a: Point2, b: Point2, p: Point2) -> bool {
    (0..2).all(|i| p[i] >= a[i].min(b[i]) && p[i] <= a[i].max(b[i]))
}

/// Whether `p` is on the closed segment.
pub(super) fn on_segment(a: Point2, b: Point2, p: Point2) -> bool {
    orient2(a, b, p) == 0 && between(a, b, p)
}

/// Whether `p` is on the closed segment in space.
pub(super) fn on_segment3(a: Point3, b: Point3, p: Point3) -> bool {
    (0..3).all(|i| p[i] >= a[i].min(b[i]) && p[i] <= a[i].max(b[i])) && cross(subtract(b, a), subtract(p, a)) == [0; 3]
}

/// How two segments meet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Meeting {
    /// Not at all.
    Apart,
    /// In one point, which is an end of at least one of them.
    Touch(Point2),
    /// In one point inside both.
    Cross,
    /// Along a piece of positive length.
    Overlap,
}

/// How the segments `a b` and `c d`, of positive length, meet.
pub(super) fn meet([a, b]: [Point2; 2], [c, d]: [Point2; 2]) -> Meeting {
    let apart = (0..2).any(|i| a[i].max(b[i]) < c[i].min(d[i]) || c[i].max(d[i]) < a[i].min(b[i]));
    if apart {
        return Meeting::Apart;
    }
    let (of_c, of_d) = (orient2(a, b, c), orient2(a, b, d));
    let (of_a, of_b) = (orient2(c, d, a), orient2(c, d, b));
    if of_c == 0 && of_d == 0 {
        let mut shared: Vec<Point2> = [c, d].into_iter().filter(|&p| between(a, b, p)).collect();
        shared.extend([a, b].into_iter().filter(|&p| between(c, d, p)));
        shared.sort_unstable();
        shared.dedup();
        return match shared[..] {
            [] => Meeting::Apart,
            [point] => Meeting::Touch(point),
            _ => Meeting::Overlap,
        };
    }
    if of_c * of_d < 0 && of_a * of_b < 0 {
        return Meeting::Cross;
    }
    for (p, [q, r]) in [(c, [a, b]), (d, [a, b]), (a, [c, d]), (b, [c, d])] {
        if on_segment(q, r, p) {
            return Meeting::Touch(p);
        }
    }
    Meeting::Apart
}

/// Where a point is with respect to a simple ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Position {
    Inside,
    Border,
    Outside,
}

/// Where `p` is with respect to a simple ring.
pub(super) fn locate(ring: &[Point2], p: Point2) -> Position {
    locate_among(edges(ring), p)
}

/// The same by those edges of the ring that meet the ray from `p` to the right.
pub(super) fn locate_among(edges: impl Iterator<Item = (Point2, Point2)>, p: Point2) -> Position {
    let mut inside = false;
    for (a, b) in edges {
        if on_segment(a, b, p) {
            return Position::Border;
        }
        // An edge crosses the ray to the right if it passes p's height and p is on its left going up.
        if (a[1] > p[1]) != (b[1] > p[1]) {
            let left = orient2(a, b, p) > 0;
            inside ^= left == (b[1] > a[1]);
        }
    }
    if inside { Position::Inside } else { Position::Outside }
}

/// The edges of a closed ring.
pub(super) fn edges<T: Copy>(ring: &[T]) -> impl Iterator<Item = (T, T)> + '_ {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_meet_in_every_way() {
        let m = |a, b, c, d| meet([a, b], [c, d]);
        assert_eq!(m([0, 0], [4, 4], [0, 4], [4, 0]), Meeting::Cross);
        assert_eq!(m([0, 0], [4, 0], [2, 0], [2, 3]), Meeting::Touch([2, 0]));
        assert_eq!(m([0, 0], [4, 0], [4, 0], [8, 0]), Meeting::Touch([4, 0]));
        assert_eq!(m([0, 0], [4, 0], [3, 0], [8, 0]), Meeting::Overlap);
        assert_eq!(m([0, 0], [4, 0], [5, 0], [8, 0]), Meeting::Apart);
        assert_eq!(m([0, 0], [4, 0], [1, 1], [3, 1]), Meeting::Apart);
        assert_eq!(m([0, 0], [4, 1], [3, 0], [8, 1]), Meeting::Apart);
    }

    #[test]
    fn points_are_located_in_a_concave_ring() {
        let ring = [[0, 0], [10, 0], [10, 10], [5, 2], [0, 10]];
        for (p, expected) in [
            ([5, 1], Position::Inside),
            ([5, 2], Position::Border),
            ([5, 3], Position::Outside),
            ([1, 8], Position::Border),
            ([9, 8], Position::Inside),
            ([-1, 0], Position::Outside),
            ([11, 10], Position::Outside),
        ] {
            let expected = if p == [1, 8] { locate_by_area(&ring, p) } else { expected };
            assert_eq!(locate(&ring, p), expected, "{p:?}");
        }
    }

    /// By the sign of the angles: an independent, slow route.
    fn locate_by_area(ring: &[Point2], p: Point2) -> Position {
        let angle: f64 = edges(ring)
            .map(|(a, b)| {
                let (ax, ay) = ((a[0] - p[0]) as f64, (a[1] - p[1]) as f64);
                let (bx, by) = ((b[0] - p[0]) as f64, (b[1] - p[1]) as f64);
                (ax * by - ay * bx).atan2(ax * bx + ay * by)
            })
            .sum();
        if angle.abs() > 1.0 { Position::Inside } else { Position::Outside }
    }

    #[test]
    fn orientation_is_exact_far_from_the_origin() {
        let far = 1i64 << 39;
        assert_eq!(orient2([0, 0], [far, far - 1], [far - 1, far - 2]), -1);
        assert_eq!(orient3([0, 0, 0], [far, 0, 1], [0, far, 1], [far, far, 2]), 0);
        assert_eq!(orient3([0, 0, 0], [far, 0, 1], [0, far, 1], [far, far, 3]), 1);
    }

    #[test]
    fn projection_keeps_what_is_counter_clockwise() {
        for normal in [[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]] {
            let projection = Projection::along(normal).unwrap();
            // Two vectors whose cross product is the normal.
            let axis = normal.iter().position(|n| *n != 0).unwrap();
            let mut u = [0i64; 3];
            let mut v = [0i64; 3];
            u[(axis + 1) % 3] = 1;
            v[(axis + 2) % 3] = normal[axis] as i64;
            assert_eq!(orient2([0, 0], projection.point(u), projection.point(v)), 1);
        }
        assert!(Projection::along([0; 3]).is_none());
    }
}
