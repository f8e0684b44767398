//! The faces of a feature by their semantic surface, for formats that know no solids.

use std::collections::BTreeMap;

use nalgebra::Point3;
use serde_json::{Map, Value};

use super::Feature;
use crate::geometry::{newell, triangle_indices};
use crate::source::cityjson::{CityObject, Face, Geometry};

/// Below this share of its length, the vertical part of a normal belongs to a wall (about 6° from the vertical).
const WALL: f64 = 0.1;

/// A semantic surface with its faces.
pub(super) struct SurfaceFaces<'a> {
    /// The level of detail.
    pub lod: &'a str,
    /// Its class: the type of the semantic surface; where it has none, for buildings and bridges that which follows from
    /// the direction of its faces, for others the type of the object.
    pub class: &'a str,
    /// The attributes of the semantic surface; `None` where there is none.
    pub attributes: Option<&'a Map<String, Value>>,
    /// Its faces, each of which has an exterior.
    pub faces: Vec<&'a Face>,
}

/// The level of detail as a number; 0 where it is none.
pub(super) fn level(lod: &str) -> f64 {
    lod.parse().ok().filter(|level: &f64| level.is_finite()).unwrap_or(0.0)
}

/// The objects of a feature with the finest of their geometries. An object that has nothing but a footprint (LoD 0) is
/// left out where another has more.
pub(super) fn finest(feature: &Feature) -> Vec<(&CityObject, &Geometry)> {
    pick(feature, |_| true)
}

/// The same of LoD 1 alone.
pub(super) fn blocks(feature: &Feature) -> Vec<(&CityObject, &Geometry)> {
    pick(feature, |geometry| (1.0..2.0).contains(&level(&geometry.lod)))
}

fn pick(feature: &Feature, is_wanted: impl Fn(&Geometry) -> bool) -> Vec<(&CityObject, &Geometry)> {
    let finest_of = |object: &'_ CityObject| -> Option<usize> {
        let wanted = object.geometries.iter().enumerate().filter(|(_, g)| !g.shells.is_empty() && is_wanted(g));
        let best = wanted.max_by(|(_, a), (_, b)| level(&a.lod).total_cmp(&level(&b.lod)));
        best.map(|(i, _)| i)
    };
    let found = feature.objects.iter().filter_map(|object| Some((object, object.geometries.get(finest_of(object)?)?)));
    let found: Vec<_> = found.collect();
    let has_more = found.iter().any(|(_, geometry)| level(&geometry.lod) >= 1.0);
    found.into_iter().filter(|(_, geometry)| !has_more || level(&geometry.lod) >= 1.0).collect()
}

/// The surfaces of a geometry in the order of its semantic surfaces, then the faces without one. `metres` are the metres
/// per unit of the CRS.
pub(super) fn surfaces<'a>(
    feature: &Feature,
    object: &'a CityObject,
    geometry: &'a Geometry,
    metres: [f64; 3],
) -> Vec<SurfaceFaces<'a>> {
    let mut by_surface: BTreeMap<(u32, &'a str), Vec<&'a Face>> = BTreeMap::new();
    let faces = geometry.shells.iter().flat_map(|shell| &shell.faces);
    for face in faces.filter(|face| face.rings.first().is_some_and(|ring| ring.len() >= 3)) {
        let given = face.surface.and_then(|s| Some((s, geometry.surfaces.get(s as usize)?)));
        let key = given.map_or_else(
            || (u32::MAX, class_by_direction(object, &points(feature, face, metres))),
            |(s, surface)| (s, surface.kind.as_str()),
        );
        by_surface.entry(key).or_default().push(face);
    }
    let rows = by_surface.into_iter().map(|((s, class), faces)| SurfaceFaces {
        lod: &geometry.lod,
        class: if class.is_empty() { &object.kind } else { class },
        attributes: geometry.surfaces.get(s as usize).map(|surface| &surface.attributes),
        faces,
    });
    rows.collect()
}

fn class_by_direction<'a>(object: &'a CityObject, rings: &[Vec<Point3<f64>>]) -> &'a str {
    if !object.kind.starts_with("Building") && !object.kind.starts_with("Bridge") {
        return &object.kind;
    }
    let area = rings.first().map(|ring| newell(ring)).unwrap_or_default();
    let up = area.z / area.norm().max(f64::MIN_POSITIVE);
    match up {
        _ if up > WALL => "RoofSurface",
        _ if up < -WALL => "GroundSurface",
        _ => "WallSurface",
    }
}

/// The rings of a face in metres from its first vertex.
pub(super) fn points(feature: &Feature, face: &Face, metres: [f64; 3]) -> Vec<Vec<Point3<f64>>> {
    let first = face.rings.iter().flatten().next();
    let origin = first.map(|&v| feature.vertex(v)).unwrap_or_default();
    let point = |&v: &u32| {
        let vertex = feature.vertex(v);
        Point3::from(std::array::from_fn(|i| (vertex[i] - origin[i]) * metres[i]))
    };
    face.rings.iter().map(|ring| ring.iter().map(point).collect()).collect()
}

/// The triangles of a face as vertices of the feature.
pub(super) fn triangles(feature: &Feature, face: &Face, metres: [f64; 3]) -> Vec<[u32; 3]> {
    let vertices: Vec<u32> = face.rings.iter().flatten().copied().collect();
    let corner = |i: usize| vertices.get(i).copied();
    let found = triangle_indices(&points(feature, face, metres)).into_iter();
    found.filter_map(|[a, b, c]| Some([corner(a)?, corner(b)?, corner(c)?])).collect()
}

/// Whether a ring turns one way only, so that a fan of triangles fills it.
pub(super) fn is_convex(ring: &[Point3<f64>]) -> bool {
    let normal = newell(ring);
    let n = ring.len();
    let corner = |i: usize| ring.get(i % n.max(1)).copied().unwrap_or_else(Point3::origin);
    (0..n).all(|i| {
        let [a, b, c] = [corner(i), corner(i + 1), corner(i + 2)];
        (b - a).cross(&(c - b)).dot(&normal) >= 0.0
    })
}
