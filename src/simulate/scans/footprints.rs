//! The footprints that the scans are known with.

use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use super::Scanned;
use crate::error::{Error, InputError, Result};
use crate::sink::write_whole;
use crate::site::{Frame, QUANTUM};
use crate::source::crs::Crs;

/// A GeoJSON file being gathered.
pub(super) struct Footprints {
    path: PathBuf,
    crs: Value,
    features: Vec<Value>,
}

impl Footprints {
    /// A file in the CRS of the points.
    pub fn create(path: &Path, crs: &Crs, overwrite: bool) -> Result<Self> {
        if !overwrite && path.exists() {
            return Err(InputError::new(path, "an existing file", "a new file name")
                .remedy("Give --overwrite to replace it")
                .into());
        }
        // RFC 7946 knows WGS 84 only; the older member is what programs read. Null means that of the points.
        let name = crs.code.as_deref().and_then(|code| {
            let (authority, code) = code.split_once(':')?;
            let horizontal = code.split('+').next()?;
            Some(json!({"type": "name", "properties": {"name": format!("urn:ogc:def:crs:{authority}::{horizontal}")}}))
        });
        Ok(Self { path: path.to_path_buf(), crs: name.unwrap_or(Value::Null), features: Vec::new() })
    }

    /// Adds the footprint of a scan.
    pub fn add(&mut self, scanned: &Scanned) {
        let frame = scanned.scan.frame;
        let ring =
            |line: &geo::LineString<f64>| -> Vec<[f64; 2]> { line.coords().map(|c| place(&frame, *c)).collect() };
        let polygons: Vec<Vec<Vec<[f64; 2]>>> = scanned
            .footprint()
            .iter()
            .map(|polygon| std::iter::once(polygon.exterior()).chain(polygon.interiors()).map(ring).collect())
            .collect();
        let mut properties = scanned.attributes.clone();
        properties.insert("id".to_owned(), scanned.id.as_str().into());
        self.features.push(json!({
            "type": "Feature",
            "properties": properties,
            "geometry": {"type": "MultiPolygon", "coordinates": polygons},
        }));
    }

    /// Writes the file.
    pub fn finish(self) -> Result<()> {
        let all = json!({"type": "FeatureCollection", "crs": self.crs, "features": self.features});
        let mut text = serde_json::to_vec(&all).map_err(|e| Error::io(&self.path, "write", e.into()))?;
        text.push(b'\n');
        write_whole(&self.path, &text)
    }
}

/// A place in CRS units, on the grid of the output.
fn place(frame: &Frame, c: geo::Coord<f64>) -> [f64; 2] {
    let [x, y, _] = frame.to_crs(&nalgebra::Point3::new(c.x, c.y, 0.0));
    [x, y].map(|v| (v / QUANTUM).round() * QUANTUM)
}
