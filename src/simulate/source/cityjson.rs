//! Models from city model files.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use geo::{Area, BooleanOps, MultiPolygon};
use rayon::prelude::*;

use super::super::mesh::Mesh;
use super::super::model::Model;
use super::Source;
use super::near::Near;
use crate::error::{InputError, Result};
use crate::geometry::Aabb;
use crate::site::Frame;
use crate::solid::Solid;
use crate::source::cityjson::{self, CityObject, Geometry};
use crate::source::crs::Crs;
use crate::validate::{self, Tolerances, codes};

/// A file with more models than this is more than one tile.
const TILE_MODELS: usize = 600;
/// Side of the square blocks that a large file is divided into, metres.
const BLOCK: f64 = 250.0;
/// How far a vertex may be off the plane of its face, metres: other makers round to centimetres.
const PLANARITY: f64 = 0.05;
/// Outlines that are smaller are those of sheds and of mistakes, m².
const LEAST_AREA: f64 = 6.0;
/// Models that are lower, metres.
const LEAST_HEIGHT: f64 = 1.5;
/// A solid whose outline has more than this in common with that of another, m², stands on it, under it or in it.
const OVERLAP: f64 = 0.5;
/// Models with a longer side, metres, are not of one building.
const MOST_SIDE: f64 = 250.0;

/// A solid of the file on its way to a model.
struct Candidate {
    id: String,
    solid: Result<Solid, String>,
}

/// Reads the LoD 2 solids of a CityJSON (1.0 to 2.0) or CityJSONSeq file, each a model: a building of several parts is as
/// many models, which are each other's neighbours. Parts that stand on one another, a dormer on a roof say, are not: each is
/// scanned as if the other were not there, since points on the other would be no part of its truth. Of an object with several geometries of LoD 2 the one with the highest
/// is taken, or that of `lod`. A `MultiSurface` that is closed is as good as a solid.
///
/// The file is one tile, unless it has more than 600 models: then blocks of 250 m are.
///
/// # Errors
/// The file cannot be read, its CRS is geographic, or it has no geometry of LoD 2.
pub fn read(path: &Path, lod: Option<&str>) -> Result<Source> {
    let features = cityjson::features(path)?;
    let crs = features.head().crs_code().and_then(|code| Crs::parse(&code).ok());
    if let Some(crs) = crs.as_ref().filter(|crs| crs.is_geographic) {
        return Err(InputError::new(path, format!("the geographic CRS {}", crs.name), "coordinates in metres or feet")
            .at("metadata.referenceSystem")
            .remedy("Reproject the model first")
            .into());
    }
    let metres_per_unit = crs.as_ref().map_or([1.0; 3], |crs| crs.metres_per_unit);
    let mut frame = None;
    let mut candidates = Vec::new();
    for feature in features {
        let feature = feature?;
        let Some(first) = feature.vertices.first() else { continue };
        let frame = *frame.get_or_insert_with(|| Frame { origin: first.map(f64::floor), metres_per_unit });
        for object in &feature.objects {
            let Some(geometry) = chosen(object, lod) else { continue };
            candidates.push(Candidate { id: object.id.clone(), solid: feature.solid(geometry, &frame) });
        }
    }
    let Some(frame) = frame.filter(|_| !candidates.is_empty()) else {
        let expected = lod.map_or_else(|| "buildings at LoD 2".to_owned(), |lod| format!("buildings at LoD {lod}"));
        return Err(InputError::new(path, "no solid of a building at that level of detail", expected)
            .remedy("Give a file of LoD 2 models, or another level with --lod")
            .into());
    };
    let name = path.file_stem().map_or_else(|| path.display().to_string(), |stem| stem.to_string_lossy().into_owned());
    Ok(assemble(&name, frame, crs, candidates))
}

/// The geometry of LoD 2 that an object is taken from.
fn chosen<'a>(object: &'a CityObject, lod: Option<&str>) -> Option<&'a Geometry> {
    if !matches!(object.kind.as_str(), "Building" | "BuildingPart") {
        return None;
    }
    let fits = |geometry: &&Geometry| {
        !geometry.shells.is_empty() && lod.map_or_else(|| geometry.lod.starts_with('2'), |lod| geometry.lod == lod)
    };
    object.geometries.iter().filter(fits).max_by(|a, b| a.lod.cmp(&b.lod))
}

