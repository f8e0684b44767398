//! City models: CityJSON 1.0 to 2.0 and CityJSONSeq, as plain data.

mod groups;
mod kind;
mod other;
mod parse;
mod paths;
mod solid;
#[cfg(test)]
mod tests;

use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::error::{Error, InputError, Result};
use crate::source::open;
use crate::source::reread::is_standard_input;
pub use kind::GeometryKind;
use parse::Document;
pub use paths::{expand, only};

/// What is expected of a file.
const EXPECTED: &str = "CityJSON 1.0, 1.1 or 2.0, or a sequence of CityJSONFeatures";

/// A city model, or one feature of a sequence.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CityModel {
    /// The version of CityJSON: `1.0`, `1.1` or `2.0`.
    pub version: String,
    /// The CRS as the file names it: an OGC URL or URN.
    pub reference_system: Option<String>,
    /// All objects, in the order of the file.
    pub objects: Vec<CityObject>,
    /// Vertices in CRS coordinates.
    pub vertices: Vec<[f64; 3]>,
    /// How they follow from the numbers in the file; `None` where the file has CRS coordinates.
    pub transform: Option<Transform>,
    /// The metadata as they are; empty in a feature of a sequence.
    pub metadata: Map<String, Value>,
    /// The extensions that the file declares, as they are; `None` in a feature of a sequence.
    pub extensions: Option<Value>,
    /// The geometry templates; none in a feature of a sequence, which uses those of the head.
    pub templates: Templates,
    /// The names of the members that are not carried over, such as `appearance` and `geometry-templates`.
    pub others: Vec<String>,
}

/// Geometries that stand in the file once and are placed many times.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Templates {
    /// The geometries; their vertex indices are those of [`Self::vertices`], and may be too large.
    pub geometries: Vec<Geometry>,
    /// Vertices in coordinates of their own, in units of the CRS.
    pub vertices: Vec<[f64; 3]>,
}

/// A template in its place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Instance {
    /// Index into [`Templates::geometries`].
    pub template: u32,
    /// The 4 × 4 matrix that its vertices are multiplied with before they are moved to their place, row by row.
    pub matrix: [f64; 16],
}

/// From the numbers in the file, which should be whole, to CRS coordinates: `number · scale + translate`, axis by axis.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Transform {
    /// Size of a step in units of the CRS.
    pub scale: [f64; 3],
    /// Where the number 0 is.
    pub translate: [f64; 3],
}

impl Transform {
    /// The CRS coordinates of a vertex.
    pub fn apply(&self, vertex: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| vertex[i] * self.scale[i] + self.translate[i])
    }
}

/// A `CityObject`.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct CityObject {
    /// Its key in `CityObjects`.
    pub id: String,
    /// Its type: `Building`, `BuildingPart`, …
    pub kind: String,
    /// The ids of its parents.
    pub parents: Vec<String>,
    /// The ids of its children.
    pub children: Vec<String>,
    /// Its attributes.
    pub attributes: Map<String, Value>,
    /// Its geometries.
    pub geometries: Vec<Geometry>,
    /// Its other members (`address`, those of extensions), as they are.
    pub members: Map<String, Value>,
}

/// A geometry of a `CityObject`.
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry {
    /// The level of detail as text (`2.2`), whether the file has text or a number; empty when it has none.
    pub lod: String,
    /// Its type.
    pub kind: GeometryKind,
    /// Its shells; empty for [`GeometryKind::Other`].
    pub shells: Vec<Shell>,
    /// The semantic surfaces that the faces refer to.
    pub surfaces: Vec<SemanticSurface>,
    /// What a `GeometryInstance` is an instance of, where it says so.
    pub instance: Option<Instance>,
}

/// A shell of a solid, or all faces of a surface.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Shell {
    /// Number of its solid in a `MultiSolid` or `CompositeSolid`; 0 otherwise. The first shell of a solid is its
    /// exterior, the others are voids.
    pub solid: usize,
    /// Its faces; none in the shell that stands for a solid without any.
    pub faces: Vec<Face>,
}

/// A polygon.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Face {
    /// Vertex indices of the exterior and of the holes, each below the number of vertices of the model; the first vertex
    /// is not repeated.
    pub rings: Vec<Vec<u32>>,
    /// Index into [`Geometry::surfaces`].
    pub surface: Option<u32>,
}

/// A semantic surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SemanticSurface {
    /// Its type: `RoofSurface`, `WallSurface`, …
    pub kind: String,
    /// Its other members.
    pub attributes: Map<String, Value>,
}

