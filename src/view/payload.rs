//! What the page is given: a head of JSON and columns of integers, deflated and in base64.
//!
//! ```text
//! base64( deflate( length of the head, u32 little endian | head, JSON | columns, LEB128 each, in the order of the head ) )
//! ```
//!
//! Coordinates are millimetres from the origin of the frame, each vertex as its difference from the one before: small numbers
//! take one or two bytes, and deflate finds what repeats. In base64 nothing that stands in a file can end a script or begin a
//! tag.

use std::collections::HashMap;

use serde::Serialize;
use serde_json::{Map, Value};

use super::faults::Fault;
use super::feature::{self, Feature};
use super::packed::{Column, STEPS_PER_METRE, folded, packed};
use super::record::Record;
use super::{Contents, Options, cloud};
use crate::audit;
use crate::error::Result;
use crate::sink::{ATTRIBUTES, PREFIX};
use crate::site::Frame;
use crate::source::cityjson::{CityModel, CityObject, SemanticSurface};
use crate::source::crs::Crs;
use crate::source::points::TileProblem;
use crate::terrain;

/// The columns of the geometry, in the order in which they are packed.
#[derive(Debug, Default)]
pub(super) struct Columns {
    /// Vertices, x, y and z each as the difference from the vertex before.
    pub vertices: Column,
    /// Per face: its object, counted from the first of its feature.
    pub objects: Column,
    /// Per face: its level of detail, an index into [`Head::lods`].
    pub lods: Column,
    /// Per face: its semantic surface, an index into [`Head::surfaces`] plus 1; 0 for none.
    pub surfaces: Column,
    /// Per face: the number of its rings, and the number of corners of each.
    pub rings: Column,
    /// Per corner: its vertex, counted from the first of its feature, as the difference from the corner before, twice; plus 1
    /// where the edge to the next corner of the ring is drawn.
    pub corners: Column,
    /// Per face: the number of its triangles, and their corners, counted from the first of the face.
    pub triangles: Column,
    /// Points, x, y and z each as the difference from the point before.
    pub points: Column,
    /// Per point: its class.
    pub classes: Column,
}

impl Columns {
    fn in_order(&self) -> [(&'static str, &Column); 9] {
        [
            ("vertices", &self.vertices),
            ("objects", &self.objects),
            ("lods", &self.lods),
            ("surfaces", &self.surfaces),
            ("rings", &self.rings),
            ("corners", &self.corners),
            ("triangles", &self.triangles),
            ("points", &self.points),
            ("classes", &self.classes),
        ]
    }
}

/// What the page is told in JSON.
#[derive(Debug, Default, Serialize)]
pub(super) struct Head {
    name: String,
    gable: &'static str,
    format: String,
    crs: Option<String>,
    origin: [f64; 3],
    metres_per_unit: [f64; 3],
    steps_per_metre: f64,
    /// Levels of detail, in the order in which they were met.
    lods: Vec<String>,
    surfaces: Vec<Surface>,
    objects: Vec<Object>,
    features: Vec<FeatureHead>,
    attributes: Vec<Known>,
    /// What is wrong with the file as a whole.
    faults: Vec<Fault>,
    points: Option<Points>,
    run: Option<Map<String, Value>>,
    /// The columns in their order, each with its number of bytes.
    columns: Vec<(&'static str, usize)>,
}

/// A semantic surface; equal ones are one.
#[derive(Debug, Serialize)]
struct Surface {
    #[serde(rename = "type")]
    kind: String,
    attributes: Map<String, Value>,
}

#[derive(Debug, Serialize)]
struct Object {
    id: String,
    #[serde(rename = "type")]
    kind: String,
    attributes: Map<String, Value>,
}

/// A top-level object with its children, the first of its objects.
#[derive(Debug, Serialize)]
pub(super) struct FeatureHead {
    objects: usize,
    vertices: usize,
    faces: usize,
    faults: Vec<Fault>,
    /// What the report of the run says of it.
    #[serde(skip_serializing_if = "Option::is_none")]
    run: Option<Value>,
}

/// What an attribute of gable's means.
#[derive(Debug, Serialize)]
struct Known {
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
}

/// The points that are shown.
#[derive(Debug, Serialize)]
struct Points {
    shown: usize,
    of: usize,
    tiles: Vec<String>,
}

/// The contents of a page while they are gathered.
#[derive(Debug)]
pub(super) struct Payload {
    frame: Frame,
    /// What the names of gable's attributes begin with in the model.
    prefix: String,
    head: Head,
    columns: Columns,
    contents: Contents,
    known_surfaces: HashMap<String, usize>,
    /// Smallest and largest x and y of each feature with geometry, local metres.
    boxes: Vec<[[f64; 2]; 2]>,
    /// The same of terrain, which counts where there is nothing else.
    terrain_boxes: Vec<[[f64; 2]; 2]>,
    last: [i64; 3],
}

impl Payload {
    /// A page without any feature in this frame, of a model in which the names of gable's attributes begin with `prefix`.
    pub fn new(frame: Frame, prefix: &str) -> Self {
        let head = Head {
            gable: env!("CARGO_PKG_VERSION"),
            origin: frame.origin,
            metres_per_unit: frame.metres_per_unit,
            steps_per_metre: STEPS_PER_METRE,
            ..Head::default()
        };
        let (columns, contents) = (Columns::default(), Contents::default());
        Self {
            frame,
            prefix: prefix.to_owned(),
            head,
            columns,
            contents,
            known_surfaces: HashMap::new(),
            boxes: Vec::new(),
            terrain_boxes: Vec::new(),
            last: [0; 3],
        }
    }

