//! A building as `CityObject`s: `Building` (LoD 0, attributes) → `BuildingPart` (LoD 1.2, 1.3, 2.2 and 2.3), as in the 3DBAG.

use foldhash::fast::RandomState;
use std::collections::{HashMap, HashSet};
use std::hash::{DefaultHasher, Hash, Hasher};

use serde_json::{Map, Value};

use super::Feature;
use super::attributes::{self, Chosen, rounded};
use super::selection::AttributeOptions;
use crate::building::Building;
use crate::record::PointCloud;
use crate::site::QUANTUM;
use crate::solid::{RoofPolygon, Solid, Surface, SurfaceType};
use crate::source::cityjson::{CityObject, Face, Geometry, GeometryKind, SemanticSurface, Shell};

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

/// Makes features of reconstructed buildings; the ids of all its features differ.
#[derive(Debug, Default)]
pub struct Encoder {
    ids: Ids,
    point_cloud: PointCloud,
    attributes: Chosen,
}

impl Encoder {
    /// An encoder of buildings made from this point cloud; `ids` are those of all buildings to come, so that no part
    /// takes the id of a building. All attributes are written; see [`Self::with_attributes`].
    pub fn new(ids: Ids, point_cloud: PointCloud) -> Self {
        Self { ids, point_cloud, attributes: Chosen::default() }
    }

    /// The same that writes these attributes only.
    #[must_use]
    pub fn with_attributes(self, options: AttributeOptions) -> Self {
        Self { attributes: Chosen::new(options), ..self }
    }

    /// A building with the attributes of the source and those of [`ATTRIBUTES`](super::ATTRIBUTES), and its parts.
    ///
    /// The building's origin is in whole CRS units, so that its vertices are the decimal numbers nearest to multiples of
    /// [`QUANTUM`].
    pub fn feature(&mut self, building: &Building) -> Feature {
        self.ids.take(&building.id);
        let mut vertices = Vertices::new(building);
        let mut whole = CityObject {
            id: building.id.clone(),
            kind: "Building".to_owned(),
            attributes: self.attributes.of(building, &self.point_cloud),
            ..CityObject::default()
        };
        whole.geometries.extend(footprint(building, &mut vertices));
        let model = &building.model;
        for (lod, roofs) in [("0.1", &model.roof_outlines), ("0.3", &model.roof_parts)] {
            whole.geometries.extend(flat_roofs(building, roofs, lod, &mut vertices));
        }
        let mut parts = Vec::new();
        for part in building.model.parts.iter().filter(|part| part.solids().next().is_some()) {
            let solids = [("1.2", &part.lod12), ("1.3", &part.lod13), ("2.2", &part.lod22), ("2.3", &part.lod23)];
            let solids = solids.into_iter().filter_map(|(lod, solid)| Some((lod, solid.as_ref()?)));
            let id = self.ids.part(&building.id, parts.len());
            whole.children.push(id.clone());
            parts.push(CityObject {
                id,
                kind: "BuildingPart".to_owned(),
                parents: vec![building.id.clone()],
                geometries: solids.map(|(lod, solid)| geometry(building, solid, lod, &mut vertices)).collect(),
                ..CityObject::default()
            });
        }
        let objects = std::iter::once(whole).chain(parts).collect();
        Feature { id: building.id.clone(), objects, vertices: vertices.list }
    }
}

impl Encoder {
    /// Gives a feature of one object another id where its own is taken.
    pub fn rename(&mut self, feature: &mut Feature) {
        while !self.ids.take(&feature.id) {
            feature.id.push('_');
        }
        if let Some(root) = feature.objects.first_mut() {
            root.id.clone_from(&feature.id);
        }
    }
}

/// The vertices of a feature in the order of their first use, each once.
struct Vertices {
    /// The building's origin in steps.
    origin: [i64; 3],
    index: HashMap<[i64; 3], u32, RandomState>,
    list: Vec<[f64; 3]>,
}

impl Vertices {
    fn new(building: &Building) -> Self {
        let origin = building.frame.origin.map(|c| c.round() as i64 * STEPS_PER_UNIT);
        Self { origin, index: HashMap::default(), list: Vec::new() }
    }