impl CityModel {
    /// The code of the CRS, as in `EPSG:7415`, from any of the ways in which files name it.
    pub fn crs_code(&self) -> Option<String> {
        let name = self.reference_system.as_deref()?;
        let parts: Vec<&str> = name.split(['/', ':']).filter(|part| !part.is_empty()).collect();
        let at = parts.iter().position(|part| part.eq_ignore_ascii_case("crs"));
        let (authority, code) = match at {
            // urn:ogc:def:crs:EPSG::7415, https://www.opengis.net/def/crs/EPSG/0/7415
            Some(at) if parts.len() >= at + 3 => (parts[at + 1], parts[parts.len() - 1]),
            None if parts.len() == 2 => (parts[0], parts[1]),
            _ => return None,
        };
        let is_plain = |text: &str| text.chars().all(|c| c.is_ascii_alphanumeric());
        (is_plain(authority) && is_plain(code)).then(|| format!("{}:{code}", authority.to_ascii_uppercase()))
    }

    /// Appends the objects and vertices of another model in the same CRS.
    fn append(&mut self, other: Self) {
        let base = self.vertices.len() as u32;
        self.vertices.extend(other.vertices);
        for name in other.others {
            if !self.others.contains(&name) {
                self.others.push(name);
            }
        }
        let from = self.objects.len();
        self.objects.extend(other.objects);
        if base == 0 {
            return;
        }
        let geometries = self.objects[from..].iter_mut().flat_map(|object| &mut object.geometries);
        let faces = geometries.flat_map(|geometry| &mut geometry.shells).flat_map(|shell| &mut shell.faces);
        faces.flat_map(|face| &mut face.rings).flatten().for_each(|vertex| *vertex += base);
    }
}

/// Reads a whole file of either format.
///
/// # Errors
/// See [`features`].
pub fn read(path: &Path) -> Result<CityModel> {
    let mut features = features(path)?;
    let mut whole = features.head.clone();
    for feature in &mut features {
        whole.append(feature?);
    }
    Ok(whole)
}

/// Opens a file, or standard input (`-`), and reads it piece by piece: a CityJSONSeq feature by feature, a CityJSON in one
/// piece.
///
/// # Errors
/// [`Error::Io`] when the file cannot be read, and an input error with line and column when it is no JSON, no CityJSON,
/// of another version than 1.0 to 2.0, or refers to vertices that it does not have.
pub fn features(path: &Path) -> Result<Features> {
    open_features(path, false)
}

/// The same, and the text of every piece is kept until it is [taken](Features::take_text) or the next piece is read.
///
/// # Errors
/// As [`features`].
pub(crate) fn features_with_text(path: &Path) -> Result<Features> {
    open_features(path, true)
}

fn open_features(path: &Path, keeps_text: bool) -> Result<Features> {
    let file = open::stream(path, "a CityJSON or CityJSONSeq file")?;
    let mut features = Features {
        path: if is_standard_input(path) { "standard input".into() } else { path.to_path_buf() },
        reader: BufReader::with_capacity(1 << 18, file),
        line: 0,
        head: CityModel::default(),
        read: 0,
        first: None,
        keeps_text,
        text: Vec::new(),
    };
    features.refuse_other_than_json()?;
    let mut bytes = features.next_line()?;
    if bytes.starts_with(b"\xEF\xBB\xBF") {
        bytes.drain(..3);
    }
    let head = match serde_json::from_slice::<Document>(&bytes) {
        // The object goes on in the next line: not a sequence.
        Err(fault) if fault.is_eof() => {
            let more = features.reader.read_to_end(&mut bytes).map_err(|e| Error::io(path, "read", e))?;
            features.read += more as u64;
            serde_json::from_slice(&bytes)
        }
        other => other,
    };
    let head = head.map_err(|fault| features.fault(&fault, 0))?;
    features.keep_text(bytes);
    features.open(head)?;
    Ok(features)
}

/// The pieces of a file, each a [`CityModel`] with its own vertices. See [`features`].
pub struct Features {
    path: PathBuf,
    reader: BufReader<Box<dyn Read + Send>>,
    line: usize,
    head: CityModel,
    read: u64,
    first: Option<CityModel>,
    keeps_text: bool,
    text: Vec<u8>,
}

impl Features {
    /// The version, CRS and transform of the file.
    pub fn head(&self) -> &CityModel {
        &self.head
    }

    /// How many bytes of the file have been read.
    pub fn bytes_read(&self) -> u64 {
        self.read
    }

    /// The text of the last piece that was read, the head at first; empty where it is not kept.
    pub(crate) fn take_text(&mut self) -> Vec<u8> {
        std::mem::take(&mut self.text)
    }

