//! Buildings as triangles.

use std::cmp::Ordering;
use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};

use gable::error::{InputError, Result};
use gable::geometry::triangle_indices;
use gable::nalgebra::Point3;
use gable::source::cityjson::{self, CityModel, CityObject, Face, Geometry};
use gable::source::crs::Crs;
use numpy::{PyArray1, PyArray2, PyArrayMethods};
use pyo3::prelude::*;

use crate::supervise::{Teller, file_size, supervised};

/// The triangles of a building.
struct Mesh {
    id: String,
    /// CRS coordinates, one after the other.
    vertices: Vec<f64>,
    /// Three vertices for each triangle.
    triangles: Vec<i64>,
    /// The type of the surface of each triangle.
    surfaces: Vec<i32>,
}

/// A mesh for Python: id, vertices [n, 3], triangles [m, 3], and the type of the surface of each triangle [m].
type Arrays<'py> = (String, Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<i64>>, Bound<'py, PyArray1<i32>>);

/// The buildings of a model at a level of detail, or each at its finest, and the names of the types of surfaces. Buildings
/// without geometry at that level are left out.
#[pyfunction]
pub fn meshes<'py>(
    py: Python<'py>,
    model: PathBuf,
    lod: Option<String>,
    listener: &Bound<'py, PyAny>,
) -> PyResult<(Vec<Arrays<'py>>, Vec<String>)> {
    let found = supervised(listener, |teller| Found::read(&model, lod.as_deref(), teller))?;
    let arrays = found.meshes.into_iter().map(|mesh| {
        let rows = |numbers: usize| [numbers / 3, 3];
        let vertices = rows(mesh.vertices.len());
        let triangles = rows(mesh.triangles.len());
        Ok((
            mesh.id,
            PyArray1::from_vec(py, mesh.vertices).reshape(vertices)?,
            PyArray1::from_vec(py, mesh.triangles).reshape(triangles)?,
            PyArray1::from_vec(py, mesh.surfaces),
        ))
    });
    Ok((arrays.collect::<PyResult<_>>()?, found.types))
}

/// What a file has.
#[derive(Default)]
struct Found {
    meshes: Vec<Mesh>,
    /// The types of surfaces, in the order in which they occur; that of a surface without one is empty.
    types: Vec<String>,
    /// The levels of detail.
    lods: BTreeSet<String>,
}

impl Found {
    fn read(path: &Path, lod: Option<&str>, teller: &Teller<'_>) -> Result<Self> {
        let mut found = Self::default();
        teller.start("triangulating", "byte", file_size(path));
        let mut pieces = cityjson::features(path)?;
        let crs = pieces.head().crs_code().and_then(|code| Crs::parse(&code).ok());
        let metres = crs.map_or([1.0; 3], |crs| crs.metres_per_unit);
        let mut read = 0;
        while let Some(piece) = pieces.next() {
            let piece = piece?;
            for group in piece.groups() {
                let group: Vec<&CityObject> = group.into_iter().filter_map(|i| piece.objects.get(i)).collect();
                let Some(top) = group.first().filter(|top| top.kind == "Building") else { continue };
                teller.heed();
                found.add(&piece, &top.id, &group, lod, metres);
            }
            teller.advance(pieces.bytes_read() - read);
            read = pieces.bytes_read();
        }
        match lod.filter(|_| found.meshes.is_empty()) {
            None => Ok(found),
            Some(lod) => {
                let levels: Vec<&str> = found.lods.iter().map(String::as_str).collect();
                let there = match levels[..] {
                    [] => "no building with surfaces".to_owned(),
                    _ => format!("buildings at LoD {} only", levels.join(", ")),
                };
                Err(InputError::new(path, there, format!("buildings at LoD {lod}")).at("lod").into())
            }
        }
    }

    /// Adds a building, if it has geometry at the level of detail.
    fn add(&mut self, model: &CityModel, id: &str, group: &[&CityObject], lod: Option<&str>, metres: [f64; 3]) {
        let geometries = || group.iter().flat_map(|object| &object.geometries).filter(|g| !g.shells.is_empty());
        self.lods.extend(geometries().map(|geometry| geometry.lod.clone()));
        let finest = geometries().map(|geometry| geometry.lod.as_str()).max_by(|a, b| by_detail(a, b));
        let Some(lod) = lod.or(finest) else { return };
        let mut mesh = Mesh { id: id.to_owned(), vertices: Vec::new(), triangles: Vec::new(), surfaces: Vec::new() };
        let mut places: HashMap<u32, i64> = HashMap::new();
        for geometry in geometries().filter(|geometry| geometry.lod == lod) {
            for face in geometry.shells.iter().flat_map(|shell| &shell.faces) {
                let surface = self.type_of(geometry, face);
                let corners: Vec<u32> = face.rings.iter().flatten().copied().collect();
                for triangle in triangle_indices(&rings(model, face, metres)) {
                    let triangle = triangle.map(|corner| corners.get(corner).copied());
                    let [Some(a), Some(b), Some(c)] = triangle else { continue };
                    for vertex in [a, b, c] {
                        let next = places.len() as i64;
                        let place = *places.entry(vertex).or_insert_with(|| {
                            mesh.vertices.extend(position(model, vertex));
                            next
                        });
                        mesh.triangles.push(place);
                    }
                    mesh.surfaces.push(surface);
                }
            }
        }
        if !mesh.surfaces.is_empty() {
            self.meshes.push(mesh);
        }
    }

    /// The number of the type of a face.
    fn type_of(&mut self, geometry: &Geometry, face: &Face) -> i32 {
        let surface = face.surface.and_then(|surface| geometry.surfaces.get(surface as usize));
        let kind = surface.map_or("", |surface| &surface.kind);
        let place = self.types.iter().position(|known| known == kind).unwrap_or_else(|| {
            self.types.push(kind.to_owned());
            self.types.len() - 1
        });
        place as i32
    }
}

fn position(model: &CityModel, vertex: u32) -> [f64; 3] {
    model.vertices.get(vertex as usize).copied().unwrap_or_default()
}

/// The rings of a face in metres from its first vertex, where numbers are small.
fn rings(model: &CityModel, face: &Face, metres: [f64; 3]) -> Vec<Vec<Point3<f64>>> {
    let origin = face.rings.iter().flatten().next().map(|&vertex| position(model, vertex)).unwrap_or_default();
    let point = |&vertex: &u32| {
        let position = position(model, vertex);
        Point3::from(std::array::from_fn(|i| (position[i] - origin[i]) * metres[i]))
    };
    face.rings.iter().map(|ring| ring.iter().map(point).collect()).collect()
}

/// Levels of detail in their order: as numbers where they are, no text first.
fn by_detail(a: &str, b: &str) -> Ordering {
    let number = |lod: &str| lod.parse::<f64>().unwrap_or(-1.0);
    number(a).total_cmp(&number(b)).then_with(|| a.cmp(b))
}