    fn index(&mut self, vertex: [i64; 3]) -> u32 {
        *self.index.entry(vertex).or_insert_with(|| {
            self.list.push(std::array::from_fn(|i| (self.origin[i] + vertex[i]) as f64 / STEPS_PER_UNIT as f64));
            self.list.len() as u32 - 1
        })
    }
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

/// LoD 0: the footprint at the height of the ground; `None` without one.
fn footprint(building: &Building, vertices: &mut Vertices) -> Option<Geometry> {
    let model = &building.model;
    if model.footprint.is_empty() {
        return None;
    }
    let mut faces = Vec::with_capacity(model.footprint.len());
    for polygon in &model.footprint {
        let mut rings = Vec::with_capacity(polygon.len());
        for ring in polygon {
            rings.push(ring.iter().map(|p| vertices.index([p[0], p[1], model.ground])).collect());
        }
        faces.push(Face { rings, surface: Some(0) });
    }
    Some(Geometry {
        lod: "0".to_owned(),
        kind: GeometryKind::MultiSurface,
        shells: vec![Shell { solid: 0, faces }],
        surfaces: vec![semantic_surface(building, &Surface::of(SurfaceType::Ground))],
        instance: None,
    })
}

/// LoD 0.1 or 0.3: level polygons at the heights of roofs, each a surface of its own; `None` without any.
fn flat_roofs(building: &Building, roofs: &[RoofPolygon], lod: &str, vertices: &mut Vertices) -> Option<Geometry> {
    let step = building.frame.step()[2];
    let mut faces = Vec::with_capacity(roofs.len());
    let mut surfaces = Vec::with_capacity(roofs.len());
    for (roof, index) in roofs.iter().zip(0_u32..) {
        let rings = roof.polygon.iter();
        let rings =
            rings.map(|ring| ring.iter().map(|p| vertices.index([p[0], p[1], roof.height])).collect()).collect();
        faces.push(Face { rings, surface: Some(index) });
        let heights = Some([roof.height as f64 * step; 2]);
        let surface = Surface { slope: Some(0.0), heights, ..Surface::of(SurfaceType::Roof) };
        surfaces.push(semantic_surface(building, &surface));
    }
    (!faces.is_empty()).then(|| Geometry {
        lod: lod.to_owned(),
        kind: GeometryKind::MultiSurface,
        shells: vec![Shell { solid: 0, faces }],
        surfaces,
        instance: None,
    })
}

/// LoD 1.2, 1.3, 2.2 or 2.3.
fn geometry(building: &Building, solid: &Solid, lod: &str, vertices: &mut Vertices) -> Geometry {
    let indices: Vec<u32> = solid.vertices.iter().map(|&v| vertices.index(v)).collect();
    let in_feature =
        |ring: &Vec<u32>| ring.iter().map(|&v| indices.get(v as usize).copied().unwrap_or_default()).collect();
    let faces = solid
        .faces
        .iter()
        .map(|face| Face { rings: face.rings.iter().map(in_feature).collect(), surface: Some(face.surface) });
    Geometry {
        lod: lod.to_owned(),
        kind: GeometryKind::Solid,
        shells: vec![Shell { solid: 0, faces: faces.collect() }],
        surfaces: solid.surfaces.iter().map(|surface| semantic_surface(building, surface)).collect(),
        instance: None,
    }
}

fn semantic_surface(building: &Building, surface: &Surface) -> SemanticSurface {
    let height = |i: usize| surface.heights.and_then(|h| attributes::height(&building.frame, h[i]));
    let members: [(&str, Option<Value>); 7] = [
        ("slope", surface.slope.and_then(|v| rounded(v, 3)).map(Value::from)),
        ("azimuth", surface.azimuth.and_then(|v| rounded(v, 3)).map(Value::from)),
        ("height_min", height(0).map(Value::from)),
        ("height_max", height(1).map(Value::from)),
        ("on_footprint_edge", surface.on_footprint_edge.map(Value::from)),
        ("floor_depth", surface.floor_depth.and_then(|v| rounded(v, 3)).map(Value::from)),
        ("confidence", surface.confidence.and_then(|v| rounded(v, 3)).map(Value::from)),
    ];
    let members = members.into_iter().filter_map(|(name, value)| Some((name.to_owned(), value?)));
    SemanticSurface { kind: surface_type(surface.kind).to_owned(), attributes: members.collect::<Map<_, _>>() }
}
