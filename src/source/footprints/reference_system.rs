//! Which reference system footprints are in, and where in it features are wanted.

use std::path::Path;

use super::{FootprintOptions, Within};
use crate::error::{InputError, Result};
use crate::source::crs::{Crs, Transformer};

/// The CRS that a file names, unless the user gave one; an error that names the file and says how to give one.
pub(super) fn crs_of_file(path: &Path, definition: &str, options: &FootprintOptions) -> Result<Option<Crs>> {
    if options.crs.is_some() || definition.trim().is_empty() {
        return Ok(None);
    }
    Crs::parse(definition).map(Some).map_err(|error| {
        let remedy = format!("Say with --footprint-crs which reference system it is. {}", error.remedy);
        InputError::new(path, error.found, error.expected).at("its reference system").remedy(remedy).into()
    })
}

/// The CRS of an entry in a database's list of reference systems: by its code where PROJ knows it, else by its definition.
/// `None` where the entry says that nothing is known.
pub(super) fn crs_of_listing(
    path: &Path,
    srid: i64,
    code: Option<String>,
    definition: Option<String>,
    options: &FootprintOptions,
) -> Result<Option<Crs>> {
    if let Some(crs) = code.as_deref().and_then(|code| Crs::parse(code).ok()) {
        return Ok(Some(crs));
    }
    // What GDAL writes for a system that it knows nothing of.
    if definition.as_deref().is_some_and(|text| text.contains("\"Undefined SRS\"")) {
        return Ok(None);
    }
    let definition = definition.filter(|text| text.contains('[')).or(code).unwrap_or_else(|| format!("EPSG:{srid}"));
    crs_of_file(path, &definition, options)
}

/// Where features are wanted, in the coordinates of a source in `crs`; `None` where all are, or nobody knows where.
pub(super) fn wanted_in(options: &FootprintOptions, crs: Option<&Crs>) -> Option<[f64; 4]> {
    let Within { crs: of_tiles, extent } = options.within.as_ref()?;
    extent_in(of_tiles, *extent, options.crs.as_ref().or(crs)?)
}

/// An extent (smallest x and y, largest x and y) in another CRS, a little wider than it is; `None` where there is no way.
fn extent_in(from: &Crs, extent: [f64; 4], to: &Crs) -> Option<[f64; 4]> {
    carried(&Transformer::new(from, to, Some(extent)).ok()?, extent)
}

/// The same of many extents at once, as far as they are known.
pub(crate) fn extents_in(from: &Crs, extents: &[Option<[f64; 4]>], to: &Crs) -> Vec<Option<[f64; 4]>> {
    let joined = |a: [f64; 4], b: [f64; 4]| [a[0].min(b[0]), a[1].min(b[1]), a[2].max(b[2]), a[3].max(b[3])];
    let around = extents.iter().copied().flatten().reduce(joined);
    let transformer = around.and_then(|around| Transformer::new(from, to, Some(around)).ok());
    extents.iter().map(|extent| carried(transformer.as_ref()?, (*extent)?)).collect()
}

fn carried(transformer: &Transformer, extent: [f64; 4]) -> Option<[f64; 4]> {
    const STEPS: u8 = 8;
    const SLACK: f64 = 0.02;
    let [x0, y0, x1, y1] = extent;
    let at = |i: u8, low: f64, high: f64| low + (high - low) * f64::from(i) / f64::from(STEPS);
    let mut points: Vec<[f64; 2]> =
        (0..=STEPS).flat_map(|i| (0..=STEPS).map(move |j| [at(i, x0, x1), at(j, y0, y1)])).collect();
    transformer.transform(&mut points);
    let bounds = points.iter().fold([f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY], |b, p| {
        [b[0].min(p[0]), b[1].min(p[1]), b[2].max(p[0]), b[3].max(p[1])]
    });
    let [x, y] = [SLACK * (bounds[2] - bounds[0]), SLACK * (bounds[3] - bounds[1])];
    bounds.iter().all(|bound| bound.is_finite()).then_some([bounds[0] - x, bounds[1] - y, bounds[2] + x, bounds[3] + y])
}
