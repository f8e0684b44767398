//! Features below the minimum size: removed by relabelling cells, which can never break a surface.
//!
//! First, whatever the minimum size, slivers of a few millimetres between planes that nearly coincide are absorbed by
//! one side ([`absorb_slivers`]). Then features are removed ([`remove`]):
//!
//! A cell is **thin** if it lies between the plane of one of its sides, its base, and a parallel plane nearer than the
//! minimum size. Facets of a thin cell within 45° of its base are **broad**, the others are **narrow**. A thin cell is
//! given the other label if that makes the surface smaller, where
//! - a broad facet counts with its projection onto the base: a thin cell with the surface on both broad sides is a
//!   spike or a slot and goes, one with the surface on one side is neutral, whatever the angle between the sides;
//! - a narrow facet counts with its area, which makes a neutral cell part with a step below the minimum size; a narrow
//!   facet towards a fixed cell does not count, for there the surface ends anyhow, along a footprint edge or the
//!   ground, and would only become lower.
//!
//! And only if all facets of the base were on the surface before any relabelling, and no vertex of the cell is farther
//! than the minimum size from the base: so no point that changes sides was farther than that from the surface. Each
//! cell is relabelled at most once, those first for which the occupancy says least.

use nalgebra::{Point3, Vector3};

use super::Labelled;
use crate::reconstruct::complex::{CellId, FacetId, OUTSIDE, PlaneId, VertexId};

/// Cosine between base and facet above which a facet is broad.
const BROAD: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// The surface must become smaller by more than this share of the cell's own surface, to be safe from rounding.
const LEAST_GAIN: f64 = 1e-9;

/// Cells thinner than this (metres) are slivers between two planes that validators cannot tell apart: val3dity snaps
/// at 1 mm, and rounding and welding take as much again on both sides.
const SLIVER: f64 = 0.003;
/// Slivers beside slivers are settled one after the other; planes that nearly coincide by fives are not worth more.
const ABSORB_ROUNDS: usize = 4;

/// A side of a thin cell that may serve as its base.
struct Base {
    normal: Vector3<f64>,
    facets: Vec<FacetId>,
}

struct Thin {
    cell: CellId,
    cost: f64,
    bases: Vec<Base>,
}

/// Relabels cells that only make features smaller than `minimum` metres; returns how many.
pub(super) fn remove(labelled: &Labelled, inside: &mut [bool], minimum: f64) -> usize {
    if minimum.is_nan() || minimum <= 0.0 {
        return 0;
    }
    let mut thin: Vec<Thin> = (0..inside.len() as CellId)
        .filter(|&cell| !labelled.is_fixed(cell))
        .filter_map(|cell| {
            let bases = bases(labelled, inside, cell, minimum);
            (!bases.is_empty()).then(|| Thin { cell, cost: labelled.cost(cell, inside[cell as usize]), bases })
        })
        .collect();
    thin.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(a.cell.cmp(&b.cell)));
    let mut removed = 0;
    loop {
        let before = removed;
        thin.retain(|candidate| {
            let gains = candidate.bases.iter().any(|base| gain(labelled, inside, candidate.cell, base));
            if gains {
                inside[candidate.cell as usize] = !inside[candidate.cell as usize];
                removed += 1;
            }
            !gains
        });
        if removed == before {
            return removed;
        }
    }
}

/// Gives every sliver the label of its neighbours across one of its two broad sides, always the one on the plane that
/// came first: as if the other plane had never cut there. Returns how many cells were relabelled.
///
/// A fixed label stays: the walls would leave the footprint.
pub(super) fn absorb_slivers(labelled: &Labelled, inside: &mut [bool]) -> usize {
    let complex = labelled.complex;
    let slivers: Vec<(CellId, PlaneId)> = (0..inside.len() as CellId)
        .filter(|&cell| !labelled.is_fixed(cell))
        .filter_map(|cell| {
            let corners = complex.cell_vertices(cell);
            let mut planes: Vec<PlaneId> =
                complex.cells[cell as usize].facets.iter().map(|&f| complex.facets[f as usize].plane).collect();
            planes.sort_unstable();
            planes.dedup();
            let thin = |plane: &PlaneId| {
                let normal = unit_normal(labelled, *plane);
                let along = |v: VertexId| normal.dot(&position(labelled, v).coords);
                let (low, high) = corners
                    .iter()
                    .fold((f64::MAX, f64::MIN), |(low, high), &v| (low.min(along(v)), high.max(along(v))));
                high - low < SLIVER
            };
            planes.into_iter().find(thin).map(|plane| (cell, plane))
        })
        .collect();
    let before: Vec<bool> = slivers.iter().map(|&(cell, _)| inside[cell as usize]).collect();
    for _ in 0..ABSORB_ROUNDS {
        let mut settled = true;
        for &(cell, plane) in &slivers {
            let mut balance = 0.0;
            for &id in &complex.cells[cell as usize].facets {
                if complex.facets[id as usize].plane == plane {
                    let other = complex.across(id, cell);
                    let is_inside = other != OUTSIDE && inside[other as usize];
                    balance += if is_inside { complex.facet_area(id) } else { -complex.facet_area(id) };
                }
            }
            settled &= inside[cell as usize] == (balance > 0.0);
            inside[cell as usize] = balance > 0.0;
        }
        if settled {
            break;
        }
    }
    slivers.iter().zip(before).filter(|((cell, _), before)| inside[*cell as usize] != *before).count()
}

