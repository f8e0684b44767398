//! From JSON to plain data, object by object: nothing but the attributes is ever held as a tree of JSON values.

use std::fmt;

use serde::Deserialize;
use serde::de::{Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde_json::{Map, Value};

use super::{CityObject, Face, Geometry, GeometryKind, Instance, SemanticSurface, Shell, Templates, Transform};

/// A root object or a feature.
#[derive(Debug, Default)]
pub(super) struct Document {
    pub kind: String,
    pub version: Option<String>,
    pub transform: Option<Transform>,
    pub metadata: Map<String, Value>,
    pub extensions: Option<Value>,
    pub objects: Option<Objects>,
    pub vertices: Option<Vec<[f64; 3]>>,
    pub templates: Option<Templates>,
    /// The names of the other members that are not empty.
    pub others: Vec<String>,
}

impl<'de> Deserialize<'de> for Document {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Members;

        impl<'de> Visitor<'de> for Members {
            type Value = Document;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a CityJSON object")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Document, A::Error> {
                let mut document = Document::default();
                let mut kind = None;
                while let Some(name) = map.next_key::<String>()? {
                    match name.as_str() {
                        "type" => kind = Some(map.next_value()?),
                        "version" => document.version = map.next_value()?,
                        "transform" => document.transform = map.next_value()?,
                        "metadata" => document.metadata = map.next_value::<Option<_>>()?.unwrap_or_default(),
                        "extensions" => document.extensions = map.next_value()?,
                        "CityObjects" => document.objects = map.next_value()?,
                        "vertices" => document.vertices = map.next_value()?,
                        "geometry-templates" => {
                            let raw = map.next_value::<Option<RawTemplates>>()?;
                            document.templates =
                                raw.map(RawTemplates::into_templates).transpose().map_err(A::Error::custom)?;
                            if document.templates.is_some() {
                                document.others.push(name);
                            }
                        }
                        // The id of a feature is that of one of its objects.
                        "id" => drop(map.next_value::<IgnoredAny>()?),
                        _ => {
                            if map.next_value::<Option<IgnoredAny>>()?.is_some() {
                                document.others.push(name);
                            }
                        }
                    }
                }
                document.kind = kind.ok_or_else(|| A::Error::missing_field("type"))?;
                Ok(document)
            }
        }

        deserializer.deserialize_map(Members)
    }
}

/// `CityObjects`, in the order of the file.
#[derive(Debug)]
pub(super) struct Objects(pub Vec<CityObject>);

impl<'de> Deserialize<'de> for Objects {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Members;

        impl<'de> Visitor<'de> for Members {
            type Value = Objects;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an object of CityObjects")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Objects, A::Error> {
                let mut objects = Vec::new();
                while let Some(id) = map.next_key::<String>()? {
                    let raw: RawObject = map.next_value()?;
                    let object = raw.into_object(id).map_err(A::Error::custom)?;
                    objects.push(object);
                }
                Ok(Objects(objects))
            }
        }

        deserializer.deserialize_map(Members)
    }
}

#[derive(Default)]
struct RawObject {
    kind: String,
    attributes: Option<Map<String, Value>>,
    parents: Option<Vec<String>>,
    children: Option<Vec<String>>,
    geometry: Option<Vec<RawGeometry>>,
    members: Map<String, Value>,
}

impl<'de> Deserialize<'de> for RawObject {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Members;

        impl<'de> Visitor<'de> for Members {
            type Value = RawObject;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("a CityObject")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<RawObject, A::Error> {
                let mut object = RawObject::default();
                let mut kind = None;
                while let Some(name) = map.next_key::<String>()? {
                    match name.as_str() {
                        "type" => kind = Some(map.next_value()?),
                        "attributes" => object.attributes = map.next_value()?,
                        "parents" => object.parents = map.next_value()?,
                        "children" => object.children = map.next_value()?,
                        "geometry" => object.geometry = map.next_value()?,
                        // It follows from the geometry.
                        "geographicalExtent" => drop(map.next_value::<IgnoredAny>()?),
                        _ => drop(object.members.insert(name, map.next_value()?)),
                    }
                }
                object.kind = kind.ok_or_else(|| A::Error::missing_field("type"))?;
                Ok(object)
            }
        }

        deserializer.deserialize_map(Members)
    }
}

impl RawObject {
    fn into_object(self, id: String) -> Result<CityObject, String> {
        let geometries = self.geometry.unwrap_or_default().into_iter().enumerate();
        let geometries = geometries
            .map(|(i, raw)| raw.into_geometry().map_err(|fault| format!("CityObject {id:?}, geometry {i}: {fault}")))
            .collect::<Result<_, _>>()?;
        Ok(CityObject {
            id,
            kind: self.kind,
            parents: self.parents.unwrap_or_default(),
            children: self.children.unwrap_or_default(),
            attributes: self.attributes.unwrap_or_default(),
            geometries,
            members: self.members,
        })
    }
}

#[derive(Deserialize)]
struct RawTemplates {
    templates: Vec<RawGeometry>,
    #[serde(rename = "vertices-templates")]
    vertices: Vec<[f64; 3]>,
}

impl RawTemplates {
    fn into_templates(self) -> Result<Templates, String> {
        let geometries = self.templates.into_iter().enumerate();
        let geometries = geometries
            .map(|(i, raw)| raw.into_geometry().map_err(|fault| format!("geometry template {i}: {fault}")))
            .collect::<Result<_, _>>()?;
        Ok(Templates { geometries, vertices: self.vertices })
    }
}

#[derive(Deserialize)]
struct RawGeometry {
    #[serde(rename = "type")]
    kind: String,
    lod: Option<Value>,
    boundaries: Option<Nested>,
    semantics: Option<RawSemantics>,
    template: Option<u32>,
    #[serde(rename = "transformationMatrix")]
    matrix: Option<Vec<f64>>,
}