    /// Whether there is no feature.
    pub fn is_empty(&self) -> bool {
        self.head.features.is_empty()
    }

    /// What is in the page so far.
    pub fn contents(&self) -> Contents {
        self.contents.clone()
    }

    /// Adds a top-level object, which comes first, with its children, and what was found wrong with it.
    pub fn add(&mut self, model: &CityModel, group: &[&CityObject], found: Option<&audit::Feature>) {
        let Some(top) = group.first() else { return };
        let feature = Feature::new(model, group, &self.frame);
        for vertex in &feature.vertices {
            self.columns.vertices.push_place(*vertex, &mut self.last);
        }
        for face in &feature.faces {
            self.add_face(face);
        }
        let boxes = if top.kind == "TINRelief" { &mut self.terrain_boxes } else { &mut self.boxes };
        boxes.extend(feature.extent());
        let object = |object: &&CityObject| Object {
            id: object.id.clone(),
            kind: object.kind.clone(),
            attributes: self.known_by_name(&object.attributes),
        };
        let objects: Vec<Object> = group.iter().map(object).collect();
        self.head.objects.extend(objects);
        let faults = found.map_or_else(Vec::new, |found| Fault::of(found, group, &feature));
        self.contents.invalid += usize::from(found.is_some_and(|found| !found.validity));
        if matches!(top.kind.as_str(), "Building" | "BuildingPart") {
            self.contents.buildings += 1;
            self.count_lod(feature.faces.iter().map(|face| face.lod).max_by(|a, b| feature::by_detail(a, b)));
        } else {
            self.contents.others += 1;
        }
        let (objects, vertices, faces) = (group.len(), feature.vertices.len(), feature.faces.len());
        self.head.features.push(FeatureHead { objects, vertices, faces, faults, run: None });
    }

    /// Attributes of an object, gable's own under the names that the page knows them by.
    fn known_by_name(&self, attributes: &Map<String, Value>) -> Map<String, Value> {
        if self.prefix == PREFIX {
            return attributes.clone();
        }
        let own = |name: &str| {
            let bare = name.strip_prefix(self.prefix.as_str())?;
            ATTRIBUTES.iter().find(|attribute| attribute.bare() == bare)
        };
        let named = |(name, value): (&String, &Value)| {
            (own(name).map_or_else(|| name.clone(), |own| own.name.to_owned()), value.clone())
        };
        attributes.iter().map(named).collect()
    }

    fn count_lod(&mut self, lod: Option<&str>) {
        let lod = lod.unwrap_or_default();
        match self.contents.lods.iter_mut().find(|(known, _)| known == lod) {
            Some((_, count)) => *count += 1,
            None => self.contents.lods.push((lod.to_owned(), 1)),
        }
        self.contents.lods.sort_by(|a, b| feature::by_detail(&b.0, &a.0));
    }

