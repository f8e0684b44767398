//! A building as `CityObject`s: `Building` (LoD 0, attributes) → `BuildingPart` (LoD 1.2 and 2.2), as in the 3DBAG.

use std::collections::HashSet;
use std::hash::{DefaultHasher, Hash, Hasher};

use serde::Serialize;
use serde_json::{Map, Value};

use super::attributes::{self, rounded};
use super::header::Metadata;
use super::vertices::Vertices;
use crate::building::Building;
use crate::site::QUANTUM;
use crate::solid::{Model, Solid, Surface, SurfaceType};

/// Grid steps in a unit of the CRS.
const STEPS_PER_UNIT: i64 = (1.0 / QUANTUM) as i64;

/// The ids that are taken, as hashes: 16 bytes an id. A false alarm costs another suffix, nothing more.
#[derive(Debug, Clone, Default)]
pub struct Ids(HashSet<u64>);

impl Ids {
    /// Takes an id; false when it was taken before.
    pub fn take(&mut self, id: &str) -> bool {
        let mut hasher = DefaultHasher::new();
        id.hash(&mut hasher);
        self.0.insert(hasher.finish())
    }

    /// A free id for part `n` of the building `id`: `<id>-<n>`, unless that is taken.
    fn part(&mut self, id: &str, n: usize) -> String {
        let mut candidate = format!("{id}-{n}");
        let mut infix = String::new();
        while !self.take(&candidate) {
            infix.push_str("-part");
            candidate = format!("{id}{infix}-{n}");
        }
        candidate
    }
}

impl<'a> FromIterator<&'a str> for Ids {
    fn from_iter<I: IntoIterator<Item = &'a str>>(ids: I) -> Self {
        let mut taken = Self::default();
        for id in ids {
            taken.take(id);
        }
        taken
    }
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

    /// Coordinates as `geographicalExtent` wants them, exact to the grid.
    pub(super) fn to_crs(self, translate: [i64; 3]) -> [f64; 6] {
        let real = |value: i64, axis: usize| (value + translate[axis] * STEPS_PER_UNIT) as f64 / STEPS_PER_UNIT as f64;
        std::array::from_fn(|i| if i < 3 { real(self.min[i], i) } else { real(self.max[i - 3], i - 3) })
    }
}

/// What one building came to.
pub(super) struct Encoded {
    pub objects: usize,
    pub extent: Option<Extent>,
}

#[derive(Serialize)]
struct CityObject<'a> {
    #[serde(rename = "type")]
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    attributes: Option<Map<String, Value>>,
    #[serde(rename = "geographicalExtent", skip_serializing_if = "Option::is_none")]
    extent: Option<[f64; 6]>,
    #[serde(skip_serializing_if = "Vec::is_empty")]
    geometry: Vec<Geometry>,
    #[serde(skip_serializing_if = "<[String]>::is_empty")]
    children: &'a [String],
    #[serde(skip_serializing_if = "<[&str]>::is_empty")]
    parents: &'a [&'a str],
}

#[derive(Serialize)]
#[serde(tag = "type")]
enum Geometry {
    MultiSurface { lod: &'static str, boundaries: Vec<Vec<Vec<u32>>>, semantics: Semantics<Vec<u32>> },
    Solid { lod: &'static str, boundaries: [Vec<Vec<Vec<u32>>>; 1], semantics: Semantics<[Vec<u32>; 1]> },
}

#[derive(Serialize)]
struct Semantics<V> {
    surfaces: Vec<SemanticSurface>,
    values: V,
}

#[derive(Serialize)]
struct SemanticSurface {
    #[serde(rename = "type")]
    kind: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    slope: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    azimuth: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    height_min: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    height_max: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    on_footprint_edge: Option<bool>,
    #[serde(skip_serializing_if = "Option::is_none")]
    confidence: Option<f64>,
}

/// The name of a semantic surface in CityJSON.
fn surface_type(kind: SurfaceType) -> &'static str {
    match kind {
        SurfaceType::Roof => "RoofSurface",
        SurfaceType::Wall => "WallSurface",
        SurfaceType::Ground => "GroundSurface",
        SurfaceType::OuterCeiling => "OuterCeilingSurface",
    }
}

/// From the grid of a building to the indices of the file.
struct Encoder<'a> {
    building: &'a Building,
    /// From the building's origin to the file's, in steps.
    shift: [i64; 3],
    vertices: &'a mut Vertices,
}