#[derive(Deserialize)]
struct RawSemantics {
    surfaces: Vec<Map<String, Value>>,
    values: Nested,
}

/// An index, or a list of lists of … indices, or nothing.
#[derive(Debug)]
enum Nested {
    Null,
    Index(u32),
    List(Vec<Nested>),
}

impl Nested {
    /// The elements of a list, or what else was found.
    fn list(&self, what: &str) -> Result<&[Self], String> {
        match self {
            Self::List(list) => Ok(list),
            Self::Null => Err(format!("null where {what} should be")),
            Self::Index(index) => Err(format!("the number {index} where {what} should be")),
        }
    }

    /// Element `i`; nothing where the list ends or is none.
    fn get(&self, i: usize) -> &Self {
        match self {
            Self::List(list) => list.get(i).unwrap_or(&Self::Null),
            _ => &Self::Null,
        }
    }
}

impl<'de> Deserialize<'de> for Nested {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Level;

        impl<'de> Visitor<'de> for Level {
            type Value = Nested;

            fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
                f.write_str("an index or a list of indices")
            }

            fn visit_unit<E: Error>(self) -> Result<Nested, E> {
                Ok(Nested::Null)
            }

            fn visit_u64<E: Error>(self, index: u64) -> Result<Nested, E> {
                u32::try_from(index)
                    .map(Nested::Index)
                    .map_err(|_| E::custom(format!("the index {index} is too large")))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Nested, A::Error> {
                let mut list = Vec::new();
                while let Some(element) = seq.next_element()? {
                    list.push(element);
                }
                Ok(Nested::List(list))
            }
        }

        deserializer.deserialize_any(Level)
    }
}

impl RawGeometry {
    fn into_geometry(self) -> Result<Geometry, String> {
        let lod = match self.lod {
            Some(Value::String(text)) => text,
            Some(number @ Value::Number(_)) => number.to_string(),
            _ => String::new(),
        };
        let kind = match self.kind.as_str() {
            "MultiSurface" => GeometryKind::MultiSurface,
            "CompositeSurface" => GeometryKind::CompositeSurface,
            "Solid" => GeometryKind::Solid,
            "MultiSolid" => GeometryKind::MultiSolid,
            "CompositeSolid" => GeometryKind::CompositeSolid,
            other => GeometryKind::Other(other.to_owned()),
        };
        if let GeometryKind::Other(_) = kind {
            let matrix = self.matrix.and_then(|matrix| matrix.try_into().ok());
            let instance = self.template.zip(matrix).map(|(template, matrix)| Instance { template, matrix });
            return Ok(Geometry { lod, kind, shells: Vec::new(), surfaces: Vec::new(), instance });
        }
        let Some(boundaries) = &self.boundaries else { return Err("no \"boundaries\"".to_owned()) };
        let values = self.semantics.as_ref().map_or(&Nested::Null, |semantics| &semantics.values);
        let mut shells = Vec::new();
        match kind {
            GeometryKind::MultiSurface | GeometryKind::CompositeSurface => {
                shells.push(shell(0, boundaries, values)?);
            }
            GeometryKind::Solid => shells_of(0, boundaries, values, &mut shells)?,
            _ => {
                for (i, solid) in boundaries.list("a list of solids")?.iter().enumerate() {
                    shells_of(i, solid, values.get(i), &mut shells)?;
                }
            }
        }
        let surfaces = self.semantics.map(|semantics| semantics.surfaces).unwrap_or_default();
        let n = surfaces.len();
        let mut labels = shells.iter().flat_map(|shell| &shell.faces).filter_map(|face| face.surface);
        if let Some(index) = labels.find(|&index| index as usize >= n) {
            return Err(format!("a face refers to semantic surface {index} of {n}"));
        }
        let surfaces = surfaces.into_iter().map(semantic_surface).collect();
        Ok(Geometry { lod, kind, shells, surfaces, instance: None })
    }
}

fn semantic_surface(mut members: Map<String, Value>) -> SemanticSurface {
    let kind = match members.shift_remove("type") {
        Some(Value::String(kind)) => kind,
        _ => String::new(),
    };
    SemanticSurface { kind, attributes: members }
}

fn shells_of(solid: usize, boundaries: &Nested, values: &Nested, out: &mut Vec<Shell>) -> Result<(), String> {
    let shells = boundaries.list("a list of shells")?;
    if shells.is_empty() {
        out.push(Shell { solid, faces: Vec::new() });
    }
    for (i, faces) in shells.iter().enumerate() {
        out.push(shell(solid, faces, values.get(i))?);
    }
    Ok(())
}

fn shell(solid: usize, faces: &Nested, values: &Nested) -> Result<Shell, String> {
    let faces = faces.list("a list of surfaces")?.iter().enumerate();
    let faces = faces.map(|(i, rings)| face(rings, values.get(i))).collect::<Result<_, _>>()?;
    Ok(Shell { solid, faces })
}

fn face(rings: &Nested, value: &Nested) -> Result<Face, String> {
    let surface = match value {
        Nested::Index(index) => Some(*index),
        Nested::Null => None,
        Nested::List(_) => return Err("a list where the semantics of one surface should be".to_owned()),
    };
    let index = |nested: &Nested| match nested {
        Nested::Index(index) => Ok(*index),
        _ => Err("something else where a vertex index should be".to_owned()),
    };
    let ring = |nested: &Nested| nested.list("a ring")?.iter().map(index).collect::<Result<Vec<u32>, String>>();
    let rings = rings.list("a list of rings")?.iter().map(ring).collect::<Result<_, _>>()?;
    Ok(Face { rings, surface })
}
