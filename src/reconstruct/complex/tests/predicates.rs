use std::cmp::Ordering;

use nalgebra::{Point3, Unit, Vector3};

use super::super::plane::gcd;
use super::super::{IntegerPlane, Vertex};
use crate::geometry::Plane;

fn plane(normal: [i64; 3], offset: i64) -> IntegerPlane {
    IntegerPlane { normal, offset }
}

#[test]
fn equal_point_sets_are_equal_planes() {
    let snap = |n: [f64; 3], offset| {
        IntegerPlane::snap(&Plane { normal: Unit::new_normalize(Vector3::from(n)), offset }).unwrap()
    };
    // z = 3, from above and from below.
    assert_eq!(snap([0.0, 0.0, 1.0], -3.0), (plane([0, 0, 1], -3), false));
    assert_eq!(snap([0.0, 0.0, -1.0], 3.0), (plane([0, 0, 1], -3), true));
    // Vertical: the sign of y decides, then that of x.
    assert_eq!(snap([1.0, 0.0, 0.0], 0.5), (plane([2, 0, 0], 1), false));
    let (forth, back) = (snap([0.6, 0.8, 0.0], -2.0), snap([-0.6, -0.8, 0.0], 2.0));
    assert_eq!((forth.0, forth.1, back.1), (back.0, false, true));
}

#[test]
fn snapping_moves_a_plane_by_less_than_a_tenth_of_a_millimetre_within_100_m() {
    let normal = Unit::new_normalize(Vector3::new(0.3, -0.5, 0.7));
    let exact = Plane::through(&Point3::new(50.0, -20.0, 8.0), normal);
    let snapped = IntegerPlane::snap(&exact).unwrap().0.to_plane();
    let u = normal.cross(&Vector3::z()).normalize();
    for (s, t) in [(0.0, 0.0), (100.0, 0.0), (0.0, 100.0), (-70.0, 70.0)] {
        let nearest = -normal.into_inner() * exact.offset;
        let point = Point3::from(nearest + u * s + normal.cross(&u) * t);
        assert!(snapped.distance(&point).abs() < 1e-4, "{}", snapped.distance(&point));
    }
}

#[test]
fn planes_out_of_range_or_not_finite_are_refused() {
    let normal = Unit::new_normalize(Vector3::new(1.0, 2.0, 3.0));
    for offset in [16385.0, -1e30, f64::INFINITY, f64::NAN] {
        assert_eq!(IntegerPlane::snap(&Plane { normal, offset }), None);
    }
    let normal = Unit::new_unchecked(Vector3::new(f64::NAN, 0.0, 1.0));
    assert_eq!(IntegerPlane::snap(&Plane { normal, offset: 0.0 }), None);
}

#[test]
fn a_vertex_is_reduced_to_one_form_whatever_its_planes() {
    // x = 1/2, y = 1/3, z = −2 by two different triples of planes.
    let direct = Vertex::meet([&plane([2, 0, 0], -1), &plane([0, 3, 0], -1), &plane([0, 0, 1], 2)]).unwrap();
    let other = Vertex::meet([&plane([2, 3, 1], 0), &plane([4, -3, 0], -1), &plane([2, 0, 1], 1)]).unwrap();
    assert_eq!(direct.homogeneous, [3, 2, -12, 6]);
    assert_eq!(direct, other);
    assert_eq!(Vertex::meet([&plane([1, 1, 0], 0), &plane([0, 1, 1], 0), &plane([1, 2, 1], 5)]), None);
}

#[test]
fn largest_coefficients_do_not_overflow() {
    let big = 1 << 20;
    let far = (1_i64 << 35) - 1;
    let planes = [plane([big, big, -big], far), plane([big, -big, big], -far), plane([-big, big, big], far)];
    let vertex = Vertex::meet([&planes[0], &planes[1], &planes[2]]).unwrap();
    for plane in &planes {
        assert_eq!(plane.side(&vertex), Ordering::Equal);
    }
    // Their sum.
    assert_eq!(plane([big, big, big], far).side(&vertex), Ordering::Equal);
    assert_eq!(plane([big, big, big], far - 1).side(&vertex), Ordering::Less);
    assert_eq!(plane([-big, -big, -big], 1 - far).side(&vertex), Ordering::Greater);
}

#[test]
fn the_sign_is_exact_where_floating_point_sees_nothing() {
    // 1/3 and planes that miss it by less than 2⁻⁵³ of its coordinates.
    let third = Vertex::meet([&plane([3, 0, 0], -1), &plane([0, 3, 0], -1), &plane([0, 0, 3], -1)]).unwrap();
    let n = 1_048_576;
    assert_eq!(plane([n, n, n], -n).side(&third), Ordering::Equal);
    assert_eq!(plane([n, n - 1, -1], 0).side(&third), Ordering::Greater);
    let near = Vertex::meet([&plane([n, 1, 0], -n), &plane([1, n - 1, 0], -1), &plane([0, 1, n], -n)]).unwrap();
    let [x, y, z, w] = near.homogeneous;
    for (a, b, c, d) in [(n, 1, 0, -n), (1, n - 1, 0, -1), (n - 1, 2 - n, 0, 1 - n), (n, 0, -n, 0), (n, 1, 1 - n, -1)] {
        let exact = i128::from(a) * x + i128::from(b) * y + i128::from(c) * z + i128::from(d) * w;
        assert_eq!(plane([a, b, c], d).side(&near), exact.cmp(&0));
    }
}

#[test]
fn vertices_are_ordered_along_an_axis_exactly() {
    let at = |numerator: i64, denominator: i64| {
        Vertex::meet([&plane([denominator, 0, 0], -numerator), &plane([0, 1, 0], 0), &plane([0, 0, 1], 0)]).unwrap()
    };
    // Distinct rationals that are nearer to each other than 2⁻³⁹.
    let (n, m) = (1_048_575, 1_048_576);
    assert_eq!(at(n - 1, n).order(&at(n, m)), Ordering::Less);
    assert_eq!(at(-n, m).order(&at(1 - n, n)), Ordering::Less);
    assert_eq!(at(2, 4).order(&at(1, 2)), Ordering::Equal);
}

#[test]
fn gcd_of_zero_and_of_common_powers_of_two() {
    assert_eq!([gcd(0, 12), gcd(12, 0), gcd(48, 36), gcd(1 << 60, 1 << 42), gcd(35, 64)], [12, 12, 12, 1 << 42, 1]);
}
