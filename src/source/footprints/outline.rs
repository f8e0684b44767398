//! From rings as they stand in a file to valid polygons (OGC 06-103r4, section 6.1.11), or the reason why not.

use crate::geometry::validity;
use crate::guard::guarded;
use geo::algorithm::bool_ops::{FillRule, unary_union};
use geo::orient::{Direction, Orient};
use geo::{
    Area, BooleanOps, BoundingRect, Coord, CoordsIter, Kernel, LineString, MakeValid, MapCoords, MultiPolygon,
    Orientation, Polygon,
};

#[cfg(test)]
#[path = "outline_tests.rs"]
mod tests;

/// The largest ring that is taken: no building has so many corners.
const LARGEST_RING: usize = 100_000;
/// No coordinate of any CRS of the Earth, in any of its units, is larger.
const LARGEST_COORDINATE: f64 = 1e9;
/// Repairs snap vertices that lie within 1e-4 units of each other. Outlines are scaled up to this size first, so that
/// this is small against them in any unit, degrees too.
const REPAIR_SIZE: f64 = 64.0;
/// Parts that a repair leaves behind and that are smaller than this share of the whole are splinters.
const SPLINTER: f64 = 1e-6;

/// A ring; whether its last point repeats the first does not matter.
pub(super) type Ring = Vec<Coord<f64>>;

/// The rings of a feature: polygon by polygon, the exterior first.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Outline {
    pub polygons: Vec<Vec<Ring>>,
    /// What was left out on the way here, one sentence each.
    pub notes: Vec<String>,
}

impl From<&MultiPolygon<f64>> for Outline {
    fn from(polygons: &MultiPolygon<f64>) -> Self {
        let rings =
            |p: &Polygon<f64>| std::iter::once(p.exterior()).chain(p.interiors()).map(|ring| ring.0.clone()).collect();
        Self { polygons: polygons.iter().map(rings).collect(), notes: Vec::new() }
    }
}

impl Outline {
    /// The outline of a geometry that held `others` beside its polygons: a note says so, and without any polygon it is none.
    ///
    /// # Errors
    /// Why the geometry is no footprint.
    pub fn beside(mut self, others: &[&str]) -> Result<Self, String> {
        if others.is_empty() {
            return Ok(self);
        }
        if self.polygons.is_empty() {
            return Err(format!("its geometry is a {}, not a polygon", others.join(" with ")));
        }
        self.notes.push(format!("of a GeometryCollection the polygons were taken, not the {}", others.join(", ")));
        Ok(self)
    }

    /// Valid polygons with counter-clockwise exteriors, and what was repaired. What is valid keeps its coordinates to
    /// the last bit.
    ///
    /// # Errors
    /// Why it cannot be used.
    pub(super) fn into_valid(self) -> Result<(MultiPolygon<f64>, Vec<String>), String> {
        let mut notes = self.notes;
        let mut polygons = Vec::new();
        let mut tidied = Tidied::default();
        for rings in self.polygons {
            let mut rings = rings.into_iter();
            let Some(exterior) = rings.next() else { continue };
            let exterior = tidied.ring(exterior)?;
            let interiors = rings.map(|ring| tidied.ring(ring)).collect::<Result<Vec<_>, _>>()?;
            match exterior {
                Some(exterior) => polygons.push(Polygon::new(exterior, interiors.into_iter().flatten().collect())),
                None => tidied.degenerate += interiors.iter().flatten().count(),
            }
        }
        notes.extend(tidied.notes());
        let polygons = MultiPolygon::new(polygons);
        if polygons.0.is_empty() {
            return Err(if tidied.degenerate > 0 { "it has no area" } else { "its geometry is empty" }.into());
        }
        let valid = match fault(&polygons) {
            None => polygons,
            Some(fault) => {
                // The booleans and the triangulation below are not ours, and one bad polygon must not end a run.
                let repaired = guarded(|| repair(&polygons))
                    .unwrap_or_else(|_| Err("the repair failed".into()))
                    .map_err(|reason| format!("{fault}, and {reason}"))?;
                notes.push(format!("repaired: {fault}"));
                return Ok((canonical(&repaired.orient(Direction::Default)), notes));
            }
        };
        Ok((valid.orient(Direction::Default), notes))
    }
}

/// Counts of what is mended ring by ring.
#[derive(Default)]
struct Tidied {
    open: usize,
    repeated: usize,
    degenerate: usize,
}

impl Tidied {
    /// A closed ring without repeated vertices; `None` when fewer than three differ.
    fn ring(&mut self, mut ring: Ring) -> Result<Option<LineString<f64>>, String> {
        if ring.iter().any(|c| !c.x.is_finite() || !c.y.is_finite()) {
            return Err("a coordinate is not finite".into());
        }
        if let Some(far) = ring.iter().flat_map(|c| [c.x, c.y]).find(|value| value.abs() > LARGEST_COORDINATE) {
            return Err(format!("a coordinate of {far:e} lies on no map"));
        }
        if ring.len() > LARGEST_RING {
            return Err(format!("a ring has {} vertices, more than {LARGEST_RING}", ring.len()));
        }
        let given = ring.len();
        ring.dedup();
        self.repeated += given - ring.len();
        if ring.len() > 1 && ring.first() != ring.last() {
            self.open += 1;
            ring.extend(ring.first().copied());
        }
        if ring.len() < 4 {
            self.degenerate += 1;
            return Ok(None);
        }
        Ok(Some(LineString::new(ring)))
    }

