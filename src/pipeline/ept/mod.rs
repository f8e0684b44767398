//! Entwine Point Tiles (EPT 1.0 and 1.1): a folder with an octree of point files.
//!
//! | module | holds |
//! |---|---|
//! | this one | `ept.json`, which says what there is |
//! | [`hierarchy`] | which nodes hold how many points |
//! | [`nodes`] | the points of a node |

mod hierarchy;
mod nodes;

use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde_json::Value;

use crate::error::{Error, InputError, Result};
use crate::pipeline::points::NumberType;
use crate::source::open;
use crate::source::points::Extent;

pub(super) use hierarchy::Key;

/// What is said of a file that is none.
const WANTED: &str = "the description of an EPT folder, ept.json";
/// Bytes of a description, or of a file of the hierarchy, at most: a million nodes take 20 MB.
const LARGEST: u64 = 1 << 28;

/// A folder of Entwine Point Tiles.
#[derive(Debug, Clone)]
pub(super) struct Ept {
    /// The folder.
    root: PathBuf,
    /// The cube of the root node.
    cube: Extent,
    /// The box around the points.
    pub extent: Extent,
    /// The dimensions of all points.
    pub fields: Vec<Field>,
    /// Number of points.
    pub points: u64,
    /// Cells of a node along each axis.
    span: f64,
    /// How the nodes are stored.
    pub encoding: Encoding,
    /// The CRS: WKT, or an authority and codes.
    pub crs: Option<String>,
}

/// How the points of nodes are stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    /// LAZ files.
    Laszip,
    /// The values of the schema, one behind the other.
    Binary,
}

/// A dimension in the schema.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Field {
    /// Its name.
    pub name: String,
    /// The type that it is stored as.
    pub kind: NumberType,
    /// Scale and offset of the stored numbers, where it has them; then it is a double.
    pub scaled: Option<[f64; 2]>,
}

impl Field {
    /// Whether it holds several flags, which are dimensions of their own.
    pub fn is_flags(&self) -> bool {
        self.name == "ClassFlags"
    }

    /// The type of its values.
    pub fn usual(&self) -> NumberType {
        if self.scaled.is_some() { NumberType::F64 } else { self.kind }
    }
}

/// The members of `ept.json` that count.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Description {
    bounds: [f64; 6],
    bounds_conforming: Option<[f64; 6]>,
    data_type: String,
    hierarchy_type: Option<String>,
    points: u64,
    schema: Vec<FieldDescription>,
    span: f64,
    srs: Option<Srs>,
}

#[derive(Deserialize)]
struct FieldDescription {
    name: String,
    #[serde(rename = "type")]
    kind: String,
    size: u8,
    scale: Option<f64>,
    offset: Option<f64>,
}

#[derive(Deserialize)]
struct Srs {
    authority: Option<String>,
    horizontal: Option<Value>,
    vertical: Option<Value>,
    wkt: Option<String>,
}

impl Srs {
    /// WKT where there is one, else an authority and codes.
    fn text(&self) -> Option<String> {
        let code = |value: &Option<Value>| match value {
            Some(Value::String(code)) => Some(code.trim().to_owned()).filter(|code| !code.is_empty()),
            Some(Value::Number(code)) => Some(code.to_string()),
            _ => None,
        };
        let wkt = self.wkt.clone().filter(|wkt| !wkt.trim().is_empty());
        wkt.or_else(|| {
            let authority = self.authority.as_deref().filter(|name| !name.is_empty()).unwrap_or("EPSG");
            let vertical = code(&self.vertical).map_or_else(String::new, |code| format!("+{code}"));
            code(&self.horizontal).map(|horizontal| format!("{authority}:{horizontal}{vertical}"))
        })
    }
}

fn extent([x0, y0, z0, x1, y1, z1]: [f64; 6]) -> Option<Extent> {
    let (min, max) = ([x0, y0, z0], [x1, y1, z1]);
    let is_real = (0..3).all(|axis| min[axis].is_finite() && max[axis].is_finite() && min[axis] <= max[axis]);
    is_real.then_some(Extent { min, max })
}