impl Encoder<'_> {
    /// The index of a vertex in the file; `extent` grows by it.
    fn index(&mut self, vertex: [i64; 3], extent: &mut Option<Extent>) -> u32 {
        let vertex = std::array::from_fn(|i| vertex[i] + self.shift[i]);
        *extent = Some(Extent::join(*extent, vertex));
        self.vertices.index(vertex)
    }

    /// LoD 0: the footprint at the height of the ground.
    fn footprint(&mut self, model: &Model, extent: &mut Option<Extent>) -> Geometry {
        let mut boundaries = Vec::with_capacity(model.footprint.len());
        for polygon in &model.footprint {
            let mut rings = Vec::with_capacity(polygon.len());
            for ring in polygon {
                rings.push(ring.iter().map(|p| self.index([p[0], p[1], model.ground], extent)).collect());
            }
            boundaries.push(rings);
        }
        let values = vec![0; boundaries.len()];
        let surfaces = vec![self.surface(&Surface::of(SurfaceType::Ground))];
        Geometry::MultiSurface { lod: "0", boundaries, semantics: Semantics { surfaces, values } }
    }

    /// LoD 1.2 or 2.2.
    fn solid(&mut self, solid: &Solid, lod: &'static str, extent: &mut Option<Extent>) -> Geometry {
        let indices: Vec<u32> = solid.vertices.iter().map(|&v| self.index(v, extent)).collect();
        let in_file = |ring: &Vec<u32>| ring.iter().map(|&v| indices[v as usize]).collect();
        let shell = solid.faces.iter().map(|face| face.rings.iter().map(in_file).collect()).collect();
        let values = solid.faces.iter().map(|face| face.surface).collect();
        let surfaces = solid.surfaces.iter().map(|surface| self.surface(surface)).collect();
        Geometry::Solid { lod, boundaries: [shell], semantics: Semantics { surfaces, values: [values] } }
    }

    fn surface(&self, surface: &Surface) -> SemanticSurface {
        let height = |i: usize| surface.heights.and_then(|h| attributes::height(&self.building.frame, h[i]));
        SemanticSurface {
            kind: surface_type(surface.kind),
            slope: surface.slope.and_then(|v| rounded(v, 3)),
            azimuth: surface.azimuth.and_then(|v| rounded(v, 3)),
            height_min: height(0),
            height_max: height(1),
            on_footprint_edge: surface.on_footprint_edge,
            confidence: surface.confidence.and_then(|v| rounded(v, 3)),
        }
    }
}

/// Appends the `CityObject`s of a building as JSON members, `"id":{…},"id-0":{…}`.
///
/// The building's origin and `translate` are whole CRS units, so that its vertices reach the file's grid exactly.
pub(super) fn encode(
    building: &Building,
    metadata: &Metadata,
    ids: &mut Ids,
    vertices: &mut Vertices,
    out: &mut Vec<u8>,
) -> serde_json::Result<Encoded> {
    let translate = metadata.translate;
    let origin = building.frame.origin;
    let shift = std::array::from_fn(|i| (origin[i].round() as i64 - translate[i]) * STEPS_PER_UNIT);
    let mut encoder = Encoder { building, shift, vertices };
    let model = &building.model;
    ids.take(&building.id);

    let mut extent = None;
    let footprint = (!model.footprint.is_empty()).then(|| encoder.footprint(model, &mut extent));
    let parents = [building.id.as_str()];
    let (mut parts, mut names) = (Vec::new(), Vec::new());
    for part in model.parts.iter().filter(|part| part.lod12.is_some() || part.lod22.is_some()) {
        let mut own = None;
        let mut geometry = Vec::with_capacity(2);
        geometry.extend(part.lod12.as_ref().map(|solid| encoder.solid(solid, "1.2", &mut own)));
        geometry.extend(part.lod22.as_ref().map(|solid| encoder.solid(solid, "2.2", &mut own)));
        extent = Extent::union(extent, own);
        names.push(ids.part(&building.id, parts.len()));
        parts.push(CityObject {
            kind: "BuildingPart",
            attributes: None,
            extent: own.map(|e| e.to_crs(translate)),
            geometry,
            children: &[],
            parents: &parents,
        });
    }
    let whole = CityObject {
        kind: "Building",
        attributes: Some(attributes::of(building, &metadata.point_cloud)),
        extent: extent.map(|e| e.to_crs(translate)),
        geometry: footprint.into_iter().collect(),
        children: &names,
        parents: &[],
    };
    member(&building.id, &whole, out)?;
    for (name, part) in names.iter().zip(&parts) {
        out.push(b',');
        member(name, part, out)?;
    }
    Ok(Encoded { objects: 1 + parts.len(), extent })
}

/// Appends `"key":value`.
fn member(key: &str, value: &impl Serialize, out: &mut Vec<u8>) -> serde_json::Result<()> {
    serde_json::to_writer(&mut *out, key)?;
    out.push(b':');
    serde_json::to_writer(out, value)
}
