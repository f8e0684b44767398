//! From a CRS with heights to geocentric coordinates: where on earth a model stands.

use super::Crs;
use super::proj_ffi::{Context, Grids, Kind, Object};
use super::transform::{WARN_FROM_METRES, degrees, horizontal};

/// Takes x, y and z of a CRS to geocentric coordinates of WGS 84 (EPSG:4978), in metres.
///
/// It belongs to the thread that made it.
pub struct Geocentric {
    operation: Object,
    /// Metres per unit of z where the operation wants metres.
    metres: f64,
    warnings: Vec<String>,
}

impl Geocentric {
    /// The best transformation that can be carried out here; `extent` is the smallest and the largest x, y, z of what
    /// will be transformed.
    ///
    /// Where the heights cannot be carried over (the CRS has none, or the grid of its vertical datum is not installed) they
    /// are taken for heights above the ellipsoid of its horizontal datum, and a warning says so.
    ///
    /// # Errors
    /// Why there is none.
    pub fn new(crs: &Crs, extent: [[f64; 3]; 2]) -> Result<Self, String> {
        let context = Context::new()?;
        let source = Object::from_wkt(&context, &crs.wkt)?;
        let target = Object::parse(&context, "EPSG:4978")?;
        let [min, max] = extent;
        let flat = horizontal(Object::from_wkt(&context, &crs.wkt)?);
        let area = flat.as_ref().and_then(|flat| degrees(flat, [min[0], min[1], max[0], max[1]]));
        let trial = [min, max, std::array::from_fn(|i| f64::midpoint(min[i], max[i]))];
        let has_heights = source.kind() == Kind::Compound || source.axis_units().len() == 3;
        let whole = has_heights.then(|| best(&source, &target, area, &trial)).flatten();
        if let Some((found, operation)) = whole.filter(|(found, _)| !found.is_ballpark()) {
            return Ok(Self { operation, metres: 1.0, warnings: inaccuracy(crs, &found, false) });
        }
        let promoted =
            flat.and_then(|flat| flat.promoted_to_3d()).ok_or_else(|| format!("{crs} has no horizontal part"))?;
        let Some((found, operation)) = best(&promoted, &target, area, &trial) else {
            return Err(format!("PROJ knows no transformation from {crs} to WGS 84 that holds for these coordinates"));
        };
        let missing = if has_heights { missing_grids(&source, &target, area) } else { Vec::new() };
        let why = match (has_heights, missing.as_slice()) {
            (false, _) => "it has no vertical datum".to_owned(),
            (true, []) => "PROJ knows no way from its vertical datum to the ellipsoid".to_owned(),
            (true, grids) => format!("the grid {} is not installed (see PROJ_DATA)", grids.join(" or ")),
        };
        let mut warnings = vec![format!(
            "heights of {crs} are taken for heights above the ellipsoid of its datum, because {why}: on earth the model stands \
             too low or too high by as much as that ellipsoid and the vertical datum differ, up to tens of metres"
        )];
        warnings.extend(inaccuracy(crs, &found, true));
        Ok(Self { operation, metres: crs.metres_per_unit[2], warnings })
    }

    /// What the user must know of the accuracy.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }

    /// Transforms points in place; what cannot be transformed becomes infinite.
    pub fn transform(&self, points: &mut [[f64; 3]]) {
        for [_, _, z] in points.iter_mut() {
            *z *= self.metres;
        }
        self.operation.transform_3d(points);
    }
}

/// The best operation that can be carried out here, as it is and as it is to be called.
fn best(source: &Object, target: &Object, area: Option<[f64; 4]>, trial: &[[f64; 3]]) -> Option<(Object, Object)> {
    source.operations_to(target, area, Grids::Installed).into_iter().find_map(|found| {
        let normalized = found.normalized()?;
        let mut points = trial.to_vec();
        normalized.transform_3d(&mut points);
        points.iter().flatten().all(|c| c.is_finite()).then_some((found, normalized))
    })
}

/// The grids that the best of all known operations lacks here.
fn missing_grids(source: &Object, target: &Object, area: Option<[f64; 4]>) -> Vec<String> {
    let known = source.operations_to(target, area, Grids::AnyKnown);
    let best = known.into_iter().find(|operation| !operation.is_ballpark());
    let grids = best.map(|operation| operation.grids()).unwrap_or_default();
    grids.into_iter().filter(|grid| !grid.is_available).map(|grid| grid.name).collect()
}

fn inaccuracy(crs: &Crs, found: &Object, is_horizontal: bool) -> Vec<String> {
    let what = if is_horizontal { "the horizontal transformation" } else { "the transformation" };
    let error = match found.accuracy() {
        Some(metres) if metres <= WARN_FROM_METRES => return Vec::new(),
        Some(metres) => format!("is expected to be off by up to {metres} m"),
        None if found.is_ballpark() => {
            "leaves out the shift between the datums and may be off by hundreds of metres".into()
        }
        None => "has an unknown accuracy".into(),
    };
    vec![format!("{what} from {crs} to WGS 84 {error}")]
}
