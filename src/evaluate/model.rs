//! City model files as shapes, and tiles as points in their frame.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use nalgebra::Point3;
use rayon::prelude::*;

use super::shape::{Shape, ShapeFace};
use crate::error::{InputError, Result};
use crate::site::Frame;
use crate::solid::{Solid, SurfaceType};
use crate::source::cityjson::{self, CityModel, Geometry, GeometryKind};
use crate::source::crs::Crs;
use crate::validate::{Tolerances, check};

/// The buildings of a city model in one local frame.
#[derive(Debug, Clone)]
pub struct ModelFile {
    /// The local frame of all shapes.
    pub frame: Frame,
    /// The CRS of the model, when the file names one that can be understood.
    pub crs: Option<Crs>,
    /// The buildings, in the order of the file. One without geometry at the level of detail has no faces.
    pub shapes: Vec<Shape>,
    /// The solids of each building on the grid of the frame, as the validator takes them; an error is what keeps a geometry
    /// from being a solid of one shell.
    pub solids: Vec<Vec<Result<Solid, String>>>,
}

impl ModelFile {
    /// The faults of the solids, building by building and solid by solid: val3dity codes, or what keeps a geometry from
    /// being a solid of one shell. A solid without any is valid.
    pub fn faults(&self) -> Vec<Vec<Vec<String>>> {
        let faults = |solid: &Result<Solid, String>| match solid {
            Ok(solid) => {
                let codes: BTreeSet<u16> =
                    check(solid, &Tolerances::default()).iter().map(|fault| fault.code).collect();
                codes.into_iter().map(|code| code.to_string()).collect()
            }
            Err(reason) => vec![reason.clone()],
        };
        self.solids.par_iter().map(|solids| solids.iter().map(faults).collect()).collect()
    }
}

/// The polygons of one building while its objects are gathered.
#[derive(Default)]
struct Gathered {
    faces: Vec<ShapeFace>,
    footprint: Vec<Vec<Vec<Point3<f64>>>>,
    /// The level of detail that it is of.
    footprint_lod: String,
    solids: Vec<Result<Solid, String>>,
    count: u32,
}

/// Reads the buildings of a CityJSON (1.0 to 2.0) or CityJSONSeq file at one level of detail, such as `2.2`.
///
/// The parts of a building become one shape under the id of the building. `frame` is that of the model to compare with;
/// without one a frame is made from the file: its origin is near the first vertex, and its units are those of the CRS.
///
/// # Errors
/// The file cannot be read, its CRS is geographic (distances in degrees mean nothing), or no building has geometry at
/// this level of detail.
pub fn read_shapes(path: &Path, lod: &str, frame: Option<Frame>) -> Result<ModelFile> {
    let features = cityjson::features(path)?;
    let crs = features.head().crs_code().and_then(|code| Crs::parse(&code).ok());
    if let Some(crs) = crs.as_ref().filter(|crs| crs.is_geographic) {
        return Err(InputError::new(path, format!("the geographic CRS {}", crs.name), "coordinates in metres or feet")
            .at("metadata.referenceSystem")
            .remedy("Reproject the model before it is measured")
            .into());
    }
    let metres_per_unit = crs.as_ref().map_or([1.0; 3], |crs| crs.metres_per_unit);
    let mut frame = frame;
    let (mut shapes, mut solids, mut lods) = (Vec::new(), Vec::new(), BTreeSet::new());
    for feature in features {
        let feature = feature?;
        let Some(first) = feature.vertices.first() else { continue };
        let frame = frame.get_or_insert_with(|| Frame { origin: first.map(f64::floor), metres_per_unit });
        for (id, gathered) in gather(&feature, lod, frame, &mut lods) {
            shapes.push(Shape::new(id, gathered.faces, &gathered.footprint));
            solids.push(gathered.solids);
        }
    }
    if shapes.iter().all(|shape| shape.faces.is_empty()) {
        let found = match lods.len() {
            0 => "no building with surfaces".to_owned(),
            _ => format!("buildings at LoD {} only", lods.into_iter().collect::<Vec<_>>().join(", ")),
        };
        return Err(InputError::new(path, found, format!("buildings at LoD {lod}"))
            .remedy("Choose a level of detail that the file has with --lod")
            .into());
    }
    let frame = frame.unwrap_or(Frame { origin: [0.0; 3], metres_per_unit });
    Ok(ModelFile { frame, crs, shapes, solids })
}

