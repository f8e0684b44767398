//! From a geometry of a city model to a labelled solid on a grid.

use std::collections::BTreeMap;

use nalgebra::{Point3, Vector3};
use serde_json::Value;

use super::{CityModel, Geometry, SemanticSurface};
use crate::site::Frame;
use crate::solid::{Face, Solid, Surface, SurfaceType};

/// How far from the origin of its grid a vertex may lie, in steps: 1 000 km, where no building is.
const FAR: i64 = 10_000_000_000;

/// Below this share of its length, the vertical part of a normal belongs to a wall (about 6° from the vertical).
const WALL: f64 = 0.1;

impl CityModel {
    /// A geometry of one shell as a labelled solid on the grid of `frame`; a geometry of surfaces is taken for a shell.
    ///
    /// Vertices that fall together on the grid become one; rings and faces that collapse are gone. Nothing else is
    /// changed: whether the shell is closed is for [`validate`](crate::validate) to say. Faces without a semantic surface
    /// that gable knows are labelled by their direction.
    ///
    /// # Errors
    /// Why it is not a solid of one shell.
    pub fn solid(&self, geometry: &Geometry, frame: &Frame) -> Result<Solid, String> {
        let [shell] = geometry.shells.as_slice() else {
            return Err(format!("{} shells where one was expected", geometry.shells.len()));
        };
        let mut solid = Solid { step: frame.step(), vertices: Vec::new(), faces: Vec::new(), surfaces: Vec::new() };
        let mut indices: BTreeMap<[i64; 3], u32> = BTreeMap::new();
        let mut labels: BTreeMap<Label, u32> = BTreeMap::new();
        let on_grid = |&vertex: &u32| {
            let crs = self.vertices.get(vertex as usize).copied().unwrap_or_default();
            frame.to_grid(&frame.to_local(crs))
        };
        let all = shell.faces.iter().flat_map(|face| &face.rings).flatten();
        if all.flat_map(on_grid).any(|c| c.unsigned_abs() > FAR.unsigned_abs()) {
            return Err(format!("a vertex lies beyond {FAR} grid steps from the origin of the grid"));
        }
        for face in &shell.faces {
            let mut rings = face.rings.iter().map(|ring| corners(ring.iter().map(on_grid).collect()));
            // Without its exterior a face is nothing; a hole that collapsed is no loss.
            let Some(Some(exterior)) = rings.next() else { continue };
            let rings: Vec<Vec<[i64; 3]>> = std::iter::once(exterior).chain(rings.flatten()).collect();
            let label = face
                .surface
                .filter(|&s| geometry.surfaces.get(s as usize).is_some_and(|s| known(&s.kind).is_some()))
                .map_or_else(|| Label::Direction(direction(&rings[0], frame)), Label::Given);
            let surface = *labels.entry(label).or_insert_with(|| {
                solid.surfaces.push(match label {
                    Label::Direction(kind) => Surface::of(kind),
                    Label::Given(s) => geometry
                        .surfaces
                        .get(s as usize)
                        .map_or_else(|| Surface::of(SurfaceType::Wall), |given| surface_of(given, frame)),
                });
                solid.surfaces.len() as u32 - 1
            });
            let mut index = |vertex: [i64; 3]| {
                *indices.entry(vertex).or_insert_with(|| {
                    solid.vertices.push(vertex);
                    solid.vertices.len() as u32 - 1
                })
            };
            let rings = rings.into_iter().map(|ring| ring.into_iter().map(&mut index).collect()).collect();
            solid.faces.push(Face { rings, surface });
        }
        if solid.faces.is_empty() { Err("no faces".to_owned()) } else { Ok(solid) }
    }
}

/// Where the label of a face comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Label {
    Given(u32),
    Direction(SurfaceType),
}

/// The type of a semantic surface that gable writes; `None` for others.
fn known(kind: &str) -> Option<SurfaceType> {
    match kind {
        "RoofSurface" => Some(SurfaceType::Roof),
        "WallSurface" => Some(SurfaceType::Wall),
        "GroundSurface" => Some(SurfaceType::Ground),
        "OuterCeilingSurface" => Some(SurfaceType::OuterCeiling),
        _ => None,
    }
}

/// A semantic surface with the properties that gable writes.
fn surface_of(given: &SemanticSurface, frame: &Frame) -> Surface {
    let number = |name: &str| given.attributes.get(name).and_then(Value::as_f64);
    let height = |name: &str| number(name).map(|h| (h - frame.origin[2]) * frame.metres_per_unit[2]);
    Surface {
        kind: known(&given.kind).unwrap_or(SurfaceType::Wall),
        slope: number("slope"),
        azimuth: number("azimuth"),
        heights: height("height_min").zip(height("height_max")).map(|(min, max)| [min, max]),
        on_footprint_edge: given.attributes.get("on_footprint_edge").and_then(Value::as_bool),
        confidence: number("confidence"),
        floor_depth: number("floor_depth"),
    }
}

/// A ring without repeated vertices; `None` when fewer than three are left.
fn corners(mut ring: Vec<[i64; 3]>) -> Option<Vec<[i64; 3]>> {
    ring.dedup();
    while ring.len() > 1 && ring.first() == ring.last() {
        ring.pop();
    }
    (ring.len() >= 3).then_some(ring)
}

/// What a face is by the direction that it looks to.
fn direction(ring: &[[i64; 3]], frame: &Frame) -> SurfaceType {
    let points: Vec<Point3<f64>> = ring.iter().map(|&v| frame.from_grid(v)).collect();
    let Some(anchor) = points.first() else { return SurfaceType::Wall };
    let area: Vector3<f64> = points.windows(2).map(|edge| (edge[0] - anchor).cross(&(edge[1] - anchor))).sum();
    let up = area.z / area.norm().max(f64::MIN_POSITIVE);
    if up > WALL {
        SurfaceType::Roof
    } else if up < -WALL {
        SurfaceType::Ground
    } else {
        SurfaceType::Wall
    }
}