/// A whole file of JSON.
fn read_json<T: serde::de::DeserializeOwned>(path: &Path, wanted: &'static str) -> Result<T> {
    let (file, size) = open::regular(path, wanted)?;
    if size > LARGEST {
        return Err(InputError::new(path, format!("{size} bytes"), format!("{wanted} of at most {LARGEST}")).into());
    }
    let bytes = std::io::read_to_string(file).map_err(|e| Error::io(path, "read", e))?;
    serde_json::from_str(&bytes).map_err(|e| {
        let fault =
            InputError::new(path, "something else", wanted).at(format!("line {}, column {}", e.line(), e.column()));
        fault.remedy(e.to_string()).into()
    })
}

impl Ept {
    /// Reads `ept.json`; `path` is that file or its folder, perhaps with `ept://` in front, as in PDAL.
    ///
    /// # Errors
    /// It cannot be read, or is not what it should be.
    pub fn open(path: &Path) -> Result<Self> {
        let plain = path.to_str().and_then(|text| text.strip_prefix("ept://")).map_or(path, Path::new);
        let file = if plain.is_dir() { plain.join("ept.json") } else { plain.to_path_buf() };
        let told: Description = read_json(&file, WANTED)?;
        let fault = |found: String, expected: &str| InputError::new(&file, found, expected);
        let encoding = match told.data_type.as_str() {
            "laszip" => Encoding::Laszip,
            "binary" => Encoding::Binary,
            other => return Err(fault(format!("{other:?} as \"dataType\""), "laszip or binary").into()),
        };
        if let Some(other) = told.hierarchy_type.filter(|kind| kind != "json") {
            return Err(fault(format!("{other:?} as \"hierarchyType\""), "json").into());
        }
        let cube = extent(told.bounds).ok_or_else(|| fault("\"bounds\" that are no box".to_owned(), "a cube"))?;
        if told.span.is_nan() || told.span < 1.0 {
            return Err(fault(format!("{} as \"span\"", told.span), "a number of cells, 1 or more").into());
        }
        let mut fields: Vec<Field> = Vec::new();
        for FieldDescription { name, kind, size, scale, offset } in told.schema {
            let number = number_type(&kind, size);
            let number =
                number.ok_or_else(|| fault(format!("{name} of {size} bytes, {kind}"), "signed, unsigned or float"))?;
            if fields.iter().any(|own| own.name.eq_ignore_ascii_case(&name)) {
                return Err(fault(format!("{name} twice"), "each dimension once").at("schema").into());
            }
            let scaled = (scale.is_some() || offset.is_some()).then(|| [scale.unwrap_or(1.0), offset.unwrap_or(0.0)]);
            fields.push(Field { name, kind: number, scaled });
        }
        if let Some(axis) = ["X", "Y", "Z"].into_iter().find(|axis| !fields.iter().any(|field| field.name == *axis)) {
            return Err(fault(format!("no {axis}"), "X, Y and Z").at("schema").into());
        }
        Ok(Self {
            root: file.parent().map(Path::to_path_buf).unwrap_or_default(),
            cube,
            extent: told.bounds_conforming.and_then(extent).unwrap_or(cube),
            fields,
            points: told.points,
            span: told.span,
            encoding,
            crs: told.srs.as_ref().and_then(Srs::text),
        })
    }

    /// How many levels it takes until points are no further apart than this.
    pub fn levels_for(&self, resolution: f64) -> u32 {
        let mut spacing = (self.cube.max[0] - self.cube.min[0]) / self.span;
        let mut levels = 1;
        while spacing > resolution && levels <= hierarchy::DEEPEST {
            spacing /= 2.0;
            levels += 1;
        }
        levels
    }
}

fn number_type(kind: &str, size: u8) -> Option<NumberType> {
    Some(match (kind, size) {
        ("unsigned", 1) => NumberType::U8,
        ("unsigned", 2) => NumberType::U16,
        ("unsigned", 4) => NumberType::U32,
        ("unsigned", 8) => NumberType::U64,
        ("signed", 1) => NumberType::I8,
        ("signed", 2) => NumberType::I16,
        ("signed", 4) => NumberType::I32,
        ("signed", 8) => NumberType::I64,
        ("float" | "floating", 4) => NumberType::F32,
        ("float" | "floating", 8) => NumberType::F64,
        _ => return None,
    })
}
