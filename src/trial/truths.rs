//! The buildings of a trial: models of any maker that are closed and valid, and generated ones.

use std::path::Path;
use std::sync::Arc;

use serde::Serialize;

use super::hash;
use crate::error::Result;
use crate::evaluate::read_shapes;
use crate::geometry::Aabb;
use crate::simulate::generator::{Generated, building};
use crate::simulate::{Mesh, Model};
use crate::solid::Solid;
use crate::validate::{Tolerances, check};

/// The levels of detail that are LoD 2.
const LODS: [&str; 5] = ["2.2", "2", "2.0", "2.1", "2.3"];
/// Neighbours nearer than this hide parts of a building, metres.
const NEARBY: f64 = 10.0;
/// Seeds tried for every generated building that must have an overhang.
const PATIENCE: u64 = 200;

/// The buildings of a model file.
#[derive(Debug, Clone)]
pub struct Truths {
    /// Those that can serve as truth.
    pub models: Vec<Model>,
    /// Those that cannot.
    pub left_out: Vec<LeftOut>,
}

/// A building that cannot serve as truth.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct LeftOut {
    /// Its id.
    pub id: String,
    /// Why.
    pub reason: String,
}

impl Truths {
    /// Reads the LoD 2 solids of a CityJSON or CityJSONSeq file; the solids of one building are truths of their own.
    ///
    /// # Errors
    /// The file cannot be read, its CRS is in degrees, or no building has LoD 2.
    pub fn read(path: &Path) -> Result<Self> {
        let mut file = read_shapes(path, LODS[0], None);
        for lod in &LODS[1..] {
            if file.is_ok() {
                break;
            }
            file = read_shapes(path, lod, None);
        }
        let file = file?;
        let (mut found, mut left_out) = (Vec::new(), Vec::new());
        for (shape, solids) in file.shapes.iter().zip(&file.solids) {
            let closed = solids.iter().filter(|solid| solid.is_ok()).count();
            for (number, solid) in solids.iter().enumerate() {
                let id = if solids.len() == 1 { shape.id.clone() } else { format!("{}#{number}", shape.id) };
                match solid {
                    Ok(solid) => match check(solid, &Tolerances::default()).first() {
                        None => found.push((id, Arc::new(solid.clone()))),
                        Some(fault) => left_out.push(LeftOut { id, reason: fault.to_string() }),
                    },
                    // The same building again, as surfaces.
                    Err(_) if closed > 0 => {}
                    Err(reason) => left_out.push(LeftOut { id, reason: reason.clone() }),
                }
            }
        }
        let tile: Arc<str> = path.display().to_string().into();
        let meshes: Vec<Arc<Mesh>> = found.iter().map(|(_, solid)| Arc::new(Mesh::of(solid))).collect();
        let boxes: Vec<Option<Aabb>> = meshes.iter().map(|mesh| mesh.aabb()).collect();
        let models = found.into_iter().zip(&meshes).zip(&boxes).filter_map(|(((id, solid), mesh), aabb)| {
            let aabb = (*aabb)?;
            let beside = |other: &Option<Aabb>| {
                other.is_some_and(|o| {
                    o != aabb && (0..2).all(|i| o.min[i] < aabb.max[i] + NEARBY && aabb.min[i] < o.max[i] + NEARBY)
                })
            };
            let near = meshes.iter().zip(&boxes).filter(|(_, other)| beside(other));
            Some(Model {
                id,
                tile: Arc::clone(&tile),
                shape: None,
                frame: file.frame,
                solid,
                mesh: Arc::clone(mesh),
                footprint: mesh.outline(),
                ground: aabb.min[2],
                neighbours: near.map(|(mesh, _)| Arc::clone(mesh)).collect(),
            })
        });
        Ok(Self { models: models.collect(), left_out })
    }

    /// Keeps this many, chosen by the seed alone.
    pub fn limit(&mut self, limit: usize, seed: u64) {
        self.models.sort_by_cached_key(|model| hash(seed, &model.id));
        self.models.truncate(limit);
    }
}

/// Generated buildings, all or only those with overhangs or arcades.
pub fn generated(count: usize, overhanging: bool, seed: u64) -> Vec<Model> {
    let seeds = (0..count as u64 * if overhanging { PATIENCE } else { 2 }).map(|i| hash(seed, &format!("generated-{i}")));
    seeds
        .filter_map(|seed| {
            let drawn = building(seed).ok()?;
            (!overhanging || !drawn.shape.is_height_field()).then(|| model(seed, drawn))
        })
        .take(count)
        .collect()
}

fn model(seed: u64, drawn: Generated) -> Model {
    let mesh = |solid: &Solid| Arc::new(Mesh::of(solid));
    Model {
        id: format!("generated-{seed:016x}"),
        tile: "generated".into(),
        shape: Some(format!("{:?}", drawn.shape.roof)),
        frame: drawn.frame,
        mesh: mesh(&drawn.solid),
        solid: Arc::new(drawn.solid),
        footprint: drawn.footprint,
        ground: drawn.ground,
        neighbours: drawn.neighbours.iter().map(mesh).collect(),
    }
}