    fn keep_text(&mut self, text: Vec<u8>) {
        if self.keeps_text {
            self.text = text;
        }
    }

    /// Looks at the first bytes: what is no object need not be read to its end, which may be far.
    fn refuse_other_than_json(&mut self) -> Result<()> {
        let start = self.reader.fill_buf().map_err(|e| Error::io(&self.path, "read", e))?;
        let text = start.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(start).trim_ascii_start();
        if text.first().is_some_and(|first| *first == b'{') {
            return Ok(());
        }
        let found = other::kind(start);
        Err(self.refusal("at its beginning", found, EXPECTED))
    }

    /// The next line that is not blank; empty at the end.
    fn next_line(&mut self) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        loop {
            self.line += 1;
            let read = self.reader.read_until(b'\n', &mut bytes).map_err(|e| Error::io(&self.path, "read", e))?;
            self.read += read as u64;
            if read == 0 || !bytes.trim_ascii().is_empty() {
                return Ok(bytes);
            }
            bytes.clear();
        }
    }

    /// Takes the root object.
    fn open(&mut self, root: Document) -> Result<()> {
        if root.kind != "CityJSON" {
            return Err(self.refusal("line 1", other::of_type(&root.kind), EXPECTED));
        }
        let version = root.version.clone().unwrap_or_default();
        if !["1.0", "1.1", "2.0"].iter().any(|known| version.starts_with(known)) {
            return Err(self.refusal("line 1", format!("the version {version:?}"), "\"1.0\", \"1.1\" or \"2.0\""));
        }
        self.head = CityModel {
            version,
            reference_system: root.metadata.get("referenceSystem").and_then(Value::as_str).map(str::to_owned),
            transform: root.transform,
            metadata: root.metadata.clone(),
            extensions: root.extensions.clone(),
            others: root.others.clone(),
            templates: root.templates.clone().unwrap_or_default(),
            ..CityModel::default()
        };
        let model = self.model(root)?;
        self.first = (!model.objects.is_empty()).then_some(model);
        Ok(())
    }

    /// The model of a root object or feature.
    fn model(&self, document: Document) -> Result<CityModel> {
        let place = format!("line {}", self.line);
        let Some(objects) = document.objects else {
            return Err(self.refusal(place, "no \"CityObjects\"", "an object of that name"));
        };
        let Some(mut vertices) = document.vertices else {
            return Err(self.refusal(place, "no \"vertices\"", "a list of that name"));
        };
        if let Some(transform) = self.head.transform {
            for vertex in &mut vertices {
                *vertex = transform.apply(*vertex);
            }
        }
        let n = vertices.len();
        for object in &objects.0 {
            let shells = object.geometries.iter().flat_map(|geometry| &geometry.shells);
            let mut indices = shells.flat_map(|shell| &shell.faces).flat_map(|face| &face.rings).flatten();
            if let Some(index) = indices.find(|&&index| index as usize >= n) {
                let place = format!("{place}, CityObject {:?}", object.id);
                return Err(self.refusal(place, format!("the vertex index {index}"), format!("one below {n}")));
            }
        }
        Ok(CityModel {
            version: self.head.version.clone(),
            reference_system: self.head.reference_system.clone(),
            objects: objects.0,
            vertices,
            transform: self.head.transform,
            others: document.others,
            ..CityModel::default()
        })
    }

    fn refusal(&self, place: impl Into<String>, found: impl Into<String>, expected: impl Into<String>) -> Error {
        InputError::new(&self.path, found, expected).at(place).into()
    }

    /// A fault of the JSON, `before` lines after the start of the file.
    fn fault(&self, fault: &serde_json::Error, before: usize) -> Error {
        let place = format!("line {}, column {}", before + fault.line(), fault.column());
        self.refusal(place, other::in_words(fault), EXPECTED)
    }

    fn next_feature(&mut self) -> Result<Option<CityModel>> {
        if let Some(first) = self.first.take() {
            return Ok(Some(first));
        }
        let bytes = self.next_line()?;
        if bytes.is_empty() {
            return Ok(None);
        }
        let feature: Document = serde_json::from_slice(&bytes).map_err(|fault| self.fault(&fault, self.line - 1))?;
        if feature.kind != "CityJSONFeature" {
            let place = format!("line {}", self.line);
            return Err(self.refusal(place, format!("the type {:?}", feature.kind), "\"CityJSONFeature\""));
        }
        self.keep_text(bytes);
        self.model(feature).map(Some)
    }
}

impl Iterator for Features {
    type Item = Result<CityModel>;

    fn next(&mut self) -> Option<Self::Item> {
        self.next_feature().transpose()
    }
}
