//! Tests of the cell complex: worked by hand, on degenerate planes, and on real primitives.

mod by_hand;
mod predicates;
mod properties;
mod real;

use nalgebra::{Point3, Unit, Vector3};

use super::build::{insert, start};
use super::{CellId, Complex, IntegerPlane, MAX_CELLS};
use crate::geometry::{Aabb, Plane};
use crate::reconstruct::primitives::{Extent, Primitive, PrimitiveKind};

/// A primitive on the plane through `point` with this normal.
fn primitive(point: [f64; 3], normal: [f64; 3], extent: Extent) -> Primitive {
    let normal = Unit::new_normalize(Vector3::from(normal));
    let plane = Plane::through(&Point3::from(point), normal);
    Primitive { kind: PrimitiveKind::Detected, plane, inliers: Vec::new(), residual: 0.0, extent }
}

/// The same without bounds.
fn everywhere(point: [f64; 3], normal: [f64; 3]) -> Primitive {
    primitive(point, normal, Extent::Everywhere)
}

/// A primitive on a rectangle: its centre and its two half sides.
fn rectangle(centre: [f64; 3], u: [f64; 3], v: [f64; 3]) -> Primitive {
    let (c, u, v) = (Point3::from(centre), Vector3::from(u), Vector3::from(v));
    let patch = vec![c - u - v, c + u - v, c + u + v, c - u + v];
    primitive(centre, u.cross(&v).into(), Extent::Patch(patch))
}

fn cube(min: f64, max: f64) -> Aabb {
    Aabb { min: [min; 3], max: [max; 3] }
}

/// The arrangement of planes given by their integers.
fn arrangement(planes: &[IntegerPlane], bounds: &Aabb) -> Complex {
    let mut partition = start(bounds).unwrap();
    for plane in planes {
        let plane = partition.plane_id(*plane);
        assert!(insert(&mut partition, plane, None, MAX_CELLS));
    }
    partition.complex
}

/// Number of cells, facets and vertices.
fn counts(complex: &Complex) -> (usize, usize, usize) {
    complex.check().unwrap();
    (complex.cells.len(), complex.facets.len(), complex.vertices.len())
}

fn volumes(complex: &Complex) -> Vec<f64> {
    let mut volumes: Vec<_> = (0..complex.cells.len() as CellId).map(|cell| complex.cell_volume(cell)).collect();
    volumes.sort_by(f64::total_cmp);
    volumes
}

/// How deep a point is inside a cell, metres; negative outside.
fn depth(complex: &Complex, cell: CellId, point: &Point3<f64>) -> f64 {
    let facets = complex.cells[cell as usize].facets.iter().map(|&f| &complex.facets[f as usize]);
    let depths = facets.map(|facet| {
        let distance = complex.planes[facet.plane as usize].to_plane().distance(point);
        if facet.cells[0] == cell { -distance } else { distance }
    });
    depths.fold(f64::INFINITY, f64::min)
}
