//! A feature as it waits on disk for its tile: cut into triangles, in coordinates of the CRS.

use serde_json::{Map, Value};

use super::bytes::{Put, Take};
use crate::sink::Feature;
use crate::sink::columns::row_of;
use crate::sink::faces::{blocks, finest, surfaces, triangles};
use crate::source::cityjson::{CityObject, Geometry};

/// A face in triangles.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Patch {
    /// Index into [`Level::surfaces`].
    pub surface: u32,
    /// Indices into [`Record::vertices`].
    pub triangles: Vec<[u32; 3]>,
}

/// A semantic surface.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Surface {
    /// The object that it belongs to.
    pub object: String,
    /// Its class; see [`crate::sink::faces::SurfaceFaces`].
    pub class: String,
    pub attributes: Map<String, Value>,
}

/// A feature at one level of detail.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Level {
    pub lod: String,
    pub surfaces: Vec<Surface>,
    pub patches: Vec<Patch>,
    /// Lowest and highest vertex in units of the CRS.
    pub heights: [f64; 2],
}

/// A feature with what its tile needs.
#[derive(Debug, Clone, Default, PartialEq)]
pub(super) struct Record {
    pub id: String,
    pub kind: String,
    pub attributes: Map<String, Value>,
    /// Vertices in CRS coordinates.
    pub vertices: Vec<[f64; 3]>,
    /// The finest level.
    pub fine: Level,
    /// The block of LoD 1 where there is one beside the finest level.
    pub block: Option<Level>,
}

impl Record {
    /// What a tile needs of a feature, and how many children have attributes that are left out.
    pub(super) fn of(feature: &Feature, metres: [f64; 3]) -> (Self, usize) {
        let (attributes, left_out) = row_of(feature);
        let [fine, block] = [finest(feature), blocks(feature)].map(|chosen| level(feature, &chosen, metres));
        let record = Self {
            id: feature.id.clone(),
            kind: feature.root().map(|root| root.kind.clone()).unwrap_or_default(),
            attributes,
            vertices: feature.vertices.clone(),
            block: (!block.patches.is_empty() && block.lod != fine.lod).then_some(block),
            fine,
        };
        (record, left_out)
    }

    /// How many triangles the finest level has.
    pub(super) fn size(&self) -> usize {
        self.fine.patches.iter().map(|patch| patch.triangles.len()).sum()
    }

    /// Metres between the tops of the block and of the finest level; 0 without a block.
    pub(super) fn block_error(&self, metres: f64) -> f64 {
        self.block.as_ref().map_or(0.0, |block| (block.heights[1] - self.fine.heights[1]).abs() * metres)
    }

    /// Appends it to a buffer.
    pub(super) fn put(&self, out: &mut Vec<u8>) {
        out.put_text(&self.id);
        out.put_text(&self.kind);
        put_attributes(&self.attributes, out);
        out.put_u32(self.vertices.len() as u32);
        self.vertices.iter().flatten().for_each(|&c| out.put_f64(c));
        self.fine.put(out);
        out.put_u32(u32::from(self.block.is_some()));
        if let Some(block) = &self.block {
            block.put(out);
        }
    }

    /// Takes one from the front of a buffer; `None` where there is none.
    pub(super) fn take(from: &mut Take<'_>) -> Option<Self> {
        Some(Self {
            id: from.text()?,
            kind: from.text()?,
            attributes: take_attributes(from)?,
            vertices: from.list(|from| Some([from.f64()?, from.f64()?, from.f64()?]))?,
            fine: Level::take(from)?,
            block: if from.u32()? == 1 { Some(Level::take(from)?) } else { None },
        })
    }
}

impl Level {
    fn put(&self, out: &mut Vec<u8>) {
        out.put_text(&self.lod);
        self.heights.iter().for_each(|&height| out.put_f64(height));
        out.put_u32(self.surfaces.len() as u32);
        for surface in &self.surfaces {
            out.put_text(&surface.object);
            out.put_text(&surface.class);
            put_attributes(&surface.attributes, out);
        }
        out.put_u32(self.patches.len() as u32);
        for patch in &self.patches {
            out.put_u32(patch.surface);
            out.put_u32(patch.triangles.len() as u32);
            patch.triangles.iter().flatten().for_each(|&v| out.put_u32(v));
        }
    }

    fn take(from: &mut Take<'_>) -> Option<Self> {
        Some(Self {
            lod: from.text()?,
            heights: [from.f64()?, from.f64()?],
            surfaces: from.list(|from| {
                Some(Surface { object: from.text()?, class: from.text()?, attributes: take_attributes(from)? })
            })?,
            patches: from.list(|from| {
                let surface = from.u32()?;
                let triangles = from.list(|from| Some([from.u32()?, from.u32()?, from.u32()?]))?;
                Some(Patch { surface, triangles })
            })?,
        })
    }
}

fn put_attributes(attributes: &Map<String, Value>, out: &mut Vec<u8>) {
    // A map of JSON values is always JSON.
    out.put_text(&serde_json::to_string(attributes).unwrap_or_default());
}

fn take_attributes(from: &mut Take<'_>) -> Option<Map<String, Value>> {
    serde_json::from_str(&from.text()?).ok()
}

/// The chosen geometries as one level.
fn level(feature: &Feature, chosen: &[(&CityObject, &Geometry)], metres: [f64; 3]) -> Level {
    let mut level = Level { heights: [f64::INFINITY, f64::NEG_INFINITY], ..Level::default() };
    for (object, geometry) in chosen {
        level.lod.clone_from(&geometry.lod);
        for surface in surfaces(feature, object, geometry, metres) {
            for face in &surface.faces {
                let triangles = triangles(feature, face, metres);
                for &v in triangles.iter().flatten() {
                    let z = feature.vertex(v)[2];
                    level.heights = [level.heights[0].min(z), level.heights[1].max(z)];
                }
                if !triangles.is_empty() {
                    level.patches.push(Patch { surface: level.surfaces.len() as u32, triangles });
                }
            }
            level.surfaces.push(Surface {
                object: object.id.clone(),
                class: surface.class.to_owned(),
                attributes: surface.attributes.cloned().unwrap_or_default(),
            });
        }
    }
    level
}
