//! A top-level object with its children as faces that can be drawn.

use std::cmp::Ordering;
use std::collections::HashMap;

use nalgebra::{Point3, Vector3};

use super::packed::{STEPS_PER_METRE, steps};
use crate::geometry::{newell, triangle_indices};
use crate::site::Frame;
use crate::source::cityjson::{CityModel, CityObject, Geometry, GeometryKind, SemanticSurface};

/// The edge between two faces that turn by less is not drawn: they are one plane, cut for the triangles' sake.
const FLAT: f64 = 0.999_8;
/// The same of the triangles of a terrain, which are edges all over: those of banks and walls are drawn (about 15°).
const FLAT_GROUND: f64 = 0.966;

/// A top-level object with its children.
#[derive(Debug)]
pub(super) struct Feature<'a> {
    /// Its vertices in steps of the page, each once.
    pub vertices: Vec<[i64; 3]>,
    /// The faces of all its geometries, in the order of the objects and of the file.
    pub faces: Vec<Face<'a>>,
}

/// A face.
#[derive(Debug)]
pub(super) struct Face<'a> {
    /// Its object: an index into the group of the feature.
    pub object: usize,
    /// The level of detail of its geometry.
    pub lod: &'a str,
    /// Its semantic surface.
    pub surface: Option<&'a SemanticSurface>,
    /// Its rings, the exterior first.
    pub rings: Vec<Vec<Corner>>,
    /// Its triangles, each of three corners counted through all rings.
    pub triangles: Vec<[usize; 3]>,
    /// Where it stands in the file, as the findings of [`audit`](crate::audit) name it.
    pub place: Place,
}

/// Where a face stands in its object.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Place {
    pub geometry: usize,
    /// Of geometries of several solids.
    pub solid: Option<usize>,
    /// Counted in its solid.
    pub shell: usize,
    /// Counted in its shell.
    pub face: usize,
}

/// A corner of a ring.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Corner {
    /// Index into [`Feature::vertices`].
    pub vertex: u32,
    /// Whether the edge to the next corner of the ring is drawn.
    pub is_drawn: bool,
}

impl<'a> Feature<'a> {
    /// The faces of a group of objects of a model.
    pub fn new(model: &'a CityModel, group: &[&'a CityObject], frame: &Frame) -> Self {
        let mut feature = Self { vertices: Vec::new(), faces: Vec::new() };
        let mut welded = Welded { model, frame, of_file: HashMap::new(), of_place: HashMap::new() };
        for (object, o) in group.iter().zip(0..) {
            for (geometry, g) in object.geometries.iter().zip(0..) {
                let first = feature.faces.len();
                feature.add(geometry, (o, g), &mut welded);
                feature.choose_edges(first, object.kind == "TINRelief");
            }
        }
        feature
    }

    fn add(&mut self, geometry: &'a Geometry, (object, number): (usize, usize), welded: &mut Welded) {
        let several = matches!(geometry.kind, GeometryKind::MultiSolid | GeometryKind::CompositeSolid);
        for of_solid in geometry.shells.chunk_by(|a, b| a.solid == b.solid) {
            for (shell, n) in of_solid.iter().zip(0..) {
                let solid = several.then_some(shell.solid);
                for (face, f) in shell.faces.iter().zip(0..) {
                    let rings: Vec<Vec<Corner>> = face
                        .rings
                        .iter()
                        .map(|ring| welded.ring(ring, &mut self.vertices))
                        .filter(|ring| !ring.is_empty())
                        .collect();
                    let surface = face.surface.and_then(|s| geometry.surfaces.get(s as usize));
                    let place = Place { geometry: number, solid, shell: n, face: f };
                    let triangles = triangle_indices(&self.points(&rings));
                    self.faces.push(Face { object, lod: &geometry.lod, surface, rings, triangles, place });
                }
            }
        }
    }

    fn points(&self, rings: &[Vec<Corner>]) -> Vec<Vec<Point3<f64>>> {
        let point = |corner: &Corner| self.vertices.get(corner.vertex as usize).map(|v| to_metres(*v));
        rings.iter().map(|ring| ring.iter().filter_map(point).collect()).collect()
    }

    /// Of the faces from the `first` on, the faces of a geometry: an edge is drawn once, and not between two that are one
    /// plane and one kind of surface. The border of a terrain is none: it goes on in the next one, or there is a wall.
    fn choose_edges(&mut self, first: usize, is_terrain: bool) {
        let Some(faces) = self.faces.get(first..) else { return };
        let normal = |face: &Face| {
            let exterior = self.points(face.rings.get(..1).unwrap_or_default());
            exterior.first().and_then(|ring| newell(ring).try_normalize(0.0)).unwrap_or_else(Vector3::zeros)
        };
        let normals: Vec<Vector3<f64>> = faces.iter().map(normal).collect();
        let mut sides: HashMap<[u32; 2], Vec<usize>> = HashMap::new();
        for (face, f) in faces.iter().zip(0..) {
            for edge in face.rings.iter().flat_map(|ring| edges(ring)) {
                sides.entry(edge).or_default().push(f);
            }
        }
        let label = |f: usize| faces.get(f).and_then(|face| face.surface).map(|surface| surface.kind.as_str());
        let mut drawn: HashMap<[u32; 2], bool> = sides
            .into_iter()
            .map(|(edge, faces)| {
                let is_inner = match faces[..] {
                    [a, b] => {
                        let turn = normals.get(a).zip(normals.get(b)).map_or(0.0, |(a, b)| a.dot(b));
                        turn > if is_terrain { FLAT_GROUND } else { FLAT } && label(a) == label(b)
                    }
                    _ => is_terrain,
                };
                (edge, !is_inner)
            })
            .collect();
        for ring in self.faces.iter_mut().skip(first).flat_map(|face| &mut face.rings) {
            let of_ring: Vec<[u32; 2]> = edges(ring).collect();
            for (corner, edge) in ring.iter_mut().zip(of_ring) {
                // The second face of the edge finds it drawn.
                corner.is_drawn = drawn.insert(edge, false).unwrap_or(false);
            }
        }
    }

    /// Smallest and largest x and y in local metres; `None` without vertices.
    pub fn extent(&self) -> Option<[[f64; 2]; 2]> {
        let mut places = self.vertices.iter().map(|v| to_metres(*v));
        let first = places.next()?;
        let start = [[first.x, first.y]; 2];
        Some(
            places.fold(start, |[low, high], p| {
                [[low[0].min(p.x), low[1].min(p.y)], [high[0].max(p.x), high[1].max(p.y)]]
            }),
        )
    }
}

