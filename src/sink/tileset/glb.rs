//! Binary glTF 2.0 with feature ids and property tables (`EXT_mesh_features`, `EXT_structural_metadata`).

use std::collections::BTreeMap;

use serde_json::{Map, Value, json};

use super::properties::Class;
use crate::sink::colour::colour;

/// Component types of accessors (glTF 2.0, section 3.6.2.2).
const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;
/// What buffer views hold (section 5.11).
const ARRAY_BUFFER: u32 = 34962;
const ELEMENT_ARRAY_BUFFER: u32 = 34963;

/// The binary part, with the views into it.
#[derive(Debug, Default)]
pub(super) struct Buffer {
    bytes: Vec<u8>,
    views: Vec<Value>,
}

impl Buffer {
    /// Adds a view; returns its index. Every view begins at a multiple of 8 bytes, as property tables demand.
    pub(super) fn view(&mut self, bytes: &[u8]) -> usize {
        self.add(bytes, None)
    }

    fn add(&mut self, bytes: &[u8], target: Option<u32>) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(8), 0);
        let mut view = json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()});
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.bytes.extend_from_slice(bytes);
        self.views.push(view);
        self.views.len() - 1
    }
}

/// The triangles of one class of surfaces. Vertices are in metres from the centre of the tile: east, north, up.
#[derive(Debug, Default)]
pub(super) struct Primitive {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    features: Vec<f32>,
    surfaces: Vec<f32>,
    indices: Vec<u32>,
}

impl Primitive {
    /// Adds a flat face: its corners, its triangles as indices of corners, its normal, and the rows of its feature and of
    /// its surface.
    pub(super) fn add(&mut self, corners: &[[f64; 3]], triangles: &[[u32; 3]], normal: [f64; 3], rows: [usize; 2]) {
        let base = self.positions.len() as u32;
        for &corner in corners {
            self.positions.push(y_up(corner));
            self.normals.push(y_up(normal));
            // A 32-bit float holds every whole number up to 16 million, which no tile has.
            self.features.push(rows[0] as f32);
            self.surfaces.push(rows[1] as f32);
        }
        self.indices.extend(triangles.iter().flatten().map(|&corner| base + corner));
    }
}

/// East, north, up as glTF has it: y is up, and z points south.
fn y_up([east, north, up]: [f64; 3]) -> [f32; 3] {
    // There is no negative zero.
    [east as f32, up as f32, (0.0 - north) as f32]
}

/// A tile: its triangles by class, and the rows of its two property tables.
#[derive(Debug, Default)]
pub(super) struct Content {
    /// The centre of the tile in the frame of the tileset, metres.
    pub centre: [f64; 3],
    pub primitives: BTreeMap<String, Primitive>,
    pub features: Vec<Map<String, Value>>,
    pub surfaces: Vec<Map<String, Value>>,
}