/// Tells models from what is none, and finds their neighbours and tiles.
fn assemble(name: &str, frame: Frame, crs: Option<Crs>, candidates: Vec<Candidate>) -> Source {
    let judged: Vec<_> = candidates.into_par_iter().map(judge).collect();
    let mut left_out = BTreeMap::new();
    let mut there: Vec<(String, Solid, Arc<Mesh>, Aabb, bool)> = Vec::new();
    for Judged { id, shape, flaw } in judged {
        let is_sound = flaw.is_none();
        if let Some(flaw) = flaw {
            *left_out.entry(flaw).or_default() += 1;
        }
        // What is open or invalid still stands in the way of others.
        if let Some((solid, mesh)) = shape
            && let Some(aabb) = mesh.aabb()
        {
            there.push((id, solid, Arc::new(mesh), aabb, is_sound));
        }
    }
    let near = Near::new(there.iter().map(|(.., aabb, _)| *aabb).collect());
    let meshes: Vec<Arc<Mesh>> = there.iter().map(|(_, _, mesh, ..)| Arc::clone(mesh)).collect();
    let outlines: Vec<MultiPolygon<f64>> = meshes.par_iter().map(|mesh| mesh.outline()).collect();
    let is_large = there.iter().filter(|(.., is_sound)| *is_sound).count() > TILE_MODELS;
    let whole: Arc<str> = name.into();
    let mut models: Vec<Model> = there
        .into_par_iter()
        .enumerate()
        .filter(|(_, (.., is_sound))| *is_sound)
        .map(|(index, (id, solid, mesh, aabb, _))| {
            let footprint = outlines.get(index).cloned().unwrap_or_else(|| MultiPolygon::new(Vec::new()));
            let beside = near.around(index).into_iter().filter(|&i| {
                outlines.get(i).is_some_and(|other| other.intersection(&footprint).unsigned_area() <= OVERLAP)
            });
            let neighbours = beside.filter_map(|i| meshes.get(i).cloned()).collect();
            let block = [0, 1].map(|i| (f64::midpoint(aabb.min[i], aabb.max[i]) / BLOCK).floor() as i64);
            let tile = if is_large { format!("{name}/{}_{}", block[0], block[1]).into() } else { Arc::clone(&whole) };
            Model {
                id,
                tile,
                shape: None,
                frame,
                solid: Arc::new(solid),
                footprint,
                mesh,
                ground: aabb.min[2],
                neighbours,
            }
        })
        .collect();
    let before = models.len();
    models.retain(|model| model.footprint.unsigned_area() >= LEAST_AREA);
    if models.len() < before {
        *left_out.entry(format!("smaller than {LEAST_AREA} m²")).or_default() += before - models.len();
    }
    let tiling = if is_large { format!("blocks of {BLOCK} m, since it is large") } else { "one tile".to_owned() };
    Source { name: name.to_owned(), models, left_out, crs, tiling, is_generated: false }
}

/// What a candidate is worth.
struct Judged {
    id: String,
    shape: Option<(Solid, Mesh)>,
    flaw: Option<String>,
}

fn judge(candidate: Candidate) -> Judged {
    let Candidate { id, solid } = candidate;
    let solid = match solid {
        Ok(solid) => solid,
        Err(reason) => return Judged { id, shape: None, flaw: Some(reason) },
    };
    // Folds as thin as that matter to no scan.
    let tolerances = Tolerances { snap: 0.0, planarity: PLANARITY, normals: 180.0, ..Tolerances::default() };
    let mesh = Mesh::of(&solid);
    let flaw = match validate::first_fault(&solid, &tolerances) {
        Some(fault) => Some(format!("{} {}", fault.code, codes::name(fault.code))),
        None => unfit(&mesh),
    };
    Judged { id, shape: Some((solid, mesh)), flaw }
}

/// Why a valid solid is no building that could be scanned.
fn unfit(mesh: &Mesh) -> Option<String> {
    let extent = mesh.aabb().map_or([0.0; 3], |aabb| aabb.extent());
    if extent[2] < LEAST_HEIGHT {
        return Some(format!("lower than {LEAST_HEIGHT} m"));
    }
    (extent.into_iter().fold(0.0, f64::max) > MOST_SIDE).then(|| format!("longer than {MOST_SIDE} m"))
}