/// Steps of the page in metres.
fn to_metres(steps: [i64; 3]) -> Point3<f64> {
    Point3::from(steps.map(|s| s as f64 / STEPS_PER_METRE))
}

/// The edges of a ring, each with its smaller vertex first; the first is that of the first corner.
fn edges(ring: &[Corner]) -> impl Iterator<Item = [u32; 2]> + '_ {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| [a.vertex.min(b.vertex), a.vertex.max(b.vertex)])
}

/// The vertices of a feature: those at one place of the page are one.
struct Welded<'a> {
    model: &'a CityModel,
    frame: &'a Frame,
    of_file: HashMap<u32, u32>,
    of_place: HashMap<[i64; 3], u32>,
}

impl Welded<'_> {
    /// A ring without corners that repeat the one before.
    fn ring(&mut self, ring: &[u32], vertices: &mut Vec<[i64; 3]>) -> Vec<Corner> {
        let mut corners: Vec<Corner> = Vec::with_capacity(ring.len());
        for &index in ring {
            let Some(vertex) = self.vertex(index, vertices) else { continue };
            if corners.last().is_none_or(|last| last.vertex != vertex) {
                corners.push(Corner { vertex, is_drawn: false });
            }
        }
        while corners.len() > 1 && corners.first() == corners.last() {
            corners.pop();
        }
        corners
    }

    fn vertex(&mut self, index: u32, vertices: &mut Vec<[i64; 3]>) -> Option<u32> {
        if let Some(&known) = self.of_file.get(&index) {
            return Some(known);
        }
        let place = steps(self.frame.to_local(*self.model.vertices.get(index as usize)?).into());
        let vertex = *self.of_place.entry(place).or_insert_with(|| {
            vertices.push(place);
            vertices.len() as u32 - 1
        });
        self.of_file.insert(index, vertex);
        Some(vertex)
    }
}

/// Levels of detail in their order: as numbers where they are, no text first.
pub(super) fn by_detail(a: &str, b: &str) -> Ordering {
    let number = |lod: &str| lod.parse::<f64>().unwrap_or(-1.0);
    number(a).total_cmp(&number(b)).then_with(|| a.cmp(b))
}