impl Content {
    /// The tile as binary glTF.
    pub(super) fn to_glb(&self, features: &Class, surfaces: &Class) -> serde_json::Result<Vec<u8>> {
        let mut buffer = Buffer::default();
        let mut accessors = Vec::new();
        let (mut primitives, mut materials) = (Vec::new(), Vec::new());
        for (class, primitive) in &self.primitives {
            let mut vectors = |vectors: &[[f32; 3]], has_bounds: bool| {
                let bytes: Vec<u8> = vectors.iter().flatten().flat_map(|c| c.to_le_bytes()).collect();
                let view = buffer.add(&bytes, Some(ARRAY_BUFFER));
                let mut accessor =
                    json!({"bufferView": view, "componentType": FLOAT, "count": vectors.len(), "type": "VEC3"});
                if has_bounds {
                    let of = |pick: fn(f32, f32) -> f32, start: f32| -> [f32; 3] {
                        std::array::from_fn(|i| vectors.iter().map(|v| v[i]).fold(start, pick))
                    };
                    accessor["min"] = json!(of(f32::min, f32::INFINITY));
                    accessor["max"] = json!(of(f32::max, f32::NEG_INFINITY));
                }
                accessors.push(accessor);
                accessors.len() - 1
            };
            let positions = vectors(&primitive.positions, true);
            let normals = vectors(&primitive.normals, false);
            let mut ids = |ids: &[f32]| {
                let bytes: Vec<u8> = ids.iter().flat_map(|id| id.to_le_bytes()).collect();
                let view = buffer.add(&bytes, Some(ARRAY_BUFFER));
                accessors
                    .push(json!({"bufferView": view, "componentType": FLOAT, "count": ids.len(), "type": "SCALAR"}));
                accessors.len() - 1
            };
            let (feature_ids, surface_ids) = (ids(&primitive.features), ids(&primitive.surfaces));
            let bytes: Vec<u8> = primitive.indices.iter().flat_map(|i| i.to_le_bytes()).collect();
            let view = buffer.add(&bytes, Some(ELEMENT_ARRAY_BUFFER));
            accessors.push(json!({
                "bufferView": view, "componentType": UNSIGNED_INT, "count": primitive.indices.len(), "type": "SCALAR",
            }));
            primitives.push(json!({
                "attributes": {
                    "POSITION": positions, "NORMAL": normals, "_FEATURE_ID_0": feature_ids, "_FEATURE_ID_1": surface_ids,
                },
                "indices": accessors.len() - 1,
                "material": materials.len(),
                "extensions": {"EXT_mesh_features": {"featureIds": [
                    {"featureCount": distinct(&primitive.features), "attribute": 0, "propertyTable": 0, "label": "feature"},
                    {"featureCount": distinct(&primitive.surfaces), "attribute": 1, "propertyTable": 1, "label": "surface"},
                ]}},
            }));
            materials.push(material(class));
        }
        let tables = [features.table(&self.features, &mut buffer), surfaces.table(&self.surfaces, &mut buffer)];
        let [east, north, up] = self.centre;
        let gltf = json!({
            "asset": {"version": "2.0", "generator": concat!("gable ", env!("CARGO_PKG_VERSION"))},
            "extensionsUsed": ["EXT_mesh_features", "EXT_structural_metadata"],
            "scene": 0,
            "scenes": [{"nodes": [0]}],
            "nodes": [{"mesh": 0, "translation": [east, up, 0.0 - north]}],
            "meshes": [{"primitives": primitives}],
            "materials": materials,
            "accessors": accessors,
            "bufferViews": buffer.views,
            "buffers": [{"byteLength": buffer.bytes.len()}],
            "extensions": {"EXT_structural_metadata": {
                "schema": {
                    "id": "gable",
                    "classes": {"feature": features.schema(), "surface": surfaces.schema()},
                },
                "propertyTables": tables,
            }},
        });
        container(&serde_json::to_vec(&gltf)?, &buffer.bytes)
            .ok_or_else(|| serde::ser::Error::custom("more than 4 GiB"))
    }
}

/// How many different ids there are.
fn distinct(ids: &[f32]) -> usize {
    let mut ids: Vec<u32> = ids.iter().map(|&id| id as u32).collect();
    ids.sort_unstable();
    ids.dedup();
    ids.len()
}

/// A matt material in the colour of a class.
fn material(class: &str) -> Value {
    // Colours of materials are linear (section 5.22.2).
    let linear = |c: f64| if c <= 0.040_45 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) };
    let [r, g, b] = colour(class).map(|c| (linear(c) * 1e4).round() / 1e4);
    json!({
        "name": class,
        "doubleSided": true,
        "pbrMetallicRoughness": {"baseColorFactor": [r, g, b, 1.0], "metallicFactor": 0.0, "roughnessFactor": 1.0},
    })
}

/// JSON and binary part in one file (section 4); `None` where it would be larger than the format allows.
fn container(json: &[u8], binary: &[u8]) -> Option<Vec<u8>> {
    const HEAD: usize = 12;
    const CHUNK_HEAD: usize = 8;
    let mut json = json.to_vec();
    // So that the binary part begins at a multiple of 8 bytes of the file.
    while !(HEAD + CHUNK_HEAD + json.len() + CHUNK_HEAD).is_multiple_of(8) {
        json.push(b' ');
    }
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let total = HEAD + 2 * CHUNK_HEAD + json.len() + binary.len();
    let mut out = Vec::with_capacity(total);
    out.extend_from_slice(b"glTF");
    for number in [2, u32::try_from(total).ok()?, json.len() as u32] {
        out.extend_from_slice(&number.to_le_bytes());
    }
    out.extend_from_slice(b"JSON");
    out.extend_from_slice(&json);
    out.extend_from_slice(&(binary.len() as u32).to_le_bytes());
    out.extend_from_slice(b"BIN\0");
    out.extend_from_slice(&binary);
    Some(out)
}