    fn add_face(&mut self, face: &feature::Face) {
        let lod = self.head.lods.iter().position(|known| known == face.lod).unwrap_or_else(|| {
            self.head.lods.push(face.lod.to_owned());
            self.head.lods.len() - 1
        });
        let surface = face.surface.map_or(0, |surface| self.surface(surface) + 1);
        let columns = &mut self.columns;
        columns.lods.push_index(lod);
        columns.objects.push_index(face.object);
        columns.surfaces.push_index(surface);
        columns.rings.push_index(face.rings.len());
        let mut last = 0;
        for ring in &face.rings {
            columns.rings.push_index(ring.len());
            for corner in ring {
                let vertex = i64::from(corner.vertex);
                columns.corners.push(folded(vertex - last) << 1 | u64::from(corner.is_drawn));
                last = vertex;
            }
        }
        columns.triangles.push_index(face.triangles.len());
        for corner in face.triangles.iter().flatten() {
            columns.triangles.push_index(*corner);
        }
        self.contents.triangles += face.triangles.len();
    }

    /// The index of a semantic surface.
    fn surface(&mut self, surface: &SemanticSurface) -> usize {
        // The values of one file: equal members in equal order, or as good as different.
        let key = format!("{} {}", surface.kind, Value::Object(surface.attributes.clone()));
        let surfaces = &mut self.head.surfaces;
        *self.known_surfaces.entry(key).or_insert_with(|| {
            surfaces.push(Surface { kind: surface.kind.clone(), attributes: surface.attributes.clone() });
            surfaces.len() - 1
        })
    }

    /// What there is to say of the file.
    pub fn describe(&mut self, name: &str, crs: Option<&Crs>, found: &audit::Report) {
        name.clone_into(&mut self.head.name);
        self.head.format.clone_from(&found.input_file_type);
        self.head.crs = crs.map(ToString::to_string);
        self.head.faults = found.dataset_errors.iter().map(Fault::of_file).collect();
        self.contents.unreadable = found.dataset_errors.len();
        let of_buildings = ATTRIBUTES.iter().map(|a| Known { name: a.name, unit: a.unit, meaning: a.meaning });
        let of_terrain = terrain::ATTRIBUTES.iter().map(|&(name, unit, meaning)| Known { name, unit, meaning });
        self.head.attributes = of_buildings.chain(of_terrain).collect();
    }

    /// The points of the tiles around the features.
    ///
    /// # Errors
    /// See [`cloud::sample_files`].
    pub fn add_points(&mut self, options: &Options, crs: Option<&Crs>) -> Result<Vec<TileProblem>> {
        if options.tiles.is_empty() {
            return Ok(Vec::new());
        }
        let boxes = if self.boxes.is_empty() { &self.terrain_boxes } else { &self.boxes };
        let cloud = cloud::sample_files(&options.tiles, options.most_points, boxes, (&self.frame, crs))?;
        let mut last = [0; 3];
        for (place, class) in &cloud.points {
            self.columns.points.push_place(*place, &mut last);
            self.columns.classes.push(u64::from(*class));
        }
        let name = |path: &std::path::PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned());
        let tiles = options.tiles.iter().filter_map(name).collect();
        self.head.points = Some(Points { shown: cloud.points.len(), of: cloud.around, tiles });
        self.contents.points = [cloud.points.len(), cloud.around];
        Ok(cloud.problems)
    }

    /// What the report of the run says, of the whole and of each building.
    pub fn add_report(&mut self, record: Option<Record>) {
        let Some(Record { run, mut buildings }) = record else { return };
        self.head.run = Some(run);
        let mut first = 0;
        for feature in &mut self.head.features {
            let top: Option<&Object> = self.head.objects.get(first);
            feature.run = top.and_then(|top| buildings.remove(&top.id));
            first += feature.objects;
        }
    }

    /// All of it as text.
    ///
    /// # Errors
    /// Never in practice: memory takes every byte.
    pub fn pack(mut self) -> Result<String> {
        let columns = self.columns.in_order();
        self.head.columns = columns.iter().map(|(name, column)| (*name, column.len())).collect();
        packed(&self.head, columns.map(|(_, column)| column))
    }
}