    fn notes(&self) -> impl Iterator<Item = String> {
        let said = [
            (self.open, "ring(s) that were not closed were closed"),
            (self.repeated, "repeated vertices were removed"),
            (self.degenerate, "ring(s) without area were left out"),
        ];
        said.into_iter().filter(|(count, _)| *count > 0).map(|(count, what)| format!("{count} {what}"))
    }
}

/// The first thing that is wrong with polygons; `None` when they are valid.
fn fault(polygons: &MultiPolygon<f64>) -> Option<String> {
    if let Err(error) = validity::check(polygons) {
        return Some(error.to_string());
    }
    let rings = polygons.iter().flat_map(|p| std::iter::once(p.exterior()).chain(p.interiors()));
    rings.into_iter().any(has_spike).then(|| "a ring has a spike".to_string())
}

/// Whether a closed ring turns back on itself at a vertex, which the check of neighbouring edges leaves open.
fn has_spike(ring: &LineString<f64>) -> bool {
    let vertices = &ring.0[..ring.0.len().saturating_sub(1)];
    let n = vertices.len();
    (0..n).any(|i| {
        let (a, b, c) = (vertices[(i + n - 1) % n], vertices[i], vertices[(i + 1) % n]);
        let (u, v) = (a - b, c - b);
        u.x * v.x + u.y * v.y > 0.0
            && geo::algorithm::kernels::RobustKernel::orient2d(a, b, c) == Orientation::Collinear
    })
}

/// The same polygons in one order, each ring from its smallest vertex on: what repairs them goes through them in an order of
/// chance.
fn canonical(polygons: &MultiPolygon<f64>) -> MultiPolygon<f64> {
    let compare = |a: &Coord<f64>, b: &Coord<f64>| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y));
    let turned = |ring: &LineString<f64>| {
        let mut vertices = ring.0.split_last().map_or_else(Vec::new, |(_, open)| open.to_vec());
        let first = (0..vertices.len()).min_by(|&i, &j| compare(&vertices[i], &vertices[j])).unwrap_or(0);
        vertices.rotate_left(first);
        vertices.extend(vertices.first().copied());
        LineString(vertices)
    };
    let by_vertices = |a: &LineString<f64>, b: &LineString<f64>| {
        let differing = a.0.iter().zip(&b.0).map(|(a, b)| compare(a, b)).find(|order| order.is_ne());
        differing.unwrap_or_else(|| a.0.len().cmp(&b.0.len()))
    };
    let part = |part: &Polygon<f64>| {
        let mut holes: Vec<_> = part.interiors().iter().map(turned).collect();
        holes.sort_by(by_vertices);
        Polygon::new(turned(part.exterior()), holes)
    };
    let mut parts: Vec<_> = polygons.iter().map(part).collect();
    parts.sort_by(|a, b| by_vertices(a.exterior(), b.exterior()));
    MultiPolygon(parts)
}

/// Valid polygons for invalid ones: exteriors by the odd-even rule, less their holes, united.
fn repair(polygons: &MultiPolygon<f64>) -> Result<MultiPolygon<f64>, String> {
    let size = polygons.bounding_rect().map_or(0.0, |b| b.width().max(b.height()));
    if size <= 0.0 {
        return Err("it has no area".into());
    }
    // A power of two, so that scaling there and back changes no coordinate.
    let scale = (REPAIR_SIZE / size).log2().ceil().max(0.0).exp2();
    let scaled = polygons.map_coords(|c| c * scale);
    let parts = scaled.iter().map(repair_polygon).collect::<Result<Vec<_>, _>>()?;
    let mut whole = match parts.as_slice() {
        [only] => only.clone(),
        several => unary_union(several.iter().flatten()),
    };
    let area = whole.unsigned_area();
    whole.0.retain(|part| part.unsigned_area() > SPLINTER * area);
    for part in &mut whole.0 {
        part.interiors_mut(|holes| holes.iter_mut().for_each(|hole| hole.0.dedup()));
    }
    if whole.0.is_empty() {
        return Err("it has no area".into());
    }
    if let Some(fault) = fault(&whole) {
        whole = whole.make_valid().map_err(|e| format!("it cannot be repaired ({e})"))?;
        if whole.0.is_empty() || self::fault(&whole).is_some() {
            return Err(format!("it cannot be repaired ({fault})"));
        }
    }
    let whole = whole.map_coords(|c| c / scale);
    match fault(&whole) {
        None => Ok(whole),
        Some(fault) => Err(format!("it cannot be repaired ({fault})")),
    }
}

fn repair_polygon(polygon: &Polygon<f64>) -> Result<MultiPolygon<f64>, String> {
    let exterior = repair_ring(polygon.exterior())?;
    let holes = polygon.interiors().iter().map(repair_ring).collect::<Result<Vec<_>, _>>()?;
    if holes.iter().all(|hole| hole.coords_count() == 0) {
        return Ok(exterior);
    }
    Ok(exterior.difference(&unary_union(holes.iter().flatten())))
}

/// What a ring encloses: by the odd-even rule, or all that it winds around where that leaves nothing, as with a ring
/// that runs twice around.
fn repair_ring(ring: &LineString<f64>) -> Result<MultiPolygon<f64>, String> {
    let polygon = Polygon::new(ring.clone(), Vec::new());
    if validity::is_valid_polygon(&polygon) && !has_spike(ring) {
        return Ok(polygon.into());
    }
    let odd_even = polygon.make_valid().map_err(|e| format!("it cannot be repaired ({e})"))?;
    if odd_even.unsigned_area() > 0.0 {
        return Ok(odd_even);
    }
    Ok(polygon.union_with_fill_rule(&MultiPolygon::<f64>::new(Vec::new()), FillRule::NonZero))
}
