//! What is in a city model.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use serde::Serialize;

use super::describe::CrsInfo;
use crate::error::Result;
use crate::sink::{own, prefix_in};
use crate::source::cityjson;
use crate::source::crs::Crs;

/// What is in a city model.
#[derive(Debug, Serialize)]
pub struct ModelInfo {
    /// The file.
    pub file: String,
    /// The version of CityJSON.
    pub version: String,
    /// Its title, if it has one.
    pub title: Option<String>,
    /// Its CRS, where it names one.
    pub crs: Option<CrsInfo>,
    /// What is wrong with its CRS.
    pub crs_fault: Option<String>,
    /// Smallest and largest coordinates, CRS units.
    pub extent: Option<[[f64; 3]; 2]>,
    /// Number of objects of each type.
    pub objects: BTreeMap<String, u64>,
    /// Number of geometries of each type and level of detail, such as `Solid, LoD 2.2`.
    pub geometries: BTreeMap<String, u64>,
    /// Number of semantic surfaces of each type.
    pub surfaces: BTreeMap<String, u64>,
    /// Of buildings of gable's making, the number of those that reached each level of detail.
    pub reached: BTreeMap<String, u64>,
}

/// Whether a file is a city model: by the end of its name, or because it says so near its beginning.
pub fn is_model(path: &Path) -> bool {
    /// Where a CityJSON says that it is one, nearly always.
    const BEGINNING: u64 = 1024;
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase()).unwrap_or_default();
    if [".city.json", ".city.jsonl"].iter().any(|end| name.ends_with(end)) {
        return true;
    }
    if ![".json", ".jsonl"].iter().any(|end| name.ends_with(end)) || !path.is_file() {
        return false;
    }
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(BEGINNING).read_to_end(&mut start));
    let text = String::from_utf8_lossy(&start);
    read.is_ok() && (text.contains("\"CityJSON\"") || text.contains("\"CityJSONFeature\""))
}

/// Counts what is in a city model, piece by piece.
///
/// # Errors
/// It cannot be read, or is none.
pub fn describe(path: &Path) -> Result<ModelInfo> {
    let mut features = cityjson::features(path)?;
    let head = features.head().clone();
    let crs = head.crs_code().map(|code| Crs::parse(&code));
    let mut info = ModelInfo {
        file: path.display().to_string(),
        version: head.version.clone(),
        title: head.metadata.get("title").and_then(|title| title.as_str()).map(str::to_owned),
        crs: crs.as_ref().and_then(|crs| crs.as_ref().ok()).map(CrsInfo::new),
        crs_fault: match (&head.reference_system, &crs) {
            (Some(name), None) => Some(name.clone()),
            (_, Some(Err(fault))) => Some(fault.to_string()),
            _ => None,
        },
        extent: None,
        objects: BTreeMap::new(),
        geometries: BTreeMap::new(),
        surfaces: BTreeMap::new(),
        reached: BTreeMap::new(),
    };
    for feature in &mut features {
        let feature = feature?;
        for vertex in &feature.vertices {
            let [min, max] = info.extent.get_or_insert([*vertex; 2]);
            for axis in 0..3 {
                min[axis] = min[axis].min(vertex[axis]);
                max[axis] = max[axis].max(vertex[axis]);
            }
        }
        for object in &feature.objects {
            *info.objects.entry(object.kind.clone()).or_default() += 1;
            if let Some(level) = own(&object.attributes, prefix_in(&head), "lod").and_then(|level| level.as_str()) {
                *info.reached.entry(level.to_owned()).or_default() += 1;
            }
            for geometry in &object.geometries {
                let lod = if geometry.lod.is_empty() { "no LoD".to_owned() } else { format!("LoD {}", geometry.lod) };
                *info.geometries.entry(format!("{}, {lod}", geometry.kind.name())).or_default() += 1;
                for surface in &geometry.surfaces {
                    *info.surfaces.entry(surface.kind.clone()).or_default() += 1;
                }
            }
        }
    }
    Ok(info)
}