/// The sides of a cell that are on the surface with all their facets and from which the whole cell is nearer than
/// `minimum`.
fn bases(labelled: &Labelled, inside: &[bool], cell: CellId, minimum: f64) -> Vec<Base> {
    let complex = labelled.complex;
    let facets = &complex.cells[cell as usize].facets;
    let surface = |facet: FacetId| is_surface(labelled, inside, facet);
    if !facets.iter().any(|&facet| surface(facet)) {
        return Vec::new();
    }
    let corners = complex.cell_vertices(cell);
    let mut planes: Vec<PlaneId> = facets.iter().map(|&f| complex.facets[f as usize].plane).collect();
    planes.sort_unstable();
    planes.dedup();
    let mut found = Vec::new();
    for plane in planes {
        let side: Vec<FacetId> =
            facets.iter().copied().filter(|&f| complex.facets[f as usize].plane == plane).collect();
        if !side.iter().all(|&facet| surface(facet)) {
            continue;
        }
        let normal = unit_normal(labelled, plane);
        let Some(&anchor) = complex.facets[side[0] as usize].corners.first() else { continue };
        let anchor = complex.vertices[anchor as usize].position;
        let near = corners.iter().all(|&v| {
            let p = &complex.vertices[v as usize].position;
            normal.dot(&(p - anchor)).abs() < minimum
                && side.iter().any(|&f| distance_to_facet(labelled, f, &normal, p) < minimum)
        });
        if near {
            found.push(Base { normal, facets: side });
        }
    }
    found
}

/// Whether the surface becomes smaller if the cell is given the other label.
fn gain(labelled: &Labelled, inside: &[bool], cell: CellId, base: &Base) -> bool {
    let complex = labelled.complex;
    let (mut change, mut total) = (0.0, 0.0);
    for &id in &complex.cells[cell as usize].facets {
        let facet = &complex.facets[id as usize];
        let other = complex.across(id, cell);
        let cosine = unit_normal(labelled, facet.plane).dot(&base.normal).abs();
        let broad = base.facets.contains(&id) || cosine > BROAD;
        if !broad && labelled.is_fixed(other) {
            continue;
        }
        let size = complex.facet_area(id) * if broad { cosine } else { 1.0 };
        total += size;
        change += if is_surface(labelled, inside, id) { -size } else { size };
    }
    change < -LEAST_GAIN * total
}

fn is_surface(labelled: &Labelled, inside: &[bool], facet: FacetId) -> bool {
    let [a, b] = labelled.complex.facets[facet as usize].cells.map(|c| c != OUTSIDE && inside[c as usize]);
    a != b
}

fn unit_normal(labelled: &Labelled, plane: PlaneId) -> Vector3<f64> {
    Vector3::from(labelled.complex.planes[plane as usize].normal.map(|n| n as f64)).normalize()
}

fn position(labelled: &Labelled, vertex: VertexId) -> Point3<f64> {
    labelled.complex.vertices[vertex as usize].position
}

/// Distance from a point to a convex facet, metres.
fn distance_to_facet(labelled: &Labelled, facet: FacetId, normal: &Vector3<f64>, p: &Point3<f64>) -> f64 {
    let corners = &labelled.complex.facets[facet as usize].corners;
    let mut over = true;
    let mut nearest = f64::INFINITY;
    let mut height = f64::INFINITY;
    for (i, &corner) in corners.iter().enumerate() {
        let a = position(labelled, corner);
        let along = position(labelled, corners[(i + 1) % corners.len()]) - a;
        let to = p - a;
        let t = (to.dot(&along) / along.norm_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        nearest = nearest.min((to - along * t).norm());
        // The corners are counter-clockwise seen from the positive side.
        over &= normal.dot(&along.cross(&to)) >= 0.0;
        height = normal.dot(&to).abs();
    }
    if over { height } else { nearest }
}
