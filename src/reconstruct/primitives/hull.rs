//! How far a detected primitive reaches: the convex hull of its inliers on its plane.

use nalgebra::{Point2, Point3, Unit, Vector3};

use crate::geometry::{Aabb, Plane};

/// More corners than this cost the partition more than they save.
const MOST_CORNERS: usize = 16;

/// Corners of a convex polygon on the plane that holds the projections of all points: their hull, counter-clockwise
/// seen from the side of the normal, with at most 16 corners (a longer hull is enlarged, never cut). `None` when the
/// projections lie on a line.
pub(super) fn convex_hull<'a>(
    plane: &Plane,
    points: impl IntoIterator<Item = &'a Point3<f64>> + Clone,
) -> Option<Vec<Point3<f64>>> {
    // The origin must be near the points, for precision, and must not depend on their order.
    let near = Point3::from(Aabb::of(points.clone())?.min);
    let origin = near - plane.normal.scale(plane.distance(&near));
    let [u, v] = axes(&plane.normal);
    let flat: Vec<Point2<f64>> = points
        .into_iter()
        .map(|p| {
            let d = p - origin;
            Point2::new(d.dot(&u), d.dot(&v))
        })
        .collect();
    let mut hull = monotone_chain(flat);
    if hull.len() < 3 {
        return None;
    }
    while hull.len() > MOST_CORNERS && drop_edge(&mut hull) {}
    Some(hull.iter().map(|p| origin + u * p.x + v * p.y).collect())
}

/// Two unit axes of the plane that form a right-handed frame with its normal.
fn axes(normal: &Unit<Vector3<f64>>) -> [Vector3<f64>; 2] {
    let helper = if normal.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
    let u = helper.cross(normal).normalize();
    [u, normal.cross(&u)]
}

fn turn(a: &Point2<f64>, b: &Point2<f64>, c: &Point2<f64>) -> f64 {
    (b - a).perp(&(c - a))
}

/// Convex hull, counter-clockwise, without corners on a straight edge (Andrew 1979).
fn monotone_chain(mut points: Vec<Point2<f64>>) -> Vec<Point2<f64>> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    points.dedup();
    let chain = |points: &mut dyn Iterator<Item = &Point2<f64>>| {
        let mut hull: Vec<Point2<f64>> = Vec::new();
        for p in points {
            while let [.., a, b] = hull[..]
                && turn(&a, &b, p) <= 0.0
            {
                hull.pop();
            }
            hull.push(*p);
        }
        hull.pop();
        hull
    };
    let mut hull = chain(&mut points.iter());
    hull.extend(chain(&mut points.iter().rev()));
    hull
}

/// Replaces the edge whose loss enlarges a convex polygon least by the point where its neighbours meet. False when no
/// edge can go.
fn drop_edge(hull: &mut Vec<Point2<f64>>) -> bool {
    let n = hull.len();
    let mut best: Option<(f64, usize, Point2<f64>)> = None;
    for i in 0..n {
        let [a, b, c, d] = [0, 1, 2, 3].map(|k| hull[(i + k) % n]);
        let (before, after) = (b - a, d - c);
        let determinant = before.perp(&after);
        // The neighbours of the edge b–c meet beyond it only when together they turn by less than half a circle.
        if determinant <= 1e-12 * before.norm() * after.norm() {
            continue;
        }
        let meeting = b + before * ((c - b).perp(&after) / determinant);
        let gain = turn(&b, &meeting, &c).abs();
        if best.is_none_or(|(least, ..)| gain < least) {
            best = Some((gain, i, meeting));
        }
    }
    let Some((_, i, meeting)) = best else { return false };
    hull[(i + 1) % n] = meeting;
    hull.remove((i + 2) % n);
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_with_points_inside_and_above_has_four_corners() {
        let plane = Plane::through(&Point3::new(0.0, 0.0, 2.0), Vector3::z_axis());
        let points: Vec<_> =
            (0..25).map(|i| Point3::new(f64::from(i % 5), f64::from(i / 5), 2.0 + 0.01 * f64::from(i % 3))).collect();
        let hull = convex_hull(&plane, &points).unwrap();
        assert_eq!(hull.len(), 4);
        assert!(hull.iter().all(|p| plane.distance(p).abs() < 1e-12));
        let area: Vector3<f64> = (0..4).map(|i| hull[i].coords.cross(&hull[(i + 1) % 4].coords)).sum();
        assert!((area.dot(&plane.normal) / 2.0 - 16.0).abs() < 1e-9, "counter-clockwise from above");
    }

    #[test]
    fn a_round_hull_is_enlarged_to_sixteen_corners() {
        let normal = Unit::new_normalize(Vector3::new(0.3, -0.5, 0.8));
        let plane = Plane::through(&Point3::new(5.0, 6.0, 7.0), normal);
        let [u, v] = axes(&normal);
        let circle: Vec<_> = (0..200)
            .map(|i| {
                let angle = f64::from(i) * std::f64::consts::TAU / 200.0;
                Point3::new(5.0, 6.0, 7.0) + u * angle.cos() * 10.0 + v * angle.sin() * 10.0
            })
            .collect();
        let hull = convex_hull(&plane, &circle).unwrap();
        assert_eq!(hull.len(), 16);
        for p in &circle {
            for i in 0..16 {
                let edge = hull[(i + 1) % 16] - hull[i];
                assert!(edge.cross(&(p - hull[i])).dot(&normal) > -1e-9, "a point is cut off");
            }
        }
        assert!(hull.iter().all(|p| (p - Point3::new(5.0, 6.0, 7.0)).norm() < 10.6), "not enlarged more than needed");
    }

    #[test]
    fn points_on_a_line_have_no_hull() {
        let plane = Plane::through(&Point3::origin(), Vector3::z_axis());
        let line: Vec<_> = (0..5).map(|i| Point3::new(f64::from(i), 0.0, 0.0)).collect();
        assert!(convex_hull(&plane, &line).is_none());
        assert!(convex_hull(&plane, &[]).is_none());
    }
}
