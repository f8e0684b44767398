//! Features as the JSON of CityJSON (2.0, sections 2 and 3), and the extent that goes with them.

use serde::Serialize;
use serde_json::{Map, Value};

use super::Feature;
use super::vertices::Vertices;
use crate::source::cityjson::{CityObject, Face, Geometry, GeometryKind, SemanticSurface, Shell, Transform};

/// The numbers in the file for a vertex: those nearest to it.
fn on_grid(transform: &Transform, vertex: [f64; 3]) -> [i64; 3] {
    std::array::from_fn(|i| ((vertex[i] - transform.translate[i]) / transform.scale[i]).round() as i64)
}

/// A box of the file's grid.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Extent {
    min: [i64; 3],
    max: [i64; 3],
}

impl Extent {
    /// Grows a box, or starts one.
    fn join(extent: Option<Self>, vertex: [i64; 3]) -> Self {
        let Self { min, max } = extent.unwrap_or(Self { min: vertex, max: vertex });
        Self {
            min: std::array::from_fn(|i| min[i].min(vertex[i])),
            max: std::array::from_fn(|i| max[i].max(vertex[i])),
        }
    }

    /// The box around both.
    pub(super) fn union(a: Option<Self>, b: Option<Self>) -> Option<Self> {
        b.map_or(a, |b| Some(Self::join(Some(Self::join(a, b.min)), b.max)))
    }

    /// Coordinates as `geographicalExtent` wants them.
    pub(super) fn to_crs(self, transform: &Transform) -> [f64; 6] {
        let real = |value: i64, axis: usize| {
            let (scale, translate) = (transform.scale[axis], transform.translate[axis]);
            // Dividing by a whole number of steps gives the decimal number itself where multiplying does not.
            let steps = (1.0 / scale).round();
            if (steps * scale - 1.0).abs() < 1e-9 {
                (value as f64 + translate * steps) / steps
            } else {
                value as f64 * scale + translate
            }
        };
        std::array::from_fn(|i| if i < 3 { real(self.min[i], i) } else { real(self.max[i - 3], i - 3) })
    }
}

/// What one feature came to.
pub(super) struct Encoded {
    pub objects: usize,
    pub extent: Option<Extent>,
}

#[derive(Serialize)]
struct JsonObject<'a> {
    #[serde(rename = "type")]
    kind: &'a str,
    #[serde(skip_serializing_if = "Map::is_empty")]
    attributes: &'a Map<String, Value>,
    #[serde(rename = "geographicalExtent", skip_serializing_if = "Option::is_none")]
    extent: Option<[f64; 6]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    geometry: Vec<JsonGeometry<'a>>,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    children: &'a [String],
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    parents: &'a [String],
    #[serde(flatten)]
    members: &'a Map<String, Value>,
}

#[derive(Serialize)]
struct JsonGeometry<'a> {
    #[serde(rename = "type")]
    kind: &'static str,
    #[serde(skip_serializing_if = "str::is_empty")]
    lod: &'a str,
    boundaries: Nested<Vec<Vec<u32>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    semantics: Option<Semantics<'a>>,
}

#[derive(Serialize)]
struct Semantics<'a> {
    surfaces: Vec<JsonSurface<'a>>,
    values: Nested<Option<u32>>,
}

#[derive(Serialize)]
struct JsonSurface<'a> {
    #[serde(rename = "type")]
    kind: &'a str,
    #[serde(flatten)]
    attributes: &'a Map<String, Value>,
}

/// Something for each face, nested as the type of the geometry wants it.
#[derive(Serialize)]
#[serde(untagged)]
enum Nested<T> {
    Faces(Vec<T>),
    Shells(Vec<Vec<T>>),
    Solids(Vec<Vec<Vec<T>>>),
}

impl<T> Nested<T> {
    fn of(geometry: &Geometry, face: impl Fn(&Face) -> T) -> Self {
        let faces = |shell: &Shell| shell.faces.iter().map(&face).collect::<Vec<T>>();
        match geometry.kind {
            GeometryKind::Solid => Self::Shells(geometry.shells.iter().map(faces).collect()),
            GeometryKind::MultiSolid | GeometryKind::CompositeSolid => {
                let solids = geometry.shells.chunk_by(|a, b| a.solid == b.solid);
                Self::Solids(solids.map(|shells| shells.iter().map(faces).collect()).collect())
            }
            _ => Self::Faces(geometry.shells.iter().flat_map(faces).collect()),
        }
    }
}

impl<'a> JsonGeometry<'a> {
    /// A geometry over the vertices `indices` of the file; `None` for one that has no faces of its own.
    fn of(geometry: &'a Geometry, indices: &[u32]) -> Option<Self> {
        let kind = geometry.kind.of_faces()?;
        let in_file = |&index: &u32| indices.get(index as usize).copied().unwrap_or_default();
        let rings = |face: &Face| face.rings.iter().map(|ring| ring.iter().map(in_file).collect()).collect();
        let semantics = (!geometry.surfaces.is_empty()).then(|| Semantics {
            surfaces: geometry.surfaces.iter().map(JsonSurface::of).collect(),
            values: Nested::of(geometry, |face| face.surface),
        });
        Some(Self { kind, lod: &geometry.lod, boundaries: Nested::of(geometry, rings), semantics })
    }
}

impl<'a> JsonSurface<'a> {
    fn of(surface: &'a SemanticSurface) -> Self {
        Self { kind: &surface.kind, attributes: &surface.attributes }
    }
}

/// Appends the `CityObject`s of a feature as JSON members, `"id":{…},"id-0":{…}`.
pub(super) fn encode(
    feature: &Feature,
    transform: &Transform,
    vertices: &mut Vertices,
    out: &mut Vec<u8>,
) -> serde_json::Result<Encoded> {
    let grid: Vec<[i64; 3]> = feature.vertices.iter().map(|&vertex| on_grid(transform, vertex)).collect();
    let indices: Vec<u32> = grid.iter().map(|&vertex| vertices.index(vertex)).collect();
    let own = |object: &CityObject| {
        let faces = object.geometries.iter().flat_map(|g| &g.shells).flat_map(|shell| &shell.faces);
        let used = faces.flat_map(|face| &face.rings).flatten();
        used.filter_map(|&v| grid.get(v as usize)).fold(None, |extent, &v| Some(Extent::join(extent, v)))
    };
    let extents: Vec<Option<Extent>> = feature.objects.iter().map(own).collect();
    let whole = extents.iter().fold(None, |all, &extent| Extent::union(all, extent));
    for (i, (object, &extent)) in feature.objects.iter().zip(&extents).enumerate() {
        // The extent of the top-level object is that of its children too.
        let extent = if i == 0 { whole } else { extent };
        if i > 0 {
            out.push(b',');
        }
        serde_json::to_writer(&mut *out, &object.id)?;
        out.push(b':');
        let object = JsonObject {
            kind: &object.kind,
            attributes: &object.attributes,
            extent: extent.map(|e| e.to_crs(transform)),
            geometry: object.geometries.iter().filter_map(|g| JsonGeometry::of(g, &indices)).collect(),
            children: &object.children,
            parents: &object.parents,
            members: &object.members,
        };
        serde_json::to_writer(&mut *out, &object)?;
    }
    Ok(Encoded { objects: feature.objects.len(), extent: whole })
}
