//! A city model file as shapes.

use std::collections::BTreeMap;
use std::path::Path;

use nalgebra::Point3;
use serde_json::Value;

use super::shape::{Shape, ShapeFace};
use crate::error::{Error, InputError, Result};
use crate::site::Frame;
use crate::solid::SurfaceType;

/// The buildings of a city model in one local frame.
#[derive(Debug, Clone)]
pub struct ModelFile {
    /// The local frame of all shapes.
    pub frame: Frame,
    /// The buildings, in the order of the file.
    pub shapes: Vec<Shape>,
}

/// TEMPORARY reader.
pub fn read_shapes(path: &Path, lod: &str) -> Result<ModelFile> {
    let text = std::fs::read_to_string(path).map_err(|e| Error::io(path, "read", e))?;
    let bad = |e: serde_json::Error| InputError::new(path, e.to_string(), "CityJSON");
    let docs: Vec<Value> = match serde_json::from_str::<Value>(&text) {
        Ok(v) => vec![v],
        Err(_) => text.lines().map(serde_json::from_str).collect::<std::result::Result<_, _>>().map_err(bad)?,
    };
    let t = docs[0]["transform"].clone();
    let arr = |v: &Value| -> [f64; 3] { std::array::from_fn(|i| v[i].as_f64().unwrap()) };
    let (scale, translate) = (arr(&t["scale"]), arr(&t["translate"]));
    let frame = Frame { origin: translate.map(f64::floor), metres_per_unit: [1.0; 3] };
    let mut shapes = Vec::new();
    for doc in &docs {
        let vertices: Vec<Point3<f64>> = doc["vertices"]
            .as_array()
            .unwrap()
            .iter()
            .map(|v| {
                let v = arr(v);
                frame.to_local(std::array::from_fn(|i| v[i] * scale[i] + translate[i]))
            })
            .collect();
        let ring = |v: &Value| -> Vec<Point3<f64>> {
            v.as_array().unwrap().iter().map(|i| vertices[i.as_u64().unwrap() as usize]).collect()
        };
        let mut groups: BTreeMap<String, (Vec<ShapeFace>, Vec<Vec<Vec<Point3<f64>>>>, u32)> = BTreeMap::new();
        for (id, object) in doc["CityObjects"].as_object().unwrap() {
            let parent = object["parents"][0].as_str().unwrap_or(id);
            let group = groups.entry(parent.to_owned()).or_default();
            for geometry in object["geometry"].as_array().into_iter().flatten() {
                let l = geometry["lod"].as_str().map(str::to_owned).unwrap_or_else(|| geometry["lod"].to_string());
                let kind = |v: &Value| {
                    let s = &geometry["semantics"]["surfaces"][v.as_u64()? as usize]["type"];
                    Some(match s.as_str()? {
                        "RoofSurface" => SurfaceType::Roof,
                        "GroundSurface" => SurfaceType::Ground,
                        "OuterCeilingSurface" => SurfaceType::OuterCeiling,
                        _ => SurfaceType::Wall,
                    })
                };
                let polygons = |b: &Value| -> Vec<Vec<Vec<Point3<f64>>>> {
                    b.as_array().unwrap().iter().map(|p| p.as_array().unwrap().iter().map(ring).collect()).collect()
                };
                if l == "0" || l == "0.0" {
                    group.1.extend(polygons(&geometry["boundaries"]));
                }
                if l != lod {
                    continue;
                }
                let (b, v) = if geometry["type"] == "Solid" {
                    (&geometry["boundaries"][0], &geometry["semantics"]["values"][0])
                } else {
                    (&geometry["boundaries"], &geometry["semantics"]["values"])
                };
                for (i, rings) in polygons(b).into_iter().enumerate() {
                    group.0.push(ShapeFace { rings, kind: kind(&v[i]), solid: group.2 });
                }
                group.2 += 1;
            }
        }
        for (id, (faces, outline, _)) in groups {
            shapes.push(Shape::new(id, faces, &outline));
        }
    }
    Ok(ModelFile { frame, shapes })
}

/// TEMPORARY
pub fn read_points(paths: &[std::path::PathBuf], classes: &[u8], model: &ModelFile) -> Result<Vec<Point3<f64>>> {
    let mut out = Vec::new();
    for path in paths {
        let mut r = las::Reader::from_path(path).unwrap();
        let d = r.read_all().unwrap();
        for (((x, y), z), c) in d.x().zip(d.y()).zip(d.z()).zip(d.classification()) {
            if classes.contains(&c) {
                out.push(model.frame.to_local([x, y, z]));
            }
        }
    }
    Ok(out)
}
