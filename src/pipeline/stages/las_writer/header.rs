//! From settings to the header of a file.

use std::path::Path;
use std::sync::Arc;

use las::{Builder, Header, Transform, Vector, Vlr};

use super::settings::{Number, Settings};
use crate::error::InputError;
use crate::pipeline::las::{ExtraDimension, Unfit};
use crate::pipeline::options::Place;
use crate::pipeline::points::Points;
use crate::source::crs::Crs;

/// The largest whole number that a file stores.
const MOST: f64 = 2_147_483_647.0;

impl Settings {
    /// The scale and offset of the axes; `points` are all points of the file where some are automatic.
    pub fn transforms(&self, points: &[Points]) -> [Transform; 3] {
        std::array::from_fn(|axis| {
            let values = || points.iter().flat_map(|points| (0..points.len()).map(|i| points.get(axis, i)));
            let low = values().fold(f64::INFINITY, f64::min);
            let high = values().fold(f64::NEG_INFINITY, f64::max);
            let offset = match self.offset[axis] {
                Number::Is(offset) => offset,
                Number::Auto => {
                    if low.is_finite() {
                        low
                    } else {
                        0.0
                    }
                }
            };
            let scale = match self.scale[axis] {
                Number::Is(scale) => scale,
                // Without an extent any scale will do.
                Number::Auto => Some((high - offset) / MOST).filter(|s| s.is_normal() && *s > 0.0).unwrap_or(0.01),
            };
            Transform { scale, offset }
        })
    }

    /// The header of the file at `path` for points in a CRS, and what its extra bytes hold.
    ///
    /// # Errors
    /// A version and a point format that do not go together, or a text that is too long.
    pub fn header(
        &self,
        path: &Path,
        crs: Option<&Arc<Crs>>,
        transforms: [Transform; 3],
    ) -> Result<(Header, Vec<ExtraDimension>), InputError> {
        let fault = |e: las::Error| Self::misfit(path, &e);
        let mut builder = Builder::from((1, self.minor_version));
        builder.point_format = las::point::Format::new(self.format).map_err(fault)?;
        builder.point_format.is_compressed = self.is_compressed(path);
        let mut at = 0;
        let mut extra = Vec::new();
        for (name, kind) in &self.extra {
            extra.push(ExtraDimension { name: name.clone(), kind: *kind, at, scaled: None });
            at += kind.size();
        }
        builder.point_format.extra_bytes = at as u16;
        let [x, y, z] = transforms;
        builder.transforms = Vector { x, y, z };
        builder.system_identifier.clone_from(&self.system_id);
        builder.generating_software.clone_from(&self.software_id);
        builder.file_source_id = self.filesource_id;
        self.date(&mut builder);
        if let Some(source) = self.encoding_of.as_ref().filter(|_| self.minor_version >= 2) {
            builder.gps_time_type = source.gps_time_type();
            builder.has_synthetic_return_numbers = self.minor_version >= 3 && source.has_synthetic_return_numbers();
        }
        if let Some(source) = &self.id_of {
            builder.guid = source.guid();
        }
        if let Some(crs) = self.crs.as_ref().or(crs) {
            builder.has_wkt_crs = self.minor_version >= 4;
            let mut data = crs.wkt1().unwrap_or_else(|| crs.wkt.clone()).into_bytes();
            data.push(0);
            builder.vlrs.push(Vlr {
                user_id: "LASF_Projection".to_owned(),
                record_id: 2112,
                description: "OGC WKT".to_owned(),
                data,
            });
        }
        if !extra.is_empty() {
            builder.vlrs.push(ExtraDimension::describe(&extra));
        }
        builder.vlrs.extend(self.vlrs.iter().cloned());
        Ok((builder.into_header().map_err(fault)?, extra))
    }

    /// What is said where the library refuses a header.
    pub fn misfit(path: &Path, fault: &las::Error) -> InputError {
        InputError::new(path, fault.to_string(), "a version and a point format that go together")
    }

    /// What is said of a value that the file at `path` cannot hold.
    pub fn unfit(&self, unfit: &Unfit, path: &Path, place: &Place) -> InputError {
        let found = format!("{} = {}", unfit.dimension, unfit.value);
        let fault = if ["X", "Y", "Z"].contains(&unfit.dimension.as_str()) {
            let expected = "a coordinate that fits into 32 bits with the scale and the offset of the file";
            let name = unfit.dimension.to_lowercase();
            let remedy = format!("Set `offset_{name}` or `scale_{name}`, perhaps to \"auto\"");
            InputError::new(path, found, expected).remedy(remedy)
        } else {
            let expected = format!("a value that point format {} can hold", self.format);
            let remedy = if self.follows_points {
                "Change the value with filters.assign"
            } else {
                "Set `dataformat_id`, or change the value with filters.assign"
            };
            InputError::new(path, found, expected).remedy(remedy)
        };
        fault.at(place.stage.clone())
    }
}
