//! What the inputs say of themselves, and what follows for the output.

use std::path::{Path, PathBuf};

use serde_json::{Map, Value};

use super::extensions;
use crate::error::{InputError, Result};
use crate::sink::{Metadata, prefix_in, reference_system};
use crate::site::QUANTUM;
use crate::source::cityjson::{self, CityModel, Transform};
use crate::source::crs::Crs;

/// The step of the grid of a file in degrees that has none: a tenth of a millimetre, as in metres.
const QUANTUM_DEGREES: f64 = 1e-9;

/// The heads of all inputs.
pub(super) struct Inputs {
    /// What is known of the output.
    pub metadata: Metadata,
    /// What the names of gable's attributes begin with in each input.
    pub prefixes: Vec<String>,
    pub warnings: Vec<String>,
}

/// The CRS of a file.
#[derive(Debug, Clone, PartialEq)]
enum Named {
    /// It names none.
    Nothing,
    /// As PROJ knows it.
    Known(Box<Crs>),
    /// As the file names it: nobody else knows it.
    Unknown(String),
}

impl Named {
    fn of(model: &CityModel) -> Self {
        let Some(name) = &model.reference_system else { return Self::Nothing };
        let known = model.crs_code().and_then(|code| Crs::parse(&code).ok()).or_else(|| Crs::parse(name).ok());
        known.map_or_else(|| Self::Unknown(name.clone()), |crs| Self::Known(Box::new(crs)))
    }

    fn text(&self) -> String {
        match self {
            Self::Nothing => "no CRS".to_owned(),
            Self::Known(crs) => format!("the CRS {crs}"),
            Self::Unknown(name) => format!("the CRS {name:?}"),
        }
    }
}

impl Inputs {
    /// Reads the heads; `crs` goes before what the files say.
    ///
    /// # Errors
    /// A file that cannot be read, a CRS that is none, or two files whose CRSs differ.
    pub(super) fn open(paths: &[PathBuf], crs: Option<&str>) -> Result<Self> {
        let given = crs.map(Crs::parse).transpose();
        let given = given.map_err(|fault| InputError { file: "--crs".into(), ..fault })?;
        let mut warnings = Vec::new();
        let mut first: Option<(&Path, Named)> = None;
        let mut heads = Vec::new();
        for path in paths {
            let head = head(path)?;
            let named = given.clone().map_or_else(|| Named::of(&head), |crs| Named::Known(Box::new(crs)));
            match &first {
                Some((other, crs)) if *crs != named => {
                    let expected = format!("{} as in {}", crs.text(), other.display());
                    return Err(InputError::new(path, named.text(), expected)
                        .at("metadata.referenceSystem")
                        .remedy("Reproject one of them, or give --crs where a file names the wrong CRS or none.")
                        .into());
                }
                Some(_) => {}
                None => first = Some((path, named)),
            }
            heads.push(head);
        }
        let named = first.map_or(Named::Nothing, |(_, named)| named);
        if let Named::Unknown(name) = &named {
            warnings.push(format!("PROJ does not know the CRS {name:?}; lengths are taken for metres"));
        }
        let (reference_system, crs) = match named {
            Named::Nothing => (None, None),
            Named::Known(crs) => {
                (crs.code.as_deref().and_then(reference_system).or_else(|| crs.reference_system()), Some(*crs))
            }
            Named::Unknown(name) => (Some(name).filter(|name| name.contains("://www.opengis.net/def/crs/")), None),
        };
        let prefixes = heads.iter().map(|head| prefix_in(head).to_owned()).collect();
        let quantum = if crs.as_ref().is_some_and(|crs| crs.is_geographic) { QUANTUM_DEGREES } else { QUANTUM };
        let mut others = Vec::new();
        let mut declared: Map<String, Value> = Map::new();
        let mut title = String::new();
        for (head, path) in heads.iter_mut().zip(paths) {
            let mut metadata = std::mem::take(&mut head.metadata);
            if let Some(Value::String(own)) = metadata.shift_remove("title").filter(|_| title.is_empty()) {
                title = own;
            }
            for follows_from_the_features in ["referenceSystem", "geographicalExtent"] {
                metadata.shift_remove(follows_from_the_features);
            }
            others.push(metadata);
            for (name, extension) in head.extensions.take().as_ref().and_then(Value::as_object).into_iter().flatten() {
                if !extensions::hold(&head.version) {
                    warnings.push(format!(
                        "{}: the extension {name:?} is one of CityJSON {}, and does not go into the 2.0 that is written",
                        path.display(),
                        head.version
                    ));
                    continue;
                }
                let known = declared.entry(name).or_insert_with(|| extension.clone());
                if known != extension {
                    warnings.push(format!(
                        "{}: the extension {name:?} is declared otherwise than before; the first declaration stays",
                        path.display()
                    ));
                }
            }
        }
        let (others, differing) = common(others);
        if !differing.is_empty() {
            warnings.push(format!("the metadata {} differ among the inputs and are left out", differing.join(", ")));
        }
        let metadata = Metadata {
            title,
            reference_system,
            crs,
            transform: grid(&heads, quantum),
            others,
            extensions: (!declared.is_empty()).then_some(Value::Object(declared)),
        };
        Ok(Self { metadata, prefixes, warnings })
    }
}

/// The head of a file, with its first vertex.
fn head(path: &Path) -> Result<CityModel> {
    let mut features = cityjson::features(path)?;
    let mut head = features.head().clone();
    if head.transform.is_none() {
        let first = features.next().transpose()?;
        head.vertices.extend(first.and_then(|model| model.vertices.first().copied()));
    }
    Ok(head)
}

/// The members that all have alike, and the names of the others.
fn common(all: Vec<Map<String, Value>>) -> (Map<String, Value>, Vec<String>) {
    let mut differing: Vec<String> = Vec::new();
    for name in all.iter().flat_map(Map::keys) {
        let mut values = all.iter().map(|metadata| metadata.get(name));
        let first = values.next();
        if values.any(|value| Some(value) != first) && !differing.contains(name) {
            differing.push(name.clone());
        }
    }
    let mut common = all.into_iter().next().unwrap_or_default();
    common.retain(|name, _| !differing.contains(name));
    (common, differing)
}

/// The finest of all grids from the origin of the first; `quantum` is the step for files that have none.
fn grid(heads: &[CityModel], quantum: f64) -> Transform {
    let usable = |transform: &&Transform| {
        transform.scale.iter().all(|s| s.is_normal() && *s > 0.0) && transform.translate.iter().all(|t| t.is_finite())
    };
    let grids = || heads.iter().filter_map(|head| head.transform.as_ref()).filter(usable);
    let has_none = heads.iter().any(|head| !head.transform.as_ref().is_some_and(|transform| usable(&transform)));
    let coarsest = if has_none { quantum } else { f64::INFINITY };
    let scale = std::array::from_fn(|i| grids().map(|grid| grid.scale[i]).fold(coarsest, f64::min));
    let near = heads.first().and_then(|head| head.vertices.first()).map(|vertex| vertex.map(f64::floor));
    let translate = grids().next().map(|grid| grid.translate).or(near).unwrap_or_default();
    Transform { scale: scale.map(|s: f64| if s.is_finite() { s } else { quantum }), translate }
}
