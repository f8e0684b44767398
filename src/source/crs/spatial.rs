//! From one CRS to another with heights.

use super::Crs;
use super::proj_ffi::{Context, Grids, Object};
use super::transform::{WARN_FROM_METRES, degrees, horizontal};

/// Takes x, y and z of one CRS to those of another, x and longitude first, angles in degrees. Heights change where both
/// systems have a vertical part; otherwise they stay as they are.
///
/// It belongs to the thread that made it.
pub struct SpatialTransformer {
    /// `None` when the systems are the same.
    operation: Option<Object>,
    warning: Option<String>,
}

impl SpatialTransformer {
    /// The best transformation that can be carried out here; `extent` (min x, min y, max x, max y, in units of `from`)
    /// says where it must hold.
    ///
    /// # Errors
    /// Why there is none.
    pub fn new(from: &Crs, to: &Crs, extent: Option<[f64; 4]>) -> Result<Self, String> {
        if from == to {
            return Ok(Self { operation: None, warning: None });
        }
        let context = Context::new()?;
        let source = Object::from_wkt(&context, &from.wkt)?;
        let target = Object::from_wkt(&context, &to.wkt)?;
        let flat = horizontal(Object::from_wkt(&context, &from.wkt)?);
        let area = flat.zip(extent).and_then(|(flat, extent)| degrees(&flat, extent));
        let trial: Vec<[f64; 3]> =
            extent.map(|[x0, y0, x1, y1]| vec![[x0, y0, 0.0], [x1, y1, 0.0]]).unwrap_or_default();
        let usable = source.operations_to(&target, area, Grids::Installed).into_iter().find_map(|found| {
            let operation = found.normalized()?;
            let mut points = trial.clone();
            operation.transform_3d(&mut points);
            points.iter().flatten().all(|c| c.is_finite()).then_some((found, operation))
        });
        let Some((found, operation)) = usable else {
            return Err(format!("PROJ knows no transformation from {from} that holds for these coordinates"));
        };
        let warning = warning(from, to, &found);
        Ok(Self { operation: Some(operation), warning })
    }

    /// What the user must know of it; `None` when it is good to a decimetre and changes what it should.
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// Transforms points in place; what cannot be transformed becomes infinite.
    pub fn transform(&self, points: &mut [[f64; 3]]) {
        if let Some(operation) = &self.operation {
            operation.transform_3d(points);
        }
    }
}

fn warning(from: &Crs, to: &Crs, found: &Object) -> Option<String> {
    let [before, after] = [from, to].map(|crs| crs.metres_per_unit[2]);
    let has_heights = |crs: &Crs| crs.wkt.contains("VERTCRS") || crs.wkt.contains("VERT_CS");
    if (before - after).abs() > 1e-9 && !(has_heights(from) && has_heights(to)) {
        return Some(format!(
            "heights stay as they are on the way from {from} to {to}, though one of the two counts in feet: give both with \
             a vertical part, such as EPSG:6339+6360 for feet and EPSG:6339+5703 for metres"
        ));
    }
    let accuracy = if found.is_ballpark() { None } else { found.accuracy() };
    let error = match accuracy {
        Some(metres) if metres <= WARN_FROM_METRES => return None,
        Some(metres) => format!("is expected to be off by up to {metres} m"),
        None if found.is_ballpark() => {
            "leaves out a shift between datums, for want of a grid or of a known shift".into()
        }
        None => "has an unknown accuracy".into(),
    };
    Some(format!("the transformation from {from} to {to} {error}"))
}