/// The buildings of a model or feature by id, in the order of the file.
fn gather(model: &CityModel, lod: &str, frame: &Frame, lods: &mut BTreeSet<String>) -> Vec<(String, Gathered)> {
    let mut found: Vec<(String, Gathered)> = Vec::new();
    let mut places: BTreeMap<&str, usize> = BTreeMap::new();
    let parents: BTreeMap<&str, &str> =
        model.objects.iter().filter_map(|o| Some((o.id.as_str(), o.parents.first()?.as_str()))).collect();
    let root = |id| {
        let mut id: &str = id;
        // Objects that are each other's parents would never end.
        for _ in 0..16 {
            id = parents.get(id).copied().unwrap_or(id);
        }
        id
    };
    for object in model.objects.iter().filter(|o| matches!(o.kind.as_str(), "Building" | "BuildingPart")) {
        let id = root(&object.id);
        let place = *places.entry(id).or_insert_with(|| {
            found.push((id.to_owned(), Gathered::default()));
            found.len() - 1
        });
        let Some((_, building)) = found.get_mut(place) else { continue };
        for geometry in &object.geometries {
            if geometry.lod == lod {
                building.add(model, geometry, frame);
            } else if matches!(geometry.lod.as_str(), "0" | "0.0" | "0.1" | "0.2" | "0.3") {
                // Outlines of its roofs are footprints, too, where there is nothing coarser.
                if building.footprint.is_empty() || geometry.lod < building.footprint_lod {
                    building.footprint.clear();
                    building.footprint_lod.clone_from(&geometry.lod);
                }
                if geometry.lod == building.footprint_lod {
                    let faces = geometry.shells.iter().flat_map(|shell| &shell.faces);
                    building.footprint.extend(faces.map(|face| points(model, &face.rings, frame)));
                }
            } else if !geometry.shells.is_empty() {
                lods.insert(geometry.lod.clone());
            }
        }
    }
    found
}

impl Gathered {
    fn add(&mut self, model: &CityModel, geometry: &Geometry, frame: &Frame) {
        let first = self.count;
        for shell in &geometry.shells {
            let solid = first + shell.solid as u32;
            self.count = self.count.max(solid + 1);
            self.faces.extend(shell.faces.iter().map(|face| {
                let surface = face.surface.and_then(|s| geometry.surfaces.get(s as usize));
                let kind = surface.and_then(|s| kind_of(&s.kind));
                ShapeFace { rings: points(model, &face.rings, frame), kind, solid }
            }));
        }
        if matches!(geometry.kind, GeometryKind::Solid) {
            self.solids.push(model.solid(geometry, frame));
        } else if !geometry.shells.is_empty() {
            self.solids.push(Err("surfaces, not a solid".to_owned()));
        }
    }
}

/// The rings of a face in local metres.
fn points(model: &CityModel, rings: &[Vec<u32>], frame: &Frame) -> Vec<Vec<Point3<f64>>> {
    let point = |&vertex: &u32| model.vertices.get(vertex as usize).map(|v| frame.to_local(*v));
    rings.iter().map(|ring| ring.iter().filter_map(point).collect()).collect()
}

/// The type of a semantic surface; `None` for those that say nothing of where a face looks.
fn kind_of(kind: &str) -> Option<SurfaceType> {
    match kind {
        "RoofSurface" | "OuterFloorSurface" => Some(SurfaceType::Roof),
        "WallSurface" => Some(SurfaceType::Wall),
        "GroundSurface" => Some(SurfaceType::Ground),
        "OuterCeilingSurface" => Some(SurfaceType::OuterCeiling),
        _ => None,
    }
}
