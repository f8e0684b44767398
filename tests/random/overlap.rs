//! Whether two solids overlap, up to the tolerance of validators.

use gable::solid::{Face, Solid};
use nalgebra::{Point3, Vector3};

/// How deep a point must lie in a solid to be taken for inside, metres: where parts touch, rounding to the grid and
/// welding below 1 mm may move them into each other by less.
const DEEP: f64 = 0.002;

/// Whether a vertex, the middle of an edge, or a place just behind a face of one of two solids lies deep inside the other
/// (601).
pub fn overlap(a: &Solid, b: &Solid) -> bool {
    [(a, b), (b, a)].into_iter().any(|(a, b)| {
        boundary(a).any(|p| is_deep_inside(b, p)) || behind(a).any(|p| is_inside(a, p) && is_deep_inside(b, p))
    })
}

/// Vertices and middles of edges.
fn boundary(solid: &Solid) -> impl Iterator<Item = Point3<f64>> + '_ {
    let vertices = (0..solid.vertices.len() as u32).map(|v| solid.point(v));
    let rings = solid.faces.iter().flat_map(|face| &face.rings);
    let middles = rings.flat_map(|ring| {
        let ends = ring.iter().zip(ring.iter().cycle().skip(1));
        ends.map(|(&a, &b)| nalgebra::center(&solid.point(a), &solid.point(b)))
    });
    vertices.chain(middles)
}

/// A little behind the middle of each face.
fn behind(solid: &Solid) -> impl Iterator<Item = Point3<f64>> + '_ {
    solid.faces.iter().filter_map(|face| {
        let ring = face.rings.first()?;
        let sum: Vector3<f64> = ring.iter().map(|&v| solid.point(v).coords).sum();
        let normal = solid.newell(ring).try_normalize(0.0)?;
        Some(Point3::from(sum / ring.len() as f64 - normal * 2.0 * DEEP))
    })
}

fn is_deep_inside(solid: &Solid, p: Point3<f64>) -> bool {
    let steps = [Vector3::x(), Vector3::y(), Vector3::z()].map(|axis| axis * DEEP);
    steps.iter().all(|step| is_inside(solid, p + step) && is_inside(solid, p - step))
}

/// By the parity of the faces above the point.
fn is_inside(solid: &Solid, p: Point3<f64>) -> bool {
    solid.faces.iter().filter(|face| is_above(solid, face, p)).count() % 2 == 1
}

fn is_above(solid: &Solid, face: &Face, p: Point3<f64>) -> bool {
    let Some(normal) = solid.newell(&face.rings[0]).try_normalize(0.0).filter(|n| n.z.abs() > 1e-6) else {
        return false;
    };
    let mut covers = false;
    for ring in &face.rings {
        for (&a, &b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
            let (a, b) = (solid.point(a), solid.point(b));
            if (a.y > p.y) != (b.y > p.y) {
                covers ^= p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x);
            }
        }
    }
    let anchor = solid.point(face.rings[0][0]);
    covers && anchor.z - (normal.x * (p.x - anchor.x) + normal.y * (p.y - anchor.y)) / normal.z > p.z
}

#[test]
fn boxes_that_overlap_are_told_from_those_that_touch() {
    let block = |x: i64| {
        let ring = vec![[x, 0], [x + 50_000, 0], [x + 50_000, 40_000], [x, 40_000]];
        gable::reconstruct::blocks::block(&vec![ring], 0, 30_000, [1e-4; 3]).unwrap()
    };
    assert!(!overlap(&block(0), &block(50_000)));
    assert!(!overlap(&block(0), &block(49_995)));
    assert!(overlap(&block(0), &block(49_000)));
    assert!(overlap(&block(0), &block(0)));
}
