//! Planar polygons with holes into triangles.

use geo::triangulate_earcut::RawTriangulation;
use geo::{LineString, Polygon, TriangulateEarcut};
use nalgebra::{Point3, Vector3};

/// Twice the vector area of a ring (Newell), in square metres; points along the normal of a counter-clockwise ring.
pub fn newell(ring: &[Point3<f64>]) -> Vector3<f64> {
    let Some(anchor) = ring.first() else { return Vector3::zeros() };
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| (a - anchor).cross(&(b - anchor))).sum()
}

/// Cuts the polygon (exterior ring first, then holes; first vertex not repeated) into triangles that turn the same way
/// as its exterior ring. Empty when the polygon has no area.
///
/// The triangles use the polygon's own vertices only, so that neighbours which share an edge still share it.
pub fn triangulate(rings: &[Vec<Point3<f64>>]) -> Vec<[Point3<f64>; 3]> {
    let vertices: Vec<Point3<f64>> = rings.iter().flatten().copied().collect();
    let point = |i: usize| vertices.get(i).copied();
    triangle_indices(rings).into_iter().filter_map(|[a, b, c]| Some([point(a)?, point(b)?, point(c)?])).collect()
}

/// The triangles of [`triangulate`] as indices into the vertices of all rings, one ring after the other.
pub fn triangle_indices(rings: &[Vec<Point3<f64>>]) -> Vec<[usize; 3]> {
    let Some(exterior) = rings.first() else { return Vec::new() };
    let normal = newell(exterior);
    if normal.norm() <= 0.0 || !normal.norm().is_finite() {
        return Vec::new();
    }
    if (exterior.len(), rings.len()) == (3, 1) {
        return vec![[0, 1, 2]];
    }
    // Dropping the axis along which the normal is longest keeps the projection far from degenerate.
    let dropped = normal.iamax();
    let (u, v) = [(1, 2), (0, 2), (0, 1)][dropped];
    let flat = |ring: &Vec<Point3<f64>>| ring.iter().map(|p| (p[u], p[v])).collect::<LineString>();
    let polygon = Polygon::new(flat(exterior), rings.iter().skip(1).map(flat).collect());
    let RawTriangulation { triangle_indices, .. } = polygon.earcut_triangles_raw();
    // earcut keeps the order of the vertices and leaves out the one that closes a ring.
    let vertices: Vec<&Point3<f64>> = rings.iter().flatten().collect();
    triangle_indices
        .chunks_exact(3)
        .filter_map(|corners| {
            let [a, b, c] = *corners.first_chunk::<3>()?;
            let [p, q, r] = [*vertices.get(a)?, *vertices.get(b)?, *vertices.get(c)?];
            let turns_along = (q - p).cross(&(r - p)).dot(&normal) >= 0.0;
            Some(if turns_along { [a, b, c] } else { [a, c, b] })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(min: f64, max: f64) -> Vec<[f64; 2]> {
        vec![[min, min], [max, min], [max, max], [min, max]]
    }

    /// Lifts a ring of the xy-plane onto a plane that stands on edge, so that every projection axis is tried.
    fn lift(ring: &[[f64; 2]], axes: [usize; 2]) -> Vec<Point3<f64>> {
        ring.iter()
            .map(|p| {
                let mut q = Point3::origin();
                (q[axes[0]], q[axes[1]]) = (p[0], p[1]);
                q
            })
            .collect()
    }

    #[test]
    fn a_square_with_a_hole_keeps_its_area_and_its_side() {
        let mut hole = square(1.0, 3.0);
        hole.reverse();
        for axes in [[0, 1], [1, 0], [1, 2], [2, 0]] {
            let rings = [lift(&square(0.0, 4.0), axes), lift(&hole, axes)];
            let triangles = triangulate(&rings);
            let area: Vector3<f64> = triangles.iter().map(|t| newell(t)).sum();
            assert!((area - newell(&rings[0]) - newell(&rings[1])).norm() < 1e-12);
            assert!(triangles.iter().all(|t| newell(t).dot(&area) > 0.0), "{axes:?}");
            assert!((area.norm() / 2.0 - 12.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_ring_without_area_has_no_triangles() {
        let line = [0.0, 1.0, 2.0].map(|x| Point3::new(x, 0.0, 0.0)).to_vec();
        assert!(triangulate(&[line]).is_empty());
        assert!(triangulate(&[]).is_empty());
    }
}
